"""Who can grasp what: boxes of all sizes on a table, in a bin and at an edge, for every built-in hand.

``python -m tools.grasp_page`` puts the tables into ``docs/research/grasps.md``.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from taskgist.perspective import least_effort
from taskgist.perspective.effort import NO_KNOWN_LEVEL, Effort, Grasped, GraspedByBoth
from taskgist.world import Scene, Stage
from tools.markdown import filled, header, row
from tools.rooms import Person, Room, Thing

PAGE = Path("docs/research/grasps.md")
BODIES = ("human", "pr2", "talos", "hrp2", "jido")
PLACES = ("table", "bin", "edge")
SIZES_MM = (1, 3, 10, 30, 100, 300)
"""Edges of the boxes."""
TOP_M = 0.75
"""Height of the table."""
NEAR_M: Mapping[str, float] = {"human": 0.30, "pr2": 0.45, "talos": 0.30, "hrp2": 0.30, "jido": 0.45}
"""How far in front of a body the table begins."""
INSET_M = 0.08
"""How far from the table's edge a box begins that is not at the edge."""
WALL_M, DEEP_M, WIDE_M = 0.01, 0.20, 0.46
"""Thickness of a bin's walls, how high these are, and how far they are apart."""
OUT = 1 / 3
"""What share of a box at the edge sticks out."""
AWAY_M = 50.0
"""Where boxes are that are not asked for."""
ONE, TILTED, SLID, DRAWN, BOTH, NONE = "1", "t", "s", "d", "2", "·"


@dataclass(frozen=True)
class Box:
    """A box that lies somewhere: height, and what of it goes across and away from who stands before it, millimetres."""

    height_mm: int
    across_mm: int
    away_mm: int

    @property
    def name(self) -> str:
        """As an object is called."""
        return f"box_{self.height_mm}_{self.across_mm}_{self.away_mm}"

    @property
    def half_m(self) -> tuple[float, float, float]:
        """Half sizes, away, across and upwards."""
        return self.away_mm / 2000, self.across_mm / 2000, self.height_mm / 2000


class Sweep:
    """Boxes of some sizes before a body, of which one after the other is asked for.

    Args:
        body: Profile of the agent.
        place: Where a box lies: ``table``, ``bin`` or ``edge``.
        sizes_mm: Edges of the boxes.
    """

    def __init__(self, body: str, place: str, sizes_mm: tuple[int, ...] = SIZES_MM) -> None:
        self.boxes = [Box(*edges) for edges in itertools.product(sizes_mm, repeat=3)]
        self._place, self._near_m = place, NEAR_M[body]
        things = [
            Thing(box.name, box.half_m, (AWAY_M, 2.0 * number, 1.0 + box.half_m[2]))
            for number, box in enumerate(self.boxes)
        ]
        half = (0.35, 0.6, 0.02)
        table = Thing("table", half, (self._near_m + half[0], 0.0, TOP_M - half[2]), free=False)
        room = Room((*things, table, *self._bin()), (Person("P", (0.0, 0.0), profile=body),))
        with TemporaryDirectory() as folder:
            for name, content in room.files().items():
                Path(folder, name).write_bytes(content)
            self._scene = Scene.load(Path(folder, "scene.toml"))

    def _bin(self) -> Iterator[Thing]:
        if self._place != "bin":
            return
        half, middle = WIDE_M / 2 + WALL_M, self._near_m + WALL_M + WIDE_M / 2
        for axis, side in itertools.product((0, 1), (-1, 1)):
            size = [half, half, DEEP_M / 2]
            at = [middle, 0.0, TOP_M + DEEP_M / 2]
            size[axis] = WALL_M / 2
            at[axis] += side * (WIDE_M + WALL_M) / 2
            yield Thing(f"wall_{axis}_{side}", (size[0], size[1], size[2]), (at[0], at[1], at[2]), free=False)

    def effort(self, box: Box) -> Effort:
        """The least effort to grasp a box."""
        half, scene = box.half_m, self._scene
        from_edge_m = {"table": INSET_M + half[0], "bin": WALL_M + WIDE_M / 2, "edge": half[0] * (1 - 2 * OUT)}
        place = (self._near_m + from_edge_m[self._place], 0.0, TOP_M + half[2])
        state = scene.initial.replace(at=scene.object_slice(box.name), to=(*place, 1.0, 0.0, 0.0, 0.0))
        return least_effort(Stage(scene, state), "P", box.name, "grasp")


def symbol(effort: Effort) -> str:
    """How an object is grasped, in one letter."""
    if effort.level == NO_KNOWN_LEVEL:
        return NONE
    found = effort.evidence.attained
    if isinstance(found, GraspedByBoth):
        return BOTH
    assert isinstance(found, Grasped)
    return {"": ONE, "tilted": TILTED, "slid over the edge": SLID, "drawn aside": DRAWN}[found.prepared]


def table(body: str, place: str, sizes_mm: tuple[int, ...] = SIZES_MM) -> Iterator[str]:
    """How a body grasps boxes that lie in a place: a row for each base, a column for each height."""
    sweep = Sweep(body, place, sizes_mm)
    yield from header("across × away, mm", *(f"{size} high" for size in sizes_mm))
    for across, away in itertools.product(sizes_mm, repeat=2):
        boxes = [box for box in sweep.boxes if (box.across_mm, box.away_mm) == (across, away)]
        yield row(f"{across} × {away}", *(symbol(sweep.effort(box)) for box in boxes))


def main() -> None:
    """Fill the page."""
    parts = {f"{body} {place}": table(body, place) for body in BODIES for place in PLACES}
    PAGE.write_text(filled(PAGE.read_text(encoding="utf-8"), parts), encoding="utf-8")


if __name__ == "__main__":
    main()
