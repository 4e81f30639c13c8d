"""The search for a plan: goal, places, grasps and stands, motions, one gate after the other (9.1).

Candidates for the thing's final place are judged by what the goal wants, cheapest literal first; those that satisfy it
go to the robot, which needs a grasp that does for both ends, two places to stand, and free ways between. What fails is
counted at the first gate that it fails, so that a refusal says what stood in the way, of how many.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import islice
from typing import NamedTuple

from taskgist.common.workers import Progress, silent
from taskgist.facts import vocabulary as v
from taskgist.facts.predicates import Predicate
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import HypothesisTree
from taskgist.facts.values import Raw
from taskgist.learning.understanding import Clause, Literal
from taskgist.observe.attributes import resting_snapshot
from taskgist.planning.candidates import Candidate, Means, candidates
from taskgist.planning.goal import Goal
from taskgist.planning.grasping import Grasping
from taskgist.planning.handing import Taker, sides_by_distance
from taskgist.planning.judging import Attention, Judge, Verdict
from taskgist.planning.motions import Motions, NoMotionError
from taskgist.planning.performer import Performer
from taskgist.planning.persons import moves_itself, phases_of, why_out_of_reach
from taskgist.planning.plan import Phase, Plan
from taskgist.planning.transfer import Transfer, Transfers
from taskgist.settings import DEFAULT, Settings
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist.world.state import State

ENDS: Mapping[Means, str] = {
    "put_on": v.ON_SUPPORT,
    "put_in": v.INSIDE_CONTAINER,
    "hold_up": v.IN_HAND,
    "hand_over": v.IN_HAND,
}
"""Where a thing is in the end, by how it gets there."""
Attempt = tuple[str, Callable[[], tuple[Phase, ...]]]
"""A hand, and what makes the phases with it, or raises ``NoMotionError``."""
MOST_PLACES = 1000
"""Candidates that are judged at most."""
MOST_TRIED = 12
"""Of those that satisfy the goal, so many are tried with the robot (ours)."""
TRANSFERS_A_PLACE = 3
"""Ways to bring the thing to a place, grasps and stands, whose motions are tried."""


@dataclass(frozen=True)
class Request:
    """What is to be performed.

    Attributes:
        clause: The meaning of the task.
        performer: Who performs it.
        target: For whom.
        thing: With what.
        attention: What the target agent is assumed to look at in the end.
        allow: Supports that may be used; None for all.
        prefer: Supports that come first.
        seed: The same request with the same seed has the same plans.
    """

    clause: Clause
    performer: str
    target: str
    thing: str
    attention: Attention = "thing"
    allow: tuple[str, ...] | None = None
    prefer: tuple[str, ...] = ()
    seed: int = 0


class Missed(NamedTuple):
    """The nearest miss of a literal: how far off it was, and what was found."""

    off: float
    found: Raw


@dataclass
class Search:
    """What became of the candidates.

    Attributes:
        places: How many were judged.
        missed: How many failed at each literal.
        out_of_hand: How many are where the target agent's hand does not get to take the thing.
        nearest: The nearest miss at each literal whose attribute is a number or a level.
        wanted: How many satisfy the goal.
        tried: How many of these were tried with the performer's body.
        refusals: Why the performer does not bring these about, each with its number.
    """

    places: int = 0
    missed: Counter[Literal] = field(default_factory=Counter)
    nearest: dict[Literal, Missed] = field(default_factory=dict)
    out_of_hand: int = 0
    wanted: int = 0
    tried: int = 0
    refusals: Counter[str] = field(default_factory=Counter)


class Planner:
    """Finds plans for a request.

    Args:
        scene: The scene.
        state: Where everything is.
        request: What is to be performed.
        tree: The tree that the clause was learned in.
        settings: All settings.
        predicates: A user's own predicates.

    Attributes:
        scene: As given.
        request: As given.
        performer: The performing robot; None for a person.
        goal: What is wanted, given, impossible.
        search: What became of the candidates until now.

    Raises:
        UnknownNameError: There is no such agent, thing or support.
        SceneError: The performer has no arm or no hand that grasps.
    """

    def __init__(
        self,
        scene: Scene,
        state: State,
        request: Request,
        *,
        tree: HypothesisTree = STANDARD_TREE,
        settings: Settings = DEFAULT,
        predicates: Sequence[Predicate] = (),
    ) -> None:
        self.scene, self._state, self.request, self._settings = scene, state, request, settings
        person = moves_itself(scene.agent(request.performer))
        self.performer = None if person else Performer(scene, request.performer, settings, start=state)
        start = resting_snapshot(
            Stage(scene, state), agent=request.target, name=request.thing, settings=settings, predicates=predicates
        )
        self.goal = Goal.of(request.clause, start, tree, settings)
        self._judge = Judge(
            scene,
            state,
            request.target,
            request.thing,
            self.goal,
            settings,
            predicates,
            attention=request.attention,
            performer=request.performer,
        )
        self._taker = Taker(scene, request.target, state)
        self.search = Search()
        self._refusal: str | None = None

    def plans(self, progress: Progress = silent) -> Iterator[Plan]:
        """Plans, the nearest to the candidates' order first, each for another place.

        Args:
            progress: Told how far it is.
        """
        if self.goal.impossible:
            return
        for candidate in self._wanted(progress):
            if self.search.tried == MOST_TRIED:
                return
            if self.performer is None:
                out = why_out_of_reach(self.scene, candidate, self.request.performer, self._settings)
                if out is not None:
                    self.search.refusals[out] += 1
                    continue
            self.search.tried += 1
            progress(f"how {self.request.performer} gets the {self.request.thing} there", self._share())
            plan = self._plan_to(candidate)
            if plan is not None:
                yield plan

    def _share(self) -> float:
        return min(1.0, max(self.search.places / MOST_PLACES, self.search.tried / MOST_TRIED))

    def _wanted(self, progress: Progress) -> Iterator[Candidate]:
        """Candidates that satisfy the goal."""
        request, search = self.request, self.search
        all_of_them = candidates(
            Stage(self.scene, self._state),
            request.thing,
            request.performer,
            request.target,
            self._settings,
            allow=request.allow,
            prefer=request.prefer,
            means=self._means(),
            seed=request.seed,
        )
        for candidate in islice(all_of_them, MOST_PLACES):
            search.places += 1
            state: State | None = candidate.state
            if candidate.means == "hand_over":
                state = self._taker.holding(candidate.state, request.thing)
            if state is None:
                search.out_of_hand += 1
                continue
            verdict = self._judge.verdict(state)
            if verdict.failed is not None:
                search.missed[verdict.failed] += 1
                self._note(verdict.failed, verdict.values)
            elif verdict.holds is True:
                search.wanted += 1
                yield candidate
            if search.places % 20 == 0:
                progress(f"{search.places} places judged", self._share())

    def _means(self) -> tuple[Means, ...]:
        """Means that may bring about the placement, and the target's hands, that are wanted."""
        placement, hands = self.goal.wants("placement"), self.goal.wants("hands")
        found = [means for means, end in ENDS.items() if placement is None or end in (placement.values or ())]
        if hands is not None and hands.values is not None:
            taken = [v.HOLDING_OBJECT in final.values() for final in hands.values if isinstance(final, Mapping)]
            found = [means for means in found if (means == "hand_over") in taken]
        return tuple(found)

    def _note(self, literal: Literal, values: Mapping[str, Raw]) -> None:
        """Keep the nearest miss of a literal."""
        for wanted in self.goal.wanted:
            if literal in wanted.literals and wanted.attribute in values:
                found = values[wanted.attribute]
                off = wanted.missed_by(found)
                if off is not None and off < self.search.nearest.get(literal, Missed(math.inf, found)).off:
                    self.search.nearest[literal] = Missed(off, found)

    def _plan_to(self, candidate: Candidate) -> Plan | None:
        """How the performer brings the thing to a place; None if it does not, which is counted."""
        failed = ""
        for side, attempt in self._by_person(candidate) if self.performer is None else self._by_robot(candidate):
            try:
                phases = attempt()
            except NoMotionError as error:
                failed = str(error)
                continue
            request = self.request
            return Plan(
                task=request.clause.task,
                performer=request.performer,
                target=request.target,
                thing=request.thing,
                side=side,
                candidate=candidate,
                phases=phases,
            )
        self.search.refusals[failed or self._refusal or "no way was found"] += 1
        return None

    def _by_person(self, candidate: Candidate) -> Iterator[Attempt]:
        """Attempts of a person, the nearer hand first."""
        request, scene = self.request, self.scene
        for side in sides_by_distance(scene, self._state.qpos, request.thing, request.performer):

            def attempt(side: str = side) -> tuple[Phase, ...]:
                phases = phases_of(
                    scene, self._state, request.performer, request.target, candidate, side, seed=request.seed
                )
                return self._ending_well(phases, self._end_of(phases))

            yield side, attempt

    def _by_robot(self, candidate: Candidate) -> Iterator[Attempt]:
        """Attempts of a robot: grasps and stands for both ends, as they are found."""
        request = self.request
        assert self.performer is not None
        grasping = Grasping(self.performer, self._state, request.thing, candidate.pose)
        transfers = Transfers(grasping)
        motions = Motions(self.performer, self._settings.planning, seed=request.seed)
        for transfer in islice(transfers, TRANSFERS_A_PLACE):

            def attempt(transfer: Transfer = transfer) -> tuple[Phase, ...]:
                return self._in_nobodys_way(motions, motions.of(transfer, candidate.means, self._taker))

            yield transfer.pick.side, attempt
        self._refusal = transfers.refusal

    def _in_nobodys_way(self, motions: Motions, phases: tuple[Phase, ...]) -> tuple[Phase, ...]:
        """The phases, and if the robot would spoil the end where it stands, its way back.

        Raises:
            NoMotionError: It spoils the end either way.
        """
        assert self.performer is not None
        verdict, holds = self._end_of(phases), phases[-1].holds
        if verdict.holds is not True and all(hold.agent != self.request.performer for hold in holds):
            phases += motions.back(phases[-1].qpos[-1], holds, self.performer.base(self._state.qpos))
            verdict = self._end_of(phases)
        return self._ending_well(phases, verdict)

    def _ending_well(self, phases: tuple[Phase, ...], verdict: Verdict) -> tuple[Phase, ...]:
        """The phases.

        Raises:
            NoMotionError: With all as it is in the end, the goal is not satisfied.
        """
        if verdict.holds is not True:
            raise NoMotionError(f"with {self.request.performer} where it is in the end, {verdict.failed} fails")
        return phases

    def _end_of(self, phases: tuple[Phase, ...]) -> Verdict:
        return self._judge.verdict(self._state.replace(at=slice(None), to=phases[-1].qpos[-1]))
