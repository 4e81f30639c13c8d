"""A whole performance: a clause and a room in, a plan carried out, audited and judged out (9.1).

Each plan that the planner finds is carried out, looked at by the audit, which believes nothing that the planner said,
and judged by the very facts that explain demonstrations. One that does not come through is counted and thrown away,
and the next one is asked for; only what is clean and judged true is returned::

    outcome = perform(scene, Request(clause, "PR2", "P2", "tape"))
    for performance in outcome.performances:
        write(performance.execution.recording, "done.mcap")

Circumstances of the clause (usually the thing ends on a support; in all demonstrations it was out of view) are
respected where they can be had: they are wanted beside it, but for those that the start rules out. Where nothing comes
through so, one is left out and it is tried again. It is the last to be judged of those that refused ends: what fails
there has all that is judged before it. (The one that refuses most is mostly but the first to be judged.) Where the
thing is to end stays wanted until no other one refuses any: what is held up for a moment is not put away. After
``LEFT_ONE_BY_ONE`` of them all others go at once, and then where it ends. So there are at most ``LEFT_ONE_BY_ONE`` + 3
searches, the last by the clause alone. The cup shall be harder to reach, and beside that hidden, and grasped without
any effort, which is never so at once::

    of 1400 places 0 will do: at 1020 it is not hidden, at 239 not harder to reach, at 141 not grasped without effort
    left out: that it is grasped without effort. Then those 141 will do, where it is hidden

They spoil no performance: whether each holds in it is told.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from taskgist.common.extras import door
from taskgist.common.frozen import FrozenMap
from taskgist.common.workers import Progress, silent
from taskgist.facts.predicates import Predicate
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import HypothesisTree, Nodes
from taskgist.facts.values import Unknown
from taskgist.learning.explanation import Explanation
from taskgist.learning.understanding import AnyLiteral, Clause, conjunction
from taskgist.performing.audit import audit
from taskgist.performing.execution import Execution, carried_out
from taskgist.performing.findings import Audit, MotionLimits
from taskgist.pipeline.explain import explain_recording
from taskgist.planning.goal import Dropped, Goal
from taskgist.planning.helping import Help
from taskgist.planning.one_by_one import OneByOne
from taskgist.planning.pddl import Pddl
from taskgist.planning.performer import Performer
from taskgist.planning.persons import moves_itself
from taskgist.planning.plan import Plan
from taskgist.planning.requests import Request, Search
from taskgist.settings import DEFAULT, Planning, Settings
from taskgist.world.scene import Scene
from taskgist.world.state import State

NONE_SO = "no way was found in which it is so"
NONE_BESIDE = "no way was found in which it is so beside the other circumstances"
"""Why circumstances are dropped that the start does not rule out."""
LEFT_ONE_BY_ONE = 2
"""So many circumstances are left out one by one, each after a search in vain, before all are (ours)."""


@dataclass(frozen=True, eq=False)
class Performance:
    """A task performed.

    Attributes:
        plan: What was done.
        execution: What happened.
        audit: What the audit looked at; it is clean.
        explanation: The facts of what happened.
        strict: Whether the whole clause holds, given literals among it.
        circumstances: Whether each circumstance of the clause holds in what happened.
    """

    plan: Plan
    execution: Execution
    audit: Audit
    explanation: Explanation
    strict: bool | Unknown
    circumstances: FrozenMap[AnyLiteral, bool | Unknown]


@dataclass(frozen=True, eq=False)
class Outcome:
    """What came of a request.

    Attributes:
        request: What was asked for.
        goal: What was wanted, given and impossible.
        performances: Those that came through, different ways; none: see ``search``.
        search: What became of the candidates.
        spoiled: Why plans were thrown away after they were carried out, a sentence for each.
        planner: What planned it.
        helps: If nothing came through: changes of the room with which it would.
        dropped: Circumstances that could not be had.
    """

    request: Request
    goal: Goal
    performances: tuple[Performance, ...]
    search: Search
    spoiled: tuple[str, ...]
    planner: OneByOne
    helps: tuple[Help, ...] = ()
    dropped: tuple[Dropped, ...] = ()

    def pddl(self) -> Pddl:
        """The same problem for other planners, with the plans that came through as sequences of its actions."""
        return self.planner.pddl([found.plan for found in self.performances])


def perform(
    scene: Scene,
    request: Request,
    *,
    state: State | None = None,
    ways: int = 1,
    tree: HypothesisTree = STANDARD_TREE,
    settings: Settings = DEFAULT,
    predicates: Sequence[Predicate] = (),
    progress: Progress = silent,
) -> Outcome:
    """Plan a task, carry it out, audit and judge it.

    Args:
        scene: The room, with the performer, the target agent and the thing in it.
        request: What is to be performed.
        state: Where everything is; by default as the scene has it.
        ways: How many different ways are asked for.
        tree: The tree that the clause was learned in.
        settings: All settings.
        predicates: A user's own predicates.
        progress: Told how far it is.

    Raises:
        UnknownNameError: There is no such agent, thing or support.
        SceneError: The performer has no arm or no hand that grasps.
        InputError: OMPL or toppra, the extra ``planning``, is not installed, and robots perform or may help.
    """
    state = scene.initial if state is None else state
    found, spoiled, dropped = list[Performance](), list[str](), dict[AnyLiteral, Dropped]()
    clause, searches = request.clause, 0
    while True:
        planner = OneByOne(
            scene, state, replace(request, clause=clause), tree=tree, settings=settings, predicates=predicates
        )
        if not all(moves_itself(scene.agent(name)) for name in planner.may_act):
            planners()  # before any long work
        spoiled.clear()
        for plan in planner.plans(progress):
            progress("carrying the plan out", 1.0)
            tried = _tried(planner, plan, request.clause.circumstances, tree, settings, predicates)
            if isinstance(tried, Performance):
                found.append(tried)
            else:
                spoiled.append(tried)
            if len(found) == ways:
                break
        searches += 1
        dropped |= {each.literal: each for each in planner.goal.dropped if each.literal not in dropped}
        kept = planner.goal.circumstances
        if found or not kept:
            break
        left = _left_next(clause, planner, one=searches <= LEFT_ONE_BY_ONE)
        why = NONE_SO if len(kept) == 1 else NONE_BESIDE
        dropped |= {literal: Dropped(literal, why) for literal in left if literal in kept}
        usual, always = (tuple(each for each in part if each not in left) for part in (clause.usual, clause.always))
        clause = replace(clause, usual=usual, always=always)
    if not found:
        progress("what would help", 1.0)
    helps = () if found else planner.helps()
    # One that another ruled out may have been admitted once that was left.
    not_had = tuple(each for literal, each in dropped.items() if literal not in planner.goal.circumstances)
    return Outcome(request, planner.goal, tuple(found), planner.search, tuple(spoiled), planner, helps, not_had)


def planners() -> None:
    """See that what robots' ways are planned with is there.

    Raises:
        InputError: OMPL or toppra, the extra ``planning``, is not installed.
    """
    for module in ("ompl", "toppra"):
        door(module, "planning")


def _left_next(clause: Clause, planner: OneByOne, *, one: bool) -> tuple[AnyLiteral, ...]:
    """The circumstances that are left out after a search in vain: one, or all but where the thing ends; then that."""
    kept, placement = planner.goal.circumstances, planner.goal.wants("placement")
    placed = tuple(each for each in kept if placement is not None and each in placement.literals)
    judged = [each for wanted in planner.goal.wanted for each in wanted.literals if each in kept and each not in placed]
    refusing = [each for each in judged if planner.search.refused_by(each)]
    if refusing:
        return (refusing[-1],) if one else tuple(each for each in clause.circumstances if each not in placed)
    # Ways that end elsewhere are not even looked for, and so counted nowhere.
    return placed or clause.circumstances


def _tried(
    planner: OneByOne,
    plan: Plan,
    circumstances: Sequence[AnyLiteral],
    tree: HypothesisTree,
    settings: Settings,
    predicates: Sequence[Predicate],
) -> Performance | str:
    """A plan carried out, audited and judged; a sentence if it does not come through."""
    scene, request = planner.scene, planner.request
    execution = carried_out(scene, plan, attention=request.attention)
    recording = execution.recording
    for let_go in execution.settled:
        if not let_go.stays:
            return f"once it is let go, {let_go.text}"
    # Whoever takes moves, too, and pushes into nothing either.
    moving = dict.fromkeys((*plan.performers, *sorted({hold.agent for holds in execution.holds for hold in holds})))
    limits = {name: limits_of(planner.robot(name), settings.planning) for name in moving}
    found = audit(
        scene,
        recording.times_s,
        recording.qpos,
        execution.holds,
        limits,
        soft=[name for name in plan.performers if planner.robot(name) is None],
        planned=plan.phases[-1].qpos[-1],
        contact=settings.contact,
    )
    if not found.clean:
        return f"the audit found: {found.findings[0].text}"
    explanation = explain_recording(recording, tree=tree, settings=settings, predicates=predicates)
    for aim in planner.aims:
        nodes = explanation.part(aim.agent, aim.thing).nodes
        failed = next((each for each in aim.goal.controllable if each.holds(nodes) is not True), None)
        if failed is not None:
            value = nodes[failed.node].value if failed.node in nodes else "not observed"
            whose = f" for {explanation.called(explanation.part(aim.agent, aim.thing))}" if explanation.parts else ""
            return f"judged by its facts {failed} fails{whose}: it is {value}"
    parts: Sequence[Nodes] = [each.nodes for each in explanation.parts or (explanation,)]
    strict = conjunction(request.clause.holds(nodes) for nodes in parts)
    so = FrozenMap({literal: conjunction(literal.holds(nodes) for nodes in parts) for literal in circumstances})
    return Performance(plan, execution, found, explanation, strict, so)


def limits_of(performer: Performer | None, planning: Planning) -> MotionLimits:
    """How fast a robot may move by the settings: its arms, lifts, hands and base; people move as they do."""
    if performer is None:
        return MotionLimits()
    speeds, accelerations = dict[str, float](), dict[str, float]()
    names = {position: name for name, position in performer.agent.joints.items()}
    for gripper in map(performer.gripper, performer.sides):
        widths = np.abs(gripper.wide - gripper.closed).tolist()  # how far each joint goes from closed to open
        for position, width in zip(gripper.positions.tolist(), widths, strict=True):
            speeds[names[position]] = width / planning.closing_s
    for chain in map(performer.chain, performer.sides):
        for name, lifts in zip(chain.names, chain.lifts.tolist(), strict=True):
            speeds[name] = planning.lift_m_s if lifts else planning.joint_rad_s
            accelerations[name] = planning.lift_m_s2 if lifts else planning.joint_rad_s2
    base = (planning.base_m_s, planning.base_m_s2, planning.base_rad_s, planning.base_rad_s2)
    return MotionLimits(speeds, accelerations, *base)
