"""Picking a thing up and putting it down elsewhere: one grasp that does for both, one stand for each.

A grasp with which a thing is easily taken may be of no use where it is to lie, so the far end is asked first: only
grasps for which the robot has a free configuration at some stand around the goal are solved at the start, with their
lines. Each pick is then tried at these stands of the goal, until both ends have all that they need.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice

from taskgist.planning.grasping import Grasping
from taskgist.planning.hand_ways import Failures, Gate, PickPose, PlacePose, farthest
from taskgist.planning.stands import Stand, Stands

STANDS_AT_START, STANDS_AT_GOAL = 8, 32
"""Stands that are looked at, at most."""
PICKS_A_STAND, GOALS_A_GRASP, FITTING = 12, 6, 2
"""Picks that are solved from one stand, stands of the goal at which each grasp is tried, and enough that fit (ours)."""


@dataclass(frozen=True, eq=False)
class Transfer:
    """How a thing is brought from one place to another.

    Attributes:
        start: Where the robot stands to pick it up.
        pick: How.
        goal: Where it stands to put it down.
        place: How.
    """

    start: Stand
    pick: PickPose
    goal: Stand
    place: PlacePose


class Transfers:
    """Ways to bring a thing to its goal, found as they are asked for; the same question gives the same ways.

    Args:
        grasping: The robot's grasps of the thing, at its place and at its goal.

    Attributes:
        starts: Stands for picking up that were looked at.
        goals: Stands for putting down.
        picked: How many picks were found.
    """

    def __init__(self, grasping: Grasping) -> None:
        self._grasping = grasping
        self._at_start, self._at_goal = Stands(grasping, "start"), Stands(grasping, "goal")
        self.starts: list[Stand] = []
        self.goals: list[Stand] = []
        self.picked = 0
        self._known: dict[tuple[str, int], list[Stand]] = {}

    def __iter__(self) -> Iterator[Transfer]:
        if self._at_start.refusal is not None or self._at_goal.refusal is not None:
            return
        self.goals = list(islice(self._at_goal, STANDS_AT_GOAL))
        for start in islice(self._at_start, STANDS_AT_START):
            self.starts.append(start)
            picks = self._grasping.picks(start.qpos, among=lambda side, row: bool(self._fitting(side, row)))
            for pick in islice(picks, PICKS_A_STAND):
                self.picked += 1
                for goal in self._fitting(pick.side, pick.grasp):
                    place = next(self._grasping.places(goal.qpos, pick), None)
                    if place is not None:
                        yield Transfer(start, pick, goal, place)
                        break

    def _fitting(self, side: str, row: int) -> list[Stand]:
        """Stands of the goal at which a hand comes to a grasp; the first of those that have it within reach."""
        if (side, row) not in self._known:
            grasping = self._grasping
            failed: Failures = []
            asked = islice((stand for stand in self.goals if (side, row) in stand.in_reach), GOALS_A_GRASP)
            fitting = (stand for stand in asked if grasping.fits(stand.qpos, side, row, failed))
            self._known[side, row] = list(islice(fitting, FITTING))
            if not self._known[side, row]:
                grasping.place_tally.add(*(farthest(failed) if failed else (Gate.REACH, None)))
        return self._known[side, row]

    @property
    def refusal(self) -> str | None:
        """Why none was found, after all were asked for; None as long as nothing stands in the way."""
        grasping, thing = self._grasping, self._grasping.thing
        for stands in (self._at_start, self._at_goal):
            if stands.refusal is not None:
                return stands.refusal
        if not len(grasping.free):
            return grasping.tally.text(thing)
        for stands, found, what in (
            (self._at_goal, self.goals, f"put the {thing} down"),
            (self._at_start, self.starts, f"pick the {thing} up"),
        ):
            if not found:
                return stands.none_free(what)
        if not self.picked:
            return grasping.tally.text(thing)
        return grasping.place_tally.text(thing) or None
