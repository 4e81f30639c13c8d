"""Which of the known tasks was performed? Each with a probability of its own, and that it was none of them.

**The question.** Whoever hides a thing away hides it, too, so several tasks may be right at once; and most of what
people do all day is none of the tasks that somebody taught. So each task is asked for by itself: how much better are
the facts of an episode explained by *this is the task* than by *this is something else*?

**Two voices**, both likelihood ratios that are learned from the same experience (``learning.task_clauses``):

- *The meaning.* A clause that holds in k of the task's n demonstrations, and in a share θ of the background, holds in
  the next demonstration with probability p = (k + b) / (n + a + b). Where it holds, the ratio is p / θ; where it fails,
  (1 − p) / (1 − θ); where it is unknown, 1. The ratios of the forty best clauses are averaged by their weights.
- *The circumstances.* A task's demonstrations also agree in what says nothing about its meaning: the thing rests in the
  end, nobody stands up. For each node, v the value there, the ratio is (h + m θ) / ((n + m) θ), where h of n
  demonstrations had v and a share θ of the background has it: the m-estimate (Eq. 27) whose prior is what is usual.
  To have what is usual says almost nothing; to lack what always was so says much. Nodes of one subtree repeat
  each other, so the logarithms are averaged over the nodes of a subtree and added over the subtrees.

**The probability.** With the prior odds of a task, the odds of task t are o(t) = prior · meaning · circumstances, its
probability o / (1 + o); and that it is none of n known tasks is 1 / (1 + o(1) + … + o(n)): something else, or one of
them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from taskgist.common.frozen import FrozenMap
from taskgist.errors import KnowledgeError
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import HypothesisTree, Nodes, TreeOf
from taskgist.facts.values import UNKNOWN, Unknown
from taskgist.learning.background import Background
from taskgist.learning.clauses import SLIPS, SMOOTHING, ClausePosterior, Support, WeighedClause, learn_clauses
from taskgist.learning.evidence import Evidence, Kind
from taskgist.learning.knowledge import Knowledge
from taskgist.learning.literals import SetLiteral, vocabularies
from taskgist.learning.task_clauses import compared_with, told_of

PRIOR_ODDS = 0.25
MEANING, CIRCUMSTANCES = 1.0, 1.0
PSEUDO = 2.0


@dataclass(frozen=True)
class LiteralWeight:
    """What one literal says about an episode.

    Args:
        literal: The literal.
        holds: Whether it holds there.
        weight: Natural logarithm of how much more often it holds, or fails, in the task's demonstrations than by
            chance; 0 where it is unknown.
    """

    literal: SetLiteral
    holds: bool | Unknown
    weight: float


@dataclass(frozen=True)
class NodeWeight:
    """What one circumstance says about an episode.

    Args:
        node: Name of the node.
        title: Its title.
        value: Its value in the episode.
        usual: The value that the task's demonstrations mostly have.
        weight: Natural logarithm of its likelihood ratio, as it counts.
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
    clause: WeighedClause
    """The task's best clause."""
    holds: bool | Unknown
    """Whether it holds in the episode."""
    literals: tuple[LiteralWeight, ...]
    """Those of the clause, each by itself."""
    meaning: float
    """Natural logarithm of the likelihood ratio of all clauses, as it counts."""
    circumstances: float
    """That of the circumstances."""
    unlike: tuple[NodeWeight, ...]
    """Circumstances that speak against the task by ``WORTH_A_WORD`` or more, the strongest first."""


@dataclass(frozen=True)
class Recognised:
    """Which of the known tasks an episode is."""

    tasks: tuple[TaskProbability, ...]
    """All of them, the most probable first. Each probability is its own: several may be near 1."""
    none: float
    """Probability that it is none of them."""

    @property
    def best(self) -> TaskProbability | None:
        """The most probable task; None where none of them is more probable than the most probable one."""
        first = self.tasks[0]
        return first if first.probability > self.none else None

    @property
    def likely(self) -> tuple[TaskProbability, ...]:
        """The tasks that are more probable than not."""
        return tuple(each for each in self.tasks if each.probability > 0.5)


@dataclass(frozen=True)
class _Known:
    """What is known of one task: its clauses, each literal's support, and how much each value of a node says."""

    posterior: ClausePosterior
    circumstances: FrozenMap[str, FrozenMap[str, float]]
    """By node and value: logarithms of likelihood ratios."""
    unseen: FrozenMap[str, float]
    """By node: that of a value that nothing known has ever had."""
    usual: FrozenMap[str, str]
    """By node: the most frequent value."""


WORTH_A_WORD = 0.3
"""Weight of a circumstance from which on it is told."""


