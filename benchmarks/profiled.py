"""Where the time of a whole scene goes: the functions that take most of it themselves."""

from __future__ import annotations

import cProfile
from collections.abc import Iterator
from pathlib import Path
from types import CodeType

from benchmarks.rooms import furnished
from benchmarks.scenes import AGENTS, OBJECTS, everything

MOST = 15


def rows() -> Iterator[dict[str, object]]:
    """Function, number of calls, share of the whole time in it alone, and with all that it calls."""
    scene = furnished(AGENTS, OBJECTS)
    everything(scene, scene.initial)
    profile = cProfile.Profile()
    profile.runcall(everything, scene, scene.initial)
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
