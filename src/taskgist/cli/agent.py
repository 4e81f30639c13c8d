"""``taskgist agent``: profiles of bodies, human and robot."""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated

import typer
from rich.text import Text

from taskgist.cli.common import FAILED, OK, JsonOption, ReplaceOption, check_target, command, console, print_json
from taskgist.common.files import writing
from taskgist.errors import InputError, SceneError, UnknownNameError, nearest
from taskgist.perspective.image import view_of
from taskgist.world.bodies.eyes import Eye
from taskgist.world.bodies.model_files import FILE, PACKAGE
from taskgist.world.bodies.profile import DERIVED_M, Axis
from taskgist.world.body_check import BODY, BodyCheck, check_body
from taskgist.world.drafting.draft import draft_profile
from taskgist.world.stage import Stage


def found_in(result: BodyCheck) -> dict[str, object]:
    """Everything that was found of a profile, as plain data."""
    found: dict[str, object] = {
        "profile": result.name,
        "fit": not result.problems,
        "problems": [_told(problem) for problem in result.problems],
        "doubts": list(result.doubts),
        "lacks": list(result.lacks),
        "derived": list(result.derived),
    }
    return found | _body(result) if result.scene is not None else found


def _body(result: BodyCheck) -> dict[str, object]:
    assert result.scene is not None
    assert result.given is not None
    stage = Stage(result.scene)
    body, given = result.scene.agent(BODY), result.given
    p, eye = body.profile, stage.eye(body)
    arms = [
        {
            "side": arm.profile.side,
            "shoulder_m": _rounded(stage.shoulder(arm).position),
            "palm_m": _rounded(stage.site(arm.palm_site).position),
            "length_m": round(arm.profile.length_m, 3),
            "length": "derived" if asked.length_m == DERIVED_M else "given",
            "azimuth_deg": _degrees(arm.profile.azimuth_rad),
            "elevation_deg": _degrees(arm.profile.elevation_rad),
        }
        for asked, arm in zip(given.arms, body.arms, strict=True)
    ]
    return {
        "name": p.name,
        "model": p.model,
        "base": {"moves": p.moves, "height_m": round(float(stage.state.qpos[body.base][2]), 3)},
        "eye": {
            "frame": p.eye.frame.name,
            "camera": p.eye.camera,
            "position_m": _rounded(eye.position),
            "looks_along": _rounded(eye.matrix[:, 0]),
            "fov_deg": _degrees(p.eye.fov_rad),
            "image_px": list(p.eye.image_px),
            "gaze_cone_deg": round(math.degrees(p.eye.gaze_cone_rad), 1),
            "hidden_by_itself": _hidden_by_itself(stage),
        }
        if p.eye.sees
        else None,
        "joints": {field: {"joint": axis.joint, "range_deg": _degrees(axis.range_rad)} for field, axis in p.axes},
        "postures": list(p.legs.can),
        "arms": arms,
        "hand": {"kind": p.hand.kind, "opening_m": p.hand.opening_m} if p.hand else None,
        "parts": {part: len(bodies) for part, bodies in body.parts.items()},
    }


def _hidden_by_itself(stage: Stage) -> dict[str, float]:
    """Share of the image that each of its own bodies takes up, at rest."""
    model, own = stage.scene.model, set(stage.scene.agent(BODY).geoms.tolist())
    view = view_of(stage, BODY).geoms
    hidden: Counter[str] = Counter()
    for geom, count in Counter(view.ravel().tolist()).items():
        if geom in own:
            hidden[str(model.body(int(model.geom_bodyid[geom])).name).partition("/")[2]] += count
    return {name: round(count / view.size, 4) for name, count in hidden.most_common()}


def _rounded(vector: Iterable[float]) -> list[float]:
    return [round(float(value), 3) for value in vector]


def _degrees(angles: tuple[float, float]) -> list[float]:
    return [round(math.degrees(angle), 1) for angle in angles]


def print_found(result: BodyCheck, found: dict[str, object]) -> None:
    """Print it for people."""
    console.print(Text.assemble(f"{result.name}: ", _verdict(result)))
    for problem in result.problems:
        console.print(Text.assemble("  ", ("problem", "bold red"), f"   {_told(problem)}"))
    for doubt in result.doubts:
        console.print(Text.assemble("  ", ("doubt", "bold yellow"), f"     {doubt}"))
    if result.scene is not None:
        _print_body(result, found)
    for lack in result.lacks:
        console.print(Text.assemble("  ", ("note", "cyan"), f"      {lack}"))
    if "picture" in found:
        console.print(f"saved {found['picture']}")


def _verdict(result: BodyCheck) -> tuple[str, str]:
    if result.problems:
        return "not fit to use", "bold red"
    return ("doubtful: is that meant?", "bold yellow") if result.doubts else ("fit to use", "green")


def _told(problem: InputError) -> str:
    """A problem in one sentence: all known names, of which a robot has a hundred, only where none is near."""
    near = nearest(problem.name, problem.known) if isinstance(problem, UnknownNameError) else None
    if near is None:
        return str(problem)
    return str(InputError(problem.problem, where=problem.where, hint=f"did you mean {near!r}?"))


