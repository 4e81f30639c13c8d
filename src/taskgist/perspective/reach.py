"""Reach: some cell of the object is within the arm's length of the shoulder and inside its sector (5.1.2).

A rough reach, as people perceive it: head, torso and base must not collide, the arm is not looked at. Who holds the
object reaches it without effort. An arm that was not tracked can be stretched out all the same, for its shoulder
hangs on the torso; only whether its hand holds the object is then unknown, unless the object is farther away than the
whole arm.
"""

from __future__ import annotations

from collections.abc import Iterator

from taskgist.perspective.by_hand import ByHand
from taskgist.perspective.judge import Miss, Outcome, best_first
from taskgist.perspective.sector import within_reach
from taskgist.perspective.standpoint import Standpoint
from taskgist.perspective.virtual_actions import Stance, stretch
from taskgist.world import ArmIndices, object_points


class Reach(ByHand):
    """Judges the ability to reach one object.

    Args:
        here: Whose, and from where.
        name: The object.
    """

    def __init__(self, here: Standpoint, name: str) -> None:
        super().__init__(here, name)
        self._points = object_points(here.stage, name, here.settings.reach.cell_m)

    def from_stance(self, stance: Stance) -> Iterator[Outcome | Miss]:
        """The arms that reach the object, the nearer shoulder's first."""
        self._stage.show(stance.state)
        yield from best_first(self._stretched(arm, stance) for arm in self._arms)

    def _stretched(self, arm: ArmIndices, stance: Stance) -> Outcome | Miss:
        reached = within_reach(self._stage.shoulder(arm), arm.profile, self._points)
        if not reached.inside.any():
            return reached.miss(arm.profile)
        nearest = int(reached.nearest_first()[0])
        distance_m = float(reached.distances_m[nearest])
        point, side = self._points[nearest], arm.profile.side
        return Outcome(
            stance.state,
            (stretch(side),),
            merit=round(distance_m, 6),
            evidence=lambda: {"arm": side, "point_m": point.tolist(), "distance_m": distance_m},
        )
