"""Rooms: people, furniture and things as values that can be varied and become a scene; and the study's living room."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol

import mujoco
import numpy as np

from taskgist.world.bodies.profile import Posture
from taskgist.world.geometry.transforms import about_z
from taskgist.world.scene import Scene
from taskgist.world.scene_file import AgentEntry

Vector = tuple[float, float, float]
Colour = tuple[float, float, float, float]
"""Red, green, blue and opacity."""

# --- Furniture and small things.

OAK: Colour = (0.62, 0.45, 0.28, 1.0)
WHITE: Colour = (0.93, 0.92, 0.89, 1.0)
GREY: Colour = (0.45, 0.47, 0.50, 1.0)
SEAT_M = 0.45
"""Height of a chair's seat."""
CHAIR_M = (0.42, 0.42, 0.04)
"""Depth and width of the seat, and the thickness of its boards."""
FURNITURE_BACK_M = 0.45
"""Height of a chair's back above its seat."""
LEG_M = 0.05
"""Thickness of the legs of tables and chairs."""


@dataclass(frozen=True)
class Thing:
    """A small object that can be moved.

    Attributes:
        name: Its name.
        size_m: Full size of a box (x, y, z), or diameter and height of a cylinder.
        position_m: Where the middle of its underside is, (3,).
        yaw_rad: Heading.
        rgba: Colour.
    """

    name: str
    size_m: tuple[float, ...]
    position_m: tuple[float, float, float]
    yaw_rad: float = 0.0
    rgba: Colour = OAK

    @property
    def height_m(self) -> float:
        """Height."""
        return self.size_m[-1]

    def add_to(self, room: mujoco.MjSpec) -> None:
        """Put it into a room: a free body whose frame is in its middle."""
        x, y, z = self.position_m
        body = room.worldbody.add_body(name=self.name, pos=(x, y, z + self.height_m / 2), quat=about_z(self.yaw_rad))
        body.add_freejoint()
        self.add_shapes(body)

    def add_shapes(self, body: mujoco.MjsBody) -> None:
        """Give its body its shapes."""
        if len(self.size_m) == 3:
            kind, size = mujoco.mjtGeom.mjGEOM_BOX, [edge / 2 for edge in self.size_m]
        else:
            kind, size = mujoco.mjtGeom.mjGEOM_CYLINDER, [self.size_m[0] / 2, self.size_m[1] / 2, 0.0]
        body.add_geom(name=self.name, type=kind, size=size, rgba=self.rgba)

    def meshes(self) -> Mapping[str, bytes]:
        """The files of its meshes by name; none."""
        return {}


@dataclass(frozen=True)
class Table:
    """A table with four legs; also any other board on legs.

    Attributes:
        name: Its name.
        centre_m: Floor point beneath its middle, (2,).
        size_m: Full size (x, y) of its top, and the height of its upper face.
        yaw_rad: Heading.
        board_m: Thickness of its top.
    """

    name: str
    centre_m: tuple[float, float] = (0.0, 0.0)
    size_m: tuple[float, float, float] = (0.70, 1.40, 0.72)
    yaw_rad: float = 0.0
    board_m: float = 0.03

    @property
    def height_m(self) -> float:
        """Height of its upper face."""
        return self.size_m[2]

    def add_to(self, room: mujoco.MjSpec) -> None:
        """Put it into a room."""
        depth, width, height = self.size_m
        body = add_furniture(room, self.name, self.centre_m, self.yaw_rad)
        add_box(body, (depth, width, self.board_m), (0, 0, height - self.board_m / 2), OAK)
        _add_legs(body, depth, width, height - self.board_m)


@dataclass(frozen=True)
class Chair:
    """A chair: its name, the floor point beneath its seat, (2,), and where it faces."""

    name: str
    centre_m: tuple[float, float]
    yaw_rad: float

    def add_to(self, room: mujoco.MjSpec) -> None:
        """Put it into a room."""
        depth, width, board = CHAIR_M
        body = add_furniture(room, self.name, self.centre_m, self.yaw_rad)
        add_box(body, (depth, width, board), (0, 0, SEAT_M - board / 2), GREY)
        behind = (-(depth + board) / 2, 0, SEAT_M + FURNITURE_BACK_M / 2)
        add_box(body, (board, width, FURNITURE_BACK_M), behind, GREY)
        _add_legs(body, depth, width, SEAT_M - board)


@dataclass(frozen=True)
class Sideboard:
    """A closed cupboard at the wall: its name, the floor point beneath its middle, (2,), and where it faces."""

    name: str
    centre_m: tuple[float, float]
    yaw_rad: float

    def add_to(self, room: mujoco.MjSpec) -> None:
        """Put it into a room."""
        body = add_furniture(room, self.name, self.centre_m, self.yaw_rad)
        add_box(body, (0.40, 1.60, 0.80), (0, 0, 0.40), WHITE)


