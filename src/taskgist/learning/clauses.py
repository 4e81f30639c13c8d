"""Bayesian clause learning: which conjunction do a task's demonstrations have in common, and not by chance?

**The question.** In ten demonstrations of *hide* the thing always ends on a support, and the other can hardly see it.
Both held in all of them. But things end on a support in most of what people do, and it says little that they did here;
that the other can hardly see it is rare elsewhere, and says much.

**The score.** A hypothesis is a conjunction of up to six literals (``literals``). Of ``n`` demonstrations in which it
is known whether the whole conjunction holds, it holds in ``k``. If it is what the task is about, it holds in all but a
few slips, whose rate is Beta(a, b) with a = 10 and b = 90; if it is not, it holds as often as by chance, in a share
``θ`` of the background. With the description length of its literals the score is, in natural logarithms::

    ln B(k + b, n − k + a) − ln B(b, a) − k ln θ − (n − k) ln(1 − θ) − ln 2 · bits

The first two terms are the likelihood of k hits and n − k slips, the next two that of as many by chance. So each
demonstration in which a clause holds adds almost −ln θ, the more the rarer it is elsewhere (the size principle,
Tenenbaum 1999); one in which it fails costs ln(1 − θ) − ln(a / (a + b)), and less with each further one, as slips
prove to be frequent.

**Chance.** ``θ`` is the mean over the kinds of background of the share in which the clause holds. Each other task is a
kind, and so is each neutral manipulation, such as lifting. A share of h hits and f failures is (h + ½) / (h + f + 1).
But neutral manipulations are shipped: nobody watched them with the user's tracker. What holds in all of a user's tasks,
because things tremble there or everybody sits, is no task's meaning, however rare it is in neutral manipulations. So θ
is no less than the mean over the other tasks, with whom all neutral manipulations together count as two.
Without any background there is no chance to compare with, and nothing is learned. The empty clause, which says that
the task is about nothing, is kept only where there is no other.

**Description length.** Two bits say that another literal follows, log2(values of the node) bits choose a value or the
one that is left out, and an interval of a ladder costs what choosing its ends does.

**Unknown.** A conjunction fails where one of its literals fails, holds where all hold, and is unknown elsewhere. Where
it is unknown it counts neither in n nor in k, of that conjunction alone; in the background neither as hit nor failure.
An unknown demonstration therefore speaks for no clause, and against none.

**The search.** A beam over conjunctions, from none to six literals, each of another node; k must be 0.6 n or more. The
forty best are kept, each weighted by its posterior probability among them. A literal that leaves the hits in the
background as they are is not added, because it can only cost; and no clause is kept that holds as often by chance. The
result is a function of the sets of demonstrations: sums are over whole numbers and one table of logarithms, and ties
are broken by length and by the literals' order.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from heapq import heappush, heapreplace, nsmallest

from taskgist.common.frozen import FrozenMap
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import HypothesisTree, Nodes
from taskgist.facts.values import UNKNOWN, Unknown
from taskgist.learning.background import NEUTRAL
from taskgist.learning.entailment import entailment_of
from taskgist.learning.evidence import Evidence, Kind
from taskgist.learning.literals import SetLiteral, Vocabulary, vocabularies
from taskgist.learning.understanding import conjunction

SLIPS = (10, 90)
"""Parameters (a, b) of the Beta distribution of the rate of slips: one in ten, as sure as after a hundred tries."""
SMOOTHING = 0.5
"""Hits and failures that are added to those of each kind of background."""
FOLLOWING_BITS = 2.0
"""Description length of there being another literal."""
MOST_LITERALS = 6
NEUTRAL_AMONG_TASKS = 2.0
"""As so many tasks neutral manipulations count where a task is compared with other tasks (ours: fitted on seed 101)."""
COVERAGE = 0.6
"""Share of the demonstrations in which a clause must hold."""
USUAL = 0.75
"""What holds in this share of the background, or more, is usually so."""
BEAM, KEPT = 12, 40
"""Clauses that are lengthened at each step, and that are kept in the end."""
EQUAL = 9
"""Decimals to which scores are compared: what differs by less differs by rounding."""


@dataclass(frozen=True)
class Support:
    """How often something holds.

    Args:
        k: Demonstrations of the task in which it holds.
        n: Demonstrations of the task in which it is known whether it does.
        chance: Share of the background in which it holds, θ.
    """

    k: int
    n: int
    chance: float


@dataclass(frozen=True)
class LiteralSupport:
    """One literal, and how often it holds alone."""

    literal: SetLiteral
    support: Support


@dataclass(frozen=True)
class MustNot:
    """Something that must not hold, and what speaks for that.

    Args:
        literal: What must not hold; its complement (``Vocabulary.complement``) is what must.
        in_wrong: Of the wrong demonstrations in which it is known: in how many it holds, and how many there are.
        in_right: The same of the right ones.
        odds: How much likelier it is a reason than chance; None where somebody said so.
    """

    literal: SetLiteral
    in_wrong: tuple[int, int]
    in_right: tuple[int, int]
    odds: float | None

    @property
    def probability(self) -> float:
        """Of its being a reason, by its odds; 1 where somebody said so."""
        return 1.0 if self.odds is None else self.odds / (1.0 + self.odds)


@dataclass(frozen=True)
class WeighedClause:
    """A conjunction of literals, and what speaks for it."""

    literals: tuple[SetLiteral, ...]
    """In canonical order; none: nothing is known of the task."""
    support: Support
    score: float
    """Natural logarithm of its odds against chance, description length included."""
    weight: float
    """Posterior probability among the clauses that were kept."""

    def holds(self, nodes: Nodes) -> bool | Unknown:
        """Whether all literals hold: false if one surely does not, else unknown if one is unknown."""
        return conjunction(literal.holds(nodes) for literal in self.literals)

    def __str__(self) -> str:
        return " ∧ ".join(map(str, self.literals)) or "nothing in common"


@dataclass(frozen=True)
class ClausePosterior:
    """What a task means by its best clauses, and what they were compared with."""

    task: str
    clauses: tuple[WeighedClause, ...]
    """The best one first; at least one."""
    alone: tuple[LiteralSupport, ...]
    """The literals of the best clause, each by itself."""
    usual: tuple[LiteralSupport, ...]
    """Usual circumstances: final states that were always so, and that usually are so in the background."""
    compared: FrozenMap[str, int]
    """Demonstrations by kind of background."""
    always: tuple[LiteralSupport, ...] = ()
    """What else was always so, final states and changes, of those in one branch of the tree the deepest. It is not so
    usual that nobody would do otherwise, nor so rare beside the clause that it says more. Who recognises a task does
    without it; who performs the task had better do the same."""
    must_not: tuple[MustNot, ...] = ()
    """What must not hold, the surest first: whoever performs keeps to the complement of each, beside a clause."""

    @property
    def best(self) -> WeighedClause:
        """The clause of the highest score."""
        return self.clauses[0]

    def probability(self, nodes: Nodes) -> float:
        """Posterior probability that what the task is about holds where the nodes are as given.

        Clauses that are unknown there have no say; it is 0.5 where all are.
        """
        truths = [(clause.weight, clause.holds(nodes)) for clause in self.clauses]
        known = math.fsum(weight for weight, truth in truths if truth is not UNKNOWN)
        return math.fsum(weight for weight, truth in truths if truth is True) / known if known else 0.5


@dataclass(frozen=True)
class Told:
    """What people said of a task: every clause has the one, and none has a literal about the other.

    Args:
        relevant: Values of nodes that it is about.
        irrelevant: Names of nodes that it is not about.
        must: Literals that each clause has.
        free: Literals that need not hold, and may fail: no clause has one that says that they hold, or that they fail.
    """

    relevant: FrozenMap[str, str] = field(default_factory=FrozenMap)
    irrelevant: frozenset[str] = frozenset()
    must: tuple[SetLiteral, ...] = ()
    free: tuple[SetLiteral, ...] = ()

    def fixed(self, tree: HypothesisTree) -> tuple[SetLiteral, ...]:
        """The literals that each clause has, in canonical order; of nodes that literals are not about, none."""
        known = {vocabulary.node.name: vocabulary for vocabulary in vocabularies(tree)}
        single = (known[node].literal((value,)) for node, value in self.relevant.items() if node in known)
        literals = dict.fromkeys((*single, *(each for each in self.must if each.node in known)))
        return tuple(sorted(literals, key=lambda each: each.order))


NOTHING_TOLD = Told()


def learn_clauses(
    evidence: Evidence,
    task: str,
    tree: HypothesisTree = STANDARD_TREE,
    told: Told = NOTHING_TOLD,
    most_literals: int = MOST_LITERALS,
    words: Sequence[Vocabulary] | None = None,
) -> ClausePosterior:
    """Learn what a task means from its demonstrations, compared with all others.

    Args:
        evidence: Demonstrations of the task, of other tasks, and neutral ones.
        task: The task.
        tree: Whose effects literals are about.
        told: What people said of it. What they said of nodes that literals are not about has no effect.
        most_literals: The longest clause.
        words: What literals are about; None: the effects of the tree.

    Raises:
        UnknownNameError: There is no evidence of this task.
    """
    search = _Search(evidence, task, tree, told, vocabularies(tree) if words is None else words)
    found = search.best(most_literals)
    weights = [math.exp(one.score - found[0].score) for one in found]
    total = math.fsum(weights)
    return ClausePosterior(
        task=task,
        clauses=tuple(
            WeighedClause(search.literals_of(one), search.supported(one), one.score, weight / total)
            for one, weight in zip(found, weights, strict=True)
        ),
        alone=tuple(map(search.alone, found[0].members)),
        usual=search.usual(found[0]),
        compared=FrozenMap({name: kind.count for name, kind in evidence.kinds.items() if name != task}),
        always=search.always(found[0]),
    )


# --- The score. Every term is a difference of entries of one table, ln i!.

LN_2 = math.log(2.0)

_LN_FACTORIALS = [0.0]


def _ln_factorial(number: int) -> float:
    for i in range(len(_LN_FACTORIALS), number + 1):
        _LN_FACTORIALS.append(_LN_FACTORIALS[-1] + math.log(i))
    return _LN_FACTORIALS[number]


def ln_beta(x: int, y: int) -> float:
    """Natural logarithm of the beta function of two whole numbers from 1 on."""
    return _ln_factorial(x - 1) + _ln_factorial(y - 1) - _ln_factorial(x + y - 1)


def smoothed(hits: int, known: int) -> float:
    """The share that so many hits are of so many, (h + ½) / (n + 1): never 0, never 1, and one half of none."""
    return (hits + SMOOTHING) / (known + 2 * SMOOTHING)


def clause_score(support: Support, bits: float, slips: tuple[int, int] = SLIPS) -> float:
    """Natural logarithm of the odds that a clause is what a task is about and not chance.

    Args:
        support: How often it holds; the chance lies between 0 and 1.
        bits: Description length of its literals.
        slips: Parameters (a, b) of the rate of slips.
    """
    hits, misses = support.k, support.n - support.k
    return _ln_likelihood(hits, misses, slips) - _ln_chance(hits, misses, support.chance) - LN_2 * bits


def _ln_likelihood(hits: int, misses: int, slips: tuple[int, int]) -> float:
    a, b = slips
    return ln_beta(hits + b, misses + a) - ln_beta(b, a)


def _ln_chance(hits: int, misses: int, chance: float) -> float:
    return hits * math.log(chance) + misses * math.log1p(-chance)


# --- The search.


@dataclass(frozen=True, slots=True)
class _Candidate:
    """A literal, its description length, and where it holds and fails."""

    literal: SetLiteral
    bits: float
    true: int
    false: int


@dataclass(frozen=True, slots=True)
class _Found:
    """A conjunction: its candidates, where it holds and fails, and how well it does."""

    members: tuple[int, ...]
    true: int
    false: int
    bits: float
    k: int
    n: int
    chance: float
    score: float

    @property
    def order(self) -> tuple[float, int, tuple[int, ...]]:
        """The best first, of equal ones the shortest, then that of the first literals."""
        return -round(self.score, EQUAL), len(self.members), self.members


class Counting:
    """Counts how often conjunctions hold. The task's own demonstrations are the lowest bits, the background follows.

    Args:
        evidence: Demonstrations of the task, of other tasks, and neutral ones.
        task: The task.

    Raises:
        UnknownNameError: There is no evidence of this task.
    """

    def __init__(self, evidence: Evidence, task: str) -> None:
        own = evidence.kind(task)
        self._evidence, self._place = evidence, own
        self._n = own.count
        self._own = (1 << own.count) - 1
        others = [kind for name, kind in evidence.kinds.items() if name != task and kind.count]
        self._kinds = tuple(
            Kind(kind.start + (own.count if kind.start < own.start else 0), kind.count) for kind in others
        )
        self._all = (1 << evidence.size) - 1
        neutral = [name.startswith(NEUTRAL) for name, kind in evidence.kinds.items() if name != task and kind.count]
        self._neutral_kinds = sum(neutral)
        self._masks = tuple(
            (kind.start, (1 << kind.count) - 1, kind.count, is_neutral)
            for kind, is_neutral in zip(self._kinds, neutral, strict=True)
        )

    @property
    def compares(self) -> bool:
        """Whether there is a background at all."""
        return bool(self._kinds)

    @property
    def background(self) -> int:
        """All demonstrations but the task's own."""
        return self._all & ~self._own

    def truth(self, literals: Iterable[SetLiteral]) -> tuple[int, int]:
        """The demonstrations in which a conjunction holds, and those in which it fails."""
        true, false = self._evidence.together(literals)
        return _moved(true, self._place), _moved(false, self._place)

    def support(self, true: int, false: int) -> Support:
        """How often something holds here, and by chance.

        Args:
            true: The demonstrations in which it holds, as ``truth`` gives them.
            false: Those in which it fails.
        """
        k, misses = ((bits & self._own).bit_count() for bits in (true, false))
        return Support(k, k + misses, self._chance(true, false))

    def alike(self, truths: Iterable[int]) -> list[tuple[int, tuple[int, ...]]]:
        """Demonstrations in groups in which the same conjunctions hold, and which these are, by index.

        Args:
            truths: The demonstrations in which each conjunction holds.
        """
        groups: list[tuple[int, tuple[int, ...]]] = [(self._all, ())]
        for index, true in enumerate(truths):
            split = [(bits & true, (*holding, index)) for bits, holding in groups]
            split += [(bits & ~true, holding) for bits, holding in groups]
            groups = [each for each in split if each[0]]
        return groups

    def share(self, bits: int) -> float:
        """Share that some demonstrations are of all, the task's own and each kind of background weighing the same."""
        parts = [(bits & self._own).bit_count() / self._n] if self._n else []
        parts += [(bits >> start & whole).bit_count() / count for start, whole, count, _ in self._masks]
        return math.fsum(parts) / max(1, len(parts))

    def _chance(self, true: int, false: int) -> float:
        """Share of the background in which something holds; one half without any.

        It is the mean over the kinds, and no less than what the other tasks say, with whom neutral manipulations count
        as ``NEUTRAL_AMONG_TASKS`` of them.
        """
        if not self._kinds:
            return 0.5
        known_everywhere = (true | false) == self._all
        total = in_tasks = in_neutral = 0.0
        for start, whole, known, is_neutral in self._masks:
            hits = (true >> start & whole).bit_count()
            if not known_everywhere:
                known = hits + (false >> start & whole).bit_count()
            share = (hits + SMOOTHING) / (known + 2 * SMOOTHING)  # as ``smoothed``, where a call would be felt
            total += share
            if is_neutral:
                in_neutral += share
            elif hits:
                in_tasks += hits / known
        mean, neutral = total / len(self._masks), self._neutral_kinds
        if not neutral:
            return mean
        among = in_tasks + NEUTRAL_AMONG_TASKS * in_neutral / neutral
        return max(mean, among / (len(self._masks) - neutral + NEUTRAL_AMONG_TASKS))


