"""The understanding of a task: the largest consistent subtree of the hypothesis tree (6.4, 7.3).

**The question.** Some demonstrations of a task have been explained: every node of the tree has a value in each of
them. Which nodes are what the task is about, and which merely happened?

**The rule.** A node at which the demonstrations agree is relevant, one at which they contradict each other is not.
How much agreement is enough is weighed by the m-estimate, which grows with experience: ``Q`` is how likely the most
frequent value v_h is to be seen again, ``NRE`` the same for the other values that were seen, and the consistency
factor ``CF = Q − NRE``. At or below ``d1`` the node is irrelevant, above ``d2`` relevant; between, it is
*confusing* and becomes a question. What was never known is *unobserved*.

**A worked example** (Table 2). In three demonstrations of *show* the cup ends in the performer's hand, in a fourth
on a box. After three, ``Q = (3+1)/(3+2) = 4/5`` and ``NRE = 0``: ``CF = 4/5 > d2 = 18/25``, *In_Hand* is relevant.
After the fourth, ``Q = 4/6``, ``NRE = 2/6``, and ``CF = 1/3 < d1 = 7/15``: irrelevant; it does not matter where the
cup ends.

**The subtree.** A node is *kept* if it and all nodes above it are relevant. (What changes above cannot be meant
below: a final state that happened to be the same, below a class that differs, is no meaning.) Nothing is thrown
away, though: all nodes stay with their counts, and one that was pruned may come back with further demonstrations.

**Questions.** What the demonstrations neither agree nor contradict about enough has to be asked (6.4 iii).

**Several targets.** What a task means holds for each of its targets. A demonstration in which they differ at a node
(hidden from P2 and P3, while P3 sees as much as before) counts there for no value, and speaks against every one: where
the band does not pass over so much dissent, the node is confusing, and asked about. But a node that may take any text
or number, as joint angles do, is irrelevant then: two bodies always differ there, and nobody can say what is meant.

**Answers.** What a person has said about a node stands above its counts until it is withdrawn.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from taskgist.common.frozen import FrozenMap
from taskgist.errors import KnowledgeError
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import HypothesisTree, Instant, Node, Nodes, TreeOf
from taskgist.facts.values import NEGLIGIBLE, UNKNOWN, Unknown
from taskgist.learning.answers import Answer, in_force, replies_in_force
from taskgist.learning.estimate import Estimate, Rule, Verdict, canonical_key, weigh
from taskgist.learning.experience import Experience
from taskgist.learning.explanation import ROLES, Explanation, Role
from taskgist.settings import DEFAULT, Learning


@dataclass(frozen=True)
class Judgement:
    """What is understood of one node."""

    node: Node
    estimate: Estimate
    """What the demonstrations say."""
    counts: FrozenMap[str, int]
    """Demonstrations by value, most frequent first, ties in canonical order."""
    divided: tuple[Explanation, ...]
    """Demonstrations whose several targets differ in it, by name: not counted for any value."""
    answer: Answer | None
    """What a person said, if anything holds."""
    verdict: Verdict
    """The answer's verdict, else that of the demonstrations."""
    value: str | None
    """Desired value: the answer's, else v_h; None if nothing is known."""
    kept: bool
    """Whether the node belongs to the largest consistent subtree."""


@dataclass(frozen=True)
class Understanding:
    """What a task means, as far as the demonstrations tell; each verdict can be traced to its evidence."""

    task: str
    tree: HypothesisTree
    judgements: FrozenMap[str, Judgement]
    """By name of the node, in canonical order."""
    experience: Experience

    def demonstrations(self, node: str, value: str) -> tuple[Explanation, ...]:
        """The explanations behind a value of a node; their nodes hold the evidence."""
        return self.experience.behind(self.tree.node(node).name, value)

    @property
    def kept(self) -> tuple[Judgement, ...]:
        """The largest consistent subtree, in canonical order."""
        return tuple(judgement for judgement in self.judgements.values() if judgement.kept)

    @property
    def each_of(self) -> tuple[Role, ...]:
        """Of which roles some demonstration had several: what the task means holds for each of them."""
        explanations = self.experience.explanations.values()
        return tuple(role for role, field in ROLES.items() if any(len(getattr(e, field)) > 1 for e in explanations))


