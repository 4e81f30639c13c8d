"""Rooms: where people are, and what is around them; a value that can be varied and becomes a scene."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol

import numpy as np

from taskgist.demonstrator.furniture import Table, Thing, chair, sideboard
from taskgist.world import Posture, Scene

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

    def mjcf(self) -> str:
        """A fixed body."""


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
        texts = {"scene.toml": self._toml().encode(), "room.xml": self._mjcf().encode()}
        return Scene.from_bundle({**texts, **self._meshes()}, where=self.name)

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

    def _toml(self) -> str:
        head = f'[scene]\nname = "{self.name}"\nmodel = "room.xml"\n'
        return "\n".join((head, *(_agent_toml(person) for person in self.people)))

    def _mjcf(self) -> str:
        floor = '<geom name="floor" type="plane" size="4 4 0.1" rgba="0.75 0.72 0.68 1"/><light pos="0 0 3"/>'
        bodies = (floor, *self._furniture(), *(thing.mjcf() for thing in self.things))
        meshes = "".join(f'<mesh name="{Path(file).stem}" file="{file}"/>' for file in self._meshes())
        assets = f"<asset>{meshes}</asset>" if meshes else ""
        return f'<mujoco model="{self.name}">{assets}<worldbody>{"".join(bodies)}</worldbody></mujoco>'

    def _meshes(self) -> dict[str, bytes]:
        return {file: text for thing in self.things for file, text in thing.meshes().items()}

    def _furniture(self) -> Iterable[str]:
        yield self.table.mjcf()
        if self.furniture is None:
            yield sideboard("sideboard", SIDEBOARD_M, -math.pi / 2)
        yield from (piece.mjcf() for piece in self.furniture or ())
        for person in self.people:
            if person.posture == "sitting" and person.chair:
                yield chair(f"chair_{person.name}", person.position_m, person.yaw_rad)


def _shift(rng: np.random.Generator, distance_m: float, angle_rad: float) -> tuple[float, float, float]:
    dx, dy = rng.uniform(-distance_m, distance_m, 2)
    return float(dx), float(dy), float(rng.uniform(-angle_rad, angle_rad))


def _agent_toml(person: Person) -> str:
    return "\n".join(
        (
            f"[agents.{person.name}]",
            f'profile = "{person.profile}"',
            f"position_m = [{person.position_m[0]:.6f}, {person.position_m[1]:.6f}]",
            f"yaw_deg = {math.degrees(person.yaw_rad):.6f}",
            f'posture = "{person.posture}"',
            *(_body_toml(person) if person.profile == HUMAN else ()),
            "",
        )
    )


def _body_toml(person: Person) -> tuple[str, str]:
    """A person's size, and how it rests; robots rest as their profiles have it."""
    joints = {f"{side}_{joint}": angle for side in ("left", "right") for joint, angle in REST[person.posture].items()}
    if person.head_deg != (0.0, 0.0):
        joints |= dict(zip(("head_pan", "head_tilt"), person.head_deg, strict=True))
    angles = ", ".join(f"{joint} = {angle:.3f}" for joint, angle in joints.items())
    return f"body = {{ stature_m = {person.stature_m:.4f} }}", f"joints_deg = {{ {angles} }}"
