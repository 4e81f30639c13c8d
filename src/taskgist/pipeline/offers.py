"""Offers by what is known: the tasks that would help somebody who is after a thing, in a scene or a recording (9.8)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from taskgist.errors import KnowledgeError
from taskgist.facts.predicates import Predicate, known_predicates
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import HypothesisTree
from taskgist.learning.knowledge import Knowledge
from taskgist.learning.task_clauses import contradicted_tasks, learned_clause
from taskgist.learning.understanding import PAPER, Clause
from taskgist.pipeline.under_way import until
from taskgist.planning.offers import Offers, offers_for
from taskgist.recognition.intentions import Intention, intentions_at_the_end
from taskgist.recording.recording import Recording
from taskgist.settings import DEFAULT, Settings
from taskgist.world.stage import Stage


@dataclass(frozen=True)
class OffersTo:
    """Who is after a thing, as it was seen, and what can be offered.

    Attributes:
        intention: Who, after what, and what tells.
        offers: What can be offered.
    """

    intention: Intention
    offers: Offers


def known_clauses(
    knowledge: Knowledge, rule: str | None = None, tree: HypothesisTree = STANDARD_TREE
) -> tuple[Clause, ...]:
    """What each known task means for its target agents; without tasks of which nothing was learned.

    Those whose answers contradict each other are left out (``contradicted_tasks``), unless the paper's rule is asked
    for.

    Args:
        knowledge: What is known.
        rule: By which rule; None: the one that speaks of each task.
        tree: The tree that it was explained with.

    Raises:
        KnowledgeError: No task is known that is done for another.
        ContradictionError: Answers about each of them contradict each other.
        UnknownNameError: There is no such rule.
    """
    tasks = [task for task in knowledge.tasks if "target" in knowledge.trees_of(task)]
    if not tasks:
        raise KnowledgeError("no task is known that is done for another", hint="learn some: taskgist learn --help")
    left_out = {} if rule == PAPER else contradicted_tasks(knowledge, tree)
    if len(left_out) == len(tasks):
        raise left_out[tasks[0]]
    clauses = (learned_clause(knowledge, task, rule, tree) for task in tasks if task not in left_out)
    return tuple(clause for clause in clauses if clause.literals)


def offers_in(
    recording: Recording,
    time_s: float,
    clauses: Iterable[Clause],
    *,
    tree: HypothesisTree = STANDARD_TREE,
    settings: Settings = DEFAULT,
    predicates: Iterable[Predicate] | None = None,
) -> tuple[OffersTo, ...]:
    """What can be offered at a moment of a recording to those who are seen to be after a thing.

    Args:
        recording: The recording; nothing after the moment is looked at.
        time_s: The moment, seconds.
        clauses: What the known tasks mean.
        tree: What the clauses were learned in.
        settings: All settings.
        predicates: A user's own predicates; by default all that are known.

    Raises:
        RecordingError: The moment is outside of the recording.
    """
    so_far = until(recording, time_s)
    known, told = tuple(clauses), known_predicates() if predicates is None else tuple(predicates)
    stage = Stage(so_far.scene, so_far.state(len(so_far) - 1))
    return tuple(
        OffersTo(
            each,
            offers_for(
                stage,
                each.agent,
                each.thing,
                each.ability,
                known,
                under_way=each.behaviour == "reaching",
                tree=tree,
                settings=settings,
                predicates=told,
            ),
        )
        for each in intentions_at_the_end(so_far, settings=settings)
    )
