"""Places: the demonstrator's own geometry, by which it reaches its intention.

A thing is shown on the line of sight, in front of the other's face, or on top of something. Only present positions,
sizes and straight lines are used; what the other could do with more effort, and what facts follow, is for others to
find out. ``hiding`` has the places at which things are hidden.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from taskgist.common.arrays import Array
from taskgist.errors import SceneError
from taskgist.moving.body import Body
from taskgist.moving.steps import POINT_SPACING_M
from taskgist.world.contacts import object_points
from taskgist.world.geometry.transforms import normalized
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage

COMFORTABLE_VIEW_M = 0.50
"""Distance from the eye at which things are held to be looked at."""
BELOW_EYES_M = 0.12
"""How far below the line between two faces a thing is held, so that neither hides the other."""
GREATEST_LEAN_RAD = 0.6
"""How far one leans, at most, to hold something up."""


def on_top(stage: Stage, thing: str) -> tuple[float, float, float]:
    """The middle of the upper face of a thing, metres, (3,)."""
    points = object_points(stage, thing, POINT_SPACING_M)
    x, y = (points.min(axis=0) + points.max(axis=0))[:2] / 2
    return float(x), float(y), float(points[:, 2].max())


def before_face(
    scene: Scene, performer: str, target: str, side: str, distance_m: float, *, also_for: Sequence[str] = ()
) -> tuple[float, float, float]:
    """A place on the line of sight from a face to another one, as near to a distance as the other can hold a thing.

    Of several faces the middle is taken.

    Args:
        scene: The scene.
        performer: Who holds.
        target: Before whose face.
        side: The holding hand.
        distance_m: Wanted distance from the target's eye.
        also_for: Before whose faces, too.

    Returns:
        The place in metres, (3,).
    """
    stage, body = Stage(scene), Body(scene, performer)
    eye = np.mean([stage.eye(scene.agent(name)).position for name in (target, *also_for)], axis=0)
    sight = stage.eye(scene.agent(performer)).position - eye
    place = eye
    for share in np.linspace(0.0, 1.0, 41):
        distance = distance_m + share * (np.linalg.norm(sight) - distance_m)
        place = eye + distance * normalized(sight) - (0.0, 0.0, BELOW_EYES_M)
        if body.torso_for(scene.initial, side, place)[1] <= GREATEST_LEAN_RAD:
            break
    return float(place[0]), float(place[1]), float(place[2])


# --- Where there is a support.

SUPPORT_SPACING_M = 0.02
LIFT_M, SUPPORT_M = 0.05, 0.005
"""From how high a support is searched, and how far it may be from where it is expected."""


def supported(stage: Stage, points: Array) -> bool:
    """Whether there is a support just beneath each of some points, metres, (n, 3); people's laps are none."""
    return all(_is_support(stage, point) for point in points)


def _is_support(stage: Stage, point: Array) -> bool:
    (geom,), (distance,) = stage.cast(point + (0.0, 0.0, LIFT_M), [(0.0, 0.0, -1.0)])
    owner = stage.scene.owners[geom] if geom >= 0 else None
    return bool(abs(distance - LIFT_M) < SUPPORT_M) and owner not in stage.scene.agents


# --- Putting: the search for a place at which a thing can be put, the same for whatever it is put there for.
#
# A means says in which order places are tried, and which of them serve its purpose; here is the rest: that there is a
# support beneath, that nothing else stands there, and that a hand has room.

Place = tuple[float, float, float]
"""Where the middle of a thing's underside goes, metres."""


