"""Robots, rooms and things as they are published: which load, and of robots what ``agent draft`` makes of them.

``python -m tools.robots_page example-robot-data=DIR robosuite=DIR ...`` puts the tables into ``docs/howto/robots.md``.
Each package is named with the folder into which its wheel was unpacked; none of them needs to be installed. Every model
is looked at in a process of its own, which is ended when it takes too long.
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from tools.markdown import filled, header, row

PAGE = Path("docs/howto/robots.md")
LONGEST_S = 60
PATTERNS: Mapping[str, tuple[str, ...]] = {
    "example-robot-data": ("**/*.urdf",),
    "robosuite": ("robosuite/models/assets/robots/*/robot.xml",),
    "gymnasium-robotics": (
        "**/assets/fetch/pick_and_place.xml",
        "**/assets/hand/reach.xml",
        "**/assets/hand/manipulate_block.xml",
        "**/assets/adroit_hand/adroit_*.xml",
        "**/assets/kitchen_franka/kitchen_assets/kitchen_env_model.xml",
        "**/envs/mujoco/assets/*.xml",
    ),
    "pybullet_data": ("pybullet_data/**/*.urdf", "pybullet_data/mjcf/*.xml"),
}
"""Files of each package that are robots."""
ROOMS: Mapping[str, tuple[str, ...]] = {
    "robosuite": ("robosuite/models/assets/arenas/*.xml", "robosuite/models/assets/objects/*.xml"),
    "gymnasium-robotics": (
        "**/assets/fetch/*.xml",
        "**/assets/hand/*.xml",
        "**/assets/adroit_hand/adroit_*.xml",
        "**/assets/kitchen_franka/kitchen_assets/kitchen_env_model.xml",
    ),
    "pybullet_data": ("pybullet_data/**/*.urdf", "pybullet_data/**/*.sdf", "pybullet_data/mjcf/*.xml"),
}
"""Files of each package that are rooms, or things; those that are robots by themselves are not asked again."""
ONE_OF_MANY = re.compile(r"random_urdfs/\d*[1-9]\d{0,1}/")
"""Of a thousand things alike, each hundredth is asked."""
NO_ROBOT = re.compile(
    r"random_urdfs|plane|objects/|toys|lego|domino|jenga|tray|table|cube|sphere|/[a-z_]*_assets\.xml|adroit_assets"
    r"|pendulum|cartpole|ground|capsule|cylinder|hello|reacher|swimmer|block|xarm/(link|base)"
)
MOVING = re.compile(rb'type="(revolute|continuous|prismatic)"|<joint\b|<include\b')
LEAST_JOINTS = 3
"""A document with fewer joints is no robot, unless it includes others."""
LETTERS = 160
"""Of a reason in the table."""


def robots(package: str, folder: Path) -> list[Path]:
    """The robots of a package."""
    found = {path for pattern in PATTERNS[package] for path in folder.glob(pattern)}
    return sorted(
        path
        for path in found
        if not NO_ROBOT.search(path.relative_to(folder).as_posix())
        and (len(MOVING.findall(path.read_bytes())) >= LEAST_JOINTS or b"<include" in path.read_bytes())
    )


def rooms(package: str, folder: Path) -> list[Path]:
    """The rooms and things of a package."""
    found = {path for pattern in ROOMS.get(package, ()) for path in folder.glob(pattern)}
    alone = {*robots(package, folder)} if package == "pybullet_data" else set()
    return sorted(path for path in found - alone if not ONE_OF_MANY.search(path.relative_to(folder).as_posix()))


def loaded(model: str) -> dict[str, Any]:
    """What becomes of a room, or a thing."""
    from taskgist.errors import InputError
    from taskgist.world.scene import Scene

    with tempfile.TemporaryDirectory() as folder:
        scene_file = Path(folder) / "room.toml"
        scene_file.write_text(f"[scene]\nmodel = {json.dumps(model)}\n", encoding="utf-8")
        try:
            scene = Scene.load(scene_file)
        except InputError as error:
            return {"loads": False, "why": _without(str(error).replace(f"{scene_file}: ", ""), model)}
    return {"loads": True, "objects": list(scene.objects)}


def looked_at(model: str) -> dict[str, Any]:
    """What becomes of a robot: drafted, and checked as it was drafted."""
    from taskgist.errors import InputError
    from taskgist.world.body_check import check_body
    from taskgist.world.drafting.draft import draft_profile

    try:
        draft = draft_profile(model)
    except InputError as error:
        return {"loads": False, "why": _without(str(error), model)}
    with tempfile.TemporaryDirectory() as folder:
        profile = Path(folder) / "robot.toml"
        profile.write_text(draft.text, encoding="utf-8")
        check = check_body(str(profile))
    return {
        "loads": True,
        "found": list(draft.found),
        "open": [_without(each, model) for each in draft.open],
        "problems": [_without(str(each).rpartition("robot.toml: ")[2], model) for each in check.problems],
        "doubts": list(check.doubts),
        "lacks": list(check.lacks),
    }


def _without(text: str, model: str) -> str:
    """A message without the folder of the model, and without its way out."""
    return text.replace(f"{Path(model).parent}/", "").partition(";")[0]


def in_a_process(path: Path, how: str) -> dict[str, Any]:
    """The same, by a process of its own: ``--robot`` or ``--room``."""
    command = [sys.executable, "-m", "tools.robots_page", how, str(path)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=LONGEST_S, check=False)
    except subprocess.TimeoutExpired:
        return {"loads": False, "why": f"not done after {LONGEST_S} s"}
    if done.returncode:
        last = (done.stderr.strip().splitlines() or ["no message"])[-1]
        return {"loads": False, "why": f"fails: {last}"}
    answer: dict[str, Any] = json.loads(done.stdout.strip().splitlines()[-1])
    return answer


def verdict(found: Mapping[str, Any]) -> tuple[str, str, str]:
    """Three cells: what was drafted, whether that is fit, and why not."""
    if not found["loads"]:
        return "does not load", "-", _cell(found["why"])
    parts = [_short(line) for line in found["found"][1:] if not line.startswith("no eye")]
    drafted = (
        "complete" if not found["open"] else "open: " + ", ".join(each.partition(":")[0] for each in found["open"])
    )
    fit = "not fit" if found["problems"] else "fit, doubtful" if found["doubts"] else "fit"
    asked = {each.partition(":")[0] for each in found["open"]}
    others = [each for each in found["problems"] if each.partition(":")[0] not in asked or not found["open"]]
    if found["problems"] and not others:
        fit = "fit once that is filled in"
    reasons = [*others, *found["doubts"]] or ["; ".join(parts) or "nothing that moves an eye, an arm or a leg"]
    return drafted, fit, _cell("; ".join(reasons))


def _short(line: str) -> str:
    """What was found, in fewer words."""
    what, _, rest = line.partition(" ")
    if what == "arm":
        return "arm: " + line.partition(" joints: ")[2] if " joints: " in line else line
    return f"{what} {rest.partition(',')[0]}"


def _cell(text: str) -> str:
    text = " ".join(text.split()).replace("|", "\\|").replace("<", "&lt;")
    return text if len(text) <= LETTERS else f"{text[:LETTERS]}..."


def table(folder: Path, results: Mapping[Path, Mapping[str, Any]]) -> Iterator[str]:
    """The table of a package, with a sentence before it."""
    fit = sum(bool(found["loads"] and not found["problems"]) for found in results.values())
    whole = sum(bool(found["loads"] and not found["problems"] and not found["open"]) for found in results.values())
    loads = sum(bool(found["loads"]) for found in results.values())
    yield f"Of {len(results)} models {loads} load. {fit} drafts are fit to use as they are written, {whole} of them"
    yield "with nothing open."
    yield ""
    yield from header("model", "draft", "`agent check`", "what is there, or why not")
    for path, found in results.items():
        yield row(f"`{_model(path.relative_to(folder))}`", *verdict(found))


def rooms_table(folder: Path, results: Mapping[Path, Mapping[str, Any]]) -> Iterator[str]:
    """What loads, in a sentence, and a row for each that does not."""
    good = [path for path, found in results.items() if found["loads"]]
    things = sum(bool(results[path]["objects"]) for path in good)
    rest = " The others:" if len(good) < len(results) else ""
    yield f"Of {len(results)} files {len(good)} load, {things} of them with things that move.{rest}"
    if not rest:
        return
    yield ""
    yield from header("file", "why not")
    for path, found in results.items():
        if not found["loads"]:
            yield row(f"`{'/'.join(path.relative_to(folder).parts[-2:])}`", _cell(found["why"]))


def _model(path: Path) -> str:
    """A model by the end of its path that tells it."""
    return "/".join(path.parts[-2:]) if path.stem in ("robot", "model", "reach") else path.name


def main() -> None:
    """Write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("packages", nargs="*", help="NAME=FOLDER of packages")
    parser.add_argument("--robot", help="look at one robot, and print what was found")
    parser.add_argument("--room", help="load one room, or thing, and print what was found")
    parser.add_argument("--json", type=Path, help="keep what was found")
    given = parser.parse_args()
    if given.robot or given.room:
        print(json.dumps(looked_at(given.robot) if given.robot else loaded(given.room)))
        return
    parts, kept = {}, {}
    for each in given.packages:
        package, _, where = each.partition("=")
        folder = Path(where).resolve()
        found = robots(package, folder)
        results = {path: in_a_process(path, "--robot") for path in found}
        parts[package] = list(table(folder, results))
        others = {path: in_a_process(path, "--room") for path in rooms(package, folder)}
        if others:
            parts[f"rooms of {package}"] = list(rooms_table(folder, others))
        kept[package] = {str(path.relative_to(folder)): result for path, result in results.items()}
        print(f"{package}: {len(results)} robots, {len(others)} rooms and things")
    if given.json:
        given.json.write_text(json.dumps(kept, indent=1), encoding="utf-8")
    PAGE.write_text(filled(PAGE.read_text(encoding="utf-8"), parts), encoding="utf-8")


if __name__ == "__main__":
    main()
