"""Ordinary rooms as values: walls and furniture, people, and things in their places."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import mujoco

from taskgist.world.scene import Scene
from taskgist.world.scene_file import AgentEntry
from taskgist_lab.ordinary.furniture import Piece, Point, Spot
from taskgist_lab.simulator.room import Person, Thing, agent_entry

LENGTH_M, WIDTH_M, SECOND_M = 7.0, 6.0, 2.6
"""Size of the living room, and breadth of the room beside it."""


@dataclass(frozen=True)
class Placed:
    """A thing in its place.

    Attributes:
        thing: The thing.
        kind: Its kind, of ``KINDS``.
        spot: On which spot it lies.
        piece: Of which piece of furniture; None: on the floor.
    """

    thing: Thing
    kind: str
    spot: Spot
    piece: Piece | None

    @property
    def middle_m(self) -> tuple[float, float, float]:
        """Its middle, (3,)."""
        x, y, z = self.thing.position_m
        return x, y, z + self.thing.height_m / 2


@dataclass(frozen=True)
class FurnishedRoom:
    """A furnished room with people and things.

    Attributes:
        name: Its name.
        pieces: Walls and furniture.
        people: Who is there.
        placed: Things in their places.
        seats: The piece that each person sits on, by the person's name.
        door: Whether there is a way to the second room.
    """

    name: str
    pieces: tuple[Piece, ...]
    people: tuple[Person, ...]
    placed: tuple[Placed, ...]
    seats: Mapping[str, Piece]
    door: bool = True

    def scene(self) -> Scene:
        """The room as a scene with everybody at rest."""
        things = [each.thing for each in self.placed]
        return scene_of(self.name, self.pieces, things, map(agent_entry, self.people))


def scene_of(
    name: str,
    pieces: Iterable[Piece],
    things: Iterable[Thing],
    agents: Iterable[AgentEntry],
    *,
    floor_m: tuple[float, float] = (10.0, 10.0),
) -> Scene:
    """A scene of furniture, things and agents on a floor.

    Args:
        name: Its name.
        pieces: Furniture.
        things: Objects.
        agents: Who is there.
        floor_m: Half of the floor's size; its middle is the origin.
    """
    room = mujoco.MjSpec()
    room.modelname = name
    room.worldbody.add_geom(name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=(*floor_m, 0.1))
    room.worldbody.add_light(pos=(0.0, 0.0, 3.0))
    for piece in pieces:
        piece.add_to(room)
    for thing in things:
        thing.add_to(room)
    return Scene.from_spec(room, agents, name=name)


def distance_m(piece: Piece, place: Point, *, over_m: float = 0.03, below_m: float = 1.9) -> float:
    """How far a floor point is from what of a piece stands between two heights; 0 within."""
    x, y = piece.local(*place)
    gaps = [
        math.hypot(
            max(abs(x - box.centre_m[0]) - box.size_m[0] / 2, 0.0),
            max(abs(y - box.centre_m[1]) - box.size_m[1] / 2, 0.0),
        )
        for box in piece.boxes
        if box.top_m > over_m and box.under_m < below_m
    ]
    return min(gaps, default=math.inf)
