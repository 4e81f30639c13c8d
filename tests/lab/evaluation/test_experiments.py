"""Experiments on the paper's study as values: laws, and numbers that can be counted by hand."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from taskgist.errors import InputError
from taskgist.learning import Experience, clause_of, understand
from taskgist_lab.evaluation.experiments import (
    ALL,
    CLAUSE,
    PARTS,
    SETTINGS,
    SIZES,
    WRONG_PERCENT,
    HeldOut,
    Waiting,
    demonstrations_needed,
    held_in,
    lasting_from,
    scores_of,
    table_of,
    transfer,
)
from taskgist_lab.evaluation.learner import RULES, Coded, in_random_order, learned
from taskgist_lab.evaluation.noise import CONDITIONS
from taskgist_lab.evaluation.robustness import JUDGED_AFTER, robustness
from taskgist_lab.evaluation.sheets import sheets_of
from taskgist_lab.evaluation.values import CLEAN, Spread
from taskgist_lab.paper.published import INTUITION, NEEDED, understood
from tests.lab.evaluation.pools import study_pool
from tests.learning.learning_samples import STUDY

POOL = study_pool(30)
CODED = Coded.of(POOL)
RUNS = 20
FEW = (RULES["paper"], RULES["wide-asked"], RULES["sharp"])


def test_the_curve_is_what_the_learner_says_of_each_order() -> None:
    """The slow way: learn each order anew, by explanations, and ask each cell."""
    needs = demonstrations_needed(CODED, runs=4, seed=5)
    by_row = {sample.values: sample for sample in POOL.samples}
    for task in ("show", "give"):
        orders = in_random_order(CODED, task, runs=4, seed=5)
        held = np.zeros(orders.shape[:2], dtype=bool)
        for run, step in np.ndindex(4, 6):
            samples = (
                by_row[tuple(None if c < 0 else CODED.values[i][c] for i, c in enumerate(row))]
                for row in orders[run, : step + 1]
            )
            experience = Experience.of(task, [each.explanation(POOL.nodes, POOL.context) for each in samples])
            held[run, step] = all(understood(understand(experience)).values())
        assert needs.row(task).curve[:6] == tuple(held.mean(axis=0)[:6].tolist())


@pytest.mark.parametrize("task", STUDY)
def test_everything_is_understood_in_the_end(task: str) -> None:
    row = demonstrations_needed(CODED, runs=RUNS, seed=0).row(task)
    assert (row.ever, row.curve[-1], row.paper) == (1.0, 1.0, NEEDED[task])
    assert row.needed.median is not None
    assert 1 <= row.needed.median <= 10


def test_it_is_needed_from_where_on_it_lasts() -> None:
    held = np.array([[0, 1, 0, 1, 1], [1, 1, 1, 1, 1], [1, 1, 1, 1, 0], [0, 0, 0, 0, 1]], dtype=bool)
    assert lasting_from(held).tolist() == [4.0, 1.0, np.inf, 5.0]
    assert Waiting.of(lasting_from(held)) == Waiting(4, 1, None)
    assert Waiting.of([np.inf, np.inf, 2.0]) == Waiting(None, 2, None)


def test_what_single_demonstrations_show() -> None:
    """Of the paper's values: *show* is always seen directly; half of its demonstrations, or so, end in the hand."""
    needs = demonstrations_needed(CODED, runs=1, seed=0)
    assert (needs.row("show", "see").agreeing, needs.row("show", "see").alike) == (1.0, None)
    ends = [sample.values[POOL.nodes.index("placement.nature")] for sample in POOL.samples if sample.task == "show"]
    assert needs.row("show", "object").alike == round(max(map(ends.count, ends)) / len(ends), 4)
    assert needs.row("show", "object").agreeing is None


def test_all_three_cells_are_never_sooner_than_one() -> None:
    needs = demonstrations_needed(CODED, runs=RUNS, seed=0)
    for task, columns in INTUITION.items():
        whole = np.array(needs.row(task, ALL).curve)
        assert all((whole <= np.array(needs.row(task, column).curve)).all() for column in columns)


def test_perfect_demonstrations_are_recognised_and_those_of_others_told_apart() -> None:
    found = transfer(CODED, runs=RUNS, seed=0)
    for part in PARTS:
        table = found.table(10, part)
        assert (table.overall.recall.mean or 0.0) > 0.9
        for own, task in enumerate(table.tasks):
            assert table.true[own][own] == table.scores[task].recall.mean
    few, many = (found.table(after, CLAUSE).overall.recall for after in (1, SIZES[-1]))
    assert (many.mean or 0.0) > (few.high or 0.0)
    assert set(found.by_means["hide"]) == {"way 0", "way 1"}


def test_learned_from_all_of_the_study_recall_is_one() -> None:
    judges = HeldOut.of(CODED)
    for task in STUDY:
        known = learned(CODED.of_task(task, held_out=False)[None], CODED)
        held = held_in(known, judges, known.kept.shape[1], CLAUSE)
        assert judges.shares(held, 1)[0, judges.tasks.index(task)] == 1.0


