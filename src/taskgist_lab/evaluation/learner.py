"""What is understood after each demonstration of each run: the learner of ``learning``, in arrays.

It follows ``learning.understand`` and ``learning.clause_of`` node by node; tests hold it to them.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from taskgist.common.arrays import Indices, Mask
from taskgist.errors import InputError
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import Node
from taskgist.learning.estimate import Band, Verdict, canonical_key
from taskgist_lab.evaluation.pool import HELD_OUT_EVERY, SOURCES, Pool
from taskgist_lab.evaluation.values import CLEAN, Sample
from taskgist_lab.paper.published import CLAUSES, Cell

# --- A pool as numbers: each value is its index in its node's canonical order, unknown is -1.

Codes = NDArray[np.int32]
UNKNOWN_CODE = -1


@dataclass(frozen=True, eq=False)
class Coded:
    """The vocabulary of a pool.

    Args:
        pool: The pool.
        nodes: The tree's nodes, in the order of the pool's values.
        values: Values of each node that occur in the pool or are declared, in canonical order, which decides ties.
    """

    pool: Pool
    nodes: tuple[Node, ...]
    values: tuple[tuple[str, ...], ...]

    @staticmethod
    def of(pool: Pool) -> Coded:
        """The vocabulary of everything in a pool."""
        nodes = tuple(STANDARD_TREE.node(name) for name in pool.nodes)
        columns = zip(*(sample.values for sample in pool.samples), strict=True) if pool.samples else ((),) * len(nodes)
        values = tuple(
            _ordered({*node.values, *(value for value in column if value is not None)}, node)
            for node, column in zip(nodes, columns, strict=True)
        )
        return Coded(pool, nodes, values)

    def index(self, node: str) -> int:
        """Column of a node."""
        return self.pool.nodes.index(node)

    def code(self, node: str, value: str) -> int:
        """Code of a value of a node."""
        return self.values[self.index(node)].index(value)

    def codes(self, samples: Iterable[Sample]) -> Codes:
        """Codes of samples, (samples, nodes)."""
        tables = [{None: UNKNOWN_CODE, **{value: code for code, value in enumerate(each)}} for each in self.values]
        rows = [[table[value] for table, value in zip(tables, each.values, strict=True)] for each in samples]
        return np.array(rows, dtype=np.int32).reshape(len(rows), len(self.nodes))

    def of_task(self, task: str, condition: str = CLEAN, *, held_out: bool) -> Codes:
        """Codes of a task's demonstrations under a condition, (demonstrations, nodes)."""
        return self.codes(self.pool.of(task, condition, held_out=held_out))


def _ordered(values: set[str], node: Node) -> tuple[str, ...]:
    return tuple(sorted(values, key=lambda value: canonical_key(value, node.values)))


# --- Random orders in which demonstrations come, some of them wrong ones if wanted.

LONGEST = 20
"""Demonstrations of a run, where no other number is wanted."""


def in_random_order(
    coded: Coded,
    task: str,
    *,
    runs: int,
    seed: int,
    condition: str = CLEAN,
    wrong_share: float = 0.0,
    longest: int = LONGEST,
) -> Codes:
    """Demonstrations in random order, none twice in a run, (runs, up to ``longest``, nodes).

    The same task and seed give the same orders whatever is compared. Where the source has a few distinct
    demonstrations, each displaced many times, all of them come, in random order, before one comes again.

    Args:
        coded: A pool.
        task: The task that is learned.
        runs: How many orders.
        seed: Their seed.
        condition: Under which the demonstrations were watched.
        wrong_share: Probability of each demonstration to be one of another task that is labelled as this one.
        longest: Demonstrations of a run at most.

    Raises:
        InputError: There are no demonstrations to learn this task from.
    """
    own = coded.of_task(task, condition, held_out=False)
    if not len(own):
        hint = f"make more demonstrations: every {HELD_OUT_EVERY}rd is held out, and some cannot be played"
        raise InputError("no demonstrations to learn from", where=f"{task}, {condition}", field="pool", hint=hint)
    rng = np.random.default_rng([seed, zlib.crc32(task.encode())])
    source = SOURCES[coded.pool.source]
    kinds = [source.kind(task, each.number) for each in coded.pool.of(task, condition, held_out=False)]
    chosen = own[_by_turns(rng, kinds, runs)[:, :longest]]
    others = _others(coded, task, condition)
    return _with_wrong(chosen, others, rng, wrong_share) if wrong_share and len(others) else chosen


def sizes_within(sizes: Sequence[int], orders: Iterable[Codes]) -> tuple[int, ...]:
    """The sizes that every run reaches.

    Raises:
        InputError: There is none.
    """
    shortest = min(each.shape[1] for each in orders)
    reached = tuple(size for size in sizes if size <= shortest)
    if not reached:
        hint = f"learn from {sizes[0]} or more; every {HELD_OUT_EVERY}rd demonstration is held out"
        raise InputError("too few demonstrations to learn from", field="pool", value=shortest, hint=hint)
    return reached