@dataclass(frozen=True)
class Recogniser:
    """Known tasks, each learned once."""

    known: tuple[_Known, ...]
    tree: HypothesisTree

    @classmethod
    def of(
        cls,
        knowledge: Knowledge,
        tree: HypothesisTree = STANDARD_TREE,
        of: TreeOf = "target",
        background: Background | None = None,
    ) -> Recogniser:
        """Learn each known task.

        Args:
            knowledge: What is known.
            tree: Whose effects clauses are about.
            of: Whose trees: those of target agents, or of who performs.
            background: Neutral manipulations, as ``learn_task``.

        Raises:
            KnowledgeError: No task is known in the trees of these agents, or one alone and nothing to compare it with.
        """
        own = [each for (_, whose), each in sorted(knowledge.experiences.items()) if whose == of]
        if not own:
            raise KnowledgeError(f"no task is known for {of} agents", hint="learn some first: taskgist learn --help")
        known = []
        for experience in own:
            evidence = compared_with(knowledge, experience, background)
            if len(evidence.kinds) == 1:
                raise KnowledgeError(
                    "there is nothing to compare it with",
                    where=f"task {experience.task}",
                    hint="learn another task as well; neutral manipulations are known for the standard tree and settings",
                )
            posterior = learn_clauses(evidence, experience.task, tree, told_of(knowledge, experience))
            known.append(_known(evidence, posterior, tree))
        return cls(tuple(known), tree)

    @property
    def tasks(self) -> tuple[str, ...]:
        """Names of the tasks."""
        return tuple(each.posterior.task for each in self.known)

    def recognise(self, nodes: Nodes) -> Recognised:
        """Which of the tasks an episode is.

        Args:
            nodes: Values of the tree's nodes; what is missing or unknown says nothing.
        """
        found = [self._probability(each, nodes) for each in self.known]
        odds = math.fsum(each.probability / (1.0 - each.probability) for each in found)
        ordered = sorted(found, key=lambda each: (-each.probability, each.task))
        return Recognised(tuple(ordered), 1.0 / (1.0 + odds))

    def _probability(self, known: _Known, nodes: Nodes) -> TaskProbability:
        posterior = known.posterior
        meaning = MEANING * meaning_of(posterior, nodes)
        weights = self._circumstances(known, nodes)
        circumstances = CIRCUMSTANCES * math.fsum(each.weight for each in weights)
        log_odds = math.log(PRIOR_ODDS) + meaning + circumstances
        against = sorted((w for w in weights if w.weight <= -WORTH_A_WORD), key=lambda each: (each.weight, each.node))
        return TaskProbability(
            posterior.task,
            1.0 / (1.0 + math.exp(-min(max(log_odds, -30.0), 30.0))),
            posterior.best,
            posterior.best.holds(nodes),
            tuple(
                LiteralWeight(each.literal, truth, ln_ratio(each.support, truth))
                for each in posterior.alone
                for truth in (each.literal.holds(nodes),)
            ),
            meaning,
            circumstances,
            tuple(against),
        )

    def _circumstances(self, known: _Known, nodes: Nodes) -> list[NodeWeight]:
        found: dict[str, list[tuple[str, str, str, float]]] = {}
        for vocabulary in vocabularies(self.tree):
            name = vocabulary.node.name
            if name not in nodes or isinstance(value := nodes[name].value, Unknown) or name not in known.usual:
                continue
            ratio = known.circumstances[name].get(value, known.unseen[name])
            found.setdefault(name.partition(".")[0], []).append((name, vocabulary.node.title, value, ratio))
        return [
            NodeWeight(name, title, value, known.usual[name], ratio / len(group))
            for group in found.values()
            for name, title, value, ratio in group
        ]


def ln_ratio(support: Support, truth: bool | Unknown, slips: tuple[int, int] = SLIPS) -> float:
    """Natural logarithm of how much more often something holds, or fails, in a task's demonstrations than by chance.

    Args:
        support: How often it holds.
        truth: Whether it holds now; 0 is the answer where that is unknown.
        slips: Parameters (a, b) of the rate of slips.
    """
    a, b = slips
    if truth is UNKNOWN or not 0.0 < support.chance < 1.0:
        return 0.0
    rate = (support.k + b) / (support.n + a + b)
    return math.log(rate / support.chance) if truth else math.log((1.0 - rate) / (1.0 - support.chance))


def meaning_of(posterior: ClausePosterior, nodes: Nodes) -> float:
    """Natural logarithm of the likelihood ratio of what a task is about, averaged over its clauses."""
    truths: dict[SetLiteral, bool | Unknown] = {}
    total = []
    for clause in posterior.clauses:
        holds: bool | Unknown = True
        for literal in clause.literals:
            if literal not in truths:
                truths[literal] = literal.holds(nodes)
            truth = truths[literal]
            if truth is False:
                holds = False
                break
            if truth is UNKNOWN:
                holds = UNKNOWN
        total.append(clause.weight * math.exp(ln_ratio(clause.support, holds)))
    return math.log(math.fsum(total))


def _known(evidence: Evidence, posterior: ClausePosterior, tree: HypothesisTree) -> _Known:
    own = evidence.kind(posterior.task)
    others = [kind for name, kind in evidence.kinds.items() if name != posterior.task and kind.count]
    ratios: dict[str, FrozenMap[str, float]] = {}
    unseen: dict[str, float] = {}
    usual: dict[str, str] = {}
    for vocabulary in vocabularies(tree):
        name = vocabulary.node.name
        having: Mapping[str, int] = evidence.having.get(name, FrozenMap())
        known = evidence.known.get(name, 0)
        n = own.of(known).bit_count()
        if not n:
            continue
        counts = {value: own.of(bits).bit_count() for value, bits in having.items()}
        chance = {value: _share(bits, known, others, len(vocabulary.values)) for value, bits in having.items()}
        ratios[name] = FrozenMap(
            {
                value: math.log((counts[value] + PSEUDO * chance[value]) / ((n + PSEUDO) * chance[value]))
                for value in having
            }
        )
        unseen[name] = math.log(PSEUDO / (n + PSEUDO))
        usual[name] = min(counts, key=lambda value: (-counts[value], value))
    return _Known(posterior, FrozenMap(ratios), FrozenMap(unseen), FrozenMap(usual))


def _share(bits: int, known: int, kinds: list[Kind], values: int) -> float:
    """Share of the background that has a value: the mean over its kinds, each smoothed."""
    shares = [
        (kind.of(bits).bit_count() + SMOOTHING) / (kind.of(known).bit_count() + values * SMOOTHING) for kind in kinds
    ]
    return math.fsum(shares) / len(shares)
