"""Offers: which known task would make it easier for an agent to get at a thing, by how much, and who could do it (9.8).

**The problem.** Somebody is after a thing and must stand up for it. What a task means says what becomes of that effort:
*make accessible* is about reaching that becomes easier; who is *given* a thing has it in hand. So whoever knows the
tasks knows what to offer.

**The way.** The clause of each task is turned into a goal here (``Goal``), which names the levels of the effort with
which the clause holds. Where all of them lie below the level now, the task lowers it, and to the greatest of them at
most. What was so in all demonstrations of a task, though it is not what the task is about, is told apart: planning
respects it where it can.

**Who could do it**: other agents who have the thing, or who grasp it with a hand that holds nothing else. A robot may
take any effort for that, people only less than it spares. If somebody has the thing, nobody else hands it on.

**When nothing is offered**: where the agent's own next act does it. What takes no more than stretching out an arm or
turning the head, people just do. Whose hand is on its way already leans along, too; but not where another has the
thing, who may let go of it or not.

No plan is made: whether there is a place and a way, ``planning.OneByOne`` tells.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from taskgist.errors import InputError
from taskgist.facts.predicates import Predicate
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import HypothesisTree, Snapshot
from taskgist.learning.understanding import Clause
from taskgist.observe.attributes import resting_snapshot
from taskgist.observe.observer import held_in
from taskgist.observe.relations import carried_by
from taskgist.perspective.effort import Ability, Effort
from taskgist.perspective.scene_efforts import SceneEfforts
from taskgist.planning.goal import Goal, is_taken
from taskgist.planning.persons import moves_itself
from taskgist.settings import DEFAULT, Settings
from taskgist.world.stage import Stage
from taskgist.world.state import HEADS_ALONE

OWN_ACT_LEVEL = 1
"""What takes no greater effort, an agent's next act does: it stretches out an arm, or turns the head."""
UNDER_WAY_LEVEL = 2
"""What takes no greater effort, an agent does whose hand is on its way already: it leans along."""
IN_HAND_LEVEL = 0
"""Effort for a thing that one has in hand."""

Declined = Literal["own act", "unknown effort", "no task", "nobody"]
"""Why nothing is offered: the agent's own next act does it; what it takes is unknown; no known task lowers it; nobody
could do it."""


@dataclass(frozen=True)
class Lowering:
    """A known task that lowers an effort.

    Attributes:
        task: Its name.
        level: To which level at most, by what the task is about; None where that leaves it open.
        level_in_all: To which level at most, if what was so in all its demonstrations is respected; None where that
            says no more.
        in_hand: Whether the agent has the thing in hand then.
    """

    task: str
    level: int | None
    level_in_all: int | None
    in_hand: bool

    @property
    def least(self) -> int:
        """The lower of the two."""
        return min(each for each in (self.level, self.level_in_all) if each is not None)


@dataclass(frozen=True)
class Helper:
    """Who could do it.

    Attributes:
        name: The agent.
        grasping: What it takes it to grasp the thing.
        robot: Whether it is no person.
        has_it: Whether it has the thing already.
    """

    name: str
    grasping: Effort
    robot: bool
    has_it: bool


@dataclass(frozen=True)
class Offers:
    """What can be offered to an agent who is after a thing.

    Attributes:
        effort: What it takes the agent now.
        tasks: The known tasks that lower that, the one that lowers it most first.
        helpers: Who could do them: robots first, then by their effort.
        unknown_helpers: Of whom that is unknown, for want of tracking.
        declined: Why nothing is offered; None where something is.
    """

    effort: Effort
    tasks: tuple[Lowering, ...] = ()
    helpers: tuple[Helper, ...] = ()
    unknown_helpers: tuple[str, ...] = ()
    declined: Declined | None = None


