"""Rooms: where people are, and what is around them; a value that can be varied and becomes a scene."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

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
    """

    name: str
    stature_m: float
    position_m: tuple[float, float]
    yaw_rad: float
    posture: Posture = "sitting"


@dataclass(frozen=True)
class Room:
    """A room: a table, people around it, things on it."""

    name: str
    people: tuple[Person, ...]
    things: tuple[Thing, ...]
    table: Table

    def scene(self) -> Scene:
        """The room as a scene with everybody at rest."""
        return Scene.from_bundle(
            {"scene.toml": self._toml().encode(), "room.xml": self._mjcf().encode()}, where=self.name
        )

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
        return f'<mujoco model="{self.name}"><worldbody>{"".join(bodies)}</worldbody></mujoco>'

    def _furniture(self) -> Iterable[str]:
        yield self.table.mjcf()
        yield sideboard("sideboard", SIDEBOARD_M, -math.pi / 2)
        for person in self.people:
            if person.posture == "sitting":
                yield chair(f"chair_{person.name}", person.position_m, person.yaw_rad)


def _shift(rng: np.random.Generator, distance_m: float, angle_rad: float) -> tuple[float, float, float]:
    dx, dy = rng.uniform(-distance_m, distance_m, 2)
    return float(dx), float(dy), float(rng.uniform(-angle_rad, angle_rad))


def _agent_toml(person: Person) -> str:
    joints = {f"{side}_{joint}": angle for side in ("left", "right") for joint, angle in REST[person.posture].items()}
    return "\n".join(
        (
            f"[agents.{person.name}]",
            'profile = "human"',
            f"position_m = [{person.position_m[0]:.6f}, {person.position_m[1]:.6f}]",
            f"yaw_deg = {math.degrees(person.yaw_rad):.6f}",
            f'posture = "{person.posture}"',
            f"body = {{ stature_m = {person.stature_m:.4f} }}",
            f"joints_deg = {{ {', '.join(f'{joint} = {angle:.3f}' for joint, angle in joints.items())} }}",
            "",
        )
    )
