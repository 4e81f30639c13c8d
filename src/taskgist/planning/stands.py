"""Where a robot can stand to pick a thing up, or to put it down.

The first gate is perspective's own word: the effort that it takes the robot to grasp the thing there, with what this
planner carries out (arms stretched, torso lifted, base moved). Candidates then stand around the thing, at distances and
bearings at which the arm's capability map has something, and get in order of the floor's ways: near ones first, and of
those that are about as near the ones that reach most grasps. What is yielded is free for the whole robot with its arms
folded, and its base can get there.
"""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np

from taskgist.common.arrays import Array
from taskgist.perspective.constraints import Collisions
from taskgist.perspective.effort import Effort, GraspedByBoth
from taskgist.perspective.floor import Floor, Place
from taskgist.perspective.scene_efforts import SceneEfforts
from taskgist.perspective.target import Recorder
from taskgist.planning.grasping import Grasping
from taskgist.planning.performer import Base, near_bases, with_values
from taskgist.world.geometry.transforms import wrapped
from taskgist.world.stage import Stage
from taskgist.world.state import State

DIRECTIONS = 16
"""Directions around the thing from which a robot comes."""
SHARES = (0.5, 0.65, 0.8, 0.92)
"""Distances of the shoulder from the thing, of how far the arm gets at that height."""
BEARINGS_RAD = tuple(math.radians(angle) for angle in (0.0, 30.0, -30.0, 60.0, -60.0))
"""Where the thing is from the shoulder: straight ahead, and to its sides."""
ENOUGH = 24
"""Grasps within reach beyond which more make a stand no better."""
WAY_COST = 0.15
"""How many shares of those a metre of way costs (ours)."""
NAMED = 3
APART_M, APART_RAD = 0.15, math.radians(25.0)
"""Stands nearer to one that was yielded than this, and turned alike, are the same for what fails there."""


@dataclass(frozen=True, eq=False)
class Stand:
    """A place to stand.

    Attributes:
        base: x, y in metres and yaw in radians.
        qpos: All positions with the robot there, arms folded, (nq,).
        way_m: Length of the way over the floor, roughly.
        in_reach: Which of the thing's free grasps are within reach of which arm: side and grasp.
    """

    base: Base
    qpos: Array
    way_m: float
    in_reach: frozenset[tuple[str, int]]


class Refusal(NamedTuple):
    """Why a robot cannot grasp a thing, and whether it perhaps could where the thing sticks out over an edge."""

    text: str
    may_slide: bool = False


