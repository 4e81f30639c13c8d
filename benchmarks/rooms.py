"""Rooms to measure in: people around tables, things of all shapes on tables and shelves. Any size, by number."""

from __future__ import annotations

import math

import numpy as np

from taskgist.world import Scene, State
from tools.rooms import Person, Room, Shape, Thing, chair

Generator = np.random.Generator
ON_A_TABLE, TABLE_M, SPACING_M = 12, (0.75, 0.45), 1.9
IMAGE_PX = (320, 240)


def furnished(agents: int, objects: int, *, image_px: tuple[int, int] = IMAGE_PX, seed: int = 0) -> Scene:
    """A scene of so many people and things; every third person sits.

    Tables stand in rows, twelve things on each, every fourth of them a shelf instead; people stand around the tables.
    """
    rng = np.random.default_rng(seed)
    count = -(-objects // ON_A_TABLE)
    places = [_spot(number, count) for number in range(count)]
    people = tuple(_person(rng, number, places) for number in range(agents))
    seats = tuple(_seat(person) for person in people if person.posture == "sitting")
    furniture = tuple(_furniture(number, place) for number, place in enumerate(places))
    things = tuple(_thing(rng, number, places[number // ON_A_TABLE]) for number in range(objects))
    return Room((*seats, *furniture, *things, *_occluders(rng, places)), people, image_px).scene()


def moved(scene: Scene, name: str, seed: int) -> State:
    """The same scene after a thing was put somewhere else, on a table or held up."""
    rng = np.random.default_rng(seed)
    state = scene.initial
    others = [other for other in scene.objects if other != name]
    x, y, z = state.qpos[scene.object_slice(others[rng.integers(len(others))])][:3]
    place = (x + rng.uniform(-0.1, 0.1), y + rng.uniform(-0.1, 0.1), z + rng.choice((0.15, 0.4)))
    return state.replace(at=scene.object_slice(name), to=(*place, 1, 0, 0, 0))


def _spot(number: int, count: int) -> tuple[float, float]:
    side = math.ceil(math.sqrt(count))
    return SPACING_M * (number % side), SPACING_M * (number // side)


def _person(rng: Generator, number: int, places: list[tuple[float, float]]) -> Person:
    x, y = places[number % len(places)]
    angle = math.pi + 2.2 * (number // len(places)) + rng.uniform(-0.2, 0.2)
    away = 0.8 + rng.uniform(0.0, 0.2)
    place = (x + away * math.cos(angle), y + away * math.sin(angle))
    yaw = math.atan2(y - place[1], x - place[0]) + rng.uniform(-0.3, 0.3)
    joints = (("head_pan", rng.uniform(-25, 25)), ("head_tilt", rng.uniform(-35, -10)))
    return Person(
        f"P{number + 1}",
        place,
        yaw,
        "sitting" if number % 3 == 2 else "standing",
        joints,
        round(rng.uniform(1.5, 1.9), 2),
    )


def _seat(person: Person) -> Thing:
    seat = chair(*person.place)
    return Thing(f"chair {person.name}", seat.size, seat.place, free=False)


def _furniture(number: int, place: tuple[float, float]) -> Thing:
    """A table with four legs; every fourth is a shelf: two boards between sides."""
    half = (TABLE_M[0] / 2 + 0.05, TABLE_M[1] / 2 + 0.15)
    shapes = [Shape("box", (*half, 0.02), (0.0, 0.0, 0.70))]
    shapes += [
        Shape("box", (0.02, 0.02, 0.34), (sx * (half[0] - 0.04), sy * (half[1] - 0.04), 0.34))
        for sx in (-1, 1)
        for sy in (-1, 1)
    ]
    if number % 4 == 3:
        shapes.append(Shape("box", (*half, 0.01), (0.0, 0.0, 1.1)))
        shapes += [Shape("box", (half[0], 0.01, 0.2), (0.0, side * half[1], 0.9)) for side in (-1, 1)]
    return Thing(f"table {number}", (), (*place, 0.0), free=False, shapes=tuple(shapes))


def _occluders(rng: Generator, places: list[tuple[float, float]]) -> tuple[Thing, ...]:
    """A screen on every second table."""
    return tuple(
        Thing(
            f"screen {n}", (0.01, 0.15, 0.12), (x + rng.uniform(-0.2, 0.2), y, 0.84), yaw=rng.uniform(-1, 1), free=False
        )
        for n, (x, y) in enumerate(places[::2])
    )


def _thing(rng: Generator, number: int, table: tuple[float, float]) -> Thing:
    column, row = number % ON_A_TABLE % 4, number % ON_A_TABLE // 4
    half = rng.uniform(0.02, 0.06, 3)
    x = table[0] + (column - 1.5) * TABLE_M[0] / 4 + rng.uniform(-0.02, 0.02)
    y = table[1] + (row - 1.0) * TABLE_M[1] / 3 + rng.uniform(-0.02, 0.02)
    kind = ("box", "cylinder", "sphere", "capsule", "ellipsoid", "mug")[number % 6]
    name, yaw = f"{kind} {number}", rng.uniform(-3, 3)
    low = {"sphere": half[0], "capsule": half[0] + half[1], "cylinder": half[1], "mug": half[2]}.get(kind, half[2])
    place = (x, y, 0.72 + float(low))
    if kind == "mug":
        return Thing(name, (), place, yaw=yaw, shapes=_mug(float(half[2])))
    sizes = {"sphere": half[:1], "capsule": half[:2], "cylinder": half[:2]}
    return Thing(name, tuple(sizes.get(kind, half)), place, kind, yaw)


def _mug(half: float) -> tuple[Shape, ...]:
    handle = Shape("capsule", (0.005, 0.6 * half), (0.065, 0.0, 0.0))
    bars = (Shape("box", (0.015, 0.005, 0.005), (0.047, 0.0, side * 0.6 * half)) for side in (-1, 1))
    return (Shape("cylinder", (0.035, half)), handle, *bars)