class _Search(Counting):
    """The search for the clauses of one task."""

    def __init__(
        self, evidence: Evidence, task: str, tree: HypothesisTree, told: Told, words: Sequence[Vocabulary]
    ) -> None:
        super().__init__(evidence, task)
        self._parents = {each.node.name: each.node.parent for each in words}
        fixed = told.fixed(tree)
        literals: list[SetLiteral] = []
        for vocabulary in words:
            literals += (each for each in fixed if each.node == vocabulary.node.name)
            if vocabulary.node.name not in told.irrelevant:
                literals += vocabulary.literals(evidence.seen(vocabulary.node.name, task))
        unlike = _left_free(told.free, tree)
        self._candidates = tuple(
            _Candidate(literal, FOLLOWING_BITS + literal.bits, *self.truth((literal,)))
            for literal in _without_twins(literals)
            if literal in fixed or not unlike(literal)
        )
        nodes = [candidate.literal.node for candidate in self._candidates]
        self._of_node = [{i for i, other in enumerate(nodes) if other == node} for node in nodes]
        total = max(1, len(self._kinds))
        self._floor = sum(SMOOTHING / (kind.count + 2 * SMOOTHING) for kind in self._kinds) / total
        self._sizes = _by_size(self._kinds, self._n)
        self._likelihoods: dict[tuple[int, int], float] = {}
        self._entailment = entailment_of(tree) if fixed else None
        self._first = self._start(fixed)

    def best(self, most_literals: int) -> list[_Found]:
        """The best clauses, the very best first."""
        found = beam = [self._first]
        for _ in range(most_literals if self._kinds else 0):
            beam = self._longer(beam)
            found = nsmallest(KEPT, [*found, *beam], key=lambda one: one.order)
            beam = beam[:BEAM]
        return [one for one in found if one.members] or found

    def literals_of(self, found: _Found) -> tuple[SetLiteral, ...]:
        """The literals of a clause."""
        return tuple(self._candidates[index].literal for index in found.members)

    def supported(self, found: _Found) -> Support:
        """How often a clause holds, what was told among it, even where that is no evidence."""
        if self._told_apart:
            return self.support(*self.truth(self.literals_of(found)))
        return Support(found.k, found.n, found.chance)

    @property
    def _told_apart(self) -> bool:
        """Whether something was told on which the demonstrations are no evidence."""
        return bool(self._first.members) and self._first.true == self._all

    def _possible(self, members: Iterable[int]) -> bool:
        """Whether all these literals can hold at once. Only what was told against demonstrations leaves that open."""
        if not self._told_apart or self._entailment is None:
            return True
        return all(self._entailment.together(self._candidates[index].literal for index in members).values())

    def alone(self, index: int) -> LiteralSupport:
        """One literal, and how often it holds."""
        candidate = self._candidates[index]
        return LiteralSupport(candidate.literal, self.support(candidate.true, candidate.false))

    def usual(self, best: _Found) -> tuple[LiteralSupport, ...]:
        """Final states that always were so, and usually are, but for those of the best clause."""
        constant = self._constant(best)
        return tuple(each for each in constant if each.literal.instant == 2 and each.support.chance >= USUAL)

    def always(self, best: _Found) -> tuple[LiteralSupport, ...]:
        """What else was always so: the deepest values of each branch, but for what is said or usually is so anyway."""
        constant = self._constant(best)
        above = {name for each in constant for name in self._ancestors(each.literal.node)}
        above |= {name for index in best.members for name in self._ancestors(self._candidates[index].literal.node)}
        return tuple(each for each in constant if each.support.chance < USUAL and each.literal.node not in above)

    def _ancestors(self, node: str) -> Iterator[str]:
        while (above := self._parents.get(node)) is not None:
            yield above
            node = above

    def _constant(self, best: _Found) -> list[LiteralSupport]:
        """Values that nodes always had, but for those of the best clause, and what was told not to be so."""
        said = {self._candidates[index].literal.node for index in best.members}
        single = (
            self.alone(index)
            for index, candidate in enumerate(self._candidates)
            if candidate.literal.node not in said
            and candidate.literal.is_value
            and self._possible((*self._first.members, index))
        )
        return [each for each in single if each.support.k == each.support.n > 0]

    def _longer(self, beam: list[_Found]) -> list[_Found]:
        """The ``KEPT`` best clauses that are one literal longer than those of the beam."""
        found: list[_Found] = []
        best: list[float] = []  # scores of the best so far, the least one first
        tried: set[frozenset[int]] = set()
        for clause in beam:
            for members, index in self._extensions(clause, tried):
                one = self._extended(clause, members, index, best[0] if len(best) == KEPT else -math.inf)
                if one is not None:
                    found.append(one)
                    (heapreplace if len(best) == KEPT else heappush)(best, one.score)
        return nsmallest(KEPT, found, key=lambda one: one.order)

    def _extensions(self, clause: _Found, tried: set[frozenset[int]]) -> Iterator[tuple[frozenset[int], int]]:
        members = frozenset(clause.members)
        used = set[int]().union(*(self._of_node[index] for index in members))
        for index in range(len(self._candidates)):
            if index not in used:
                longer = members | {index}
                if longer not in tried:
                    tried.add(longer)
                    yield longer, index

    def _extended(self, clause: _Found, members: frozenset[int], index: int, least: float) -> _Found | None:
        """A clause and one literal more; None if it covers too little, says no more, cannot hold, or scores less."""
        candidate = self._candidates[index]
        true, false = clause.true & candidate.true, clause.false | candidate.false
        k = (true & self._own).bit_count()
        n = k + (false & self._own).bit_count()
        hits = true >> self._n
        if not k or k < COVERAGE * n or hits == clause.true >> self._n:
            return None
        bits = clause.bits + candidate.bits
        rarest = self._floor  # no chance is less than what follows, and a greater one scores less
        for of_size, weight in self._sizes:
            rarest += weight * (hits & of_size).bit_count()
        if rarest * n >= k or self._score(k, n, rarest, bits) < least - 10.0**-EQUAL:
            return None
        chance = self._chance(true, false)
        if chance * n >= k or not self._possible(members):
            return None
        return _Found(tuple(sorted(members)), true, false, bits, k, n, chance, self._score(k, n, chance, bits))

    def _start(self, fixed: Collection[SetLiteral]) -> _Found:
        """The clause that all others lengthen: what was told to be relevant, or nothing.

        Where the demonstrations contradict what was told, they are no evidence on it: what else they have in common
        is learned as if nothing had been told, and stands beside it, but for what cannot be so together with it.
        """
        chosen = tuple(index for index, candidate in enumerate(self._candidates) if candidate.literal in fixed)
        if not chosen:
            return _Found((), self._all, 0, 0.0, self._n, self._n, 1.0, 0.0)
        true, false = self.truth(fixed)
        bits = math.fsum(self._candidates[index].bits for index in chosen)
        support = self.support(true, false)
        if support.k < COVERAGE * support.n:
            return _Found(chosen, self._all, 0, bits, self._n, self._n, 1.0, -LN_2 * bits)
        return _Found(chosen, true, false, bits, support.k, support.n, support.chance, clause_score(support, bits))

    def _score(self, k: int, n: int, chance: float, bits: float) -> float:
        """As ``clause_score``, whose likelihood is reckoned once for all conjunctions that hold as often."""
        if (k, n) not in self._likelihoods:
            self._likelihoods[k, n] = _ln_likelihood(k, n - k, SLIPS)
        return self._likelihoods[k, n] - _ln_chance(k, n - k, chance) - LN_2 * bits