def test_a_table_is_what_clauses_say_of_each_demonstration() -> None:
    """The slow way, for one order."""
    task = "make accessible"
    order = in_random_order(CODED, task, runs=1, seed=2)
    found = held_in(learned(order, CODED), HeldOut.of(CODED), 5, CLAUSE)
    by_row = {sample.values: sample for sample in POOL.samples}
    samples = [by_row[tuple(None if c < 0 else CODED.values[i][c] for i, c in enumerate(row))] for row in order[0, :5]]
    clause = clause_of(
        understand(Experience.of(task, [each.explanation(POOL.nodes, POOL.context) for each in samples]))
    )
    tests = [each for other in POOL.tasks for each in POOL.of(other, held_out=True)]
    expected = [int(clause.holds(each.explanation(POOL.nodes, POOL.context).nodes) is True) for each in tests]
    assert found[0].tolist() == expected


def test_scores_by_hand() -> None:
    scores = scores_of(np.array([[0.5, 0.25, 0.25], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]), 0)
    assert scores == pytest.approx(np.array([[0.5, 0.0, 1.0], [0.5, 0.0, 1.0], [0.5, 0.0, 1.0]]))


def test_unknown_is_neither_true_nor_false() -> None:
    judges = HeldOut.of(CODED)
    held = {task: np.full((2, len(judges.codes)), -1, dtype=np.int8) for task in judges.tasks}
    table = table_of(held, judges, after=1, part=CLAUSE)
    assert {share for row in table.unknown for share in row} == {1.0}
    assert {share for row in table.true for share in row} == {0.0}
    assert table.overall.f1 == Spread(0.0, 0.0, 0.0, 2)


def test_wrong_demonstrations_make_it_worse_on_average() -> None:
    found = robustness(CODED, runs=RUNS, seed=0, rules=FEW)
    names = ["clean", *(f"wrong-{percent}" for percent in WRONG_PERCENT)]
    for rule in FEW:
        f1 = [np.mean([after.f1.mean or 0.0 for after in found.outcome(name, rule.name).after]) for name in names]
        assert f1 == sorted(f1, reverse=True)
    asked = [found.outcome(name, "wide-asked").after[-1].questions for name in names]
    assert asked == sorted(asked)
    assert found.questions["paper"] == 0.0
    assert found.scores == dict(sorted(found.scores.items(), key=lambda item: -item[1]))


def test_conditions_without_effect_change_nothing() -> None:
    pool = study_pool(12, (CLEAN, "gap", "noise-3cm"))
    found = robustness(Coded.of(pool), runs=5, seed=0, rules=FEW[:1])
    clean, *others = (found.outcome(name, "paper") for name in (CLEAN, "gap", "noise-3cm"))
    assert {each.setting for each in found.outcomes} >= {CLEAN, "gap", "noise-3cm"}
    for other in others:
        assert (other.understood, other.after) == (clean.understood, clean.after)
    assert found.changed == {CLEAN: 0.0, "gap": 0.0, "noise-3cm": 0.0}
    spoiled = [replace(each, condition="gap", values=(None, *each.values[1:])) for each in pool.samples[::3]]
    part = replace(pool, samples=tuple(each for each in pool.samples if each.condition != "gap")).with_more(spoiled)
    assert robustness(Coded.of(part), runs=2, seed=0, rules=FEW[:1]).changed["gap"] == round(1 / len(part.nodes), 4)


def test_settings_cover_every_condition() -> None:
    assert [each.name for each in SETTINGS] == [*CONDITIONS, "wrong-5", "wrong-10", "wrong-20"]
    assert tuple(sorted(JUDGED_AFTER)) == JUDGED_AFTER


def test_results_are_plain_data_and_tables() -> None:
    results = (
        demonstrations_needed(CODED, runs=3, seed=0),
        transfer(CODED, runs=3, seed=0),
        robustness(CODED, runs=3, seed=0),
    )
    for result in results:
        document = json.loads(json.dumps(result.to_json(), allow_nan=False))
        assert document.keys() == result.to_json().keys()
        for sheet in sheets_of(result):
            assert {len(row) for row in sheet.rows} == {len(sheet.header)}


def test_a_spread_of_nothing() -> None:
    assert Spread.of([np.nan]) == Spread(None, None, None, 0)
    assert Spread.of([1, 2, 3]) == Spread(2.0, 1.2, 2.8, 3)


def test_what_was_not_learned_from_so_many_is_not_told() -> None:
    coded = Coded.of(study_pool(9))  # six to learn from
    assert transfer(coded, runs=2, seed=0).sizes == (1, 2, 3, 5)
    found = robustness(coded, runs=2, seed=0, rules=FEW)
    assert {tuple(after.demonstrations for after in each.after) for each in found.outcomes} == {(3, 5)}
    for result in (transfer(coded, runs=2, seed=0), found):
        assert all(len(row) == len(sheet.header) for sheet in sheets_of(result) for row in sheet.rows)


def test_too_few_demonstrations_are_told() -> None:
    with pytest.raises(InputError, match="too few demonstrations to learn from"):
        robustness(Coded.of(study_pool(3)), runs=2, seed=0)
    with pytest.raises(InputError, match="no demonstrations held out"):
        transfer(Coded.of(study_pool(2)), runs=2, seed=0)