def _orders(rng: np.random.Generator, count: int, runs: int) -> Indices:
    """Orders of indices, (runs, count)."""
    return np.asarray(rng.permuted(np.tile(np.arange(count), (runs, 1)), axis=1))


def _by_turns(rng: np.random.Generator, kinds: Sequence[int], runs: int) -> Indices:
    """Orders of indices in rounds, each with every kind once as long as there are any; all kinds differ: one round."""
    rounds = np.empty((runs, len(kinds)))
    for kind in sorted(set(kinds)):
        members = np.flatnonzero(np.equal(kinds, kind))
        rounds[:, members] = rng.permuted(np.tile(np.arange(len(members)), (runs, 1)), axis=1)
    return np.argsort(rounds + rng.random(rounds.shape), axis=1)


def _others(coded: Coded, task: str, condition: str) -> Codes:
    tasks = (each for each in coded.pool.tasks if each != task)
    return np.concatenate([coded.codes(()), *(coded.of_task(each, condition, held_out=False) for each in tasks)])


def _with_wrong(chosen: Codes, others: Codes, rng: np.random.Generator, share: float) -> Codes:
    wrong = rng.random(chosen.shape[:2]) < share
    orders = _orders(rng, len(others), len(chosen))
    replacing = others[orders[:, np.arange(chosen.shape[1]) % orders.shape[1]]]
    return np.where(wrong[:, :, None], replacing, chosen)


# --- Somebody who answers questions: who knows the clauses that the paper printed, and no demonstration.


@dataclass(frozen=True, eq=False)
class Oracle:
    """Somebody who knows what a task means and answers questions.

    Attributes:
        kept: Whether each node is part of the task, (nodes,).
        values: Code of the value that each must have, (nodes,); -1: whichever was seen most often.
    """

    kept: Mask
    values: Codes


def published_oracle(task: str, coded: Coded) -> Oracle:
    """Who has read the paper's clause of a task (Eq. 37 to 42).

    Its predicates are relevant, with their values; what stands above them in the tree is relevant, too, with whichever
    value was seen most often; everything else is irrelevant.

    Raises:
        KeyError: The paper has no clause of this task.
    """
    names = coded.pool.nodes
    kept = np.zeros(len(names), dtype=bool)
    values = np.full(len(names), UNKNOWN_CODE, dtype=np.int32)
    for predicate in CLAUSES[task].predicates:
        column = coded.index(predicate.node)
        if predicate.value in coded.values[column]:  # else no demonstration ever shows it
            values[column] = coded.code(predicate.node, predicate.value)
        name: str | None = predicate.node
        while name is not None:
            kept[coded.index(name)] = True
            name = coded.nodes[coded.index(name)].parent
    return Oracle(kept, values)


# --- Counts along runs: after each demonstration, what the learner counts of each node.
#
# A verdict on a node follows from three numbers: in how many demonstrations it was known (N), how often it had its
# most frequent value (n), and how many different values it had (k). So runs are counted once, in arrays, and judged
# by as many rules as one likes.

Counts = NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class Tally:
    """What has been counted after each demonstration of each run; all arrays are (runs, demonstrations, nodes)."""

    best: Codes
    """Code of the most frequent value, ties by canonical order; -1 where nothing is known."""
    n: Counts
    """Demonstrations that showed it."""
    N: Counts
    """Demonstrations in which the node was known."""
    k: Counts
    """Different values that were seen."""


def tally(orders: Codes) -> Tally:
    """Count along runs.

    Args:
        orders: Codes, (runs, demonstrations, nodes).
    """
    columns = [_column(orders[:, :, node]) for node in range(orders.shape[2])]
    best, n, N, k = (np.stack([column[part] for column in columns], axis=2) for part in range(4))
    return Tally(best, n, N, k)


def _column(codes: Codes) -> tuple[Codes, Counts, Counts, Counts]:
    """Counts of one node: best, n, N and k, (runs, demonstrations) each."""
    seen = np.unique(codes[codes != UNKNOWN_CODE])  # sorted: the first of several maxima is the canonical one
    if not len(seen):
        nothing = np.zeros(codes.shape, dtype=np.int32)
        return np.full_like(codes, UNKNOWN_CODE), nothing, nothing, nothing
    counts = np.cumsum(codes[:, :, None] == seen, axis=1, dtype=np.int32)
    n = counts.max(axis=2)
    best = np.where(n > 0, seen[counts.argmax(axis=2)], UNKNOWN_CODE).astype(np.int32)
    return best, n, counts.sum(axis=2, dtype=np.int32), (counts > 0).sum(axis=2, dtype=np.int32)