@dataclass(frozen=True, eq=False)
class Putting:
    """A thing that is to be put somewhere, upright as it stands.

    Attributes:
        stage: The scene with everything where it is now.
        thing: The thing.
        lies: The middle of its underside now, metres, (3,).
        shape: Points of its surface from there, (n, 3).
        others: Points of all other objects on the floor plan, (m, 2).
    """

    stage: Stage
    thing: str
    lies: Array
    shape: Array
    others: Array

    @classmethod
    def of(cls, scene: Scene, thing: str) -> Putting:
        """A thing of a scene.

        Raises:
            UnknownNameError: There is no such object.
        """
        stage = Stage(scene)
        points = object_points(stage, thing, SUPPORT_SPACING_M)
        low, high = points.min(axis=0), points.max(axis=0)
        lies = np.array([*((low + high) / 2)[:2], low[2]])
        others = [object_points(stage, other, SUPPORT_SPACING_M)[:, :2] for other in scene.objects if other != thing]
        return cls(stage, thing, lies, points - lies, np.concatenate((np.empty((0, 2)), *others)))

    @property
    def radius_m(self) -> float:
        """How far it extends from its middle, over the floor."""
        return float(np.linalg.norm(self.shape[:, :2], axis=1).max())

    @property
    def middle(self) -> Array:
        """Its middle from the middle of its underside, metres, (3,)."""
        return np.array((0.0, 0.0, self.shape[:, 2].max() / 2))

    def first(
        self, places: Iterable[Array], *, around: Array, room_m: float, suits: Callable[[Array], bool]
    ) -> Place | None:
        """The first place at which it stands on a support, nothing else is near, and that suits; None if none does.

        Args:
            places: Places to try, metres, (3,) each.
            around: Offsets from a place at which there must be a support, too, (k, 3).
            room_m: Gap between it and other things, at least.
            suits: Whether a place serves the purpose.
        """
        for place in places:
            if self._is_free(place, room_m) and supported(self.stage, place + around) and suits(place):
                return float(place[0]), float(place[1]), float(place[2])
        return None

    def _is_free(self, place: Array, room_m: float) -> bool:
        gaps = np.linalg.norm(self.others - place[:2], axis=1)
        return bool(np.all(gaps > self.radius_m + room_m))

    def in_view(self, place: Array, target: str) -> bool:
        """Whether nothing but the thing itself would be on the lines from somebody's eye to it at a place."""
        scene = self.stage.scene
        agent = scene.agent(target)
        eye = self.stage.eye(agent).position
        lines = place + self.shape - eye
        geoms, distances = self.stage.cast(eye, normalized(lines), exclude_body=agent.eye_exclude_body)
        free = distances > np.linalg.norm(lines, axis=1) - SUPPORT_M
        return bool(np.all(free | (geoms < 0) | np.isin(geoms, scene.geoms_of(self.thing))))


# --- Hiding places: where straight lines from the other's eye to a thing all meet the occluder.

HAND_ROOM_M = 0.08
"""Room that a hand needs around a thing: fingers reach this far beyond it."""
GAPS_M = tuple(0.02 * step for step in range(10))
"""Gaps beyond that room that are tried behind an occluder."""
ASIDES_M = (0.0, 0.03, -0.03, 0.06, -0.06)
"""Offsets across the line of sight that are tried."""
HEAD_MOVES_M = 0.05
"""Nobody keeps the head quite still: a thing is hidden from places so far around the eye, too."""


def behind(scene: Scene, thing: str, occluder: str, target: str, *, also_for: Sequence[str] = ()) -> Place:
    """A place on the occluder's own support at which the occluder hides a thing from the target agents' eyes.

    Candidates lie behind the occluder as seen from the middle of the eyes, the nearest to it first.

    Args:
        scene: The scene.
        thing: What is hidden.
        occluder: Behind what.
        target: From whom.
        also_for: From whom, too.

    Returns:
        Where the middle of the thing's underside goes, metres, (3,).

    Raises:
        SceneError: No candidate is hidden, free and on the support.
    """
    putting, targets = Putting.of(scene, thing), (target, *also_for)
    place = putting.first(
        _beyond(putting, occluder, targets),
        around=np.zeros((1, 3)),
        room_m=HAND_ROOM_M / 2,
        suits=lambda place: all(
            _hidden(putting.stage, thing, putting.shape + place, occluder, name) for name in targets
        ),
    )
    if place is None:
        raise SceneError(
            f"no place behind {occluder!r} hides {thing!r} from {' and '.join(map(repr, targets))}",
            where=scene.name,
            field=occluder,
            hint="take a larger occluder, or clear the support behind it",
        )
    return place


def _beyond(putting: Putting, occluder: str, targets: Sequence[str]) -> Iterator[Array]:
    """Places behind the occluder as seen by the target agents, at the height of its underside, near ones first."""
    stage = putting.stage
    eye = np.mean([stage.eye(stage.scene.agent(name)).position for name in targets], axis=0)
    points = object_points(stage, occluder, SUPPORT_SPACING_M)
    low, high = points.min(axis=0), points.max(axis=0)
    middle = (low + high)[:2] / 2
    away = normalized(middle - eye[:2])
    across = np.array([-away[1], away[0]])
    least = float(np.max((points[:, :2] - middle) @ away)) + HAND_ROOM_M + putting.radius_m
    for gap, aside in product(GAPS_M, ASIDES_M):
        yield np.array([*(middle + (least + gap) * away + aside * across), low[2]])


def _hidden(stage: Stage, thing: str, points: Array, occluder: str, target: str) -> bool:
    """Whether the lines from places around the target agent's eye to all points meet the occluder."""
    scene = stage.scene
    head = stage.eye(scene.agent(target))
    for move in HEAD_MOVES_M * np.array([(0, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]):
        eye = head.to_world(move)
        away = np.linalg.norm(points - eye, axis=1)
        geoms, distances = stage.cast(eye, normalized(points - eye), exclude_body=scene.object_body(thing))
        owners = [scene.owners[geom] if geom >= 0 else "" for geom in geoms]
        if not all(owner == occluder for owner in owners) or np.any(distances >= away):
            return False
    return True
