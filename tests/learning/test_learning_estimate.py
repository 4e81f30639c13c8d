"""m-estimate, consistency factor, verdicts: Eq. 27-35, Table 2, and the arithmetic of both bands."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from taskgist.errors import InputError, UnknownNameError
from taskgist.learning import Band, Rule, Verdict, m_estimate, weigh
from taskgist.settings import Learning

NARROW, WIDE = Rule.of(Learning()), Rule.of(Learning(band="wide"))
SEEDED = settings(derandomize=True)
COUNTS = st.integers(0, 200)
SIZES = st.integers(1, 20)
PRIORS = st.fractions(Fraction(1, 100), Fraction(99, 100))


def test_table_2() -> None:
    seen: dict[str, int] = {}
    rows = []
    for value in ("In_Hand", "In_Hand", "In_Hand", "On_Support"):
        seen[value] = seen.get(value, 0) + 1
        got = weigh(seen, NARROW)
        assert got.value == "In_Hand"
        rows.append((got.Q, got.NRE, got.d1, got.d2, got.CF, got.verdict))
    assert rows == [
        # The paper prints 0.66667, 0, 0.46667, 0.6, 0.66667; then the same to five digits in each row.
        (Fraction(2, 3), 0, Fraction(7, 15), Fraction(3, 5), Fraction(2, 3), Verdict.RELEVANT),
        (Fraction(3, 4), 0, Fraction(21, 40), Fraction(27, 40), Fraction(3, 4), Verdict.RELEVANT),
        (Fraction(4, 5), 0, Fraction(14, 25), Fraction(18, 25), Fraction(4, 5), Verdict.RELEVANT),
        (Fraction(2, 3), Fraction(1, 3), Fraction(7, 15), Fraction(3, 5), Fraction(1, 3), Verdict.IRRELEVANT),
    ]


def test_the_wide_band_turns_the_fourth_demonstration_into_a_question() -> None:
    got = weigh({"In_Hand": 3, "On_Support": 1}, WIDE)
    assert (round(float(got.d1), 5), got.verdict) == (0.26667, Verdict.CONFUSING)


@pytest.mark.parametrize("N", range(2, 60))
def test_one_dissent_with_the_narrow_band(N: int) -> None:
    got = weigh({"a": N - 1, "b": 1}, NARROW)
    expected = Verdict.IRRELEVANT if N <= 6 else Verdict.CONFUSING if N <= 20 else Verdict.RELEVANT
    assert got.verdict is expected
    assert (got.d2 == got.CF) == (N == 20)


@pytest.mark.parametrize("N", range(2, 60))
def test_one_dissent_with_the_wide_band_asks_from_four(N: int) -> None:
    expected = Verdict.IRRELEVANT if N <= 3 else Verdict.CONFUSING if N <= 20 else Verdict.RELEVANT
    assert weigh({"a": N - 1, "b": 1}, WIDE).verdict is expected


def test_the_limits_themselves() -> None:
    band = Band.named("narrow")
    Q = Fraction(1, 2)
    d1, d2 = band.limits(Q)
    hair = Fraction(1, 10**12)
    verdicts = [band.verdict(Q, CF) for CF in (d1, d1 + hair, d2, d2 + hair)]
    assert verdicts == [Verdict.IRRELEVANT, Verdict.CONFUSING, Verdict.CONFUSING, Verdict.RELEVANT]


def test_ties_go_to_the_first_in_canonical_order() -> None:
    counts = {"Sitting": 2, "Standing": 2}
    assert weigh(counts, NARROW, ("Standing", "Sitting")).value == "Standing"
    assert weigh(counts, NARROW).value == "Sitting"
    assert weigh({"zoo": 1, "Sitting": 1}, NARROW, ("Standing", "Sitting")).value == "Sitting"


def test_nothing_known_is_unobserved() -> None:
    got = weigh({}, NARROW)
    assert (got.verdict, got.value, got.N, got.Q) == (Verdict.UNOBSERVED, None, 0, Fraction(1, 2))


@SEEDED
@given(N=COUNTS, m=SIZES, prior=PRIORS)
def test_properties_of_the_m_estimate(N: int, m: int, prior: Fraction) -> None:
    def Q(n: int, of: int) -> Fraction:
        return m_estimate(n, of, m=m, prior=prior)

    assert Q(0, 0) == prior > 0  # Eq. 28
    assert Q(0, N) == m * prior / (N + m) > 0  # Eq. 29
    assert Q(N, N) < 1  # Eq. 30
    assert Q(N + 1, N + 1) > Q(N, N)  # Eq. 31
    # Eq. 32 is printed the wrong way round: with more demonstrations without it, a value becomes less likely.
    assert Q(0, N + 1) < Q(0, N)


@SEEDED
@given(st.dictionaries(st.sampled_from("abcdef"), st.integers(1, 30), min_size=1), st.sampled_from([NARROW, WIDE]))
def test_agreement_is_relevant_and_a_tie_is_not(counts: dict[str, int], rule: Rule) -> None:
    got = weigh(counts, rule)
    assert got.CF == got.Q - got.NRE
    assert got.n == max(counts.values())
    if len(counts) == 1:
        assert got.verdict is Verdict.RELEVANT
    if list(counts.values()).count(got.n) > 1:
        assert got.verdict is Verdict.IRRELEVANT


@pytest.mark.parametrize(
    ("given_settings", "message"),
    [
        (Learning(m=0), "m: too small (got 0)"),
        (Learning(prior=(0, 1)), "prior: no probability (got '0')"),
        (Learning(prior=(1, 1)), "prior: no probability (got '1')"),
        (Learning(prior=(1, 0)), "prior: division by zero (got (1, 0))"),
    ],
)
def test_impossible_settings_are_refused(given_settings: Learning, message: str) -> None:
    with pytest.raises(InputError) as caught:
        Rule.of(given_settings)
    assert message in str(caught.value)


def test_impossible_bands_are_refused() -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'narrow'"):
        Band.named("narow")
    with pytest.raises(InputError, match="choose 0 ≤ l2 ≤ l1 ≤ 1"):
        Band(Fraction(1, 10), Fraction(3, 10))
