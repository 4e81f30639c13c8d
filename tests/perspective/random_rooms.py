"""Furnished rooms at random: people and robots at tables and shelves, things of every shape, on, in and behind.

A case is a room in a state: hands hold things, and some of it may not have been tracked. The same seed gives the same
case.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from taskgist.world import Posture, Scene, Stage, State
from tools.rooms import Person, Room, Shape, Thing, chair, table

Generator = np.random.Generator
IMAGES_PX = ((32, 24), (48, 36), (64, 48))
LARGE = 6.0
"""Some things are so much larger than others: large enough to stand in, or to hide a room."""
ROBOTS = ("jido", "hrp2")
OCTAHEDRON = tuple(
    tuple(sign * float(i == axis) for i in range(3)) for axis in range(3) for sign in (-1, 1)
)  # fmt: skip
WEDGE = tuple(itertools.product((-1, 1), (-1, 1), (-1,))) + ((-1, -1, 1), (-1, 1, 1))


@dataclass(frozen=True, eq=False)
class Case:
    """A furnished room in a state."""

    seed: int
    scene: Scene
    state: State

    def stage(self) -> Stage:
        return Stage(self.scene, self.state)


def random_case(
    seed: int, *, image_px: tuple[int, int] | None = None, untracked: bool = True, large: bool = True
) -> Case:
    """A room with 2–4 people and 3–8 objects.

    Args:
        seed: Which one.
        image_px: Size of everybody's image; a small one at random if left out.
        untracked: Whether something may not have been tracked.
        large: Whether some things may be so large that people stand in them.
    """
    rng = np.random.default_rng(seed)
    room = _room(rng, image_px or IMAGES_PX[rng.integers(len(IMAGES_PX))], LARGE if large else 1.0)
    scene = room.scene()
    state = _with_held(scene, rng)
    return Case(seed, scene, _with_untracked(scene, state, rng) if untracked else state)


def _room(rng: Generator, image_px: tuple[int, int], largest: float) -> Room:
    people = tuple(_person(rng, number) for number in range(rng.integers(2, 5)))
    seats = tuple(
        _named(chair(*person.place, height=rng.uniform(0.38, 0.5)), f"chair {person.name}")
        for person in people
        if person.posture == "sitting"
    )
    furniture = tuple(_furniture(rng))
    objects = tuple(_object(rng, number, furniture, largest) for number in range(rng.integers(3, 9)))
    return Room((*seats, *furniture, *objects), people, image_px)


# people ------------------------------------------------------------------------------------------------------


def _person(rng: Generator, number: int) -> Person:
    """All round a table in the middle, looking more or less at it; P1 at its near side."""
    angle = math.pi + (0.0 if number == 0 else number * 1.5 + rng.uniform(-0.4, 0.4))
    away = rng.uniform(0.55, 1.3)
    place = (0.9 + away * math.cos(angle), away * math.sin(angle))
    yaw = math.atan2(-place[1], 0.9 - place[0]) + rng.uniform(-0.6, 0.6)
    if rng.random() < 0.15:
        return Person(f"P{number + 1}", place, yaw, profile=ROBOTS[rng.integers(len(ROBOTS))])
    posture: Posture = "sitting" if rng.random() < 0.4 else "standing"
    return Person(f"P{number + 1}", place, yaw, posture, tuple(_joints(rng)), round(rng.uniform(1.2, 1.95), 2))


def _joints(rng: Generator) -> Iterator[tuple[str, float]]:
    yield "head_pan", rng.uniform(-60, 60)
    yield "head_tilt", rng.uniform(-30, 20)
    if rng.random() < 0.5:
        yield "torso_turn", rng.uniform(-30, 30)
        yield "torso_lean", rng.uniform(0, 25)
    for side in ("left", "right"):
        yield f"{side}_shoulder_flexion", rng.uniform(0, 80)
        yield f"{side}_elbow", rng.uniform(0, 100)


# furniture ---------------------------------------------------------------------------------------------------


def _furniture(rng: Generator) -> Iterator[Thing]:
    yield table(0.9 + rng.uniform(-0.1, 0.1), rng.uniform(-0.1, 0.1), rng.uniform(0.6, 0.85))
    if rng.random() < 0.6:
        yield _shelf(rng)
    if rng.random() < 0.5:
        yield _screen(rng, 0)
    if rng.random() < 0.3:
        yield Thing(
            "wall", (0.03, rng.uniform(0.3, 2.0), 1.2), (rng.uniform(1.2, 2.2), rng.uniform(-1, 1), 1.2), free=False
        )
    if rng.random() < 0.5:
        yield _named(chair(rng.uniform(-1.2, 0.4), rng.uniform(-1.0, 1.0), rng.uniform(0.2, 0.8)), "stool")
    if rng.random() < 0.2:
        yield Thing(
            "lamp", (0.15,), (rng.uniform(-0.3, 1), rng.uniform(-0.5, 0.5), rng.uniform(1.5, 2.1)), "sphere", free=False
        )


def _shelf(rng: Generator) -> Thing:
    """Three boards between two sides, with a back."""
    half_width, half_depth = rng.uniform(0.25, 0.5), rng.uniform(0.12, 0.2)
    boards = tuple(Shape("box", (half_depth, half_width, 0.01), (0.0, 0.0, z)) for z in (0.4, 0.9, 1.4))
    sides = tuple(Shape("box", (half_depth, 0.01, 0.75), (0.0, sign * half_width, 0.75)) for sign in (-1, 1))
    back = Shape("box", (0.01, half_width, 0.75), (half_depth, 0.0, 0.75))
    place = (rng.uniform(0.3, 1.6), rng.choice((-1, 1)) * rng.uniform(0.9, 1.3), 0.0)
    return Thing("shelf", (), place, yaw=rng.uniform(-3, 3), free=False, shapes=(*boards, *sides, back))


def _screen(rng: Generator, number: int) -> Thing:
    place = (rng.uniform(0.4, 0.9), rng.uniform(-0.5, 0.5), rng.uniform(0.8, 1.4))
    return Thing(f"screen {number}", (0.02, *rng.uniform(0.1, 0.4, 2)), place, yaw=rng.uniform(-1, 1), free=False)


def _named(thing: Thing, name: str) -> Thing:
    return Thing(name, thing.size, thing.place, thing.kind, thing.yaw, thing.free)


# objects -----------------------------------------------------------------------------------------------------


def _object(rng: Generator, number: int, furniture: tuple[Thing, ...], largest: float) -> Thing:
    kinds = ("box", "sphere", "cylinder", "capsule", "ellipsoid", "mug", "bin", "mesh")
    kind = kinds[rng.integers(len(kinds))]
    scale = largest if rng.random() < 0.05 else 1.0
    name, half = f"{kind} {number}", tuple(scale * rng.uniform(0.02, 0.09, 3))
    place = _place(rng, half[2], furniture)
    yaw, roll = rng.uniform(-3, 3), rng.uniform(-3, 3) if rng.random() < 0.25 else 0.0
    build = {"mug": _mug, "bin": _bin, "mesh": _mesh}.get(kind)
    if build is not None:
        return Thing(name, (), place, yaw=yaw, roll=roll, shapes=build(half, rng))
    sizes = {"sphere": half[:1], "cylinder": half[:2], "capsule": half[:2]}
    return Thing(name, sizes.get(kind, half), place, kind, yaw, roll=roll)


def _place(rng: Generator, half_height: float, furniture: tuple[Thing, ...]) -> tuple[float, float, float]:
    """On the table, on a board of the shelf, on the floor or in the air."""
    where = rng.random()
    desk, shelf = furniture[0], next((each for each in furniture if each.name == "shelf"), None)
    if where < 0.5:
        x, y = desk.place[0] + rng.uniform(-0.35, 0.35), desk.place[1] + rng.uniform(-0.5, 0.5)
        return x, y, desk.place[2] + desk.size[2] + half_height
    if where < 0.65 and shelf is not None:
        board = shelf.shapes[rng.integers(3)]
        return shelf.place[0], shelf.place[1], board.at[2] + board.size[2] + half_height
    if where < 0.75:
        return rng.uniform(-0.5, 1.8), rng.uniform(-1.0, 1.0), half_height
    return rng.uniform(-0.2, 2.0), rng.uniform(-1.2, 1.2), rng.uniform(0.3, 2.0)


def _mug(half: tuple[float, ...], rng: Generator) -> tuple[Shape, ...]:
    """A can with a handle of three bars."""
    radius, height = rng.uniform(0.03, 0.05), half[2]
    out = radius + 0.03
    bars = (
        Shape("capsule", (0.005, 0.6 * height), (out, 0.0, 0.0)),
        *(Shape("box", (0.015, 0.005, 0.005), (radius + 0.012, 0.0, sign * 0.6 * height)) for sign in (-1, 1)),
    )
    return (Shape("cylinder", (radius, height)), *bars)


def _bin(half: tuple[float, ...], rng: Generator) -> tuple[Shape, ...]:
    """A floor and four walls."""
    (w, d), h = rng.uniform(0.06, 0.15, 2), half[2]
    walls = [Shape("box", (0.004, d, h), (sign * w, 0.0, 0.0)) for sign in (-1, 1)]
    walls += [Shape("box", (w, 0.004, h), (0.0, sign * d, 0.0)) for sign in (-1, 1)]
    return (Shape("box", (w, d, 0.004), (0.0, 0.0, -h)), *walls)


def _mesh(half: tuple[float, ...], rng: Generator) -> tuple[Shape, ...]:
    """The hull of a few points: an octahedron, a wedge, or points at random."""
    corners = (np.array(OCTAHEDRON), np.array(WEDGE), rng.uniform(-1, 1, (12, 3)))[rng.integers(3)] * half
    return (Shape("mesh", vertices=tuple(tuple(corner) for corner in corners.tolist())),)


# state -------------------------------------------------------------------------------------------------------


def _with_held(scene: Scene, rng: Generator) -> State:
    """Now and then an object is in somebody's hand."""
    state = scene.initial
    stage = Stage(scene, state)
    for name in scene.objects:
        if rng.random() < 0.12:
            agent = scene.agent(scene.agents[rng.integers(len(scene.agents))])
            palm = stage.site(agent.arms[rng.integers(len(agent.arms))].palm_site)
            wxyz = state.qpos[scene.object_slice(name)][3:]
            state = state.replace(at=scene.object_slice(name), to=(*palm.position, *wxyz))
    return state


def _with_untracked(scene: Scene, state: State, rng: Generator) -> State:
    """Now and then an object, a person or a part of one was not tracked."""
    parts = [f"{agent}/{part}" for agent in scene.agents for part in ("", *scene.parts(agent))]
    names = [*scene.objects, *(part.removesuffix("/") for part in parts)]
    lost = frozenset(name for name in names if rng.random() < 0.02)
    return State(state.qpos, state.time_s, lost, state.holding)
