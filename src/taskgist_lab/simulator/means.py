"""Means: ways to reach an intention, as scripts whose places are chosen in the scene at hand."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from taskgist.common.arrays import Array
from taskgist.errors import SceneError
from taskgist.moving.body import Body
from taskgist.moving.steps import HandOver, HoldUp, LayHand, PutDown, Take, Withdraw
from taskgist.world.geometry.transforms import about_z, normalized, rotate
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist_lab.simulator.demonstration import Script, Step
from taskgist_lab.simulator.places import (
    COMFORTABLE_VIEW_M,
    GREATEST_LEAN_RAD,
    Place,
    Putting,
    before_face,
    behind,
    on_top,
)

HELD_S = 1.0
"""How long something is held up before the recording ends, at least."""

Means = Callable[[Scene], Script]


@dataclass(frozen=True)
class Roles:
    """Who does it, with what, for whom.

    Attributes:
        performer: Who acts.
        target: For whom.
        thing: The object.
        side: The acting hand.
        target_watches: What the target agent looks at in the beginning; None: the performer's face.
        target_returns_to: What it is busy with, and looks at again when the thing rests; None: nothing.
        also_for: Further target agents.
    """

    performer: str
    target: str
    thing: str
    side: str
    target_watches: str | None = None
    target_returns_to: str | None = None
    also_for: tuple[str, ...] = ()

    @property
    def targets(self) -> tuple[str, ...]:
        """All target agents."""
        return (self.target, *self.also_for)

    def script(self, task: str, means: str, *steps: Step) -> Script:
        """A script with these roles, which begins with taking the thing."""
        return Script(
            task,
            self.performer,
            self.target,
            self.thing,
            (Take(self.thing, self.side), *steps),
            self.target_watches,
            means,
            self.target_returns_to,
            self.also_for,
        )

    def putting(self, task: str, means: str, place: Callable[[Scene], Place]) -> Means:
        """Means that are a putting down of the thing at a place, which is looked for in the scene at hand."""
        return lambda scene: self.script(task, means, PutDown(place(scene)), Withdraw())


def hold_up(roles: Roles, *, distance_m: float = COMFORTABLE_VIEW_M) -> Means:
    """Show by holding up, before the target agent's face, or amid several, at a distance from the eye."""

    def script(scene: Scene) -> Script:
        place = before_face(scene, roles.performer, roles.target, roles.side, distance_m, also_for=roles.also_for)
        return roles.script("show", "held up before the face", HoldUp(place, HELD_S))

    return script


def put_on_top(roles: Roles, *, of: str) -> Means:
    """Show by putting on top of something."""
    return roles.putting("show", f"put on top of {of}", lambda scene: on_top(Stage(scene), of))


def put_behind(roles: Roles, *, occluder: str) -> Means:
    """Hide by putting behind something, as seen by the target agent."""

    def place(scene: Scene) -> Place:
        return behind(scene, roles.thing, occluder, roles.target, also_for=roles.also_for)

    return roles.putting("hide", f"put behind {occluder}", place)


# --- Nearness: places near somebody, at which a thing can be taken.
#
# As everywhere, only present positions, sizes and straight lines decide: how far a place is from the other's
# shoulders, whether something stands there, whether a straight line from the other's eye to it is free.

HAND_ROOM_M = 0.06
"""Room left for a hand between a thing and others."""
ASIDES_RAD = tuple(math.radians(degrees) for degrees in (0, 10, -10, 20, -20, 30, -30, 40, -40))
"""Directions tried, off the line between the two people."""
FARTHER_STEPS_M = (0.0, 0.02, -0.02, 0.04, -0.04, 0.06, 0.08, 0.10)
"""Offsets of the wanted distance that are tried."""
NEAR_EDGE_M = 0.06
"""Nothing is put nearer than this to the edge of a support."""
NEARNESS_AROUND_M = NEAR_EDGE_M * np.array([(0, 0, 0), (1, 1, 0), (1, -1, 0), (-1, 1, 0), (-1, -1, 0)])
BELOW_SHOULDERS_M = 0.20
"""How far below shoulders a thing is held out: before the chest."""