def add_furniture(room: mujoco.MjSpec, name: str, centre_m: tuple[float, float], yaw_rad: float) -> mujoco.MjsBody:
    """Add a body that does not move, its frame on the floor; its shapes are up to the caller."""
    return room.worldbody.add_body(name=name, pos=(*centre_m, 0.0), quat=about_z(yaw_rad))


def add_box(body: mujoco.MjsBody, size_m: Vector, centre_m: Vector, rgba: Colour) -> None:
    """Add a box of full size (x, y, z) to a body."""
    half = [edge / 2 for edge in size_m]
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=half, pos=centre_m, rgba=rgba)


def add_cylinder(body: mujoco.MjsBody, radius_m: float, height_m: float, centre_m: Vector, rgba: Colour) -> None:
    """Add an upright cylinder to a body."""
    size = (radius_m, height_m / 2, 0.0)
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=size, pos=centre_m, rgba=rgba)


def _add_legs(body: mujoco.MjsBody, depth_m: float, width_m: float, height_m: float) -> None:
    for x in (-1, 1):
        for y in (-1, 1):
            place = (x * (depth_m - LEG_M) / 2, y * (width_m - LEG_M) / 2, height_m / 2)
            add_box(body, (LEG_M, LEG_M, height_m), place, GREY)


LAP = {
    "shoulder_flexion": -16.0,
    "shoulder_abduction": 8.0,
    "shoulder_rotation": -15.0,
    "elbow": 88.0,
    "forearm_rotation": -55.0,
}
"""Degrees with which the hands lie in the lap, palms down."""
HANGING = {"shoulder_abduction": 8.0, "elbow": 12.0}
"""Degrees with which the arms hang."""
REST = {"sitting": LAP, "standing": HANGING}
HUMAN = "human"
SIDEBOARD_M = (0.0, 2.0)
"""Where the sideboard stands, out of everybody's way."""


@dataclass(frozen=True)
class Person:
    """Somebody in a room.

    Attributes:
        name: Name of the agent.
        stature_m: Standing height.
        position_m: Floor point beneath the pelvis, (2,).
        yaw_rad: Heading; 0 looks along x.
        posture: Sitting (a chair is put there) or standing.
        head_deg: Pan and tilt of the head at rest; who acts, or is acted for, looks where the script says.
        chair: Whether a chair is put there for somebody who sits; without it, furniture is to sit on.
        profile: What body it has: that of a person, or a robot's, which stands and has the size that it has.
    """

    name: str
    stature_m: float
    position_m: tuple[float, float]
    yaw_rad: float
    posture: Posture = "sitting"
    head_deg: tuple[float, float] = (0.0, 0.0)
    chair: bool = True
    profile: str = HUMAN


class Furniture(Protocol):
    """Something that stands in a room and is not moved."""

    def add_to(self, room: mujoco.MjSpec) -> None:
        """Put it into a room."""


@dataclass(frozen=True)
class Room:
    """A room: a table, people around it, things on it.

    Attributes:
        name: Its name.
        people: Who is there.
        things: What can be moved.
        table: The table.
        furniture: What else stands there; None: a sideboard at the wall.
    """

    name: str
    people: tuple[Person, ...]
    things: tuple[Thing, ...]
    table: Table
    furniture: tuple[Furniture, ...] | None = None

    def scene(self) -> Scene:
        """The room as a scene with everybody at rest."""
        return Scene.from_spec(self._spec(), map(agent_entry, self.people), name=self.name)

    def varied(self, rng: np.random.Generator, *, distance_m: float, angle_rad: float) -> Room:
        """The room with its people and things moved and turned at random.

        Args:
            rng: Source of the variation.
            distance_m: Largest displacement in x and in y.
            angle_rad: Largest turn.
        """
        people, things = [], []
        for person in self.people:
            dx, dy, turn = _shift(rng, distance_m, angle_rad)
            x, y = person.position_m
            people.append(replace(person, position_m=(x + dx, y + dy), yaw_rad=person.yaw_rad + turn))
        for thing in self.things:
            dx, dy, turn = _shift(rng, distance_m, angle_rad)
            x, y, z = thing.position_m
            things.append(replace(thing, position_m=(x + dx, y + dy, z), yaw_rad=thing.yaw_rad + turn))
        return replace(self, people=tuple(people), things=tuple(things))

    def _spec(self) -> mujoco.MjSpec:
        room = mujoco.MjSpec()
        room.modelname = self.name
        room.worldbody.add_geom(
            name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=(4.0, 4.0, 0.1), rgba=(0.75, 0.72, 0.68, 1.0)
        )
        room.worldbody.add_light(pos=(0.0, 0.0, 3.0))
        room.assets = {file: content for thing in self.things for file, content in thing.meshes().items()}
        for file in room.assets:
            room.add_mesh(name=Path(file).stem, file=file)
        for piece in (*self._furniture(), *self.things):
            piece.add_to(room)
        return room

    def _furniture(self) -> Iterator[Furniture]:
        yield self.table
        yield from (Sideboard("sideboard", SIDEBOARD_M, -math.pi / 2),) if self.furniture is None else self.furniture
        for person in self.people:
            if person.posture == "sitting" and person.chair:
                yield Chair(f"chair_{person.name}", person.position_m, person.yaw_rad)


