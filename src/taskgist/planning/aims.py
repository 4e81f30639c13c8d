"""Aims: what a task asks for one target agent with one thing; where there are several, all must come true (9.6, 9.7).

A clause says what is to become true for *the* target agent with *the* object. Hidden from P2 and P3 means hidden from
each: one place must do for both, though what is harder than now is another level for each. So each target agent has a
goal and a judge of its own, and a state will do if all of them say so.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from taskgist.facts.predicates import Predicate
from taskgist.facts.tree import HypothesisTree
from taskgist.facts.values import UNKNOWN, Observation, Raw
from taskgist.learning.understanding import AnyLiteral, Clause
from taskgist.observe.attributes import resting_snapshot
from taskgist.planning.goal import Goal, Impossible, Wanted, is_taken
from taskgist.planning.judging import Judge, Verdict
from taskgist.settings import Settings
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist.world.state import State


@dataclass(frozen=True, eq=False)
class Aim:
    """What is wanted for one target agent with one thing.

    Attributes:
        agent: The target agent.
        thing: The thing.
        goal: What is wanted, from how things are for this agent at the start.
    """

    agent: str
    thing: str
    goal: Goal


def aims_of(
    scene: Scene,
    start: State,
    clause: Clause,
    agents: Sequence[str],
    thing: str,
    tree: HypothesisTree,
    settings: Settings,
    predicates: Sequence[Predicate] = (),
) -> tuple[Aim, ...]:
    """The aims of a clause for some target agents with a thing, in the order of the agents.

    Args:
        scene: The scene.
        start: Where everything is before anything is done.
        clause: The meaning of the task.
        agents: The target agents.
        thing: The thing.
        tree: The tree that the clause was learned in.
        settings: All settings.
        predicates: A user's own predicates.

    Raises:
        UnknownNameError: There is no such agent or thing.
    """
    stage, found = Stage(scene, start), list[Aim]()
    for agent in agents:
        known = resting_snapshot(stage, agent=agent, name=thing, settings=settings, predicates=predicates)
        found.append(Aim(agent, thing, Goal.of(clause, known, tree, settings)))
    return tuple(found)


def goal_of_all(aims: Sequence[Aim]) -> Goal:
    """What is wanted, given here, not to be judged, or impossible for any of some aims, each once.

    What several want is as the first has it: levels and scores that will do are each one's own.

    Args:
        aims: Of one or more target agents with one or more things.
    """
    wanted, known = list[Wanted](), set[AnyLiteral]()
    for each in (each for aim in aims for each in aim.goal.wanted):
        if not known.issuperset(each.literals):
            wanted.append(each)
            known |= set(each.literals)
    given = dict.fromkeys(each for aim in aims for each in aim.goal.given)
    unjudged = dict.fromkeys(each for aim in aims for each in aim.goal.unjudged)
    impossible = {each.why: each for aim in aims for each in aim.goal.impossible}
    for thing in dict.fromkeys(aim.thing for aim in aims):
        taken = [aim for aim in aims if aim.thing == thing and is_taken(aim.goal.wanted)]
        if len(taken) > 1:
            hands = taken[0].goal.wants("hands")
            assert hands is not None
            who = " and of ".join(aim.agent for aim in taken)
            why = f"the {thing} cannot be in the hands of {who} at once"
            impossible[why] = Impossible(hands.attribute, hands.literals, hands.aspect.initial, why)
    return Goal(
        aims[0].goal.clause,
        given=tuple(given),
        wanted=tuple(wanted),
        impossible=tuple(impossible.values()),
        unjudged=tuple(unjudged),
        circumstances=tuple(dict.fromkeys(each for aim in aims for each in aim.goal.circumstances)),
        dropped=tuple(dict.fromkeys(each for aim in aims for each in aim.goal.dropped)),
    )


class Judges:
    """Judges who must all agree.

    Args:
        judges: One or more, those first who are cheap to ask or fail often.
    """

    def __init__(self, judges: Sequence[Judge]) -> None:
        self.judges = tuple(judges)

    def verdict(self, state: State) -> Verdict:
        """Whether all say that a final state will do; the first who says no is who says so (``Verdict.judge``)."""
        first, unknown = Verdict(True), False
        for number, judge in enumerate(self.judges):
            found = judge.verdict(state)
            if found.holds is False:
                return replace(found, judge=number)
            first, unknown = (found if number == 0 else first), unknown or found.holds is UNKNOWN
        return replace(first, holds=UNKNOWN) if unknown else first

    def observed(self, state: State, attribute: str) -> tuple[Observation[Raw], ...]:
        """What an attribute is in a final state for each of them."""
        return tuple(judge.observed(state, attribute) for judge in self.judges)
