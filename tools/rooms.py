"""Rooms for tests and benchmarks: simple things that can be moved, turned and mirrored as a whole, and a coarse eye.

Their MJCF is written here and not by MuJoCo, which writes six digits: a room that is moved and one that is not would
differ by more than rounding.
"""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import chain

import numpy as np

from taskgist.settings import Efforts, Grasp, Settings
from taskgist.world import AgentEntry, Posture, Scene, Stage
from taskgist.world.bodies.profile import builtin_profile_text
from taskgist.world.scene_file import SceneFile, write_scene_file

COARSE = Settings(
    efforts=replace(
        Efforts(),
        turn_step_rad=math.radians(45),
        lean_step_rad=0.5,
        head_steps=3,
        bends=((0.0, 0.5), (0.1, 1.0)),
        leaving_step_m=0.4,
        move_radius_m=1.0,
        move_step_m=0.5,
    ),
    grasp=replace(Grasp(), approaches=4),
)
"""Fewer states, so that all of them can be tried."""
ROUGH = replace(COARSE, reach=replace(COARSE.reach, model="sector"))
"""With the paper's reach, which can be worked out point by point."""


@dataclass(frozen=True)
class Shape:
    """One shape of a thing, in the thing's frame; a mesh is the hull of its vertices."""

    kind: str
    size: tuple[float, ...] = ()
    at: tuple[float, float, float] = (0.0, 0.0, 0.0)
    vertices: tuple[tuple[float, float, float], ...] = ()

    def add_to(self, body: ET.Element, assets: ET.Element, mesh: str) -> None:
        """Add the shape to a thing's body; ``mesh`` is the name that a mesh gets."""
        geom = ET.SubElement(body, "geom", type=self.kind)
        if self.kind == "mesh":
            ET.SubElement(assets, "mesh", name=mesh, vertex=_numbers(chain.from_iterable(self.vertices)))
            geom.set("mesh", mesh)
        else:
            geom.set("size", _numbers(self.size))
        geom.set("pos", _numbers(self.at))


@dataclass(frozen=True)
class Thing:
    """A box (half sizes), a sphere, cylinder or capsule (radius, half height), or several shapes; free: an object."""

    name: str
    size: tuple[float, ...]
    place: tuple[float, float, float]
    kind: str = "box"
    yaw: float = 0.0
    free: bool = True
    shapes: tuple[Shape, ...] = ()
    roll: float = 0.0

    def add_to(self, world: ET.Element, assets: ET.Element) -> None:
        """Put the thing into a room."""
        yaw, roll = self.yaw / 2, self.roll / 2
        turn = (
            math.cos(yaw) * math.cos(roll),
            math.cos(yaw) * math.sin(roll),
            math.sin(yaw) * math.sin(roll),
            math.sin(yaw) * math.cos(roll),
        )
        body = ET.SubElement(world, "body", name=self.name, pos=_numbers(self.place), quat=_numbers(turn))
        if self.free:
            ET.SubElement(body, "freejoint")
        for number, shape in enumerate(self.shapes or (Shape(self.kind, self.size),)):
            shape.add_to(body, assets, f"{self.name} {number}")


def _numbers(values: Iterable[float]) -> str:
    return " ".join(repr(float(value)) for value in values)


@dataclass(frozen=True)
class Person:
    """Somebody, human or robot, with feet at a place."""

    name: str
    place: tuple[float, float]
    yaw: float = 0.0
    posture: Posture = "standing"
    joints_deg: tuple[tuple[str, float], ...] = ()
    stature: float = 1.75
    profile: str = "human"

    def entry(self) -> AgentEntry:
        """The agent as a scene places it."""
        return AgentEntry(
            self.name,
            profile=self.profile,
            position_m=self.place,
            yaw_rad=self.yaw,
            posture=self.posture,
            body={"stature_m": self.stature} if self.profile == "human" else {},
            joints_rad={joint: math.radians(angle) for joint, angle in self.joints_deg},
        )


