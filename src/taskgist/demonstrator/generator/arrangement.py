"""An arrangement: a room that is being furnished, piece by piece, without overlaps."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from taskgist.demonstrator.furniture import Table, Thing
from taskgist.demonstrator.generator.furnishing import any_place, on_top
from taskgist.demonstrator.generator.people import bearing_of
from taskgist.demonstrator.generator.setting import Setting
from taskgist.demonstrator.generator.things import LARGE, SMALL, any_of, at, radius_m
from taskgist.demonstrator.means import Roles
from taskgist.demonstrator.room import Furniture, Person, Room
from taskgist.errors import SceneError

Array = NDArray[np.float64]
Where = Callable[[Array], bool]

TRIES = 200
"""Places that are tried for a thing."""
EDGE_M, GAP_M = 0.03, 0.05
"""How far inside the edge of a table things stand, and from each other, at least."""
LEVEL_M = 0.3
"""Things that stand so much higher or lower are not in each other's way."""
ASKEW_RAD = 0.35
"""How far things are turned that stand across the line between two people."""
EITHER_HAND_RAD = 0.3
"""Within this angle from straight ahead people use either hand."""


def anywhere(_place: Array) -> bool:
    """Accept any place."""
    return True


@dataclass
class Arrangement:
    """A room in the making.

    Attributes:
        rng: Source of everything that is drawn.
        table: The table that people are at.
        performer: Who will act.
        target: For whom.
        others: Bystanders.
        furniture: What stands there besides.
        things: What lies on things, in the order in which it was put there.
    """

    rng: np.random.Generator
    table: Table
    performer: Person
    target: Person
    others: list[Person] = field(default_factory=list)
    furniture: list[Furniture] = field(default_factory=list)
    things: list[Thing] = field(default_factory=list)

    def put(self, thing: Thing, where: Where = anywhere, *, yaw_rad: float | None = None) -> Thing:
        """Put a thing on the table, at a free place.

        Args:
            thing: The thing.
            where: Whether a place (3,) will do.
            yaw_rad: Its heading; None: any.

        Returns:
            The thing where it is, under a name of its own.

        Raises:
            SceneError: There is no such place.
        """
        table, radius = self.table, radius_m(thing)
        for _ in range(TRIES):
            place = any_place(table, self.rng, radius + EDGE_M)
            if on_top(table, place, radius + EDGE_M) and self.free(place, radius) and where(place):
                return self.put_at(thing, place, yaw_rad=yaw_rad)
        raise SceneError(f"no place for {thing.name!r}", where="room", hint="draw another room")

    def put_at(self, thing: Thing, place: Array, *, yaw_rad: float | None = None) -> Thing:
        """Put a thing at a place (3,), whatever is there."""
        yaw = self.rng.uniform(-np.pi, np.pi) if yaw_rad is None else yaw_rad
        laid = at(replace(thing, name=self._free_name(thing.name)), place, yaw)
        self.things.append(laid)
        return laid

    def free(self, place: Array, radius: float) -> bool:
        """Whether a circle around a place is clear of all things."""
        gaps = (
            np.linalg.norm(place[:2] - np.array(other.position_m[:2])) - radius - radius_m(other)
            for other in self.things
            if abs(other.position_m[2] - place[2]) < LEVEL_M
        )
        return all(gap > GAP_M for gap in gaps)

    def add_distractors(self, most: int, *, where: Where = anywhere) -> None:
        """Put some other things on the table, as many as there is room for."""
        for _ in range(int(self.rng.integers(1, most + 1))):
            thing = any_of(self.rng, {**SMALL, **LARGE})
            try:
                self.put(thing, where)
            except SceneError:
                return

    def replaced(self, thing: Thing, by: Thing) -> Thing:
        """Put another thing in the place of one."""
        self.things[self.things.index(thing)] = by
        return by

    def hand_for(self, *things: Thing) -> str:
        """The performer's hand that is nearer to some things; straight ahead it is either one."""
        bearing = float(np.mean([bearing_of(self.performer, np.array(thing.position_m)) for thing in things]))
        if abs(bearing) < EITHER_HAND_RAD:
            return str(self.rng.choice(("left", "right")))
        return "left" if bearing > 0 else "right"

    def hand_past(self, obstacle: Thing, thing: Thing) -> str:
        """The performer's hand that gets to a thing without passing over an obstacle beside the way."""
        aside, ahead = (bearing_of(self.performer, np.array(each.position_m)) for each in (obstacle, thing))
        return "right" if aside > ahead else "left"

    def roles(self, thing: Thing, side: str, *, watches: float) -> Roles:
        """Who acts with what for whom.

        Args:
            thing: The thing that it is all about.
            side: The acting hand.
            watches: How often the target agent looks at that thing in the beginning; else it looks at the performer's
                face or at some other thing.
        """
        return Roles(self.performer.name, self.target.name, thing.name, side, self._watched(thing.name, watches))

    def _watched(self, thing: str, watches: float) -> str | None:
        others = [each.name for each in self.things if each.name != thing]
        share = self.rng.random()
        if share < watches:
            return thing
        return str(self.rng.choice(others)) if others and share < (1 + watches) / 2 else None

    def setting(
        self,
        roles: Roles,
        *,
        props: Mapping[str, str] | None = None,
        amounts: Mapping[str, float] | None = None,
        places: Mapping[str, tuple[float, float, float]] | None = None,
    ) -> Setting:
        """The finished room, with who acts in it."""
        people = sorted((self.performer, self.target, *self.others), key=lambda person: person.name)
        room = Room("room", tuple(people), tuple(self.things), self.table, tuple(self.furniture))
        return Setting(room, roles, props or {}, amounts or {}, places or {})

    def _free_name(self, name: str) -> str:
        taken = {thing.name for thing in self.things}
        return next(each for each in (name, *(f"{name}_{n}" for n in range(2, 99))) if each not in taken)


def across(arrangement: Arrangement) -> float:
    """A heading in which what is wide stands across the line between the two people."""
    acting, watching = arrangement.performer, arrangement.target
    x, y = np.array(watching.position_m) - np.array(acting.position_m)
    return float(np.arctan2(y, x) + arrangement.rng.uniform(-ASKEW_RAD, ASKEW_RAD))
