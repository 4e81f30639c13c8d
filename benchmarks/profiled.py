"""Where the time of a whole scene goes: the functions that take most of it themselves."""

from __future__ import annotations

import cProfile
import pstats
from collections.abc import Iterator
from pathlib import Path

from benchmarks.rooms import furnished
from benchmarks.scenes import AGENTS, OBJECTS, everything

MOST = 15


def rows() -> Iterator[dict[str, object]]:
    """Function, number of calls, share of the whole time in it alone, and with all that it calls."""
    scene = furnished(AGENTS, OBJECTS)
    everything(scene, scene.initial)
    profile = cProfile.Profile()
    profile.runcall(everything, scene, scene.initial)
    stats = pstats.Stats(profile)
    found = stats.get_stats_profile()
    total = found.total_tt
    ordered = sorted(found.func_profiles.items(), key=lambda item: -item[1].tottime)
    for name, each in ordered[:MOST]:
        yield {
            "function": f"{Path(each.file_name).name} {name}" if each.line_number else name,
            "calls": str(each.ncalls),
            "own": each.tottime / total,
            "with_calls": each.cumtime / total,
        }