class Stands:
    """Places where a robot can stand for a thing.

    Args:
        grasping: The robot's grasps of the thing.
        where: Whether the thing is picked up, or put down.
        qpos: Positions of the scene from where the robot drives, (nq,); by default its start. Its arms are folded.

    Attributes:
        rejected: What blocked candidates until now, by what they met.
        looked_at: How many candidates were looked at until now.
    """

    def __init__(
        self,
        grasping: Grasping,
        where: Literal["start", "goal"] = "start",
        *,
        qpos: Array | None = None,
    ) -> None:
        self._grasping, self._performer = grasping, grasping.performer
        self._at_start = where == "start"
        place = grasping.start if self._at_start else grasping.goal
        assert place is not None, "a thing that is not to be put down has no such stands"
        self._place: State = place
        self._now = self._performer.at_rest(self._performer.start.qpos if qpos is None else qpos)
        self._now = with_values(self._now, grasping.thing_slice, place.qpos[grasping.thing_slice])
        self.rejected: Counter[str] = Counter()
        self.looked_at = 0

    @property
    def refusal(self) -> str | None:
        """Why the robot cannot grasp the thing there at all, by its own effort; None if it can."""
        return None if self._refused is None else self._refused.text

    @property
    def may_slide(self) -> bool:
        """Whether it is refused as it lies, and would perhaps not be once it sticks out over an edge."""
        return self._refused is not None and self._refused.may_slide

    @cached_property
    def _refused(self) -> Refusal | None:
        if self._grasping.miss is not None:
            return Refusal(self._grasping.miss.text)
        name, thing = self._performer.agent.name, self._grasping.thing
        there = self._place.replace(at=self._performer.agent.base, to=self._now[self._performer.agent.base])
        efforts = SceneEfforts(Stage(self._performer.scene, there), self._performer.settings)
        effort = efforts.effort(name, thing, "grasp", self._performer.actions)
        if effort.is_known_to_do:
            return self._refused_as_it_lies(effort)
        what = self._performer.would_have_to(efforts, thing)
        if what is not None:
            return Refusal(f"{name} would have to {what} to grasp the {thing}, which is not planned")
        return Refusal(f"{name} cannot grasp the {thing}: {effort.reason}")

    def _refused_as_it_lies(self, effort: Effort) -> Refusal | None:
        """What would have to be done first, where no hand closes on the thing as it is; None if one does."""
        if not self._at_start or len(self._grasping.free):
            return None
        thing, evidence = self._grasping.thing, effort.evidence
        both = isinstance(evidence.attained, GraspedByBoth)
        may_slide = both or evidence.prepared == "slid over the edge"
        if evidence.prepared:
            planned = "" if may_slide else ", which is not planned"
            text = f"the {thing} would have to be {evidence.prepared} before it is grasped{planned}"
            return Refusal(text, may_slide)
        if both:
            return Refusal(f"the {thing} would have to be taken between both hands, which is not planned", may_slide)
        return None

    def __iter__(self) -> Iterator[Stand]:
        """Stands, near ones first; looked for as they are asked for."""
        if self.refusal is not None or not len(self._grasping.free):
            return
        yielded: list[Base] = []
        waiting = self._candidates()
        for places in self._reachable():
            near = self._near(places, waiting)
            for index in sorted(near, key=lambda index: (self._cost(waiting[index], near[index]), index)):
                base = waiting[index]
                if any(near_bases(base, other, APART_M, APART_RAD) for other in yielded):
                    continue
                stand = self._checked(base, near[index])
                if stand is not None:
                    yielded.append(base)
                    yield stand
            waiting = [base for index, base in enumerate(waiting) if index not in near]

    def none_free(self, what: str) -> str:
        """A sentence on why no candidate was one: "PR2 can stand nowhere to pick the tape up: ..."."""
        name = self._performer.agent.name
        if not self.looked_at:
            return f"{name} can stand nowhere to {what}: it gets to no place from where an arm reaches a grasp"
        counts = most(self.rejected)
        return f"{name} can stand nowhere to {what}: at all {self.looked_at} places something is in the way: {counts}"

    def _checked(self, base: Base, way_m: float) -> Stand | None:
        """A stand, if something is in reach from there and the whole robot is free."""
        reached = self._reached(base)
        if not reached:
            return None
        self.looked_at += 1
        qpos = self._performer.at(self._now, base)
        blocked = self._performer.blocking(qpos)
        if blocked is not None:
            self.rejected[blocked.other] += 1
            return None
        return Stand(base, qpos, way_m, reached)

    def _cost(self, base: Base, way_m: float) -> float:
        return WAY_COST * way_m - min(len(self._reached(base)), ENOUGH) / ENOUGH

    def _reached(self, base: Base) -> frozenset[tuple[str, int]]:
        """Which free grasps arms reach from a base: side and grasp."""
        if base not in self._reached_from:
            found: set[tuple[str, int]] = set()
            for side, shoulder in self._shoulders.items():
                lifts = self._grasping.lifts(self._now, side)
                rows = self._grasping.reached_from(_moved(shoulder, base), side, self._place, lifts)
                found |= {(side, row) for row in rows.tolist()}
            self._reached_from[base] = frozenset(found)
        return self._reached_from[base]

    @cached_property
    def _reached_from(self) -> dict[Base, frozenset[tuple[str, int]]]:
        return {}

    @cached_property
    def _shoulders(self) -> dict[str, Array]:
        """Each shoulder's row, (12,), with the base at the origin of the floor."""
        at_origin = self._performer.at(self._now, (0.0, 0.0, 0.0))
        return {side: self._performer.shoulder(at_origin, side) for side in self._performer.sides}

    def _candidates(self) -> list[Base]:
        """Where the robot stands now, and bases around the thing from where an arm may reach it."""
        here = self._performer.base(self._now)
        if not self._performer.drives:
            return [here]
        target = self._grasping.centers(self._place).mean(axis=0)
        found = [here]
        for side, shoulder in self._shoulders.items():
            longest_m = (
                float(self._performer.agent.arm(side).reach.map.radius_m) * self._performer.agent.arm(side).reach.scale
            )
            lifts = self._grasping.lifts(self._now, side)
            high = [abs(float(target[2] - shoulder[2]) - up_m) for up_m in lifts]
            level_m = math.sqrt(max(longest_m**2 - min(high) ** 2, 0.0))
            for share, bearing, number in itertools.product(SHARES, BEARINGS_RAD, range(DIRECTIONS)):
                towards = here[2] + 2 * math.pi * number / DIRECTIONS
                yaw, away_m = towards - bearing, share * level_m
                cosine, sine = math.cos(yaw), math.sin(yaw)
                x = float(target[0]) - away_m * math.cos(towards) - (cosine * shoulder[0] - sine * shoulder[1])
                y = float(target[1]) - away_m * math.sin(towards) - (sine * shoulder[0] + cosine * shoulder[1])
                found.append((float(x), float(y), wrapped(yaw)))
        return found

    def _reachable(self) -> Iterator[list[Place]]:
        """Places of the floor that the base can get to, batch by batch; the robot's own first."""
        yield [Place((0.0, 0.0), 0.0)]
        agent, settings = self._performer.agent, self._performer.settings
        if not self._performer.drives:
            return
        stage = Stage(self._performer.scene, State(self._now, untracked=self._place.untracked))
        collisions = Collisions(stage, agent, settings, (), Recorder())
        yield from Floor(stage.state, agent, settings.efforts, collisions.footprint()).batches()

    def _near(self, places: list[Place], bases: list[Base]) -> dict[int, float]:
        """Which bases are within half a cell of a place, and how long the way to it is, metres."""
        if not places or not bases:
            return {}
        x, y, _ = self._performer.base(self._now)
        at = np.array([place.offset_m for place in places]) + (x, y)
        away_m = np.linalg.norm(np.array(bases)[:, None, :2] - at[None], axis=2)
        nearest = away_m.argmin(axis=1)
        half_m = self._performer.settings.efforts.move_step_m / math.sqrt(2) + 1e-9
        within = np.flatnonzero(away_m[np.arange(len(bases)), nearest] <= half_m)
        alone = len(places) == 1 and places[0].way_m == 0.0
        kept = within[:1] if alone else within  # before the floor is asked, only where the robot stands
        return {int(index): places[int(nearest[index])].way_m for index in kept if not alone or index == 0}


def most(counts: Counter[str]) -> str:
    """What was met most often: "table (12), chair (3)"."""
    return ", ".join(f"{other} ({count})" for other, count in counts.most_common(NAMED))


def _moved(shoulder: Array, base: Base) -> Array:
    """A shoulder's row, (12,), once the base has moved from the floor's origin."""
    x, y, yaw = base
    turn = np.array([[math.cos(yaw), -math.sin(yaw), 0.0], [math.sin(yaw), math.cos(yaw), 0.0], [0.0, 0.0, 1.0]])
    position = turn @ shoulder[:3] + (x, y, 0.0)
    return np.concatenate((position, (turn @ shoulder[3:].reshape(3, 3)).reshape(9)))