def _by_size(kinds: Iterable[Kind], own: int) -> tuple[tuple[int, float], ...]:
    """Bits of the background by the size of their kind to a factor of two, and what one hit adds to θ, at least.

    Args:
        kinds: The kinds.
        own: Where the first of them begins: the bits count from there.
    """
    kinds = tuple(kinds)
    found: dict[int, tuple[int, float]] = {}
    for kind in kinds:
        bits, weight = found.get(kind.count.bit_length(), (0, math.inf))
        bits |= ((1 << kind.count) - 1) << (kind.start - own)
        found[kind.count.bit_length()] = bits, min(weight, 1 / (kind.count + 2 * SMOOTHING) / len(kinds))
    return tuple(found.values())


def _without_twins(literals: Iterable[SetLiteral]) -> list[SetLiteral]:
    """Literals in canonical order, those once that say the same of their node; the first of them stays."""
    found: dict[tuple[str, bool, tuple[str, ...]], SetLiteral] = {}
    for literal in literals:
        found.setdefault(literal.order, literal)
    return [found[order] for order in found]


def _left_free(free: Collection[SetLiteral], tree: HypothesisTree) -> Callable[[SetLiteral], bool]:
    """Tells whether a literal says that one holds, or that it fails, which was said to be free."""
    entailment = entailment_of(tree)
    worlds = [entailment.worlds(each) for each in free]

    def settles(literal: SetLiteral) -> bool:
        own = entailment.worlds(literal)
        return any(own.space == each.space and own.bits & each.bits in (0, own.bits) for each in worlds)

    return settles


def _moved(bits: int, own: Kind) -> int:
    """The bits of all demonstrations, those of one kind taken to the lowest place."""
    below = bits & ((1 << own.start) - 1)
    return own.of(bits) | (below << own.count) | (bits >> (own.start + own.count) << (own.start + own.count))
