"""What questions are worth, in demonstrations: a simulated teacher answers who knows the generator's intention alone.

**The teacher.** Each task of the generator has a check, by lines of sight and distances (``generator.intentions``).
What it demands is written down here in predicates (``INTENTIONS``), from the check's own words: who hides a thing
takes it out of view, so that seeing it becomes harder, and turning the head does not help. From this, and nothing
else, the teacher answers: *yes* where the intention entails what is asked, *no* where it contradicts it, *either*
where it leaves it open. It sees no demonstration, no fact of one, and nothing of the learner. It may be wrong, as
people are: that what is taken farther off becomes harder to reach is meant, and is not so in every demonstration by
the facts. How often its words hold by the facts is reported beside.

**The experiment.** After two demonstrations the learner asks, one question after the other, each the best one by what
is known then. It is judged as in ``clause_learning``, beside the same learner after further demonstrations without
any question.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from taskgist.common.arrays import Mask
from taskgist.common.workers import Progress, silent
from taskgist.facts import vocabulary as v
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.values import NEGLIGIBLE
from taskgist.learning.answers import Reply
from taskgist.learning.asking import Asking, told_by
from taskgist.learning.clauses import ClausePosterior, learn_clauses
from taskgist.learning.entailment import entailment_of
from taskgist.learning.evidence import Evidence
from taskgist.learning.literals import SetLiteral, vocabulary_by_node
from taskgist_lab.evaluation.clause_learning import MOST_RUNS, Judges, run_evidence
from taskgist_lab.evaluation.learner import Coded, in_random_order
from taskgist_lab.evaluation.values import CLEAN, Result, Spread

DEMONSTRATIONS = (1, 2, 3, 4, 5)
"""Demonstrations after which clauses are judged without any question."""
FIRST = (1, 2)
"""Demonstrations after which it is asked."""
QUESTIONS = 3
"""Questions that are asked, one after the other."""
OTHERS = (0, 5)
"""Other tasks that are known, beside neutral manipulations."""

_HIDDEN = (
    ("see.class", (v.BECOMES_DIFFICULT,)),  # in view before, no line of sight in the end
    ("see.effort.2", v.SEE_EFFORTS[2:]),  # nor from where a head that turns gets to
    ("visibility.class", (v.DECREASED,)),
    ("visibility.score.2", (NEGLIGIBLE,)),
)
_FARTHER = (("reach.class", (v.BECOMES_DIFFICULT,)), ("grasp.class", (v.BECOMES_DIFFICULT,)))
_STANDS = (
    ("placement.nature", (v.supportive_of(v.ON_SUPPORT), v.supportive_of(v.INSIDE_CONTAINER))),
    ("motion.status.2", (v.STATIC,)),
)
_HELD = (
    ("hands.class", (v.MANIP_GAINED,)),  # in a hand in the end, and in none before
    ("placement.nature", (v.supportive_of(v.IN_HAND),)),
    ("reach.effort.2", (v.REACH_EFFORTS[0],)),
    ("grasp.effort.2", (v.REACH_EFFORTS[0],)),
)

INTENTIONS: Mapping[str, tuple[tuple[str, tuple[str, ...]], ...]] = MappingProxyType(
    {
        "make accessible": (  # a free line of sight, and nearer, or no longer covered
            ("see.nature", (v.SUPPORTIVE,)),
            ("reach.class", (v.BECOMES_EASIER,)),
        ),
        "hide": _HIDDEN,
        "show": (  # comes into view, or before the eyes
            ("see.nature", (v.SUPPORTIVE,)),
            ("visibility.class", (v.INCREASED,)),
        ),
        "give": _HELD,
        "put away": (  # in view all the time, farther off, and standing on something
            ("see.class", (v.REMAINS_SAME,)),
            *_FARTHER,
            ("placement.nature", (v.supportive_of(v.ON_SUPPORT),)),
            ("motion.status.2", (v.STATIC,)),
        ),
        "hide away": (*_HIDDEN, *_FARTHER, *_STANDS),
    }
)
"""What the generator's check of each task demands, in predicates: nodes with the values that they may have."""


def intention(task: str) -> tuple[SetLiteral, ...]:
    """What is meant by a task, as literals.

    Raises:
        KeyError: The generator has no check of it.
    """
    known = vocabulary_by_node(STANDARD_TREE)
    return tuple(known[node].literal(values) for node, values in INTENTIONS[task])


@dataclass(frozen=True)
class Teacher:
    """Somebody who means something, and answers accordingly."""

    meant: tuple[SetLiteral, ...]

    def answer(self, literal: SetLiteral) -> Reply:
        """Whether it must be so."""
        entailment = entailment_of(STANDARD_TREE)
        asked = entailment.worlds(literal)
        meant = entailment.together(self.meant).get(asked.space, entailment.all(asked.space))
        if not meant & ~asked.bits:
            return Reply.YES
        return Reply.EITHER if meant & asked.bits else Reply.NO


