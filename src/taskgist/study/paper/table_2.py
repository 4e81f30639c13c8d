"""Table 2: consistency of the object's final status over the demonstrations of *show*; and the wide band (7.3)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction

from taskgist.facts import Json
from taskgist.language import asked
from taskgist.learning import Understanding, questions_of
from taskgist.settings import DEFAULT
from taskgist.study.paper.demonstrations import Judged, understanding_of
from taskgist.study.paper.result import Result, Section, Verdict, compared

TASK, NODE = "show", "placement.status.2"
HALF_A_DIGIT = Fraction(1, 200_000)
"""The paper rounds to five decimals."""
PRINTED: tuple[Mapping[str, str], ...] = tuple(
    dict(zip(("observed", "value", "Q", "P", "NRE", "d1", "d2", "CF"), row.split(), strict=True))
    for row in (
        "In_Hand    In_Hand 0.66667 1    0       0.46667 0.6   0.66667",
        "In_Hand    In_Hand 0.75    1    0       0.525   0.675 0.75",
        "In_Hand    In_Hand 0.8     1    0       0.56    0.72  0.8",
        "On_Support In_Hand 0.66667 0.75 0.33333 0.46667 0.6   0.33334",
    )
)
"""The table's rows; P of the first three is 1 by the text."""
WIDE = {"d1": "0.26667", "verdict": "confusing"}
"""What 7.3 says of the fourth demonstration with the band from 10 to 60 %."""
ROUNDED = "{column} is the difference of rounded columns ({Q} − {NRE} = {printed}); exactly it is {exact}"


def table_2_section(judged: Mapping[str, tuple[Judged, ...]]) -> Section:
    """Compare Table 2 row by row, in exact fractions, and what the wide band makes of its last row.

    Args:
        judged: The judged demonstrations by task.
    """
    results = []
    for number, printed in enumerate(PRINTED, start=1):
        shown = judged[TASK][:number]
        results.append(_compared_row(number, printed, row(shown) if len(shown) == number else {}))
    wide = understanding_of(TASK, judged[TASK], settings=replace(DEFAULT.learning, band="wide"))
    judgement = wide.judgements[NODE]
    limit = judgement.estimate.d1
    ours = {"d1": str(limit), "verdict": judgement.verdict.value}
    expected = {**WIDE, "d1": str(limit)} if agrees(WIDE["d1"], limit) else WIDE
    results.append(replace(compared("demonstration 4, wide", "7.3", expected, ours), paper=WIDE))
    return Section(
        "table_2", "Table 2: consistency of O_s² in show", tuple(results), details={"question": question(wide)}
    )


def row(shown: Sequence[Judged]) -> dict[str, str | Fraction]:
    """Our row of the table: symbols as they are, numbers as exact fractions.

    Args:
        shown: The demonstrations so far, one or more.
    """
    estimate = understanding_of(TASK, shown).judgements[NODE].estimate
    return {
        "observed": str(shown[-1].explanation.nodes[NODE].value),
        "value": str(estimate.value),
        "Q": estimate.Q,
        "P": Fraction(estimate.n, estimate.N),
        "NRE": estimate.NRE,
        "d1": estimate.d1,
        "d2": estimate.d2,
        "CF": estimate.CF,
    }


def question(understanding: Understanding) -> str:
    """The question about the node, or nothing if there is none."""
    return " ".join(asked(each) for each in questions_of(understanding) if each.node.name == NODE)


def agrees(printed: str, exact: Fraction) -> bool:
    """Whether a printed decimal is an exact fraction, rounded."""
    return abs(Fraction(printed) - exact) <= HALF_A_DIGIT


def _compared_row(number: int, printed: Mapping[str, str], ours: Mapping[str, str | Fraction]) -> Result:
    different = [column for column in printed if not _same(printed[column], ours.get(column))]
    explained = [text for column in different if (text := _rounding(column, printed, ours))]
    verdict = Verdict.EQUAL
    if different:
        verdict = Verdict.DIFFERS_EXPLAINED if len(explained) == len(different) else Verdict.FAILS
    plain: dict[str, Json] = {column: str(value) for column, value in ours.items()}
    return Result(f"demonstration {number}", "Table 2", dict(printed), plain, verdict, "; ".join(explained))


def _same(printed: str, ours: str | Fraction | None) -> bool:
    return agrees(printed, ours) if isinstance(ours, Fraction) else printed == ours


def _rounding(column: str, printed: Mapping[str, str], ours: Mapping[str, str | Fraction]) -> str:
    """Says so where the paper subtracted rounded numbers, and nothing where the cause is another."""
    if column != "CF" or Decimal(printed["Q"]) - Decimal(printed["NRE"]) != Decimal(printed["CF"]):
        return ""
    if not all(_same(printed[each], ours.get(each)) for each in ("Q", "NRE")):
        return ""
    return ROUNDED.format(column=column, Q=printed["Q"], NRE=printed["NRE"], printed=printed["CF"], exact=ours["CF"])
