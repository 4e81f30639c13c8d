"""Rules by which counts become verdicts: the paper's, others of its kind, and plain intersection.

**What can differ.** The verdict compares ``CF = Q − NRE`` with ``Q − l·Q``, that is NRE with l·Q. Both have the same
denominator N + m (Eq. 27), so it cancels: of m and prior only their product a = m × prior has a say, and a node at
which all demonstrations agree is relevant whatever it is. The rules here therefore differ in a and in the band; that
m = 1 with prior 1/2 and m = 2 with prior 1/4 are one rule is no finding, but arithmetic.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from taskgist.facts import Node
from taskgist.learning import Band, Verdict
from taskgist.study.evaluation.tally import Tally

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
        """Codes of verdicts, (draws, demonstrations, nodes), in whole numbers: a boundary is a boundary."""
        n, N, k = (each.astype(np.int64) for each in (counted.n, counted.N, counted.k))
        irrelevant, relevant = self._compared(n, N, k, nodes) if self.band else (k > 1, k == 1)
        found = np.where(irrelevant, IRRELEVANT, np.where(relevant, RELEVANT, CONFUSING))
        return np.where(N == 0, UNOBSERVED, found).astype(np.int8)

    def _compared(
        self, n: NDArray[np.int64], N: NDArray[np.int64], k: NDArray[np.int64], nodes: tuple[Node, ...]
    ) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
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