@dataclass(frozen=True)
class Room:
    """Things and people, each found by its name."""

    things: tuple[Thing, ...]
    people: tuple[Person, ...]
    image_px: tuple[int, int] = (320, 240)

    def moved(self, yaw: float, x: float, y: float) -> Room:
        """The same room standing elsewhere and facing another way."""
        cos, sin = math.cos(yaw), math.sin(yaw)

        def at(px: float, py: float) -> tuple[float, float]:
            return cos * px - sin * py + x, sin * px + cos * py + y

        things = tuple(
            replace(t, place=(*at(t.place[0], t.place[1]), t.place[2]), yaw=t.yaw + yaw) for t in self.things
        )
        return replace(
            self, things=things, people=tuple(replace(p, place=at(*p.place), yaw=p.yaw + yaw) for p in self.people)
        )

    def mirrored(self) -> Room:
        """The room as a mirror along the x axis shows it."""
        things = tuple(replace(t, place=(t.place[0], -t.place[1], t.place[2]), yaw=-t.yaw) for t in self.things)
        people = tuple(replace(p, place=(p.place[0], -p.place[1]), yaw=-p.yaw) for p in self.people)
        return replace(self, things=things, people=people)

    @lru_cache(maxsize=128)  # noqa: B019 - rooms are small, and so is what is kept
    def scene(self) -> Scene:
        """The room as a scene; equal rooms have the same one, which never changes."""
        px, files = "image_px = [{}, {}]".format(*self.image_px), self.files()
        for person in self.people:
            profile = builtin_profile_text(person.profile)
            files[f"{person.name}.profile.toml"] = re.sub(r"image_px = \[.*?\]", px, profile).encode()
        return Scene.from_bundle(files)

    def files(self) -> dict[str, bytes]:
        """The room's scene file and model by their names; people have the built-in profiles."""
        model = ET.Element("mujoco")
        assets, world = ET.SubElement(model, "asset"), ET.SubElement(model, "worldbody")
        ET.SubElement(world, "geom", name="floor", type="plane", size="9 9 0.1")
        for thing in self.things:
            thing.add_to(world, assets)
        people = tuple(person.entry() for person in self.people)
        return {
            "scene.toml": write_scene_file(SceneFile("scene", "room.xml", None, (), people, "scene.toml")),
            "room.xml": ET.tostring(model),
        }

    def stage(self) -> Stage:
        """The room on a stage."""
        return Stage(self.scene())


def wall(name: str, x: float, *, half: tuple[float, float, float] = (0.02, 1.5, 1.25), y: float = 0.0) -> Thing:
    """A wall that stands across the x axis."""
    return Thing(name, half, (x, y, half[2]), free=False)


def table(x: float, y: float = 0.0, height: float = 0.72) -> Thing:
    """A table top."""
    return Thing("table", (0.4, 0.6, 0.02), (x, y, height - 0.02), free=False)


def chair(x: float, y: float = 0.0, height: float = 0.45) -> Thing:
    """Something to sit on."""
    return Thing("chair", (0.2, 0.2, height / 2), (x, y, height / 2), free=False)


def random_room(seed: int, image_px: tuple[int, int] = (64, 48)) -> Room:
    """An agent, sitting or standing, with a table, an occluder, another agent and two objects around."""
    rng = np.random.default_rng(seed)
    sits = bool(rng.integers(2))
    cup = Thing("cup", (0.03, 0.05), _place(rng, 0.5, 0.9, 0.4, 1.5), "cylinder", rng.uniform(-3, 3))
    brick = Thing("brick", (0.04, 0.03, 0.05), _place(rng, 0.3, 1.7, 0.1, 1.9), yaw=rng.uniform(-3, 3))
    screen = Thing("screen", (0.02, *rng.uniform(0.1, 0.3, 2)), _place(rng, 0.4, 0.8, 0.8, 1.2), yaw=rng.uniform(-1, 1))
    head = (("head_pan", rng.uniform(-30, 30)), ("head_tilt", rng.uniform(-20, 10)), ("torso_turn", rng.uniform(-9, 9)))
    person = Person("P1", (0.0, 0.0), rng.uniform(-0.2, 0.2), "sitting" if sits else "standing", head)
    other = Person("P2", (1.9, rng.uniform(-0.5, 0.5)), math.pi)
    things = (table(0.85, rng.uniform(-0.2, 0.2)), cup, brick, screen, *((chair(0.0),) if sits else ()))
    return Room(things, (person, other), image_px)


def _place(rng: np.random.Generator, near: float, far: float, low: float, high: float) -> tuple[float, float, float]:
    distance, side = rng.uniform(near, far), rng.uniform(-1.2, 1.2)
    return distance * math.cos(side), distance * math.sin(side), rng.uniform(low, high)
