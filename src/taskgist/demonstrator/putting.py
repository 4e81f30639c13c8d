"""Putting: the search for a place at which a thing can be put, the same for whatever it is put there for.

A means says in which order places are tried, and which of them serve its purpose; here is the rest: that there is a
support beneath, that nothing else stands there, and that a hand has room.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskgist.demonstrator.supports import POINT_SPACING_M, SUPPORT_M, supported
from taskgist.world import Scene, Stage, object_points
from taskgist.world.geometry.rotations import normalized

Array = NDArray[np.float64]
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
        points = object_points(stage, thing, POINT_SPACING_M)
        low, high = points.min(axis=0), points.max(axis=0)
        lies = np.array([*((low + high) / 2)[:2], low[2]])
        others = [object_points(stage, other, POINT_SPACING_M)[:, :2] for other in scene.objects if other != thing]
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
