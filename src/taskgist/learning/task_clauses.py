"""What a known task means by whole clauses, what it was compared with, and which of its demonstrations look odd."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from taskgist.common.frozen import FrozenMap
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import HypothesisTree, TreeOf
from taskgist.learning.background import Background, shipped_background
from taskgist.learning.clauses import ClausePosterior, Told, learn_clauses
from taskgist.learning.estimate import Verdict
from taskgist.learning.evidence import Evidence, evidence_of
from taskgist.learning.experience import Experience
from taskgist.learning.explanation import Explanation
from taskgist.learning.knowledge import Knowledge
from taskgist.learning.understanding import Answer, in_force

LIKELY = 0.5
"""What a task is about holds where its posterior probability is greater."""
FEWEST = 3
"""Of fewer demonstrations none can be called odd: each is as odd as the others."""


def learn_task(
    knowledge: Knowledge,
    task: str,
    tree: HypothesisTree = STANDARD_TREE,
    of: TreeOf = "target",
    background: Background | None = None,
) -> ClausePosterior:
    """What a task means, compared with the other tasks that are known and with neutral manipulations.

    Answers fix literals: each clause has those about relevant nodes, and none about irrelevant ones.

    Args:
        knowledge: Experience of the task, and of others.
        task: Its name.
        tree: Whose effects clauses are about.
        of: For whom: its target agents, or who performs it; as ``Knowledge.experience``.
        background: Neutral manipulations; the shipped ones by default. They are left aside where the task was explained
            under another context, or for who performs it.

    Raises:
        UnknownNameError: The task is not known.
        KnowledgeError: It is not known of who performs it.
    """
    evidence = task_evidence(knowledge, task, of, background)
    return learn_clauses(evidence, task, tree, told_of(knowledge, task, of=of))


def task_evidence(
    knowledge: Knowledge, task: str, of: TreeOf = "target", background: Background | None = None
) -> Evidence:
    """The demonstrations of a task beside all that it is compared with; arguments and errors as ``learn_task``."""
    own = knowledge.experience(task, of)
    neutral = background or shipped_background()
    others = [each for (name, whose), each in knowledge.experiences.items() if whose == own.tree_of and name != task]
    comparable = own.tree_of == "target" and set(own.contexts) == {neutral.context}
    return evidence_of([own, *others], neutral.kinds if comparable else {})


def told_of(knowledge: Knowledge, task: str, *, of: TreeOf = "target") -> Told:
    """What the answers that are in force fix of a task; arguments and errors as ``learn_task``."""
    own = knowledge.experience(task, of)
    key = own.task, own.tree_of
    return _told(own, in_force(each for each in knowledge.answers if (each.task, each.tree_of) == key))


def _told(own: Experience, answers: Mapping[str, Answer]) -> Told:
    """What answers fix; a relevant node without a value has the most frequent one."""
    relevant = {}
    for node, answer in answers.items():
        counts = own.counts.get(node, FrozenMap())
        value = answer.value or min(counts, key=lambda each: (-counts[each], each), default=None)
        if answer.verdict is Verdict.RELEVANT and value is not None:
            relevant[node] = value
    irrelevant = frozenset(node for node, answer in answers.items() if answer.verdict is Verdict.IRRELEVANT)
    return Told(FrozenMap(relevant), irrelevant)


@dataclass(frozen=True)
class Odd:
    """A demonstration in which what its task is about does not hold: mislabelled, or not done well?"""

    explanation: Explanation
    probability: float
    """Posterior probability that it holds there."""
    looks_like: tuple[str, ...]
    """Other tasks of which it holds there what they are about; sorted."""


def odd_demonstrations(
    knowledge: Knowledge, learned: ClausePosterior, tree: HypothesisTree = STANDARD_TREE, of: TreeOf = "target"
) -> tuple[Odd, ...]:
    """The demonstrations of a task that look odd beside the others, the oddest first, and what they look like instead.

    Args:
        knowledge: What is known.
        learned: What ``learn_task`` found in it.
        tree: Whose effects clauses are about.
        of: For whom, as ``learn_task``.
    """
    own = knowledge.experience(learned.task, of)
    if len(own.explanations) < FEWEST:
        return ()
    found = {each: learned.probability(each.nodes) for each in own.explanations.values()}
    odd = sorted(
        ((probability, each) for each, probability in found.items() if probability < LIKELY),
        key=lambda pair: (pair[0], pair[1].demonstration, pair[1].digest),
    )
    others = (task for task in knowledge.tasks if task != own.task and own.tree_of in knowledge.trees_of(task))
    posteriors = [learn_task(knowledge, task, tree, own.tree_of) for task in others] if odd else []
    return tuple(
        Odd(each, probability, tuple(one.task for one in posteriors if one.probability(each.nodes) > LIKELY))
        for probability, each in odd
    )
