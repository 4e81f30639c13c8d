"""How time and memory grow with agents, objects and pixels. Every size is measured in a process of its own."""

from __future__ import annotations

import multiprocessing
import re
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

from benchmarks.rooms import furnished
from benchmarks.scenes import everything
from benchmarks.timing import once, use_one_core

AGENTS = (1, 2, 4, 8, 16)
OBJECTS = (10, 50, 100, 200, 500)
PIXELS = ((80, 60), (160, 120), (320, 240), (640, 480))
USUAL = (2, 50, (320, 240))


@dataclass(frozen=True)
class Size:
    """A scene's size."""

    along: str
    agents: int
    objects: int
    image_px: tuple[int, int]


@dataclass(frozen=True)
class Point:
    """What a size costs.

    Attributes:
        size: Of the scene.
        load_s: Compiling the scene.
        first_s: Everything about it, for the first time.
        seconds: And again.
        memory_mib: Peak of the process beyond what it took before the scene was loaded; 0 where that is not known.
    """

    size: Size
    load_s: float
    first_s: float
    seconds: float
    memory_mib: float

    @property
    def plain(self) -> dict[str, object]:
        """Plain data, fit for JSON."""
        return asdict(self) | {"per_pair_ms": 1000 * self.seconds / self.size.agents / self.size.objects}


def points() -> Iterator[Point]:
    """Measure every size."""
    for size in sizes():
        with multiprocessing.get_context("spawn").Pool(1) as pool:
            yield pool.apply(measured, (size,))


def sizes() -> Iterator[Size]:
    """Each size along one dimension; the others as usual."""
    agents, objects, pixels = USUAL
    yield from (Size("agents", count, objects, pixels) for count in AGENTS)
    yield from (Size("objects", agents, count, pixels) for count in OBJECTS)
    yield from (Size("pixels", agents, objects, image) for image in PIXELS)


def measured(size: Size) -> Point:
    """Time and memory of one size, in this process."""
    use_one_core()
    smallest = furnished(1, 1, image_px=(8, 6))
    everything(smallest, smallest.initial)
    before = _memory_mib("VmRSS")
    _forget_peak()
    made = []
    load = once(lambda: made.append(furnished(size.agents, size.objects, image_px=size.image_px)))
    scene = made[0]
    first = once(lambda: everything(scene, scene.initial))
    again = once(lambda: everything(scene, scene.initial))
    return Point(size, load, first, again, _memory_mib("VmHWM") - before)


STATUS, PEAK = Path("/proc/self/status"), Path("/proc/self/clear_refs")


def _forget_peak() -> None:
    """The peak begins anew, as Linux has it."""
    if PEAK.exists():
        PEAK.write_text("5", encoding="ascii")


def _memory_mib(field: str) -> float:
    found = (
        re.search(rf"^{field}:\s+(\d+) kB", STATUS.read_text(encoding="ascii"), re.MULTILINE)
        if STATUS.exists()
        else None
    )
    return int(found[1]) / 1024 if found else 0.0