def near(scene: Scene, thing: str, performer: str, target: str, distance_m: float) -> Place:
    """A free place on the thing's own support, near somebody and in sight, best on the line to the performer.

    Args:
        scene: The scene.
        thing: What is put there.
        performer: Who puts it there.
        target: Near whom.
        distance_m: Wanted horizontal distance from between the target agent's shoulders.

    Returns:
        Where the middle of the thing's underside goes, metres, (3,).

    Raises:
        SceneError: No candidate is supported, free and in sight.
    """
    putting = Putting.of(scene, thing)
    place = putting.first(
        _nearness_around(putting, performer, target, distance_m),
        around=NEARNESS_AROUND_M,
        room_m=HAND_ROOM_M,
        suits=lambda place: putting.in_view(place, target),
    )
    if place is None:
        raise SceneError(
            f"no place {distance_m:g} m from {target!r} for {thing!r}",
            where=scene.name,
            field=thing,
            hint="clear the support before that agent, or take another distance",
        )
    return place


def held_out(scene: Scene, roles: Roles, taking: str, distance_m: float) -> Place:
    """A place before somebody's chest, towards the performer, where a thing is held out.

    It is as near to the wanted distance as the performer gets without leaning far; the other leans for the rest.

    Args:
        scene: The scene.
        roles: Who holds it out, with which hand, to whom.
        taking: The hand that shall take it.
        distance_m: Wanted distance from the shoulder of that hand.

    Returns:
        The place in metres, (3,).
    """
    stage, body = Stage(scene), Body(scene, roles.performer)
    shoulder = stage.shoulder(scene.agent(roles.target).arm(taking)).position
    line = _between_shoulders(stage, roles.performer) - shoulder
    length = float(np.linalg.norm(line))
    place = shoulder
    for distance in np.linspace(distance_m, max(distance_m, length / 2), 21):
        place = shoulder + distance * line / length - (0.0, 0.0, BELOW_SHOULDERS_M)
        if body.torso_for(scene.initial, roles.side, place)[1] <= GREATEST_LEAN_RAD:
            break
    return float(place[0]), float(place[1]), float(place[2])


def _between_shoulders(stage: Stage, name: str) -> Array:
    return np.asarray(np.mean([stage.shoulder(arm).position for arm in stage.scene.agent(name).arms], axis=0))


def _nearness_around(putting: Putting, performer: str, target: str, distance_m: float) -> Iterator[Array]:
    """Places around somebody, at a distance and the height of a thing, those towards the performer first."""
    start = _between_shoulders(putting.stage, target) * (1.0, 1.0, 0.0)
    ahead = normalized((_between_shoulders(putting.stage, performer) - start) * (1.0, 1.0, 0.0))
    for aside, farther in product(ASIDES_RAD, FARTHER_STEPS_M):
        yield start + (distance_m + farther) * rotate(about_z(aside), ahead) + (0.0, 0.0, putting.lies[2])


# --- Offering: means of making something accessible, and of giving it.


def put_within_reach(roles: Roles, *, distance_m: float) -> Means:
    """Make accessible by putting near the target agent, at a horizontal distance from its shoulders."""

    def place(scene: Scene) -> Place:
        return near(scene, roles.thing, roles.performer, roles.target, distance_m)

    return roles.putting("make accessible", f"put {distance_m:g} m before the shoulders", place)


def lift_onto(roles: Roles, *, of: str) -> Means:
    """Make accessible by putting on top of something that stands near the target agent, where hands are."""
    return roles.putting("make accessible", f"lifted onto {of}", lambda scene: on_top(Stage(scene), of))


def hand_over(
    roles: Roles, *, taking: str, distance_m: float, rests_m: tuple[float, float, float] | None = None
) -> Means:
    """Give by holding out, for the target agent to take it.

    Args:
        roles: Who does it.
        taking: The taking hand.
        distance_m: Distance from the taker's shoulder at which it is held out.
        rests_m: Where the taking hand lies on a table before, (3,); None: it is at rest like the other one.
    """

    def script(scene: Scene) -> Script:
        place = held_out(scene, roles, taking, distance_m)
        steps = (HoldUp(place, 0.0), HandOver(taking), Withdraw())
        plain = roles.script("give", f"handed over to the {taking} hand", *steps)
        if rests_m is None:
            return plain
        return replace(plain, steps=(LayHand(roles.target, taking, rests_m), *plain.steps))

    return script