def understand(
    experience: Experience,
    tree: HypothesisTree = STANDARD_TREE,
    settings: Learning = DEFAULT.learning,
    answers: Iterable[Answer] = (),
) -> Understanding:
    """Judge every node of the tree by the experience of a task.

    Args:
        experience: Explanations of the task. Empty is allowed: then all is unobserved.
        tree: The nodes to judge; may leave out subtrees or levels of the tree that the explanations were made with.
        settings: Parameters of the m-estimate and the band.
        answers: What people said; answers on other tasks, in other agents' trees, or on nodes that the tree lacks, have
            no effect.

    Raises:
        KnowledgeError: An answer calls a node relevant that has no value.
    """
    rule = Rule.of(settings)
    about = (experience.task, experience.tree_of)
    holding = _verdicts((answer for answer in answers if (answer.task, answer.tree_of) == about), tree)
    several = sorted(
        (each for each in experience.explanations.values() if each.parts), key=lambda e: (e.demonstration, e.digest)
    )
    judgements: dict[str, Judgement] = {}
    for node in tree.nodes:  # parents come first
        above = node.parent is None or judgements[node.parent].kept
        divided = tuple(each for each in several if each.differing(node.name))
        judgements[node.name] = _judge(node, experience, divided, rule, holding.get(node.name), above=above)
    return Understanding(experience.task, tree, FrozenMap(judgements), experience)


def _verdicts(answers: Iterable[Answer], tree: HypothesisTree) -> dict[str, Answer]:
    """The answers that hold by node, those about sets of values where they settle one value or that none matters."""
    given, values = list(answers), {node.name: node.values for node in tree.nodes}
    exact = (each.exact(values.get(each.node, ())) for each in replies_in_force(given))
    return in_force([each for each in given if not each.among] + [each for each in exact if each is not None])


def _judge(
    node: Node,
    experience: Experience,
    divided: tuple[Explanation, ...],
    rule: Rule,
    answer: Answer | None,
    *,
    above: bool,
) -> Judgement:
    counts = experience.counts.get(node.name, FrozenMap())
    estimate = weigh(counts, rule, node.values)
    verdict = answer.verdict if answer and answer.verdict else _verdict(node, counts, estimate, len(divided), rule)
    value = answer.value if answer and answer.value else estimate.value
    if verdict is Verdict.RELEVANT and value is None:
        hint = "answer with a value, or withdraw the answer"
        raise KnowledgeError(
            "relevant without a value", where=f"answer on {experience.task}", field=node.name, hint=hint
        )
    return Judgement(
        node=node,
        estimate=estimate,
        counts=FrozenMap(
            dict(sorted(counts.items(), key=lambda item: (-item[1], canonical_key(item[0], node.values))))
        ),
        divided=divided,
        answer=answer,
        verdict=verdict,
        value=value,
        kept=above and verdict is Verdict.RELEVANT,
    )


DIVIDED = "targets differ"
"""Stands for a value that speaks against all others."""


def _verdict(node: Node, counts: FrozenMap[str, int], estimate: Estimate, divided: int, rule: Rule) -> Verdict:
    """What the demonstrations say, those included in which targets differ."""
    if not divided or estimate.verdict is Verdict.IRRELEVANT:
        return estimate.verdict
    contested = weigh({**counts, DIVIDED: divided}, rule, node.values)
    if contested.verdict is Verdict.RELEVANT and contested.value != DIVIDED:
        return Verdict.RELEVANT
    return Verdict.CONFUSING if node.values else Verdict.IRRELEVANT


# Questions: what the demonstrations neither agree nor contradict about enough (6.4 iii).


@dataclass(frozen=True)
class Choice:
    """A value in conflict with others, and the demonstrations that showed it."""

    value: str
    demonstrations: tuple[str, ...]
    """Names of the demonstrations."""
    targets: tuple[tuple[str, str], ...] = ()
    """Where several targets of a demonstration differ: which of them had this value, and the demonstration's name."""


@dataclass(frozen=True)
class Question:
    """Does this node matter for the task, and with which value?"""

    task: str
    node: Node
    choices: tuple[Choice, ...]
    """The values observed, most frequent first, those of single targets last."""
    tree_of: TreeOf = "target"
    """Whose tree the node is in."""

    def answer(self, verdict: Verdict, *, author: str, time: str, value: str | None = None) -> Answer:
        """An answer to this question; see ``Answer``.

        Args:
            verdict: Relevant or irrelevant.
            author: Who answers.
            time: ISO 8601 with the offset from UTC.
            value: Desired value where relevant; the most frequent one by default.

        Raises:
            KnowledgeError: As ``Answer``.
        """
        return Answer(self.task, self.node.name, verdict, author, time, value, self.tree_of)


def questions_of(understanding: Understanding) -> tuple[Question, ...]:
    """The questions whose answers can change the understanding, from abstract to concrete.

    A confusing node below an irrelevant one is not asked about: no answer could bring it back. Once the node above is
    settled otherwise, it will be. Where the targets of a demonstration differ, only the uppermost such node is asked
    about: those below follow from it, or come next.
    """
    return tuple(
        _question(understanding, judgement)
        for judgement in understanding.judgements.values()
        if judgement.verdict is Verdict.CONFUSING and _can_be_kept(understanding, judgement)
    )


