"""The m-estimate, the consistency factor and the verdict on one predicate (6.3, 6.4), in exact fractions.

Fractions, because a boundary is a boundary: 19 of 20 demonstrations lie exactly on d2 of the paper's band, and
floating point would decide by rounding.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from fractions import Fraction

from taskgist.errors import InputError, UnknownNameError
from taskgist.settings import BANDS, Learning


class Verdict(Enum):
    """What the demonstrations say about a predicate."""

    RELEVANT = "relevant"
    IRRELEVANT = "irrelevant"
    CONFUSING = "confusing"
    UNOBSERVED = "unobserved"


@dataclass(frozen=True)
class Band:
    """The zone of confusion, as tolerances relative to the relevance evidence Q (Eq. 34, 35, Fig. 12).

    Args:
        l1: Share of Q from which on the dissent makes a predicate irrelevant.
        l2: Share of Q below which the dissent is ignored.

    Raises:
        InputError: Not 0 ≤ l2 ≤ l1 ≤ 1.
    """

    l1: Fraction
    l2: Fraction

    def __post_init__(self) -> None:
        if not 0 <= self.l2 <= self.l1 <= 1:
            value = (str(self.l1), str(self.l2))
            raise InputError("not a band", field="band (l1, l2)", value=value, hint="choose 0 ≤ l2 ≤ l1 ≤ 1")

    @staticmethod
    def named(name: str) -> Band:
        """A band of ``taskgist.settings.BANDS``.

        Raises:
            UnknownNameError: There is none of this name.
        """
        if name not in BANDS:
            raise UnknownNameError("band", name, BANDS)
        l1, l2 = BANDS[name]
        return Band(Fraction(*l1), Fraction(*l2))

    def limits(self, Q: Fraction) -> tuple[Fraction, Fraction]:
        """The limits (d1, d2) of the consistency factor, given the relevance evidence."""
        return Q - self.l1 * Q, Q - self.l2 * Q

    def verdict(self, Q: Fraction, CF: Fraction) -> Verdict:
        """Verdict on a predicate (6.4): d1 itself is irrelevant, d2 itself confusing."""
        d1, d2 = self.limits(Q)
        if d1 >= CF:
            return Verdict.IRRELEVANT
        return Verdict.RELEVANT if d2 < CF else Verdict.CONFUSING


@dataclass(frozen=True)
class Rule:
    """How counts become verdicts: equivalent sample size m, prior, band.

    Raises:
        InputError: m or the prior is out of range.
    """

    m: int
    prior: Fraction
    band: Band

    def __post_init__(self) -> None:
        if self.m <= 0:
            raise InputError("too small", field="m", value=self.m, hint="a + b = m must be 1 or more (Eq. 27)")
        if not 0 < self.prior < 1:
            hint = "a = m × prior and b must be greater than 0 (Eq. 27)"
            raise InputError("no probability", field="prior", value=str(self.prior), hint=hint)

    @staticmethod
    def of(settings: Learning) -> Rule:
        """The rule that the settings describe."""
        if settings.prior[1] == 0:
            raise InputError("division by zero", field="prior", value=settings.prior, hint="give it as (1, 2)")
        return Rule(settings.m, Fraction(*settings.prior), Band.named(settings.band))


@dataclass(frozen=True)
class Estimate:
    """What the counts of one predicate say."""

    value: str | None
    """v_h, the value with the highest m-estimate; None if the predicate was never known."""
    n: int
    """Demonstrations in which it had that value."""
    N: int
    """Demonstrations in which it was known."""
    Q: Fraction
    """m-estimate of v_h (Eq. 27): the relevance evidence."""
    NRE: Fraction
    """Sum of the m-estimates of the other observed values: the non-relevance evidence."""
    CF: Fraction
    """Consistency factor Q − NRE (Eq. 33)."""
    d1: Fraction
    """At or below it, the predicate is irrelevant (Eq. 35)."""
    d2: Fraction
    """Above it, the predicate is relevant (Eq. 34)."""
    verdict: Verdict


def m_estimate(n: int, N: int, *, m: int, prior: Fraction) -> Fraction:
    """Likelihood that the next demonstration shows a value again (Eq. 27, with a = m × prior).

    Args:
        n: Demonstrations that showed it.
        N: Demonstrations in which the predicate was known.
        m: Equivalent sample size a + b.
        prior: Probability of the value before any demonstration.
    """
    assert 0 <= n <= N, (n, N)
    return (n + m * prior) / (N + m)


def weigh(counts: Mapping[str, int], rule: Rule, order: Sequence[str] = ()) -> Estimate:
    """Judge one predicate by how often each of its values was observed.

    Args:
        counts: Demonstrations by value, each 1 or more; unknown is not counted.
        rule: Parameters of estimate and band.
        order: Canonical order of the values, which decides ties; further values follow by name.
    """
    N = sum(counts.values())
    Q = {value: m_estimate(n, N, m=rule.m, prior=rule.prior) for value, n in counts.items()}
    best = min(counts, key=lambda value: (-counts[value], canonical_key(value, order)), default=None)
    relevance = m_estimate(0, 0, m=rule.m, prior=rule.prior) if best is None else Q[best]
    dissent = sum((q for value, q in Q.items() if value != best), Fraction(0))
    CF = relevance - dissent  # Eq. 33
    d1, d2 = rule.band.limits(relevance)
    verdict = Verdict.UNOBSERVED if best is None else rule.band.verdict(relevance, CF)
    n = 0 if best is None else counts[best]
    return Estimate(best, n, N, relevance, dissent, CF, d1, d2, verdict)


def canonical_key(value: str, order: Sequence[str]) -> tuple[int, str]:
    """Sort key: declared values in their order, then the others by name."""
    return (order.index(value) if value in order else len(order), value)