# --- Removing: putting things where they are far from somebody, in plain view or hidden, as places and means.
#
# A demonstrator who puts something away looks for a free place that is as far off as it wishes, and takes the one
# that is least trouble: the nearest to where the thing lies. Distances over the floor and straight lines of sight are
# all it uses.

GRID_M, REMOVING_AROUND_M = 0.05, 1.0
"""Spacing of the places that are looked at, and how far around the performer."""
CROSS = np.array([(0, 0, 0), (1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0)])
EDGE_M = 0.02
"""How far inside the edge of its support a thing is put, at least."""
REMOVING_LEAN_RAD = 0.9
"""How far one leans, at most, to put something down: who stands stoops over a table anyway."""
FARTHER_M = 0.15
"""Who hides something away takes it so much farther off, at least."""


def put_far_from(roles: Roles, *, distance_m: float) -> Means:
    """Put away, in plain view, at least so far from where the target agent is (over the floor)."""
    return roles.putting(
        "put away", f"put {distance_m:g} m from {roles.target}", lambda scene: far_from(scene, roles, distance_m)
    )


def put_behind_far(roles: Roles, *, occluder: str) -> Means:
    """Hide away: put behind something that is farther from the target agent, as it sees it."""

    def place(scene: Scene) -> Place:
        found = behind(scene, roles.thing, occluder, roles.target)
        _check_farther(scene, roles, occluder, np.array(found))
        return found

    return roles.putting("hide away", f"put far off behind {occluder}", place)


def far_from(scene: Scene, roles: Roles, distance_m: float) -> Place:
    """The place nearest to a thing that is far from the target agent, in its view, and handy for the performer.

    Args:
        scene: The scene.
        roles: Who puts what away from whom, with which hand.
        distance_m: Least distance over the floor from the target agent's pelvis.

    Returns:
        Where the middle of the thing's underside goes, metres, (3,).

    Raises:
        SceneError: There is no such place.
    """
    putting, body = Putting.of(scene, roles.thing), Body(scene, roles.performer)
    places = (
        place for place in _removing_around(putting, body) if _distance_m(scene, roles.target, place) >= distance_m
    )
    place = putting.first(
        places,
        around=(putting.radius_m + EDGE_M) * CROSS,
        room_m=HAND_ROOM_M,
        suits=lambda place: (
            _handy(body, scene, roles.side, place + putting.middle) and putting.in_view(place, roles.target)
        ),
    )
    if place is None:
        raise SceneError(
            f"no free place {distance_m:g} m from {roles.target!r} that {roles.performer!r} gets to",
            where=scene.name,
            field=roles.thing,
            hint="ask for less, or clear the support before the performing agent",
        )
    return place


def _removing_around(putting: Putting, body: Body) -> list[Array]:
    """Places at the height of a thing around the performer, those nearest to the thing first."""
    x, y = putting.stage.scene.initial.qpos[body.agent.base][:2]
    offsets = np.arange(-REMOVING_AROUND_M, REMOVING_AROUND_M + GRID_M / 2, GRID_M)
    places = [np.array([x + dx, y + dy, putting.lies[2]]) for dx, dy in product(offsets, offsets)]
    return sorted(places, key=lambda place: float(np.linalg.norm(place - putting.lies)))


def _distance_m(scene: Scene, name: str, place: Array) -> float:
    """Distance of a place from an agent's pelvis, over the floor."""
    return float(np.linalg.norm(place[:2] - scene.initial.qpos[scene.agent(name).base][:2]))


def _handy(body: Body, scene: Scene, side: str, place: Array) -> bool:
    """Whether a hand gets there without leaning far."""
    return bool(body.torso_for(scene.initial, side, place)[1] <= REMOVING_LEAN_RAD)


def _check_farther(scene: Scene, roles: Roles, occluder: str, place: Array) -> None:
    """Raise a SceneError unless a place is farther from the target agent than where the thing lies."""
    lies = Stage(scene).body_position(scene.object_body(roles.thing))
    farther = _distance_m(scene, roles.target, place) - _distance_m(scene, roles.target, lies)
    if farther < FARTHER_M:
        raise SceneError(
            f"the place behind {occluder!r} is not {FARTHER_M:g} m farther from {roles.target!r}",
            where=scene.name,
            field=occluder,
            value=round(farther, 3),
            hint="let the occluder stand farther from the target agent",
        )