def _print_body(result: BodyCheck, found: dict[str, object]) -> None:
    assert result.scene is not None
    stage, body = Stage(result.scene), result.scene.agent(BODY)
    p = body.profile
    _line("model", p.model)
    _line("base", "moves about" if p.moves else "stays where it stands")
    _line("eye", _eye(p.eye, float(stage.eye(body).position[2])) if p.eye.sees else "none")
    axes = dict(p.axes)
    for part, fields in (("head", ("pan", "tilt")), ("torso", ("turn", "lean"))):
        named = [(field, axes.get(f"{part}.{field}")) for field in fields]
        _line(part, ", ".join(_axis(field, axis) for field, axis in named if axis) or "no joints that turn")
    _line("postures", " and ".join(p.legs.can))
    for arm in body.arms:
        reach = f"reaches {arm.profile.length_m:.2f} m"
        sector = f"azimuth {_span(arm.profile.azimuth_rad)}, elevation {_span(arm.profile.elevation_rad)}"
        shoulder = f"shoulder {arm.profile.shoulder.name}, {stage.shoulder(arm).position[2]:.2f} m high"
        _line(f"{arm.profile.side} arm", f"{shoulder}; {reach}; {sector}")
    _line("hand", f"{p.hand.kind}, opens {100 * p.hand.opening_m:.1f} cm" if p.hand else "none")
    parts = (f"{part} ({len(bodies)})" for part, bodies in body.parts.items())
    _line("parts", f"{', '.join(parts)}: bodies of the model")
    for derived in result.derived:
        console.print(Text.assemble("  ", ("derived", "cyan"), f"   {derived}"))
    eye = found["eye"]
    for name, share in eye["hidden_by_itself"].items() if isinstance(eye, dict) else ():
        hint = "; if that is the eye's own housing, add it to eye.exclude" if share > SUSPECT else ""
        console.print(Text.assemble("  ", ("note", "cyan"), f"      {name} hides {share:.1%} of its view{hint}"))


def _eye(eye: Eye, height_m: float) -> str:
    fov = " × ".join(f"{math.degrees(angle):.0f}°" for angle in eye.fov_rad)
    pixels = " × ".join(map(str, eye.image_px))
    cone = math.degrees(eye.gaze_cone_rad)
    name = eye.camera or eye.frame.name
    return f"{name}, {height_m:.2f} m high; {fov}, {pixels} pixels; gaze cone {cone:.0f}°"


SUSPECT = 0.25
"""Share of the image above which what hides it is probably around the eye."""


def _line(what: str, text: str) -> None:
    console.print(f"  {what:9} {text}")


def _axis(field: str, axis: Axis) -> str:
    return f"{field} {axis.joint} {_span(axis.range_rad)}"


def _span(angles: tuple[float, float]) -> str:
    return f"{math.degrees(angles[0]):.0f}° to {math.degrees(angles[1]):.0f}°"


agent_app = typer.Typer(help="Bodies: draft and check agent profiles, human or robot.", no_args_is_help=True)


@agent_app.callback()
def agent() -> None:
    """Bodies: draft and check agent profiles, human or robot."""


@agent_app.command("check")
@command
def check(
    profile: Annotated[str, typer.Argument(help="A built-in profile, or a file (.toml).", show_default=False)],
    out: Annotated[Path | None, typer.Option("--out", "-o", help="A PNG file for a picture of the body.")] = None,
    replace: ReplaceOption = False,
    as_json: JsonOption = False,
) -> int:
    """Say whether an agent profile is fit to use, and what it has.

    Every problem is named, and what is doubtful: an eye that looks aside, a joint about the wrong axis. The picture
    shows the body from the side and from above, with its eye, shoulders, hands, reach and field of view. The exit code
    is 1 if the profile cannot be used.

    Example: taskgist agent check pr2 -o pr2.png

    Example: taskgist agent check my_robot.toml
    """
    if out is not None:
        check_target(out, "--out", replace=replace, suffix=".png", what="pictures")
    result = check_body(profile)
    found = found_in(result)
    if out is not None and result.scene is not None:
        from taskgist.view.agent_card import agent_card  # with matplotlib, which only pictures should wait for

        found["picture"] = str(agent_card(Stage(result.scene), BODY, out, title=str(found["name"])))
    if as_json:
        print_json(found)
    else:
        print_found(result, found)
    return FAILED if result.problems else OK


@agent_app.command("draft")
@command
def draft(
    model: Annotated[
        str, typer.Argument(help="A robot's model: URDF, MJCF, or package://NAME/path.", show_default=False)
    ],
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", help="The profile to write (.toml); default: named as the model, here."),
    ] = None,
    replace: ReplaceOption = False,
    as_json: JsonOption = False,
) -> None:
    """Look into a robot's model and write a profile.

    Says what it found: arms and their hands, cameras, head, torso, legs or wheels. Each line of the profile has its
    reason beside it; what the model does not tell is a line called open, to fill in. agent check looks at the profile.

    Example: taskgist agent draft panda.urdf

    Example: taskgist agent draft package://my_robot/urdf/robot.urdf -o robot.toml
    """
    out = Path(f"{Path(model).stem}.toml") if out is None else out
    check_target(out, "--out", replace=replace, suffix=".toml", what="profiles")
    named = model if model.startswith(PACKAGE) else os.path.relpath(model.removeprefix(FILE), out.parent)
    found = draft_profile(model, named=named)
    with writing(out, replace=replace, error=SceneError) as stream:
        stream.write(found.text.encode())
    if as_json:
        print_json({"profile": str(out), "model": model, "found": list(found.found), "open": list(found.open)})
        return
    console.print(f"{found.model.name}: {found.found[0]}")
    for line in found.found[1:]:
        console.print(f"  {line}")
    for question in found.open:
        console.print(Text.assemble("  ", ("open", "bold yellow"), f"      {question}"))
    console.print(f"wrote {out}, the profile")
    then = f"taskgist agent check {out} -o {out.with_suffix('.png')}"
    console.print(f"{'fill in what it calls open, then' if found.open else 'look at it'}: {then}")
