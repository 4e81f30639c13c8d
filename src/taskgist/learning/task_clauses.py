"""What a known task means by whole clauses, what it was compared with, and which of its demonstrations look odd.

And what it means by either rule, as one clause, which planning takes.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from taskgist.common.frozen import FrozenMap
from taskgist.errors import ContradictionError, UnknownNameError
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import HypothesisTree, TreeOf
from taskgist.learning.answers import Answer, Reply, in_force, replies_in_force
from taskgist.learning.asking import Asking
from taskgist.learning.background import Background, shipped_background
from taskgist.learning.clauses import ClausePosterior, Told, learn_clauses
from taskgist.learning.entailment import entailment_of
from taskgist.learning.estimate import Verdict
from taskgist.learning.evidence import Effects, Evidence, effects_of, evidence_of
from taskgist.learning.experience import Experience
from taskgist.learning.explanation import Context, Explanation
from taskgist.learning.knowledge import Knowledge
from taskgist.learning.literals import SetLiteral, vocabulary_by_node
from taskgist.learning.must_not import learn_must_not
from taskgist.learning.understanding import PAPER, Clause, clause_of, several_of

BAYES = "bayes"
RULES = (PAPER, BAYES)
"""Rules by which a task is understood: the largest consistent subtree, or whole clauses compared with all else."""
BY_RULE: Mapping[str, str] = FrozenMap({PAPER: "by the paper's rule", BAYES: "by whole clauses"})
"""How texts say by which rule something was learned."""
WRONG = " ! wrong"
"""The kind of a task's own demonstrations that were done wrong; no other kind is called so."""
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

    Other tasks that were explained with other settings or another tree are left aside; ``compared`` names the rest.

    Demonstrations that were done wrong are one more kind that it is compared with, and teach what must not hold.

    Answers fix literals: each clause has those about relevant nodes and those that must hold, and none about irrelevant
    nodes or what need not hold.

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
        ContradictionError: Two answers contradict each other; names both.
    """
    evidence = task_evidence(knowledge, task, of, background)
    learned = learn_clauses(evidence, task, tree, told_of(knowledge, task, tree, of))
    own = knowledge.experience(task, of)
    if WRONG not in learned.compared:
        return learned
    right = [effects_of(each) for each in own.explanations.values()]
    must_not = learn_must_not(_wrong(knowledge, own), right, tree)
    return replace(learned, compared=learned.compared.without(WRONG), must_not=must_not)


def task_evidence(
    knowledge: Knowledge, task: str, of: TreeOf = "target", background: Background | None = None
) -> Evidence:
    """The demonstrations of a task beside all that it is compared with; arguments and errors as ``learn_task``."""
    own = knowledge.experience(task, of)
    others, kinds = _background(knowledge, own, background or shipped_background())
    if (own.task, own.tree_of) in knowledge.wrong:
        kinds[WRONG] = _wrong(knowledge, own)
    return evidence_of([own, *others], kinds)


def evidence_by_task(
    knowledge: Knowledge, of: TreeOf = "target", background: Background | None = None
) -> dict[str, Evidence]:
    """``task_evidence`` of each task that is known in these trees, sorted by name; what is the same is made once."""
    shared: dict[frozenset[Context], Evidence] = {}
    found = {}
    for task, whose in sorted(knowledge.experiences):
        if whose == of and (task, of) in knowledge.wrong:
            found[task] = task_evidence(knowledge, task, of, background)
        elif whose == of:
            contexts = frozenset(knowledge.experiences[task, of].contexts)
            if contexts not in shared:
                shared[contexts] = task_evidence(knowledge, task, of, background)
            found[task] = shared[contexts]
    return found


def _background(
    knowledge: Knowledge, own: Experience, neutral: Background
) -> tuple[list[Experience], dict[str, Iterable[Effects]]]:
    """The other tasks, and the neutral manipulations by kind, that a task can be compared with."""
    others = [
        each
        for (name, whose), each in knowledge.experiences.items()
        if whose == own.tree_of and name != own.task and set(each.contexts) <= set(own.contexts)
    ]
    comparable = own.tree_of == "target" and set(own.contexts) == {neutral.context}
    return others, dict(neutral.kinds) if comparable else {}


def _wrong(knowledge: Knowledge, own: Experience) -> list[Effects]:
    """The demonstrations of a task that were done wrong."""
    return [effects_of(each) for each in knowledge.wrong[own.task, own.tree_of].explanations.values()]


def told_of(knowledge: Knowledge, task: str, tree: HypothesisTree = STANDARD_TREE, of: TreeOf = "target") -> Told:
    """What answers fix: literals that each clause has, and those that need not hold.

    A relevant node without a value has the most frequent one. Answers on nodes that literals are not about say nothing.

    Raises:
        UnknownNameError: The task is not known.
        KnowledgeError: It is not known of who performs it.
        ContradictionError: Two answers contradict each other; names both.
    """
    own = knowledge.experience(task, of)
    return own_told(
        own, [each for each in knowledge.answers if (each.task, each.tree_of) == (own.task, own.tree_of)], tree
    )


def contradicted_tasks(
    knowledge: Knowledge, tree: HypothesisTree = STANDARD_TREE, of: TreeOf = "target"
) -> dict[str, ContradictionError]:
    """The tasks that are known in these trees whose answers contradict each other, and how; sorted.

    What is asked of all tasks leaves them out; what is asked of one of them is refused.
    """
    found = {}
    for task in (task for task in knowledge.tasks if of in knowledge.trees_of(task)):
        try:
            told_of(knowledge, task, tree, of)
        except ContradictionError as error:
            found[task] = error
    return found


def own_told(own: Experience, answers: Iterable[Answer], tree: HypothesisTree = STANDARD_TREE) -> Told:
    """As ``told_of``, by the experience of a task and the answers about it."""
    answers = list(answers)
    known = vocabulary_by_node(tree)
    of_nodes = in_force(answers)
    irrelevant = {node: each for node, each in of_nodes.items() if each.verdict is Verdict.IRRELEVANT}
    relevant = {node: value for node in sorted(of_nodes) if (value := _wanted(own, of_nodes[node])) is not None}
    must, free = _stated(own, answers, tree)
    _check(own.task, must, free, irrelevant, tree)
    single = {known[node].literal((value,)) for node, value in relevant.items() if node in known}
    return Told(
        FrozenMap(relevant), frozenset(irrelevant), tuple(each for each in must if each not in single), tuple(free)
    )


def _wanted(own: Experience, answer: Answer) -> str | None:
    """The value that a node must have by an answer about it: by default the one that was seen most often."""
    counts = own.counts.get(answer.node, FrozenMap())
    if answer.verdict is not Verdict.RELEVANT:
        return None
    return answer.value or min(counts, key=lambda each: (-counts[each], each), default=None)


def _stated(
    own: Experience, answers: Iterable[Answer], tree: HypothesisTree
) -> tuple[dict[SetLiteral, Answer], dict[SetLiteral, Answer]]:
    """What must hold by answers that are in force, and what need not, each with the answer that says so."""
    answers = list(answers)
    known = vocabulary_by_node(tree)
    must: dict[SetLiteral, Answer] = {}
    free: dict[SetLiteral, Answer] = {}
    for node, answer in sorted(in_force(answers).items()):
        value = _wanted(own, answer)
        if node in known and value is not None:
            must[known[node].literal((value,))] = answer
    for answer in replies_in_force(answers):
        if answer.node not in known:
            continue
        literal = known[answer.node].literal(answer.among, but=answer.but)
        if answer.reply is Reply.EITHER:
            free[literal] = answer
        elif answer.reply in (Reply.YES, Reply.NO):
            must[literal if answer.reply is Reply.YES else known[literal.node].complement(literal)] = answer
    return must, free


def answers_against_all(
    knowledge: Knowledge, task: str, tree: HypothesisTree = STANDARD_TREE, of: TreeOf = "target"
) -> tuple[Answer, ...]:
    """The answers that stand against all demonstrations of a task: what must be so by them was so in none.

    They are taken at their word; but who gave one may have meant something else, and the demonstrations are not odd.

    Raises:
        UnknownNameError: The task is not known.
        KnowledgeError: It is not known of who performs it.
    """
    own = knowledge.experience(task, of)
    given = (each for each in knowledge.answers if (each.task, each.tree_of) == (own.task, own.tree_of))
    must, _ = _stated(own, given, tree)
    shown = own.explanations.values()
    found = (answer for literal, answer in must.items() if all(literal.holds(each.nodes) is False for each in shown))
    return tuple(dict.fromkeys(found))


def _check(
    task: str,
    must: Mapping[SetLiteral, Answer],
    free: Mapping[SetLiteral, Answer],
    irrelevant: Mapping[str, Answer],
    tree: HypothesisTree,
) -> None:
    """Refuse answers that cannot all be true."""
    entailment = entailment_of(tree)
    for literal, answer in must.items():
        if literal.node in irrelevant:
            raise _contradiction(task, answer, irrelevant[literal.node])
    left: dict[str, tuple[int, list[Answer]]] = {}
    for literal, answer in must.items():
        worlds = entailment.worlds(literal)
        bits, before = left.get(worlds.space, (entailment.all(worlds.space), []))
        if worlds.bits and not bits & worlds.bits:
            raise _contradiction(task, *before, answer)
        left[worlds.space] = bits & worlds.bits, [*before, answer]
    for literal, answer in free.items():
        worlds = entailment.worlds(literal)
        if worlds.space in left:
            bits, before = left[worlds.space]
            if bits & worlds.bits in (0, bits):
                raise _contradiction(task, *before, answer)


def _contradiction(task: str, *answers: Answer) -> ContradictionError:
    told = " and ".join(
        f"{each.reply.value if each.reply else each.verdict.value if each.verdict else ''} to {each.about} "
        f"({each.author}, {each.second})"
        for each in answers
    )
    kept = min(answers, key=lambda each: (each.time, each.about))  # the last one may be that which is refused here
    return ContradictionError(
        f"answers contradict each other: {told}",
        where=f"task {task}",
        hint="withdraw one that is kept: "
        f"taskgist ask {task!r} --withdraw --question {kept.about!r} --author {kept.author!r}",
    )


@dataclass(frozen=True)
class Sides:
    """The demonstrations of a task in which something held, in which it did not, and in which that is unknown."""

    holds: tuple[str, ...]
    fails: tuple[str, ...]
    unknown: tuple[str, ...]


def sides(own: Experience, literal: SetLiteral) -> Sides:
    """The demonstrations on both sides of a literal, by name."""
    truths = sorted((each.demonstration, str(literal.holds(each.nodes))) for each in own.explanations.values())
    by_truth = {truth: tuple(name for name, told in truths if told == truth) for truth in ("True", "False")}
    unknown = tuple(name for name, told in truths if told not in by_truth)
    return Sides(by_truth["True"], by_truth["False"], unknown)


def open_questions(
    knowledge: Knowledge,
    task: str,
    tree: HypothesisTree = STANDARD_TREE,
    of: TreeOf = "target",
    background: Background | None = None,
) -> Asking:
    """What there is to ask about a task, by all that is known; arguments and errors as ``learn_task``."""
    own = knowledge.experience(task, of)
    evidence, told = task_evidence(knowledge, task, of, background), told_of(knowledge, task, tree, of)
    known = vocabulary_by_node(tree)
    given = (each for each in knowledge.answers if (each.task, each.tree_of) == (own.task, own.tree_of))
    asked = [
        known[each.node].literal(each.among, but=each.but) for each in replies_in_force(given) if each.node in known
    ]
    return Asking(evidence, learn_clauses(evidence, own.task, tree, told), tree, told, asked)


def rule_for(knowledge: Knowledge, task: str, of: TreeOf = "target") -> str:
    """The rule that speaks of a task where none is named: whole clauses, where there is anything to compare with.

    On held-out demonstrations they do better than the paper's rule, but for a first task with five demonstrations or
    more of which none is wrong, where they are up to 3 points behind (docs/how/clauses.md). Without any background they
    learn nothing, and the paper's rule does.

    Raises:
        UnknownNameError: The task is not known.
        KnowledgeError: It is not known of who performs it.
    """
    others, kinds = _background(knowledge, knowledge.experience(task, of), shipped_background())
    return BAYES if others or kinds else PAPER


def learned_clause(
    knowledge: Knowledge,
    task: str,
    rule: str | None = None,
    tree: HypothesisTree = STANDARD_TREE,
    of: TreeOf = "target",
) -> Clause:
    """What a task means by a rule, as one clause whichever it is.

    Args:
        knowledge: Experience of the task, and of others.
        task: Its name.
        rule: One of ``RULES``; None: ``rule_for`` the task.
        tree: The nodes that it may be about.
        of: For whom: its target agents, or who performs it; as ``Knowledge.experience``.

    Returns:
        The clause; of whole clauses the best one, with what keeps to all that must not hold, circumstances kept apart.
        It has no literals where nothing was learned.

    Raises:
        UnknownNameError: The task, or the rule, is not known.
        KnowledgeError: It is not known of who performs it.
    """
    rule = rule or rule_for(knowledge, task, of)
    if rule not in RULES:
        raise UnknownNameError("rule", rule, RULES)
    if rule == PAPER:
        return clause_of(knowledge.understand(task, tree, of=of))
    return clause_of_posterior(knowledge.experience(task, of), learn_task(knowledge, task, tree, of), tree)


def clause_of_posterior(own: Experience, learned: ClausePosterior, tree: HypothesisTree = STANDARD_TREE) -> Clause:
    """The best of whole clauses as a clause: with what keeps to all that must not hold, circumstances apart."""
    usual, always = (tuple(each.literal for each in part) for part in (learned.usual, learned.always))
    known = vocabulary_by_node(tree)
    avoided = (known[each.literal.node].complement(each.literal) for each in learned.must_not)
    literals = tuple(dict.fromkeys((*learned.best.literals, *avoided)))
    return Clause(own.task, literals, several_of(own), own.tree_of, usual, always, BAYES)


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

    None does where an answer stands against all of them (``answers_against_all``): they are alike.

    Args:
        knowledge: What is known.
        learned: What ``learn_task`` found in it.
        tree: Whose effects clauses are about.
        of: For whom, as ``learn_task``.
    """
    own = knowledge.experience(learned.task, of)
    if len(own.explanations) < FEWEST or answers_against_all(knowledge, own.task, tree, of):
        return ()
    found = {each: learned.probability(each.nodes) for each in own.explanations.values()}
    odd = sorted(
        ((probability, each) for each, probability in found.items() if probability < LIKELY),
        key=lambda pair: (pair[0], pair[1].demonstration, pair[1].digest),
    )
    left_out = {own.task, *contradicted_tasks(knowledge, tree, own.tree_of)}
    others = (task for task in knowledge.tasks if task not in left_out and own.tree_of in knowledge.trees_of(task))
    posteriors = [learn_task(knowledge, task, tree, own.tree_of) for task in others] if odd else []
    return tuple(
        Odd(each, probability, tuple(one.task for one in posteriors if one.probability(each.nodes) > LIKELY))
        for probability, each in odd
    )