@dataclass(frozen=True)
class Taught:
    """How well clauses do after so many demonstrations and questions: F1 as means over tasks.

    Attributes:
        others: Other tasks that were known.
        demonstrations: How many were seen.
        questions: How many were answered, at most: it is not asked on where nothing is left to ask.
        as_played: Judged by the one task that a demonstration was played as.
        as_fulfilled: Judged by all tasks that it fulfils.
        asked: Questions that were asked of each task, mean.
    """

    others: int
    demonstrations: int
    questions: int
    as_played: Spread
    as_fulfilled: Spread
    asked: float


@dataclass(frozen=True)
class Asked(Result):
    """What questions are worth."""

    rows: tuple[Taught, ...]
    runs: int
    truth: Mapping[str, float]
    """In which share of the clean demonstrations that fulfil a task its teacher's words hold, by task and literal."""
    replies: Mapping[str, int]
    """How often each answer was given."""


def ask_and_learn(
    evidence: Evidence, task: str, teacher: Teacher, questions: int
) -> list[tuple[ClausePosterior, Reply]]:
    """What is known of a task after each answer of a teacher; shorter where nothing is left to ask.

    Args:
        evidence: Demonstrations.
        task: The task.
        teacher: Who answers.
        questions: How many are asked, at most.
    """
    said: list[tuple[SetLiteral, Reply]] = []
    posterior = learn_clauses(evidence, task)
    found = []
    for _ in range(questions):
        asked = Asking(evidence, posterior, STANDARD_TREE, told_by(said, STANDARD_TREE)).questions()
        if not asked:
            break
        said.append((asked[0].literal, teacher.answer(asked[0].literal)))
        posterior = learn_clauses(evidence, task, STANDARD_TREE, told_by(said, STANDARD_TREE))
        found.append((posterior, said[-1][1]))
    return found


def asking(
    coded: Coded,
    *,
    runs: int,
    seed: int,
    others: Sequence[int] = OTHERS,
    demonstrations: Sequence[int] = DEMONSTRATIONS,
    progress: Progress = silent,
) -> Asked:
    """Compare questions with demonstrations.

    Args:
        coded: A pool of demonstrations of the paper's tasks.
        runs: Random orders of each task; ``MOST_RUNS`` at most.
        seed: Their seed.
        others: Numbers of other tasks that are known; more than there are are left out.
        demonstrations: After how many it is judged; after those of ``FIRST`` it is asked, too.
        progress: Told how far it is.

    Raises:
        InputError: The pool has no demonstrations of a task to learn from, or none held out.
    """
    judges, runs = Judges.of(coded), min(runs, MOST_RUNS)
    orders = {task: in_random_order(coded, task, runs=runs, seed=seed) for task in coded.pool.tasks}
    teachers = {task: Teacher(intention(task)) for task in orders}
    rows: list[Taught] = []
    replies = dict.fromkeys((reply.value for reply in Reply), 0)
    settings = [(count, after) for count in others if count < len(orders) for after in demonstrations]
    for number, (count, after) in enumerate(settings):
        questions = QUESTIONS if after in FIRST else 0
        held: list[dict[str, list[Mask]]] = [{task: [] for task in orders} for _ in range(questions + 1)]
        asked = [0] * (questions + 1)
        for place, task in enumerate(orders):
            progress("asking", (number + place / len(orders)) / len(settings))
            for run in range(runs):
                evidence = run_evidence(coded, orders, task, run, after=after, others=count, seed=seed)
                known = judges.holds(learn_clauses(evidence, task))
                held[0][task].append(known)
                answered = ask_and_learn(evidence, task, teachers[task], questions)
                for index in range(1, questions + 1):
                    if index <= len(answered):
                        posterior, reply = answered[index - 1]
                        known = judges.holds(posterior)
                        replies[reply.value] += 1
                    asked[index] += min(index, len(answered))
                    held[index][task].append(known)
        for index, by_task in enumerate(held):
            scores = judges.scores({task: np.stack(each) for task, each in by_task.items()})
            rows.append(Taught(count, after, index, *scores, asked[index] / (len(orders) * runs)))
    return Asked(tuple(rows), runs, _truth(coded), replies)


def _truth(coded: Coded) -> dict[str, float]:
    """How often the teachers' words hold by the facts, where these are known."""
    found = {}
    clean = [each for each in coded.pool.samples if each.condition == CLEAN]
    for task in coded.pool.tasks:
        columns = {node: coded.index(node) for node, _ in INTENTIONS[task]}
        done = [each for each in clean if each.fulfils(task)]
        for literal in intention(task):
            values = [each.values[columns[literal.node]] for each in done]
            known = [value for value in values if value is not None]
            holding = sum(literal.admits(value) for value in known)
            found[f"{task}: {literal}"] = holding / len(known) if known else float("nan")
    return found
