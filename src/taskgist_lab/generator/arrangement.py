"""An arrangement: a room that is being furnished, piece by piece, without overlaps; who is there, and what is where."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np

from taskgist.common.arrays import Array
from taskgist.errors import SceneError
from taskgist.moving.hand_pose import SIGNS
from taskgist.moving.steps import lift_m
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist_lab.generator.furnishing import (
    HIGH_M,
    LOW_M,
    STATURES_M,
    Sofa,
    any_place,
    any_seat,
    bearing_of,
    distance_m,
    on_top,
    person_at,
)
from taskgist_lab.generator.things import LARGE, SMALL, any_of, at, radius_m
from taskgist_lab.simulator.means import Roles
from taskgist_lab.simulator.places import Place
from taskgist_lab.simulator.room import Chair, Furniture, Person, Room, Table, Thing

# --- A setting: a furnished room, who acts in it for whom, and what the means needs.


@dataclass(frozen=True)
class Setting:
    """What a demonstration begins with.

    Attributes:
        room: The room with its people and things.
        roles: Who acts with what for whom.
        props: Names of what else the means needs, by the part that it plays ("occluder", "container").
        amounts: Distances in metres and the like, by name.
        places: Places that the means needs, metres, (3,) each, by name ("board").
    """

    room: Room
    roles: Roles
    props: Mapping[str, str] = field(default_factory=dict)
    amounts: Mapping[str, float] = field(default_factory=dict)
    places: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("props", "amounts", "places"):
            object.__setattr__(self, name, MappingProxyType(dict(getattr(self, name))))


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
        rng: Source of everything that is chosen.
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
        raise SceneError(f"no place for {thing.name!r}", where="room", hint="try another room")

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


# --- Bystanders: who else is in a room, at the table, standing about or on a sofa, and looks on.

BYSTANDER_TRIES = 20
FROM_PERFORMER_M, FROM_OTHERS_M = 1.05, 0.80
"""How far bystanders are from the performer, whose arms need room, and from everybody else."""
ABOUT_M, SOFA_M = (1.3, 2.2), (1.7, 2.4)
"""How far from the middle of the table somebody stands, or sits on a sofa."""
FACING_RAD = math.radians(35.0)
"""How far from the middle of the table somebody is turned who is not at it."""
HEAD_DEG = ((-55.0, 55.0), (-30.0, 15.0))
"""How far heads are turned aside and up."""
EYE_SHARE = {"sitting": 0.69, "standing": 0.936}
"""How high eyes are, as shares of the stature [Winter 2009]; sitting, over a seat of usual height."""
EMPTY_SHARE = 0.3
"""How often a chair stands about that nobody sits on."""


def add_bystanders(arrangement: Arrangement, names: Sequence[str]) -> None:
    """Put bystanders into a room as far as there is room for them, and maybe an empty chair."""
    for name in names:
        place = PLACES[str(arrangement.rng.choice(list(PLACES)))]
        for _ in range(BYSTANDER_TRIES):
            person = place(arrangement, name)
            if _has_room(arrangement, person):
                _add(arrangement, person)
                break
    _add_empty_chair(arrangement)


def _at_the_table(arrangement: Arrangement, name: str) -> Person:
    rng, table = arrangement.rng, arrangement.table
    sits = LOW_M <= table.height_m <= HIGH_M and rng.random() < 0.5
    return person_at(rng, name, any_seat(rng, table), table, "sitting" if sits else "standing", back=False)


def _standing_about(arrangement: Arrangement, name: str) -> Person:
    return _somewhere(arrangement, name, ABOUT_M)


def _on_a_sofa(arrangement: Arrangement, name: str) -> Person:
    return replace(_somewhere(arrangement, name, SOFA_M), posture="sitting", chair=False)


def _somewhere(arrangement: Arrangement, name: str, away_m: tuple[float, float]) -> Person:
    """Somebody who stands in the room and faces the table, more or less."""
    rng = arrangement.rng
    bearing, away = rng.uniform(-math.pi, math.pi), rng.uniform(*away_m)
    x, y = arrangement.table.centre_m
    place = (round(x + away * math.cos(bearing), 4), round(y + away * math.sin(bearing), 4))
    yaw = math.remainder(bearing + math.pi + rng.uniform(-FACING_RAD, FACING_RAD), math.tau)
    return Person(name, round(rng.uniform(*STATURES_M), 3), place, round(yaw, 4), "standing")


PLACES: dict[str, Callable[[Arrangement, str], Person]] = {
    "table": _at_the_table,
    "about": _standing_about,
    "sofa": _on_a_sofa,
}
"""Where bystanders are."""


def _has_room(arrangement: Arrangement, person: Person) -> bool:
    place = np.array(person.position_m)
    others = (arrangement.target, *arrangement.others)
    return distance_m(arrangement.performer, place) > FROM_PERFORMER_M and all(
        distance_m(other, place) > FROM_OTHERS_M for other in others
    )


def _add(arrangement: Arrangement, person: Person) -> None:
    """Add somebody, who looks at the performer, at the target agent or at the table, and its seat."""
    watched = arrangement.rng.integers(3)
    acting, watching = arrangement.performer, arrangement.target
    subjects = (_face(acting), _face(watching), np.array([*arrangement.table.centre_m, arrangement.table.height_m]))
    arrangement.others.append(_looking_at(person, subjects[watched]))
    if person.posture == "sitting" and not person.chair:
        arrangement.furniture.append(Sofa(f"sofa_{person.name}", person.position_m, person.yaw_rad))


def _face(person: Person) -> Array:
    return np.array([*person.position_m, EYE_SHARE[person.posture] * person.stature_m])


def _looking_at(person: Person, place: Array) -> Person:
    """Somebody with the head turned to a place (3,), as far as heads turn."""
    eye = _face(person)
    pan = math.degrees(bearing_of(person, place))
    tilt = math.degrees(math.atan2(place[2] - eye[2], float(np.linalg.norm((place - eye)[:2]))))
    head = tuple(round(float(np.clip(angle, *limits)), 1) for angle, limits in zip((pan, tilt), HEAD_DEG, strict=True))
    return replace(person, head_deg=(head[0], head[1]))


def _add_empty_chair(arrangement: Arrangement) -> None:
    """Maybe let a chair stand about."""
    if arrangement.rng.random() > EMPTY_SHARE:
        return
    chair = _somewhere(arrangement, "", ABOUT_M)
    if _has_room(arrangement, chair):
        arrangement.furniture.append(Chair("empty_chair", chair.position_m, chair.yaw_rad))


# --- Zones: where things are handy for somebody, or far from somebody, as conditions on places.

HANDY_SHARE = 0.48
"""How far from a pelvis things are taken without effort, as a share of the stature."""
OFF_M = 0.18
"""How far off somebody's way to a thing others stand."""
HANDY_RAD = math.radians(55.0)
"""How far aside of where somebody faces."""


