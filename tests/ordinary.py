"""Ordinary scenes in a line each: furniture, a body, a thing; and what any person would say it takes."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, replace

import mujoco

from taskgist.perspective.effort import Ability
from taskgist.world import Scene
from taskgist.world.geometry.transforms import about_z
from taskgist.world.scene_file import AgentEntry
from taskgist_lab.ordinary.furniture import Box, Piece
from taskgist_lab.ordinary.rooms import scene_of
from taskgist_lab.ordinary.things import thing_of
from taskgist_lab.simulator.room import RED, WHITE, Colour, Thing

# --- Expected levels, as text.

BOUND = re.compile(r"(?:(?P<most><=)|(?P<least>>=))?(?P<low>[0-5])(?:\.\.(?P<high>[0-5]))?")
ANY = frozenset(range(6))


@dataclass(frozen=True)
class Expected:
    """What effort levels are right, and why the answer is wrong today; None where it is right."""

    levels: frozenset[int]
    wrong: str | None = None

    @staticmethod
    def of(text: str) -> Expected:
        """``3``, ``3..4``, ``<=2``, ``>=4``, or ``?`` for whatever; after ``!``, why it is wrong today."""
        bound, _, wrong = (part.strip() for part in text.partition("!"))
        if bound == "?":
            assert not wrong
            return Expected(ANY)
        found = BOUND.fullmatch(bound)
        assert found, text
        low = int(found["low"])
        first, last = (0, low) if found["most"] else (low, 5) if found["least"] else (low, int(found["high"] or low))
        return Expected(frozenset(range(first, last + 1)), wrong or None)


@dataclass(frozen=True)
class Line:
    """A scene in a line.

    Attributes:
        what: What it shows; names the test.
        body: Who is asked about.
        pieces: Furniture.
        thing: What is asked about, named thing.
        see: Right levels to see it; see ``Expected.of``.
        reach: The same to reach it.
        grasp: The same to grasp it.
    """

    what: str
    body: AgentEntry
    pieces: tuple[Piece, ...]
    thing: Thing
    see: str
    reach: str
    grasp: str

    def text(self, ability: Ability) -> str:
        """What is right for an ability, as it is written."""
        return {"see": self.see, "reach": self.reach, "grasp": self.grasp}[ability]

    def expected(self, ability: Ability) -> Expected:
        """What is right for an ability."""
        return Expected.of(self.text(ability))

    def scene(self) -> Scene:
        """The scene."""
        return scene_of("ordinary", self.pieces, [self.thing], [self.body])


# --- Bodies, at the origin and looking along x if not said otherwise.


def stands(x: float = 0.0, y: float = 0.0, yaw_deg: float = 0.0, *, tall: float = 1.75) -> AgentEntry:
    return AgentEntry("P", position_m=(x, y), yaw_rad=math.radians(yaw_deg), body={"stature_m": tall})


def sits(x: float = 0.0, y: float = 0.0, yaw_deg: float = 0.0, *, tall: float = 1.75) -> AgentEntry:
    return replace(stands(x, y, yaw_deg, tall=tall), posture="sitting")


def robot(profile: str, x: float = 0.0, y: float = 0.0, yaw_deg: float = 0.0) -> AgentEntry:
    return AgentEntry("P", profile=profile, position_m=(x, y), yaw_rad=math.radians(yaw_deg))


# --- Things: the middle of the underside is where it is said.


def a(kind: str, x: float, y: float, z: float = 0.0, yaw_deg: float = 0.0) -> Thing:
    """A thing of a kind that people have a word for."""
    return thing_of(kind, "thing", (x, y, z), math.radians(yaw_deg))


def block(size: tuple[float, float, float], x: float, y: float, z: float = 0.0, rgba: Colour = RED) -> Thing:
    return Thing("thing", size, (x, y, z), rgba=rgba)


def tube(diameter: float, height: float, x: float, y: float, z: float = 0.0, rgba: Colour = RED) -> Thing:
    return Thing("thing", (diameter, height), (x, y, z), rgba=rgba)


@dataclass(frozen=True)
class Ball(Thing):
    """A ball; its size is (diameter, diameter)."""

    def add_shapes(self, body: mujoco.MjsBody) -> None:
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=(self.size_m[0] / 2, 0, 0), rgba=self.rgba)


def ball(diameter: float, x: float, y: float, z: float = 0.0) -> Thing:
    return Ball("thing", (diameter, diameter), (x, y, z), rgba=RED)


@dataclass(frozen=True)
class Pen(Thing):
    """A round pen that lies along y; its size is (length, diameter)."""

    def add_shapes(self, body: mujoco.MjsBody) -> None:
        length, diameter = self.size_m
        lying = (math.sqrt(0.5), math.sqrt(0.5), 0, 0)
        size = (diameter / 2, length / 2, 0)
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_CAPSULE, size=size, quat=lying, rgba=self.rgba)


@dataclass(frozen=True)
class Mug(Thing):
    """A mug with a wall of sixteen staves, a bottom and a handle on its right; its size is (diameter, height)."""

    def add_shapes(self, body: mujoco.MjsBody) -> None:
        radius, half, thick = self.size_m[0] / 2, self.size_m[1] / 2, 0.002
        box = mujoco.mjtGeom.mjGEOM_BOX
        for number in range(16):
            turn = 2 * math.pi * number / 16
            at, size = (radius - thick) * math.cos(turn), (thick, radius * math.tan(math.pi / 16), half)
            place = (at, (radius - thick) * math.sin(turn), 0)
            body.add_geom(type=box, size=size, pos=place, quat=about_z(turn), rgba=self.rgba)
        bottom = (radius - 0.004, 0.003, 0)
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=bottom, pos=(0, 0, 0.003 - half), rgba=self.rgba)
        for z in (-0.03, 0.03):
            body.add_geom(type=box, size=(0.005, 0.016, 0.005), pos=(0, -radius - 0.016, z), rgba=self.rgba)
        body.add_geom(type=box, size=(0.005, 0.004, 0.035), pos=(0, -radius - 0.032, 0), rgba=self.rgba)


def pen(x: float, y: float, z: float = 0.0, yaw_deg: float = 0.0) -> Thing:
    return Pen("thing", (0.14, 0.008), (x, y, z), math.radians(yaw_deg), RED)


# --- Pieces that people do not call furniture.

GLASS: Colour = (0.8, 0.9, 1.0, 0.2)


def board(
    name: str,
    size: tuple[float, float, float],
    x: float,
    y: float,
    z: float,
    rgba: Colour = WHITE,
    yaw_deg: float = 0.0,
) -> Piece:
    """One box, its middle at a height."""
    return Piece(name, name, (x, y), math.radians(yaw_deg), (Box(size, (0, 0, z), rgba),))


def case(
    name: str,
    size: tuple[float, float, float],
    x: float,
    y: float,
    z: float,
    *,
    without: Iterable[str] = (),
    rgba: Colour = WHITE,
    thick: float = 0.02,
) -> Piece:
    """Six boards around a space of that size, its underside at a height.

    ``without`` leaves out some of front, back, left, right, top and bottom; the front is at the lesser x.
    """
    (dx, dy, dz), t = size, thick
    mid = z + dz / 2
    boards = {
        "bottom": Box((dx + 2 * t, dy + 2 * t, t), (0, 0, z - t / 2), rgba),
        "top": Box((dx + 2 * t, dy + 2 * t, t), (0, 0, z + dz + t / 2), rgba),
        "front": Box((t, dy, dz), (-(dx + t) / 2, 0, mid), rgba),
        "back": Box((t, dy, dz), ((dx + t) / 2, 0, mid), rgba),
        "left": Box((dx + 2 * t, t, dz), (0, (dy + t) / 2, mid), rgba),
        "right": Box((dx + 2 * t, t, dz), (0, -(dy + t) / 2, mid), rgba),
    }
    return Piece(name, name, (x, y), 0.0, tuple(box for side, box in boards.items() if side not in set(without)))


@dataclass(frozen=True)
class PlaneWall(Piece):
    """A finite plane that stands across x and faces along it, half a metre and more to each side."""

    def add_to(self, room: mujoco.MjSpec) -> None:
        quat = (math.sqrt(0.5), 0, math.sqrt(0.5), 0)
        body = room.worldbody.add_body(name=self.name, pos=(*self.centre_m, 1.6), quat=about_z(0.0))
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=(0.6, 0.6, 0.1), quat=quat)