def _can_be_kept(understanding: Understanding, judgement: Judgement) -> bool:
    above = (understanding.judgements[node.name] for node in understanding.tree.ancestors(judgement.node.name))
    return all(
        each.verdict is Verdict.RELEVANT or (each.verdict is Verdict.CONFUSING and not each.divided) for each in above
    )


def _question(understanding: Understanding, judgement: Judgement) -> Question:
    name = judgement.node.name
    targets: dict[str, list[tuple[str, str]]] = {value: [] for value in judgement.counts}
    for each in judgement.divided:
        for value, parts in each.differing(name).items():
            targets.setdefault(value, []).extend((each.called(part), each.demonstration) for part in parts)
    choices = (
        Choice(value, tuple(each.demonstration for each in understanding.demonstrations(name, value)), tuple(who))
        for value, who in targets.items()
    )
    return Question(understanding.task, judgement.node, tuple(choices), understanding.experience.tree_of)


# --- The clause: what a task means, as a conjunction of predicates (6, step 3; Eq. 36-42).
#
# The paper forms it of the leaves of the kept subtree. Leaves alone would lose meaning where a constant initial
# effort stands beside a varying final one: the constant is a leaf, and *Becomes_Easier* above it is none. So
# *effects* are the deepest kept nodes with the initial ones (¹) left aside, and *preconditions* the deepest kept
# initial ones; the clause of the paper is both together.


@dataclass(frozen=True)
class Literal:
    """One predicate of a clause: this node must have this value."""

    node: str
    title: str
    value: str
    instant: Instant | None

    def __str__(self) -> str:
        relation = "" if self.value == NEGLIGIBLE else "= "
        return f"({self.title} {relation}{self.value})"

    def holds(self, nodes: Nodes) -> bool | Unknown:
        """Whether it holds where the nodes are as given; unknown where its node is missing or unknown."""
        if self.node not in nodes or isinstance(value := nodes[self.node].value, Unknown):
            return UNKNOWN
        return value == self.value


@dataclass(frozen=True)
class Clause:
    """The learned meaning of a task.

    Args:
        task: Name of the task.
        literals: Its predicates, in the canonical order of the tree.
        each_of: Roles of which demonstrations had several: the predicates hold for each of them.
        tree_of: For whom they hold: the target agents, or who performs it.
    """

    task: str
    literals: tuple[Literal, ...]
    each_of: tuple[Role, ...] = ()
    tree_of: TreeOf = "target"

    @property
    def effects(self) -> tuple[Literal, ...]:
        """What the task brings about."""
        return tuple(literal for literal in self.literals if literal.instant != 1)

    @property
    def preconditions(self) -> tuple[Literal, ...]:
        """How the world was at the start of each demonstration."""
        return tuple(literal for literal in self.literals if literal.instant == 1)

    def __str__(self) -> str:
        return f"{self.head} ← {' ∧ '.join(map(str, self.literals)) or 'nothing in common'}"

    @property
    def head(self) -> str:
        """The task, and for whom its predicates hold where that is not the one target agent."""
        whose = ", for the performing agent" if self.tree_of == "performer" else ""
        return f"Task({self.task}{whose}{''.join(f', each of the {role}' for role in self.each_of)})"

    def holds(self, nodes: Nodes) -> bool | Unknown:
        """Whether all predicates hold: false if one surely does not, else unknown if one is unknown."""
        return conjunction(literal.holds(nodes) for literal in self.literals)


def clause_of(understanding: Understanding) -> Clause:
    """The clause of the largest consistent subtree."""
    kept = understanding.kept
    parents_of_effects = {each.node.parent for each in kept if each.node.instant != 1}
    parents_of_preconditions = {each.node.parent for each in kept if each.node.instant == 1}
    deepest = (
        each
        for each in kept
        if each.node.name not in (parents_of_preconditions if each.node.instant == 1 else parents_of_effects)
    )
    literals = tuple(_literal(each) for each in deepest)
    return Clause(understanding.task, literals, understanding.each_of, understanding.experience.tree_of)


def conjunction(truths: Iterator[bool | Unknown]) -> bool | Unknown:
    """Three-valued *and*."""
    unknown = False
    for truth in truths:
        if truth is False:
            return False
        unknown = unknown or truth is UNKNOWN
    return UNKNOWN if unknown else True


def _literal(judgement: Judgement) -> Literal:
    node: Node = judgement.node
    assert judgement.value is not None, node  # kept nodes are relevant, and relevant nodes have a value
    return Literal(node.name, node.title, judgement.value, node.instant)