def handy(person: Person, *, share: float = HANDY_SHARE, aside_rad: float = HANDY_RAD) -> Where:
    """Within the reach of somebody's arms, nearly without leaning."""

    def where(place: Array) -> bool:
        near = distance_m(person, place) <= share * person.stature_m
        return near and abs(bearing_of(person, place)) <= aside_rad

    return where


def apart(person: Person, least_m: float, most_m: float = math.inf) -> Where:
    """So far from somebody's pelvis."""
    return lambda place: least_m <= distance_m(person, place) <= most_m


def nearer_to(person: Person, other: Person, *, by_m: float = 0.0) -> Where:
    """So much nearer to somebody's pelvis than to another's, at least."""
    return lambda place: distance_m(person, place) + by_m <= distance_m(other, place)


def both(*conditions: Where) -> Where:
    """Where all of some conditions hold."""
    return lambda place: all(where(place) for where in conditions)


def off_the_way(person: Person, *things: Thing, least_m: float = OFF_M) -> Where:
    """Off the straight ways, over the floor, from somebody to some things: out of the way of arms, or of sight."""

    def where(place: Array) -> bool:
        return all(_off_m(place, person, thing) > least_m for thing in things)

    return where


def _off_m(place: Array, person: Person, thing: Thing) -> float:
    """Distance of a place from the straight way to a thing."""
    start, way = np.array(person.position_m), np.array(thing.position_m[:2]) - person.position_m
    share = np.clip((place[:2] - start) @ way / max(float(way @ way), 1e-9), 0.0, 1.0)
    return float(np.linalg.norm(place[:2] - start - share * way))