# --- Rules by which counts become verdicts: the paper's, others of its kind, and plain intersection.
#
# **What can differ.** The verdict compares ``CF = Q − NRE`` with ``Q − l·Q``, that is NRE with l·Q. Both have the
# same denominator N + m (Eq. 27), so it cancels: of m and prior only their product a = m × prior has a say, and a
# node at which all demonstrations agree is relevant whatever it is. The rules here therefore differ in a and in the
# band; that m = 1 with prior 1/2 and m = 2 with prior 1/4 are one rule is no finding, but arithmetic.

HALF = Fraction(1, 2)
NARROW, WIDE, SHARP = Band.named("narrow"), Band.named("wide"), Band.named("sharp")
VERDICTS = tuple(Verdict)
"""Verdicts by their code."""
RELEVANT, IRRELEVANT, CONFUSING, UNOBSERVED = range(len(VERDICTS))


@dataclass(frozen=True)
class Judging:
    """How the counts of a node become its verdict.

    Args:
        name: Its name.
        text: What it is, in a few words.
        m: Equivalent sample size.
        prior: Prior probability of a value; None: one over the number of values that the node may take (one half
            where these are not known beforehand).
        band: The zone of confusion; None: every node with two values or more is irrelevant (intersection).
        asks: Whether confusing nodes become questions that somebody answers.
    """

    name: str
    text: str
    m: int = 2
    prior: Fraction | None = HALF
    band: Band | None = NARROW
    asks: bool = False

    def share(self, node: Node) -> Fraction:
        """The product m × prior for a node's values: what Eq. 27 calls a."""
        prior = self.prior or (Fraction(1, len(node.values)) if len(node.values) > 1 else HALF)
        return self.m * prior

    def verdicts(self, counted: Tally, nodes: tuple[Node, ...]) -> NDArray[np.int8]:
        """Codes of verdicts, (runs, demonstrations, nodes), in whole numbers: a boundary is a boundary."""
        n, N, k = (each.astype(np.int64) for each in (counted.n, counted.N, counted.k))
        irrelevant, relevant = self._compared(n, N, k, nodes) if self.band else (k > 1, k == 1)
        found = np.where(irrelevant, IRRELEVANT, np.where(relevant, RELEVANT, CONFUSING))
        return np.where(N == 0, UNOBSERVED, found).astype(np.int8)

    def _compared(
        self, n: NDArray[np.int64], N: NDArray[np.int64], k: NDArray[np.int64], nodes: tuple[Node, ...]
    ) -> tuple[Mask, Mask]:
        """Where NRE ≥ l1·Q, which is CF ≤ d1; and where NRE < l2·Q, which is CF > d2 (Eq. 33-35)."""
        assert self.band is not None
        shares = [self.share(node) for node in nodes]
        a, unit = (np.array([getattr(each, part) for each in shares]) for part in ("numerator", "denominator"))
        Q, NRE = unit * n + a, unit * (N - n) + (k - 1) * a  # both times (N + m), and the denominator of a
        l1, l2 = self.band.l1, self.band.l2
        return NRE * l1.denominator >= l1.numerator * Q, NRE * l2.denominator < l2.numerator * Q


PAPER = Judging("paper", "the paper's: m = 2, prior 1/2, band 10-30 %")
INTERSECTION = Judging("intersection", "plain intersection: one dissent makes irrelevant", band=None)

RULES: Mapping[str, Judging] = MappingProxyType(
    {
        each.name: each
        for each in (
            PAPER,
            Judging("paper-asked", "the paper's, its questions answered", asks=True),
            Judging("wide", "band 10-60 %, nobody answers", band=WIDE),
            Judging("wide-asked", "band 10-60 %, its questions answered", band=WIDE, asks=True),
            Judging("m1", "m = 1, prior 1/2 (as m = 2, prior 1/4)", m=1),
            Judging("m4", "m = 4, prior 1/2", m=4),
            Judging("m8", "m = 8, prior 1/2", m=8),
            Judging("prior-1/values", "m = 2, prior 1 / number of values", prior=None),
            Judging("sharp", "relevant up to NRE = 30 % of Q, never asks", band=SHARP),
            Judging("sharp-m1", "the same with m = 1", m=1, band=SHARP),
            Judging("sharp-50", "relevant up to NRE = 50 % of Q, never asks", band=Band(HALF, HALF)),
            INTERSECTION,
        )
    }
)
"""The rules that are compared, by name."""