def _shift(rng: np.random.Generator, distance_m: float, angle_rad: float) -> tuple[float, float, float]:
    dx, dy = rng.uniform(-distance_m, distance_m, 2)
    return float(dx), float(dy), float(rng.uniform(-angle_rad, angle_rad))


def agent_entry(person: Person) -> AgentEntry:
    """The person as an agent of a scene, to micrometres; robots rest as their profiles have it."""
    entry = AgentEntry(
        person.name,
        profile=person.profile,
        position_m=(round(person.position_m[0], 6), round(person.position_m[1], 6)),
        yaw_rad=math.radians(round(math.degrees(person.yaw_rad), 6)),
        posture=person.posture,
    )
    if person.profile != HUMAN:
        return entry
    joints = {f"{side}_{joint}": angle for side in ("left", "right") for joint, angle in REST[person.posture].items()}
    if person.head_deg != (0.0, 0.0):
        joints |= dict(zip(("head_pan", "head_tilt"), person.head_deg, strict=True))
    return replace(
        entry,
        body={"stature_m": round(person.stature_m, 4)},
        joints_rad={joint: math.radians(round(angle, 3)) for joint, angle in joints.items()},
    )


# --- What is in the living room of the study: people at a table, and things on it. Sizes are ours.

TABLE = Table("table")
HIGH_TABLE = Table("table", size_m=(*TABLE.size_m[:2], 0.92))
"""As high as a kitchen's worktop: people stand at it."""
CLOSE_M, LIVING_ROOM_BACK_M, STANDING_M = 0.67, 0.93, 0.63
"""Distances of a pelvis from the middle of the table: sitting with the thighs under it, sitting back with the knees
before it (room to stand up), standing at it."""
RED: Colour = (0.78, 0.16, 0.13, 1.0)
BLUE: Colour = (0.18, 0.32, 0.62, 1.0)
GREEN: Colour = (0.25, 0.50, 0.30, 1.0)
BLACK: Colour = (0.12, 0.12, 0.13, 1.0)
PINE: Colour = (0.85, 0.68, 0.42, 1.0)
SIZES_M: Mapping[str, tuple[tuple[float, ...], Colour]] = {
    "cup": ((0.075, 0.10), RED),
    "wooden_cube": ((0.07, 0.07, 0.07), PINE),
    "white_box": ((0.16, 0.32, 0.26), WHITE),
    "screen": ((0.06, 0.50, 0.40), OAK),
    "book": ((0.15, 0.22, 0.03), BLUE),
    "bottle": ((0.07, 0.24), GREEN),
    "tape": ((0.09, 0.03), BLACK),
}
"""Full sizes (box, or diameter and height) and colours of the things."""


def on_table(name: str, x: float, y: float, yaw_deg: float = 0.0, *, table: Table = TABLE) -> Thing:
    """One of the things, on the table.

    Args:
        name: One of ``SIZES_M``.
        x: Place across the table, metres from its middle.
        y: Place along it.
        yaw_deg: Heading.
        table: The table; its middle is that of the room.
    """
    size, rgba = SIZES_M[name]
    return Thing(name, size, (x, y, table.height_m), math.radians(yaw_deg), rgba)


def left(stature_m: float, away_m: float, y: float = 0.0, *, posture: Posture = "sitting") -> Person:
    """P1, at the left side of the table and facing it, ``away_m`` from its middle."""
    return Person("P1", stature_m, (-away_m, y), 0.0, posture)


def right(
    stature_m: float, away_m: float, y: float = 0.0, *, posture: Posture = "sitting", turned_deg: float = 0.0
) -> Person:
    """P2, at the right side, facing the table or turned from it (positive: to its left)."""
    return Person("P2", stature_m, (away_m, y), math.pi + math.radians(turned_deg), posture)
