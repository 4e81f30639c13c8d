"""Where the time goes of whole scenes, of following and of maps: the functions that take most of it themselves."""

from __future__ import annotations

import cProfile
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from types import CodeType

from benchmarks import demonstrations, maps, scenes
from benchmarks.rooms import furnished
from taskgist.perspective.scene_efforts import SceneEfforts
from taskgist.world import Stage

MOST = 12
Row = dict[str, object]


def profiles() -> dict[str, list[Row]]:
    """Function, number of calls, share of the whole time in it alone, and with all that it calls; of each work."""
    return {name: list(_rows(prepare())) for name, prepare in WORKS.items()}


def _demonstrations() -> Callable[[], None]:
    shown = [(Stage(each.scene), each) for each in demonstrations.shipped()]

    def judge() -> None:
        for stage, each in shown:
            demonstrations.both_ends(stage, each)

    return judge


def _scene() -> Callable[[], object]:
    scene = furnished(scenes.AGENTS, scenes.OBJECTS)
    return lambda: scenes.everything(scene, scene.initial)


def _following() -> Callable[[], None]:
    scene = furnished(scenes.AGENTS, scenes.OBJECTS)
    follower, states = SceneEfforts(Stage(scene)), list(scenes.frames(scene))
    follower.all()

    def follow() -> None:
        for state in states:
            scenes.follow(follower, state)

    return follow


def _maps() -> Callable[[], None]:
    stage = Stage(furnished(maps.AGENTS, maps.OBJECTS))
    return lambda: maps.all_maps(stage)


WORKS: Mapping[str, Callable[[], Callable[[], object]]] = {
    "demonstrations": _demonstrations,
    "scene": _scene,
    "following": _following,
    "maps": _maps,
}


def _rows(run: Callable[[], object]) -> Iterator[Row]:
    run()  # warm
    profile = cProfile.Profile()
    profile.runcall(run)
    entries = sorted(profile.getstats(), key=lambda entry: -entry.inlinetime)
    total = sum(entry.inlinetime for entry in entries)
    for entry in entries[:MOST]:
        yield {
            "function": _name(entry.code),
            "calls": f"{entry.callcount:,}",
            "own": entry.inlinetime / total,
            "with_calls": entry.totaltime / total,
        }


def _name(code: CodeType | str) -> str:
    """Of our own functions file and name; built-in ones have a name only."""
    return code if isinstance(code, str) else f"{Path(code.co_filename).name} {code.co_name}"
