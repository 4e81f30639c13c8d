"""Which of the known tasks was performed? Each with a probability of its own, and that it was none of them.

**The question.** Who hides a thing away hides it, too, so several tasks may be right at once; and most of what people
do all day is none of the tasks that somebody taught. So each task is asked for by itself: are the facts of an episode
better explained by *this is the task*, or by *this is something else*?

**The meaning speaks for a task.** A clause that holds in k of the task's n demonstrations, and in a share θ of the
background, holds in the next demonstration with probability p = (k + b) / (n + a + b), slips being Beta(a, b)
(``learning.clauses``). Where it holds, the likelihood ratio is p / θ; where it fails, (1 − p) / (1 − θ); where that is
unknown, 1. The forty best clauses vote with their posterior weights: the mean of their ratios counts.

**The least typical circumstance speaks against it.** A clause is compared with what is known, and a manipulation of a
kind that nobody has seen may fulfil it: who lifts a thing up may make it easier to see, and shows it to nobody. But
demonstrations of a task also agree in what is no part of its meaning: the thing comes to rest, the posture stays. For
each node with value v the ratio is (h + m θ) / ((n + m) θ), where h of the task's n demonstrations had v and a share θ
of the background has it: the m-estimate (Eq. 27) whose prior is what is usual, m = 2. To have what is usual says
hardly anything, to lack what always was so says much. The nodes of one subtree repeat each other, so their logarithms
are averaged; and subtrees depend on each other, so they are not added: the one that speaks most against counts, and
what speaks for the task does not.

**The probability.** With the prior odds π of a task, its odds are o = π · meaning · least typical circumstance, and its
probability by itself is o / (1 + o); a task that another one entails is at least as probable as that one lets expect
(``entailed``). That it is none of n known tasks has probability 1 / (1 + o₁ + … + oₙ): it is something else or one of
them, each weighing as its odds; and it is never more than what is left by the most probable one. π was fitted
(``PRIOR_ODDS``). Figures stand in docs/howto/recognition.md.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from taskgist.common.frozen import FrozenMap
from taskgist.errors import KnowledgeError
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import HypothesisTree, Nodes, TreeOf
from taskgist.facts.values import UNKNOWN, Unknown
from taskgist.learning.background import Background
from taskgist.learning.clauses import (
    NOTHING_TOLD,
    SLIPS,
    SMOOTHING,
    ClausePosterior,
    Support,
    Told,
    WeighedClause,
    learn_clauses,
)
from taskgist.learning.evidence import Evidence, Kind
from taskgist.learning.knowledge import Knowledge
from taskgist.learning.literals import SetLiteral, vocabularies
from taskgist.learning.task_clauses import LIKELY, contradicted_tasks, evidence_by_task, told_of
from taskgist.recognition.entailed import Entailed, entailed_tasks, raised

PRIOR_ODDS = 0.7
"""π: fitted on generated demonstrations of seed 101 (``taskgist evaluate recognition``): the log loss after 3 to 15
demonstrations of each of six tasks is within 0.02 of its least, and 3 % of what is a task are called none."""
PSEUDO = 2.0
"""m of the m-estimate of how often a task's demonstrations have a value: as a + b of the paper's default."""
NEARLY = 0.9
"""A task that entails the most probable one, and is at least so probable beside it, is named first (ours: with less the
more general one is missed, with more the more special one; seed 101)."""
LEAST_LN_ODDS = -30.0
"""Log odds are kept within ± 30: nothing is certain."""


@dataclass(frozen=True)
class LiteralWeight:
    """What one literal of a task's clause says about an episode.

    Args:
        literal: The literal.
        holds: Whether it holds there.
        weight: Natural logarithm of how much more often it holds, or fails, in the task's demonstrations than
            elsewhere; 0 where it is unknown.
    """

    literal: SetLiteral
    holds: bool | Unknown
    weight: float


@dataclass(frozen=True)
class Circumstance:
    """How typical of a task the values of one subtree are.

    Args:
        node: The node of the subtree that is least typical.
        title: Its title.
        value: Its value in the episode.
        usual: The value that the task's demonstrations have most often.
        weight: Natural logarithm of the likelihood ratio, the mean over the subtree's nodes.
    """

    node: str
    title: str
    value: str
    usual: str
    weight: float


@dataclass(frozen=True)
class TaskProbability:
    """How probable it is that an episode is a demonstration of a task, and what decides that."""

    task: str
    probability: float
    odds: float
    """By itself: π · meaning · least typical circumstance."""
    clause: WeighedClause
    """The task's best clause."""
    holds: bool | Unknown
    """Whether it holds in the episode."""
    literals: tuple[LiteralWeight, ...]
    """Those of the best clause, each by itself."""
    meaning: float
    """Natural logarithm of the likelihood ratio of what the task is about."""
    least_typical: Circumstance | None
    """The circumstance that speaks most against the task; None where none does."""
    entailed_by: str | None = None
    """The task that it is done with, where that makes it more probable than it is by itself."""


