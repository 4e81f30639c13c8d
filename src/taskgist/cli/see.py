"""``taskgist see``: a picture of what an agent sees."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from taskgist.cli.common import (
    AtOption,
    JsonOption,
    ReplaceOption,
    WhereArgument,
    about,
    check_target,
    command,
    console,
    open_stage,
    print_json,
)
from taskgist.perspective.effort import Visibility, assumed_gaze, evidence_document
from taskgist.perspective.image import visibility


@command
def see(
    where: WhereArgument,
    agent: Annotated[str, typer.Option(help="Whose eyes.", show_default=False)],
    at: AtOption = None,
    object: Annotated[str | None, typer.Option("--object", help="An object to mark.")] = None,  # noqa: A002
    out: Annotated[Path | None, typer.Option("--out", "-o", help="The PNG file; default: beside, by agent.")] = None,
    replace: ReplaceOption = False,
    as_json: JsonOption = False,
) -> None:
    """Save a picture of what an agent sees.

    Also says which objects are visible to it, and how much of them. No display is needed.

    Example: taskgist see kitchen.toml --agent P2 --object cup

    Example: taskgist see handover.mcap --agent taker --at 3.2 -o taker.png
    """
    stage = open_stage(where, at)
    scene = stage.scene
    with about(where):
        body = scene.agent(agent)
        if object is not None:
            scene.object_body(object)
    path = out or where.with_name(f"{where.stem}_{body.name}_sees.png")
    check_target(path, "--out", replace=replace, suffix=".png", what="pictures")
    from taskgist.view.scene import see_picture  # with matplotlib, which only pictures should wait for

    see_picture(stage, agent, path, target=object)
    seen = {name: visibility(stage, agent, name) for name in scene.objects}
    if as_json:
        objects = {name: ({"visibility": v.score, **evidence_document(v)} if v else None) for name, v in seen.items()}
        print_json({"picture": str(path), "agent": agent, "time_s": stage.state.time_s, "objects": objects})
        return
    console.print(f"saved {path}")
    for name, visible in seen.items():
        console.print(f"  {name:20} {_sentence(visible)}")
    if not seen:
        console.print("  there are no objects in this scene")


def _sentence(visible: Visibility | None) -> str:
    if visible is None:
        return "unknown: it was not tracked"
    if not visible.visible_px:
        hidden_by = ", ".join(owner for owner, _ in visible.occluders)
        if hidden_by:
            return f"not visible: hidden by {hidden_by}"
        return f"not visible: {'too small' if visible.unoccluded_px else 'out of the field of view'}"
    where = "in the gaze cone" if visible.in_gaze_cone else "beside the gaze cone"
    if visible.eyes_towards is not None:
        where += f" ({assumed_gaze(visible.eyes_towards, visible.eyes_rad)})"
    unoccluded = _percent(visible.visible_share, 0)
    return f"visibility score {_percent(visible.score, 2)}, {where}, {unoccluded} of it unoccluded"


def _percent(share: float, digits: int) -> str:
    """A share above zero, never written as zero."""
    least = 10.0**-digits
    return f"{100 * share:.{digits}f} %" if 100 * share >= least else f"below {least:g} %"