# --- Places at which something is held, let go or put, as a performer picks them.

FARTHEST_EDGE_M = 1.2
LIFTED_M = 0.10
"""How far above where it stands something is held, at least."""
DISTRACTORS, WATCHES = 5, 0.3
"""Most other things, and how often the target agent looks at the thing in the beginning."""


def thing_at_hand(arrangement: Arrangement, thing: Thing | None = None, *, distractors: int = DISTRACTORS) -> Setting:
    """Put something handy for the performer on the table, and others around it.

    Args:
        arrangement: The room.
        thing: What is acted on; None: any small thing.
        distractors: How many others, at most.

    Returns:
        The room as it is then, with who acts on the thing.
    """
    rng = arrangement.rng
    put = arrangement.put(thing or any_of(rng, SMALL), handy(arrangement.performer))
    arrangement.add_distractors(distractors, where=off_the_way(arrangement.performer, put))
    return arrangement.setting(arrangement.roles(put, arrangement.hand_for(put), watches=WATCHES))


def free_place(arrangement: Arrangement, where: Where, *, radius_m: float) -> Array:
    """A place (3,) on the table with nothing around it.

    Raises:
        SceneError: There is none.
    """
    table = arrangement.table
    for _ in range(TRIES):
        place = any_place(table, arrangement.rng, radius_m + EDGE_M)
        if on_top(table, place, radius_m + EDGE_M) and arrangement.free(place, radius_m) and where(place):
            return place
    raise SceneError("no free place on the table", where="room", hint="try another room")


def to_the_edge_m(person: Person, table: Table) -> float:
    """How far the edge of a table is before somebody."""
    ahead = np.array([math.cos(person.yaw_rad), math.sin(person.yaw_rad)])
    away = np.arange(0.0, FARTHEST_EDGE_M, 0.01)
    on = [on_top(table, np.array(person.position_m) + each * ahead, 0.0) for each in away]
    return float(away[on.index(True)]) if any(on) else FARTHEST_EDGE_M


def beside(person: Person, side: str, *, aside_m: float, ahead_m: float) -> tuple[float, float]:
    """A floor point beside somebody, metres, (2,).

    Args:
        person: Who.
        side: On the side of which hand.
        aside_m: How far from the pelvis to that side.
        ahead_m: How far before it.
    """
    cos, sin = math.cos(person.yaw_rad), math.sin(person.yaw_rad)
    left = -SIGNS[side] * aside_m
    x, y = person.position_m
    return x + ahead_m * cos - left * sin, y + ahead_m * sin + left * cos


def before_chest(scene: Scene, roles: Roles, *, before_m: float, below_m: float) -> Place:
    """Where the performer holds the thing before its chest, on the side of the hand, metres, (3,).

    Args:
        scene: The scene, in which the thing stands somewhere.
        roles: Who holds what, in which hand.
        before_m: How far ahead of the shoulders.
        below_m: How far below them; but it is always held above the table.
    """
    stage, agent = Stage(scene), scene.agent(roles.performer)
    shoulder, both = stage.shoulder(agent.arm(roles.side)), [stage.shoulder(arm).position for arm in agent.arms]
    x, y, z = (shoulder.position + np.mean(both, axis=0)) / 2 + before_m * shoulder.matrix[:, 0]
    return lifted(stage, roles.thing, (float(x), float(y), float(z) - below_m))


def lifted(stage: Stage, thing: str, place: Place) -> Place:
    """A place for the middle of a thing, (3,), raised until it is clear of its support and of what stands beneath."""
    stands, there = stage.body_position(stage.scene.object_body(thing)), np.array(place)
    clear = max(LIFTED_M, lift_m(stage, thing, start=there, end=there))
    return place[0], place[1], max(place[2], float(stands[2]) + clear)