@dataclass(frozen=True)
class Recognised:
    """Which of the known tasks an episode is."""

    tasks: tuple[TaskProbability, ...]
    """All of them, the most probable first. Each probability is its own: several may be near 1."""
    none: float
    """Probability that it is none of them."""

    @property
    def best(self) -> TaskProbability | None:
        """The most probable task, or one that is done with it and nearly as probable: that says more.

        None where it is more probably none of them.
        """
        best, by_name = self.tasks[0], {each.task: each for each in self.tasks}
        if best.entailed_by is not None and by_name[best.entailed_by].probability >= NEARLY * best.probability:
            best = by_name[best.entailed_by]
        return best if best.probability > self.none else None

    @property
    def likely(self) -> tuple[TaskProbability, ...]:
        """The tasks that are more probable than not."""
        return tuple(each for each in self.tasks if each.probability > LIKELY)


@dataclass(frozen=True)
class Recogniser:
    """Known tasks, each learned once.

    Args:
        known: What is known of each, sorted by name.
        entailed: Which of them entail which others, and in which share of their demonstrations.
        left_out: Names of tasks that are not asked for, because answers about them contradict each other.
    """

    known: tuple[KnownTask, ...]
    entailed: Entailed = field(default_factory=FrozenMap)
    left_out: tuple[str, ...] = ()

    @classmethod
    def of(
        cls,
        knowledge: Knowledge,
        tree: HypothesisTree = STANDARD_TREE,
        of: TreeOf = "target",
        background: Background | None = None,
    ) -> Recogniser:
        """Learn each known task; others are compared with those that are left out, too.

        Args:
            knowledge: What is known.
            tree: Whose effects clauses are about.
            of: In whose trees: those of target agents, or of who performs.
            background: Neutral manipulations, as ``learn_task``.

        Raises:
            KnowledgeError: No task is known in these trees, or one alone and there is nothing to compare it with.
            ContradictionError: All of them have answers that contradict each other.
        """
        by_task = evidence_by_task(knowledge, of, background)
        if not by_task:
            others = "learn tasks first: taskgist learn --help; or ask in the trees of other agents (of)"
            raise KnowledgeError("no task is known in the trees of these agents", field="of", value=of, hint=others)
        for task, evidence in by_task.items():
            if len(evidence.kinds) == 1:
                raise KnowledgeError(
                    "there is nothing to compare it with",
                    where=f"task {task}",
                    hint="learn another task as well: the neutral manipulations that are shipped are known for "
                    "target agents, with the standard tree and settings",
                )
        left_out = contradicted_tasks(knowledge, tree, of)
        by_task = {task: evidence for task, evidence in by_task.items() if task not in left_out}
        if not by_task:
            raise next(iter(left_out.values()))
        told = {task: told_of(knowledge, task, tree, of) for task in by_task}
        return replace(cls.by_evidence(by_task, tree, told), left_out=tuple(left_out))

    @classmethod
    def by_evidence(
        cls,
        by_task: Mapping[str, Evidence],
        tree: HypothesisTree = STANDARD_TREE,
        told: Mapping[str, Told] | None = None,
    ) -> Recogniser:
        """Learn each task from evidence of its own; arguments and errors as ``learn_clauses``."""
        known = {
            task: KnownTask.of(by_task[task], task, tree, (told or {}).get(task, NOTHING_TOLD)) for task in by_task
        }
        clauses = {task: each.posterior.best for task, each in known.items()}
        found = entailed_tasks(by_task, clauses, lambda task, nodes: known[task].recognised(nodes).probability)
        return cls(tuple(known.values()), found)

    @property
    def tasks(self) -> tuple[str, ...]:
        """Names of the tasks."""
        return tuple(each.posterior.task for each in self.known)

    def recognise(self, nodes: Nodes) -> Recognised:
        """Which of the tasks an episode is.

        Args:
            nodes: Values of the tree's nodes; what is missing or unknown says nothing.
        """
        alone = {each.posterior.task: each.recognised(nodes) for each in self.known}
        whole = raised({task: each.probability for task, each in alone.items()}, self.entailed)
        found = [replace(alone[task], probability=value, entailed_by=by) for task, (value, by) in whole.items()]
        found.sort(key=lambda each: (-each.probability, -each.odds, each.task))
        none = 1.0 / (1.0 + math.fsum(each.odds for each in found))
        return Recognised(tuple(found), min(none, 1.0 - found[0].probability))


