"""Picking a thing up and putting it down elsewhere: one grasp that does for both, one stand for each.

Where many goals are asked for one after the other, what picking up takes is the same for all: it is found out once,
stand by stand and grasp by grasp, as far as it is needed. For each grasp the hand comes to it first where the thing
lies, then at stands of a goal; only if both are so, its lines are followed, until both ends have all that they need.
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import count, islice

from taskgist.common.arrays import Array
from taskgist.planning.grasping import Grasping, Kind
from taskgist.planning.hand_ways import Failures, Gate, PickPose, PlacePose, farthest
from taskgist.planning.performer import Performer
from taskgist.planning.placing import Candidate
from taskgist.planning.sliding import Pressing, Slid
from taskgist.planning.stands import Stand, Stands, most
from taskgist.world.state import State

MOST_STANDS, STANDS_AT_GOAL = 24, 32
"""Stands that are looked at, at most, to pick the thing up, and for each goal."""
PICKS_A_STAND, GOALS_A_GRASP, FITTING = 12, 6, 2
"""Picks that are solved from one stand, stands of the goal at which each grasp is tried, and enough that fit (ours)."""
PRESSES_A_STAND = 2
"""Ways to slide a thing that are solved from one stand."""


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


def _any(_side: str, _grasp: int) -> bool:
    return True


def _none(_side: str, _grasp: int) -> bool:
    return False


class Picks:
    """Ways to pick the thing up from one stand: each grasp is solved once, and when somebody wants it.

    Args:
        grasping: The robot's grasps of the thing.
        qpos: Positions of the scene with the robot at the stand, (nq,).
    """

    def __init__(self, grasping: Grasping, qpos: Array) -> None:
        self._grasping, self._qpos = grasping, qpos
        self._within_reach = grasping.within_reach(qpos)
        self._come: dict[tuple[str, int], bool] = {}
        self._solved: dict[tuple[str, int], PickPose | None] = {}

    def by(
        self, wanted: Callable[[str, int], bool] = _any, *, hopeless: Callable[[str, int], bool] = _none
    ) -> Iterator[PickPose]:
        """Picks by grasps that somebody wants.

        Where grasps of a kind failed, those of other kinds come first: alike ones mostly fail alike.

        Args:
            wanted: Whether a pick by a side and a grasp will do; asked where the hand is known to come there.
            hopeless: Whether it is known already that it will not; asked before.
        """
        waiting = {kind: deque(rows) for kind, rows in self._within_reach.items()}
        failures: Counter[Kind] = Counter()
        rank = {row: number for number, row in enumerate(self._grasping.free.tolist())}
        while waiting:
            kind = min(waiting, key=lambda kind: (failures[kind], rank[waiting[kind][0]]))
            side, row = kind[0], waiting[kind].popleft()
            if not waiting[kind]:
                del waiting[kind]
            if hopeless(side, row):
                continue
            pick = self._pick(side, row) if self._comes(side, row) and wanted(side, row) else None
            if pick is None:
                failures[kind] += 1
            else:
                yield pick

    def _comes(self, side: str, row: int) -> bool:
        if (side, row) not in self._come:
            self._come[side, row] = self._grasping.comes(self._qpos, side, row)
        return self._come[side, row]

    def _pick(self, side: str, row: int) -> PickPose | None:
        if (side, row) not in self._solved:
            self._solved[side, row] = self._grasping.pick(self._qpos, side, row)
        return self._solved[side, row]


class Picking:
    """What a robot's picking a thing up takes, wherever it is to go: grasps, stands, and the picks that were solved.

    Args:
        grasping: Its grasps of the thing.

    Attributes:
        grasping: As given.
        nowhere: How many stands were looked at to put it down where none was free.
        in_the_way: What was in the way there.
        cannot: Why the robot could not grasp it where it is to be, by its own effort.
    """

    def __init__(self, grasping: Grasping) -> None:
        self.grasping = grasping
        self._at_start = Stands(self.grasping, "start")
        self._coming = islice(self._at_start, MOST_STANDS)
        self._found: list[tuple[Stand, Picks]] = []
        self._in_vain: set[tuple[Stand, Kind]] = set()
        self.nowhere, self.in_the_way, self.cannot = 0, Counter[str](), Counter[str]()

    def __iter__(self) -> Iterator[tuple[Stand, Picks]]:
        """Where the robot can stand to pick the thing up, and how it picks it up from there."""
        for number in count():
            if number == len(self._found):
                stand = next(self._coming, None)
                if stand is None:
                    return
                self._found.append((stand, Picks(self.grasping, stand.qpos)))
            yield self._found[number]

    def give_up(self, transfer: Transfer) -> None:
        """Ask no more for picks as alike to one as mostly fail alike: its hand does not get there from its stand."""
        kind = (transfer.pick.side, self.grasping.kind(transfer.pick.grasp))
        self._in_vain.add((transfer.start, kind))

    def has_given_up(self, stand: Stand, side: str, grasp: int) -> bool:
        """Whether that is so of a grasp."""
        return (stand, (side, self.grasping.kind(grasp))) in self._in_vain

    @cached_property
    def refusal(self) -> str | None:
        """Why the thing cannot be picked up at all, wherever it is to go; None if it can."""
        grasping, thing = self.grasping, self.grasping.thing
        if self._at_start.refusal is not None or not len(grasping.free):
            return self._at_start.refusal or grasping.tally.text(thing)
        if any(True for _, picks in self for _ in picks.by()):
            return None
        return grasping.tally.text(thing) if self._found else self._at_start.none_free(f"pick the {thing} up")

    @property
    def may_slide(self) -> bool:
        """Whether no hand closes on the thing as it lies, but perhaps once it is slid over an edge."""
        return self._at_start.may_slide

    @property
    def text(self) -> tuple[str, ...]:
        """Where grasps and stands failed until now, all goals together, in sentences."""
        thing, told = self.grasping.thing, []
        if self.grasping.tally.counts:
            told.append(f"where it lies, {self.grasping.tally.text(thing)}")
        if self.grasping.place_tally.counts:
            told.append(f"where it is to be, {self.grasping.place_tally.text(thing)}")
        told += [f"where it is to be, {reason}" for reason, _ in self.cannot.most_common(1)]
        if self.nowhere:
            told.append(
                f"at {self.nowhere} stands for putting it down something is in the way: {most(self.in_the_way)}"
            )
        return tuple(told)


class Transfers:
    """Ways to bring a thing to a goal, found as they are asked for; the same question gives the same ways.

    Args:
        picking: The robot's picking the thing up.
        goal: Where the thing's body is to be: position in metres and wxyz, (7,).

    Attributes:
        goals: Stands for putting it down.
        picked: How many picks do there, the hand at the grasp alone.
    """

    def __init__(self, picking: Picking, goal: Array) -> None:
        self._picking, self._grasping = picking, picking.grasping.towards(goal)
        self._at_goal = Stands(self._grasping, "goal")
        self.goals: list[Stand] = []
        self.picked = 0
        self._known: dict[tuple[str, int], list[Stand]] = {}

    def __iter__(self) -> Iterator[Transfer]:
        grasping = self._grasping
        if self._at_goal.refusal is not None:
            self._picking.cannot[self._at_goal.refusal] += 1
            return
        if not len(grasping.free):
            return
        self.goals = list(islice(self._at_goal, STANDS_AT_GOAL))
        if not self.goals:
            self._picking.nowhere += self._at_goal.looked_at
            self._picking.in_the_way += self._at_goal.rejected
            return
        free = set(grasping.free.tolist())
        for start, picks in self._picking:

            def hopeless(side: str, row: int, start: Stand = start) -> bool:
                given_up = self._picking.has_given_up(start, side, row)
                return row not in free or given_up or self._known.get((side, row)) == []

            fitting = picks.by(lambda side, row: bool(self._fitting(side, row)), hopeless=hopeless)
            for pick in islice(fitting, PICKS_A_STAND):
                self.picked += 1
                stands = self._fitting(pick.side, pick.grasp)
                while stands:
                    place = next(grasping.places(stands[0].qpos, pick), None)
                    if place is not None:
                        yield Transfer(start, pick, stands[0], place)
                        break
                    stands.pop(0)  # as it was picked up from here, so it is from elsewhere

    def _fitting(self, side: str, row: int) -> list[Stand]:
        """Stands of the goal at which a hand comes to a grasp and has not failed to put the thing down by it.

        They are the first of those that have it within reach.
        """
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
    def refusal(self) -> str:
        """At what it failed, after all were asked for, in the same words for all goals; see ``Picking.text``."""
        thing = self._grasping.thing
        if self._at_goal.refusal is not None or not len(self._grasping.free):
            return f"no grasp of the {thing} does for both ends"
        if not self.goals:
            return f"there is nowhere to stand to put the {thing} down"
        if not self.picked:
            return f"the {thing} cannot be picked up by any grasp that does there"
        return f"the {thing} cannot be put down as it can be picked up"


def slidings(performer: Performer, state: State, candidate: Candidate) -> Iterator[tuple[Stand, Slid]]:
    """Ways in which a robot slides a thing to where it sticks out: where it stands, and what its hand does.

    Args:
        performer: The robot.
        state: Where everything is.
        candidate: Where the thing is to stick out.
    """
    thing = candidate.thing
    shift = candidate.pose[:3] - state.qpos[performer.scene.object_slice(thing)][:3]
    pressing = Pressing(performer, state, thing, shift)
    for stand, picks in Picking(pressing):
        for press in islice(picks.by(), PRESSES_A_STAND):
            slid = pressing.left(press)
            if slid is not None:
                yield stand, slid
