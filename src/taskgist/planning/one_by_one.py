"""Several things: one after the other, each from where everything is once the one before is there (9.7).

Pen and paper are given one by one. Each thing has plans of its own, which begin where the plan before has left
everything: the robot where it stands then, what was let go where physics has it, and what the other holds by then in
its hand, wherever that moves. What has been brought about must stay so: the judges of things that came before are
asked about every end as well. Where the next thing finds no way, another plan for the one before is tried.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import chain, islice

import numpy as np

from taskgist.common.arrays import Array
from taskgist.common.workers import Progress, silent
from taskgist.errors import SceneError
from taskgist.facts.predicates import Predicate
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import HypothesisTree
from taskgist.planning.actions import after
from taskgist.planning.aims import Aim, aims_of, goal_of_all
from taskgist.planning.goal import Goal
from taskgist.planning.helping import Help
from taskgist.planning.pddl import Pddl
from taskgist.planning.performer import Performer
from taskgist.planning.plan import Action, Cost, Plan, total_cost
from taskgist.planning.planner import Planner
from taskgist.planning.requests import Request, Search, check_one_problem
from taskgist.settings import DEFAULT, Settings
from taskgist.world.geometry.transforms import matrix_from_wxyz, wxyz_from_matrix
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist.world.state import Hold, State

PLANS_OF_A_THING = 3
"""So many plans for a thing are tried as a beginning for what follows (ours)."""


class OneByOne:
    """Finds plans for a request, thing by thing; of one thing those of its planner.

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
        goal: What is wanted, given, or impossible, for any target agent with any thing.
        aims: What is wanted of each target agent with each thing.
        search: What became of the candidates of the thing that was looked at last.

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
        self.scene, self._state, self.request = scene, state, request
        self._tree, self._settings, self._predicates = tree, settings, tuple(predicates)
        self._planner = self._planner_for(request.thing, state, ())
        further = (
            aims_of(scene, state, request.clause, request.targets, thing, tree, settings, predicates)
            for thing in request.also_with
        )
        self.aims: tuple[Aim, ...] = (*self._planner.aims, *chain.from_iterable(further))
        self.goal: Goal = goal_of_all(self.aims)

    @property
    def search(self) -> Search:
        """What became of the candidates of the thing that was looked at last."""
        return self._planner.search

    @property
    def may_act(self) -> tuple[str, ...]:
        """The performer, and who may help it."""
        return self._planner.may_act

    def robot(self, name: str) -> Performer | None:
        """One of those who act, as it starts; None for a person."""
        return self._planner.robot(name)

    def helps(self) -> tuple[Help, ...]:
        """After a search in vain: the least changes of the room with which it would not have been."""
        return () if self.goal.impossible else self._planner.helps()

    def pddl(self, plans: Sequence[Plan] = ()) -> Pddl:
        """The same problem for other planners, the places of some plans among its places.

        Raises:
            InputError: There are several things, whose order and judges PDDL does not have.
        """
        check_one_problem(self.request)
        return self._planner.pddl(plans)

    def plans(self, progress: Progress = silent) -> Iterator[Plan]:
        """Plans for all things.

        Args:
            progress: Told how far it is.
        """
        if not self.goal.impossible:
            yield from self._plans(self._planner, (), (), (), progress)

    def _plans(
        self,
        planner: Planner,
        done: tuple[Action, ...],
        spent: tuple[Cost, ...],
        kept: tuple[Aim, ...],
        progress: Progress,
    ) -> Iterator[Plan]:
        """Plans that go on with a planner's thing, after actions that cost something for the things before."""
        things, thing = self.request.things, planner.request.thing
        rest = things[things.index(thing) + 1 :]
        holds = done[-1].phases[-1].holds if done else frozenset[Hold]()
        for plan in islice(planner.plans(progress), PLANS_OF_A_THING if rest or done else None):
            actions = tuple(_with_held(self.scene, action, holds) for action in plan.actions)
            if not rest:
                yield replace(
                    plan,
                    thing=things[0],
                    also_with=self.request.also_with,
                    actions=(*done, *actions),
                    cost=total_cost((*spent, plan.cost)),
                )
                continue
            end = self._end(planner, actions)
            if end is None:
                continue
            try:
                following = self._planner_for(rest[0], end, (*kept, *planner.aims))
            except SceneError as error:
                planner.search.refusals[f"from there it goes on with nothing: {error}"] += 1
                continue
            self._planner = following
            costs = (*spent, plan.cost)
            yield from self._plans(following, (*done, *actions), costs, (*kept, *planner.aims), progress)

    def _planner_for(self, thing: str, state: State, kept: tuple[Aim, ...]) -> Planner:
        return Planner(
            self.scene,
            state,
            replace(self.request, thing=thing, also_with=()),
            tree=self._tree,
            settings=self._settings,
            predicates=self._predicates,
            start=self._state,
            kept=kept,
            lets_go=thing != self.request.things[-1],
        )

    def _end(self, planner: Planner, actions: tuple[Action, ...]) -> State | None:
        """Where everything is after some actions; None if nothing can follow."""
        holds = actions[-1].phases[-1].holds
        performers = {action.performer for action in actions}
        own = next((hold for hold in sorted(holds) if hold.agent in performers), None)
        if own is not None:
            planner.search.refusals[f"{own.agent} has the {own.object} in its hand then, and more is to follow"] += 1
            return None
        end = after(self.scene, self._state.with_holding(None), actions[-1])
        if isinstance(end, str):
            planner.search.refusals[end] += 1
            return None
        return end


def _with_held(scene: Scene, action: Action, holds: Iterable[Hold]) -> Action:
    """An action during which somebody has something in the hand that it had before."""
    own = {hold.object for phase in action.phases for hold in phase.holds}
    kept = frozenset(hold for hold in holds if hold.object not in own)
    if not kept:
        return action
    phases, first = list[Array](), action.phases[0].qpos[0]
    for phase in action.phases:
        qpos = np.array(phase.qpos)
        for hold in kept:
            column = scene.object_slice(hold.object)
            qpos[:, column] = _carried(scene, hold, first, qpos)
        phases.append(qpos)
    return replace(
        action,
        phases=tuple(
            replace(phase, qpos=qpos, holds=phase.holds | kept)
            for phase, qpos in zip(action.phases, phases, strict=True)
        ),
    )


def _carried(scene: Scene, hold: Hold, first: Array, qpos: Array) -> Array:
    """Poses, (n, 7), of what a hand holds as it does in a first state, (nq,), through frames (n, nq)."""
    stage, column = Stage(scene), scene.object_slice(hold.object)
    body = scene.agent(hold.agent).arm(hold.side).hand_body
    hand = stage.show(State(first)).body(body)
    place, turn = hand.to_local(first[column][:3]), hand.matrix.T @ matrix_from_wxyz(first[column][3:])
    poses = np.empty((len(qpos), 7))
    for row, frame in zip(poses, qpos, strict=True):
        now = stage.show(State(frame)).body(body)
        row[:3], row[3:] = now.to_world(place), wxyz_from_matrix(now.matrix @ turn)
    return poses