@dataclass(frozen=True)
class KnownTask:
    """What is known of one task.

    Args:
        posterior: What it is about.
        typical: Of each node, how typical its values are.
    """

    posterior: ClausePosterior
    typical: tuple[TypicalNode, ...]

    @classmethod
    def of(
        cls, evidence: Evidence, task: str, tree: HypothesisTree = STANDARD_TREE, told: Told = NOTHING_TOLD
    ) -> KnownTask:
        """What is known of a task; arguments and errors as ``learn_clauses``."""
        return cls(learn_clauses(evidence, task, tree, told), _typical(evidence, task, tree))

    def recognised(self, nodes: Nodes) -> TaskProbability:
        """How probable it is that an episode is a demonstration of it; ``nodes`` as ``Recogniser.recognise``."""
        best = self.posterior.best
        meaning, against = meaning_of(self.posterior, nodes), self._least_typical(nodes)
        ln_odds = math.log(PRIOR_ODDS) + meaning + (against.weight if against else 0.0)
        odds = math.exp(min(max(ln_odds, LEAST_LN_ODDS), -LEAST_LN_ODDS))
        truths = [(each, each.literal.holds(nodes)) for each in self.posterior.alone]
        return TaskProbability(
            task=self.posterior.task,
            probability=odds / (1.0 + odds),
            odds=odds,
            clause=best,
            holds=best.holds(nodes),
            literals=tuple(LiteralWeight(each.literal, truth, ln_ratio(each.support, truth)) for each, truth in truths),
            meaning=meaning,
            least_typical=against,
        )

    def _least_typical(self, nodes: Nodes) -> Circumstance | None:
        by_subtree: dict[str, list[Circumstance]] = {}
        for each in self.typical:
            if each.node in nodes and not isinstance(value := nodes[each.node].value, Unknown):
                weight = each.weights.get(value, each.unseen)
                found = Circumstance(each.node, each.title, value, each.usual, weight)
                by_subtree.setdefault(each.node.partition(".")[0], []).append(found)
        least: Circumstance | None = None
        for group in by_subtree.values():
            mean = math.fsum(each.weight for each in group) / len(group)
            if mean < (least.weight if least else 0.0):
                told = min(group, key=lambda each: each.weight)
                least = Circumstance(told.node, told.title, told.value, told.usual, mean)
        return least


@dataclass(frozen=True)
class TypicalNode:
    """How typical of a task the values of a node are.

    Args:
        node: Its name.
        title: Its title.
        weights: By value, the natural logarithm of how much more often the task's demonstrations have it than others.
        unseen: That of a value that nothing known has had.
        usual: The value that the task's demonstrations have most often.
    """

    node: str
    title: str
    weights: FrozenMap[str, float]
    unseen: float
    usual: str


def ln_ratio(support: Support, truth: bool | Unknown, slips: tuple[int, int] = SLIPS) -> float:
    """Natural logarithm of how much more often something holds, or fails, in a task's demonstrations than by chance.

    Args:
        support: How often it holds.
        truth: Whether it holds now; where that is unknown, the answer is 0.
        slips: Parameters (a, b) of the rate of slips.
    """
    a, b = slips
    if truth is UNKNOWN or support.chance >= 1.0:  # the empty clause holds everywhere and says nothing
        return 0.0
    rate = (support.k + b) / (support.n + a + b)
    return math.log(rate / support.chance) if truth else math.log((1.0 - rate) / (1.0 - support.chance))


def meaning_of(posterior: ClausePosterior, nodes: Nodes) -> float:
    """Natural logarithm of the likelihood ratio of what a task is about: the weighted mean over its clauses."""
    truths = {each: each.holds(nodes) for each in {each for one in posterior.clauses for each in one.literals}}
    total = []
    for clause in posterior.clauses:
        found = [truths[literal] for literal in clause.literals]
        holds = False if False in found else UNKNOWN if UNKNOWN in found else True
        total.append(clause.weight * math.exp(ln_ratio(clause.support, holds)))
    return math.log(math.fsum(total))


def _typical(evidence: Evidence, task: str, tree: HypothesisTree) -> tuple[TypicalNode, ...]:
    """How typical of a task the values of each node are of which anything is known in its demonstrations."""
    own = evidence.kind(task)
    others = [kind for name, kind in evidence.kinds.items() if name != task and kind.count]
    found = []
    for vocabulary in vocabularies(tree):
        name = vocabulary.node.name
        having: Mapping[str, int] = evidence.having.get(name, FrozenMap())
        known = evidence.known.get(name, 0)
        n = own.of(known).bit_count()
        if n:
            hits = {value: own.of(bits).bit_count() for value, bits in having.items()}
            weights = {}
            for value, bits in having.items():
                chance = _share(bits, known, others, len(vocabulary.values))
                weights[value] = math.log((hits[value] + PSEUDO * chance) / ((n + PSEUDO) * chance))
            usual = min(hits, key=lambda value: (-hits[value], value))
            unseen = math.log(PSEUDO / (n + PSEUDO))
            found.append(TypicalNode(name, vocabulary.node.title, FrozenMap(weights), unseen, usual))
    return tuple(found)


def _share(bits: int, known: int, kinds: list[Kind], values: int) -> float:
    """Share of the background that has one of so many values: the mean over its kinds, each smoothed."""
    shares = [
        (kind.of(bits).bit_count() + SMOOTHING) / (kind.of(known).bit_count() + values * SMOOTHING) for kind in kinds
    ]
    return math.fsum(shares) / len(shares)