@dataclass(frozen=True, eq=False)
class Learned:
    """What is understood, (runs, demonstrations, nodes) each.

    Attributes:
        nodes: The tree's nodes.
        kept: Whether each node belongs to the largest consistent subtree.
        values: Code of each node's desired value.
        asked: Questions asked so far, (runs, demonstrations).
    """

    nodes: tuple[Node, ...]
    kept: Mask
    values: Codes
    asked: NDArray[np.int32]

    def effects(self) -> Mask:
        """Which nodes are effects of the clause: the deepest kept ones, initial ones left aside."""
        return self._deepest(np.array([node.instant != 1 for node in self.nodes]))

    def preconditions(self) -> Mask:
        """Which nodes are preconditions of the clause: the deepest kept initial ones."""
        return self._deepest(np.array([node.instant == 1 for node in self.nodes]))

    def holds(self, cell: Cell, coded: Coded) -> Mask:
        """Whether a cell of Table 4 holds, (runs, demonstrations)."""
        true = np.ones(self.kept.shape[:2], dtype=bool)
        for name, value in cell.kept:
            column = coded.index(name)
            true &= self.kept[:, :, column] & (self.values[:, :, column] == coded.code(name, value))
        for name in cell.pruned:
            true &= ~self.kept[:, :, coded.index(name)]
        return true

    def _deepest(self, chosen: Mask) -> Mask:
        """The chosen nodes that are kept and have no chosen, kept child."""
        kept = self.kept & chosen
        deepest = kept.copy()
        for column, parent in enumerate(_parents(self.nodes)):
            if parent is not None:
                deepest[:, :, parent] &= ~kept[:, :, column]
        return deepest


def learned(orders: Codes, coded: Coded, judging: Judging = PAPER, oracle: Oracle | None = None) -> Learned:
    """Learn along runs.

    Args:
        orders: Codes, (runs, demonstrations, nodes).
        coded: The pool that they come from.
        judging: How counts become verdicts.
        oracle: Who answers, where the judging asks.
    """
    return from_tally(tally(orders), coded, judging, oracle)


def from_tally(counted: Tally, coded: Coded, judging: Judging, oracle: Oracle | None = None) -> Learned:
    """What is understood from counts; see ``learned``."""
    verdicts = judging.verdicts(counted, coded.nodes)
    if judging.asks:
        assert oracle is not None, "somebody must answer"
        return _asking(counted, coded.nodes, verdicts, oracle)
    kept = verdicts == RELEVANT
    for column, parent in enumerate(_parents(coded.nodes)):
        if parent is not None:
            kept[:, :, column] &= kept[:, :, parent]
    return Learned(coded.nodes, kept, counted.best, np.zeros(kept.shape[:2], dtype=np.int32))


def _asking(counted: Tally, nodes: tuple[Node, ...], verdicts: NDArray[np.int8], oracle: Oracle) -> Learned:
    """Whatever is confusing below what is kept is asked at once, and stays as answered."""
    runs, demonstrations, count = verdicts.shape
    kept = np.zeros(verdicts.shape, dtype=bool)
    answered = np.zeros((runs, count), dtype=bool)
    values = counted.best.copy()
    asked = np.zeros((runs, demonstrations), dtype=np.int32)
    for step in range(demonstrations):
        for column, parent in enumerate(_parents(nodes)):
            above = np.ones(runs, dtype=bool) if parent is None else kept[:, step, parent]
            answered[:, column] |= above & (verdicts[:, step, column] == CONFUSING)
            relevant = np.where(answered[:, column], oracle.kept[column], verdicts[:, step, column] == RELEVANT)
            kept[:, step, column] = above & relevant
        told = answered & oracle.kept & (oracle.values != UNKNOWN_CODE)
        values[:, step] = np.where(told, oracle.values, values[:, step])
        asked[:, step] = answered.sum(axis=1)
    return Learned(nodes, kept, values, asked)


def _parents(nodes: tuple[Node, ...]) -> list[int | None]:
    """Column of each node's parent."""
    columns = {node.name: column for column, node in enumerate(nodes)}
    return [None if node.parent is None else columns[node.parent] for node in nodes]


def truths(mask: Mask, values: Codes, samples: Codes) -> NDArray[np.int8]:
    """Whether clauses hold in demonstrations: 1 true, 0 false, -1 unknown, (clauses, demonstrations).

    Args:
        mask: Nodes of each clause, (clauses, nodes).
        values: Code of the value that each must have, (clauses, nodes).
        samples: Codes of demonstrations, (demonstrations, nodes).
    """
    false = np.zeros((len(mask), len(samples)), dtype=bool)
    unknown = false.copy()
    for node in np.flatnonzero(mask.any(axis=0)):
        meant, has = mask[:, [node]], samples[:, node]
        missing = has == UNKNOWN_CODE
        unknown |= meant & missing
        false |= meant & ~missing & (has != values[:, [node]])
    return np.where(false, 0, np.where(unknown, UNKNOWN_CODE, 1)).astype(np.int8)