def offers_for(
    stage: Stage,
    agent: str,
    name: str,
    ability: Ability,
    clauses: Sequence[Clause],
    *,
    under_way: bool = False,
    tree: HypothesisTree = STANDARD_TREE,
    settings: Settings = DEFAULT,
    predicates: Iterable[Predicate] = (),
) -> Offers:
    """What can be offered to an agent who wants to see, reach or grasp an object.

    Args:
        stage: The scene in a state, taken as one in which all stands still; it shows the same one afterwards.
        agent: Whom it would help.
        name: The object that it is after.
        ability: What it wants: ``see``, ``reach`` or ``grasp``.
        clauses: What the known tasks mean for target agents.
        under_way: Whether the agent's hand is on its way to the object already.
        tree: What the clauses were learned in.
        settings: All settings.
        predicates: A user's own predicates.

    Raises:
        UnknownNameError: There is no such agent, object or ability.
        InputError: A clause is about who performs the task.
    """
    for clause in clauses:
        if clause.tree_of != "target":
            raise InputError(
                "what a task means for who performs it helps nobody else",
                where=f"task {clause.task}",
                hint="learn it for its target agents: taskgist learn --of target",
            )
    scene, shown = stage.scene, stage.state
    scene.agent(agent)
    scene.object_body(name)
    stage.show(shown.with_holding(None).with_eyes(HEADS_ALONE))
    try:
        efforts = SceneEfforts(stage, settings)
        effort = efforts.effort(agent, name, ability)
        level = effort.level
        if level is None:
            return Offers(effort, declined="unknown effort")
        others_have_it = bool(set(carried_by(stage, name, settings) or ()) - {agent})
        own_level = UNDER_WAY_LEVEL if under_way and not others_have_it else OWN_ACT_LEVEL
        if level <= own_level or _held_by(stage, agent, name, settings):
            return Offers(effort, declined="own act")
        start = resting_snapshot(stage, agent=agent, name=name, settings=settings, predicates=tuple(predicates))
        found = (lowering(clause, start, ability, level, tree, settings) for clause in clauses)
        tasks = sorted((each for each in found if each), key=lambda each: (each.least, each.task))
        if not tasks:
            return Offers(effort, declined="no task")
        helpers, unknown = _helpers(efforts, agent, name, level, settings)
    finally:
        stage.show(shown)
    return Offers(effort, tuple(tasks), helpers, unknown, None if helpers else "nobody")


def lowering(
    clause: Clause, start: Snapshot, ability: Ability, level: int, tree: HypothesisTree, settings: Settings = DEFAULT
) -> Lowering | None:
    """How far a task lowers an effort from what is known at the start; None where it need not.

    A task that cannot be done from this start lowers nothing.

    Args:
        clause: What the task means.
        start: What is so now for the agent and the thing, by attribute.
        ability: Of which effort.
        level: Its level now.
        tree: What the clause was learned in, or more.
        settings: All settings.
    """
    about = Goal.of(replace(clause, usual=(), always=()), start, tree, settings)
    if about.impossible:
        return None
    surely, in_all = _most(about, ability), None
    if clause.always:
        in_all = _most(Goal.of(replace(clause, usual=()), start, tree, settings), ability)
    surely, in_all = (each if each is not None and each < level else None for each in (surely, in_all))
    if in_all is not None and surely is not None and in_all >= surely:
        in_all = None
    if surely is None and in_all is None:
        return None
    return Lowering(clause.task, surely, in_all, is_taken(about.wanted))


def _most(goal: Goal, ability: Ability) -> int | None:
    """The greatest level of an effort with which all holds that is wanted; None where any will do."""
    if ability != "see" and is_taken(goal.wanted):
        return IN_HAND_LEVEL
    wanted = goal.wants(f"{ability}.effort")
    return max(wanted.levels) if wanted and wanted.levels else None


def _helpers(
    efforts: SceneEfforts, agent: str, name: str, level: int, settings: Settings
) -> tuple[tuple[Helper, ...], tuple[str, ...]]:
    """Who could do something with a thing for an agent to whom it takes an effort; and of whom that is unknown."""
    stage, helpers, unknown = efforts.stage, list[Helper](), list[str]()
    holders = carried_by(stage, name, settings) or ()
    for other in stage.scene.agents:
        if other == agent or (holders and other not in holders):
            continue
        body, effort = stage.scene.agent(other), efforts.effort(other, name, "grasp")
        robot, has_it = not moves_itself(body), other in holders
        if effort.level is None:
            unknown.append(other)
        elif has_it or (
            effort.is_known_to_do and (robot or effort.level < level) and _free_hand(stage, other, settings)
        ):
            helpers.append(Helper(other, effort, robot, has_it))
    helpers.sort(key=lambda each: (not each.robot, each.grasping.level or 0, _amount(each.grasping), each.name))
    return tuple(helpers), tuple(unknown)


def _amount(effort: Effort) -> tuple[float, ...]:
    return effort.amount.key if effort.amount else ()


def _free_hand(stage: Stage, agent: str, settings: Settings) -> bool:
    """Whether some hand of an agent holds nothing."""
    return any(held_in(stage, agent, side, settings.contact) is None for side in stage.scene.agent(agent).sides)


def _held_by(stage: Stage, agent: str, name: str, settings: Settings) -> bool:
    return any(held_in(stage, agent, side, settings.contact) == name for side in stage.scene.agent(agent).sides)
