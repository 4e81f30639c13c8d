"""Endings: what is moved where so that the goal holds, whoever does it and from whatever state (9.1, 9.2).

The thing itself may go anywhere that satisfies the goal; something else may go over it; what is in somebody's way may
go elsewhere. All of these are candidates of one kind, and one judge says of each final state whether it will do.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from taskgist.facts import vocabulary as v
from taskgist.facts.predicates import Predicate
from taskgist.perspective.effort import NO_KNOWN_LEVEL
from taskgist.perspective.scene_efforts import SceneEfforts
from taskgist.planning.actions import WhyNot
from taskgist.planning.aims import Aim, Judges
from taskgist.planning.candidates import candidates, check_supports, in_turn
from taskgist.planning.covering import covers
from taskgist.planning.goal import Goal
from taskgist.planning.handing import Taker
from taskgist.planning.judging import EndFails, Judge, Reason, Verdict
from taskgist.planning.placing import Candidate, Means
from taskgist.planning.requests import Request
from taskgist.planning.resting import level_faces
from taskgist.planning.robot_taking import taker_of
from taskgist.settings import Settings
from taskgist.world.contacts import rest_of
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
HANDED: tuple[Means, ...] = ("hand_over",)
IN_AIR: frozenset[Means] = frozenset({"hold_up", "hand_over"})
"""Ways that are of one target agent."""
NOT_KNOWN = "it is not known whether that would do"
AWAY_M = 1e3
"""Where a thing is put that is thought away."""


class Judged(NamedTuple):
    """A candidate, and what is found of its state; or why the target agent does not take it there, in words."""

    candidate: Candidate
    verdict: Verdict | str


class Endings:
    """Final places of what is moved, each judged.

    Args:
        scene: The scene.
        state: Where everything is at the start.
        request: What is to be performed.
        aims: What is wanted, for each target agent; those first with the thing that is brought now.
        settings: All settings.
        predicates: A user's own predicates.
        lets_go: Whether the performer's hands must be empty in the end.
    """

    def __init__(
        self,
        scene: Scene,
        state: State,
        request: Request,
        aims: Sequence[Aim],
        settings: Settings,
        predicates: Sequence[Predicate],
        *,
        lets_go: bool = False,
    ) -> None:
        self._scene, self._state, self._request, self._settings = scene, state, request, settings
        self._aims, self._lets_go = tuple(aims), lets_go
        self._own = tuple(aim for aim in aims if aim.thing == request.thing)
        self._predicates = tuple(predicates)
        self._judges: dict[bytes, Judges] = {}
        # Names that nobody knows are told before any long work.
        self.judge(state)
        check_supports((*(request.allow or ()), *request.prefer), level_faces(Stage(scene, state), request.thing))

    def judge(self, state: State) -> Judges:
        """The judges of states that differ little from one."""
        key = state.qpos.tobytes()
        if key not in self._judges:
            request = self._request
            self._judges[key] = Judges(
                [
                    Judge(
                        self._scene,
                        state,
                        aim.agent,
                        aim.thing,
                        aim.goal,
                        self._settings,
                        self._predicates,
                        attention=request.attention,
                        performer=request.performer,
                        watched=request.thing,
                    )
                    for aim in self._aims
                ]
            )
        return self._judges[key]

    def why_not(self, state: State, agent: str) -> WhyNot:
        """Why a final state, as an agent leaves it that began in another one, does not satisfy the goal."""
        judge = self.judge(state)

        def asked(end: State) -> Reason | None:
            verdict = judge.verdict(end)
            if verdict.holds is True:
                return None
            if verdict.failed is None:
                return f"with {agent} where it is in the end, {NOT_KNOWN}"
            return EndFails(agent, verdict.failed)

        return asked

    def moved(self, state: State, agent: str) -> Iterator[Judged]:
        """The thing itself elsewhere, in the order in which places are tried."""
        request, judge = self._request, self.judge(state)
        takers = {name: self._taker(name, state) for name in request.targets}
        # Places on supports are the same for all; those before a face, or in a hand, are of one of them.
        means = {name: self._means(name) for name in request.targets}
        for name in request.also_for:
            means[name] = tuple(each for each in means[name] if each in IN_AIR)
        asked = (
            candidates(
                Stage(self._scene, state),
                request.thing,
                agent,
                target,
                self._settings,
                allow=request.allow,
                prefer=request.prefer,
                means=means[target],
                seed=request.seed,
            )
            for target in request.targets
            if means[target]
        )
        for candidate in in_turn(list(asked)):
            end: State | str = candidate.state
            if candidate.means == "hand_over":
                end = takers[candidate.carrier].holding(candidate.state, request.thing)
            yield Judged(candidate, end if isinstance(end, str) else judge.verdict(end))

    def _taker(self, name: str, state: State) -> Taker:
        return taker_of(self._scene, name, state, self._settings, seed=self._request.seed)

    def covered(self, state: State, agent: str, cover: str) -> Iterator[Judged]:
        """A cover over the thing, which stays where it is."""
        request, stage = self._request, Stage(self._scene, state)
        found = covers(stage, request.thing, cover, agent, request.target, self._settings, seed=request.seed)
        return self._judged(state, found)

    def cleared(self, state: State, agent: str, other: str) -> Iterator[Judged]:
        """Something that is in the way elsewhere."""
        return self._judged(state, self.put(state, agent, other))

    def put(self, state: State, agent: str, other: str) -> Iterator[Candidate]:
        """Where something may be put down on the way: on what may be used, or what it is on already."""
        request, stage = self._request, Stage(self._scene, state)
        able = {face.owner for face in level_faces(stage, other)}
        rest = rest_of(stage, other, self._settings.contact)
        allow = None
        if request.allow is not None:
            allow = tuple(name for name in able if name in (*request.allow, rest.support, rest.container))
        return candidates(
            stage,
            other,
            agent,
            request.target,
            self._settings,
            allow=allow,
            prefer=tuple(name for name in request.prefer if name in able),
            seed=request.seed,
        )

    def handed(self, state: State, agent: str, helper: str) -> Iterator[Candidate]:
        """Where the thing may be handed over to a person who helps."""
        request, taker = self._request, self._taker(helper, state)
        found = candidates(
            Stage(self._scene, state),
            request.thing,
            agent,
            helper,
            self._settings,
            means=HANDED,
            seed=request.seed,
        )
        return (each for each in found if isinstance(taker.holding(each.state, request.thing), State))

    def _judged(self, state: State, found: Iterator[Candidate]) -> Iterator[Judged]:
        judge = self.judge(state)
        return (Judged(candidate, judge.verdict(candidate.state)) for candidate in found)

    def _means(self, name: str) -> tuple[Means, ...]:
        """How the thing may get where it shall be for all, before a target agent's face or into its hand if in any's.

        What brings about the placement that is wanted, and that hands hold it, or do not.
        """
        return tuple(
            means
            for means in ENDS
            if not (self._lets_go and means == "hold_up")
            and all(
                _brings_about(aim.goal, means, taken=means == "hand_over" and aim.agent == name) for aim in self._own
            )
        )

    # --- What it takes the target agents.

    @property
    def target_takes(self) -> bool:
        """Whether the goal is that target agents get at the thing, so that their own effort is a cost."""
        wanted = (aim.goal.wants(f"{ability}.effort") for ability in ("reach", "grasp") for aim in self._own)
        return any(each is not None and NO_KNOWN_LEVEL not in each.levels for each in wanted)

    def target_levels(self, candidate: Candidate) -> dict[str, int]:
        """The least effort level with which each target agent reaches the thing at a place; none known: 5."""
        efforts = SceneEfforts(Stage(self._scene, candidate.state.with_holding(None)), self._settings)
        found = {name: efforts.effort(name, self._request.thing, "reach").level for name in self._request.targets}
        return {name: NO_KNOWN_LEVEL if level is None else level for name, level in found.items()}

    # --- What is in the way.

    def others(self, state: State) -> tuple[str, ...]:
        """Things besides the thing itself whose place is known."""
        return tuple(name for name in self._scene.objects if name != self._request.thing and state.known([name]))

    def upon(self, state: State, name: str) -> tuple[str, ...]:
        """Things that stand or lie on a thing, or in it."""
        stage, contact = Stage(self._scene, state), self._settings.contact
        known = [other for other in self._scene.objects if other != name and state.known([other])]
        rests = {other: rest_of(stage, other, contact) for other in known}
        return tuple(other for other, rest in rests.items() if name in (rest.support, rest.container))

    def occluders(self, state: State) -> tuple[str, ...]:
        """Things without which the goal would hold as all else is; if none alone, those that hide the thing most."""
        judge, others = self.judge(state), self.others(state)
        alone = tuple(name for name in others if judge.verdict(self.without(state, name)).holds is True)
        if alone:
            return alone
        hiding = [each.evidence.get("occluders", ()) for each in judge.observed(state, "visibility.score")]
        pairs = [pair for each in hiding if isinstance(each, Sequence) for pair in each]
        names = dict.fromkeys(str(pair[0]) for pair in pairs if isinstance(pair, Sequence))
        return tuple(name for name in names if name in others)

    def without(self, state: State, name: str) -> State:
        """A state with a thing thought away."""
        column = self._scene.object_slice(name)
        pose = np.array(state.qpos[column])
        pose[0] += AWAY_M
        return state.replace(at=column, to=pose)

    def blockers(self, state: State, able: Callable[[State], bool]) -> tuple[str, ...]:
        """Things without which, and what lies on them, somebody would be able to do what it is not now."""
        return tuple(name for name in self.others(state) if able(self._without_all(state, name)))

    def _without_all(self, state: State, name: str) -> State:
        """A state with a thing, and what stands or lies on it, thought away."""
        for upon in (*self.upon(state, name), name):
            state = self.without(state, upon)
        return state


def _brings_about(goal: Goal, means: Means, *, taken: bool) -> bool:
    """Whether a goal's placement can come of a means, and its hands of whether the target agent takes the thing."""
    placement, hands = goal.wants("placement"), goal.wants("hands")
    if placement is not None and ENDS[means] not in (placement.values or ()):
        return False
    if hands is None or hands.values is None:
        return True
    return taken in [v.HOLDING_OBJECT in final.values() for final in hands.values if isinstance(final, Mapping)]


def laden(thing: str, upon: Sequence[str]) -> str:
    """Why a thing is not carried: what stands or lies on it, or in it, would be left in the air."""
    return f"on the {thing}, or in it, there is the {' and the '.join(upon)}"
