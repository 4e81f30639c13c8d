"""The learner in arrays does what the learner does."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from taskgist.errors import InputError
from taskgist.facts import STANDARD_TREE, UNKNOWN
from taskgist.learning import (
    Answer,
    Band,
    Context,
    Experience,
    Explanation,
    Rule,
    Understanding,
    Verdict,
    clause_of,
    questions_of,
    understand,
    weigh,
)
from taskgist.settings import Learning
from taskgist_lab.evaluation.experiments import CLAUSE, EFFECTS, mask_of
from taskgist_lab.evaluation.learner import (
    INTERSECTION,
    NARROW,
    PAPER,
    RULES,
    VERDICTS,
    Coded,
    Codes,
    Judging,
    Learned,
    Oracle,
    Tally,
    in_random_order,
    learned,
    published_oracle,
    truths,
)
from taskgist_lab.evaluation.pool import Pool, turn
from taskgist_lab.paper.published import CLAUSES, INTUITION
from tests.lab.evaluation.pools import NODES, sample, study_pool
from tests.learning.learning_samples import STUDY, explanations

PLAIN = {"paper": Learning(), "wide": Learning(band="wide"), "m8": Learning(m=8), "m1": Learning(m=1)}
BARE = STANDARD_TREE.node("see.state.1")
NOON = "2024-05-01T12:00:00+00:00"


def pool_of(given: Iterable[Explanation]) -> Pool:
    samples = [sample(each, number) for number, each in enumerate(given)]
    return Pool(Context.of(), "study", 1000, NODES).with_more(samples)


def experience(pool: Pool, count: int) -> Experience:
    task = pool.samples[0].task
    return Experience.of(task, [each.explanation(NODES, pool.context) for each in pool.samples[:count]])


def agree(found: Learned, step: int, coded: Coded, slow: Understanding) -> None:
    """Kept nodes, values and clause after one step of the first run."""
    names = coded.pool.nodes
    kept = {name for name, each in zip(names, found.kept[0, step], strict=True) if each}
    assert kept == {each.node.name for each in slow.kept}
    values = {each.node.name: each.value for each in slow.kept}
    for name in kept:
        column = coded.index(name)
        assert coded.values[column][found.values[0, step, column]] == values[name]
    clause = clause_of(slow)
    for mask, literals in ((found.effects(), clause.effects), (found.preconditions(), clause.preconditions)):
        assert {name for name, each in zip(names, mask[0, step], strict=True) if each} == {
            literal.node for literal in literals
        }


@settings(max_examples=12, deadline=None)
@given(explanations(), st.sampled_from(sorted(PLAIN)))
def test_it_understands_as_the_learner_does(given: list[Explanation], rule: str) -> None:
    if not given:
        return
    pool = pool_of(given)
    coded = Coded.of(pool)
    found = learned(coded.codes(pool.samples)[None], coded, RULES[rule])
    for count in range(1, len(given) + 1):
        slow = understand(experience(pool, count), settings=PLAIN[rule])
        agree(found, count - 1, coded, slow)
        for cell in (cell for row in INTUITION.values() for cell in row.values()):
            wanted = all(value in coded.values[coded.index(node)] for node, value in cell.kept)
            assert wanted
            assert found.holds(cell, coded)[0, count - 1] == cell.holds(slow)


@settings(max_examples=12, deadline=None)
@given(explanations(most=4), explanations(most=3))
def test_clauses_hold_where_the_learners_hold(given: list[Explanation], tests: list[Explanation]) -> None:
    if not given:
        return
    pool = pool_of([*given, *tests])
    coded = Coded.of(pool)
    codes = coded.codes(pool.samples)
    found = learned(codes[None, : len(given)], coded)
    clause = clause_of(understand(experience(pool, len(given))))
    held = truths(mask_of(found, CLAUSE)[:, -1], found.values[:, -1], codes)[0]
    expected = [clause.holds(each.nodes) for each in [*given, *tests]]
    assert held.tolist() == [-1 if each is UNKNOWN else int(each is True) for each in expected]


@settings(max_examples=12, deadline=None)
@given(explanations(most=6), explanations(most=4))
def test_questions_are_answered_as_people_would(given: list[Explanation], known: list[Explanation]) -> None:
    """After each demonstration all questions are answered, until there are no more; answers stay."""
    if not given or not known:
        return
    both = pool_of([*given, *known])
    coded = Coded.of(both)
    codes = coded.codes(both.samples)
    found = learned(codes[None, : len(given)], coded, RULES["wide-asked"], who_learned(codes[len(given) :], coded))
    told = understand(
        Experience.of("show", [each.explanation(NODES, both.context) for each in both.samples[len(given) :]])
    )
    answers: list[Answer] = []
    for count in range(1, len(given) + 1):
        while questions := questions_of(slow := asked(both, count, answers)):
            answers += [answered(each.node.name, told) for each in questions]
        agree(found, count - 1, coded, slow)
        assert found.asked[0, count - 1] == len(answers)


def who_learned(samples: Codes, coded: Coded) -> Oracle:
    known = learned(samples[None], coded)
    return Oracle(known.kept[0, -1], known.values[0, -1])


@pytest.mark.parametrize("task", STUDY)
def test_the_oracle_knows_the_printed_clause(task: str) -> None:
    """Asked about everything, it leaves what the paper printed; what stands above is kept without a value."""
    coded = Coded.of(study_pool(3))
    oracle = published_oracle(task, coded)
    printed = {each.node: each.value for each in CLAUSES[task].predicates}
    for column, node in enumerate(coded.nodes):
        below = [name for name in printed if name == node.name or node.name in above(name)]
        assert oracle.kept[column] == bool(below)
        told = None if oracle.values[column] < 0 else coded.values[column][oracle.values[column]]
        assert told == printed.get(node.name)


def above(name: str) -> list[str]:
    parent = STANDARD_TREE.node(name).parent
    return [] if parent is None else [parent, *above(parent)]


def asked(pool: Pool, count: int, answers: list[Answer]) -> Understanding:
    return understand(experience(pool, count), settings=Learning(band="wide"), answers=answers)


def answered(node: str, told: Understanding) -> Answer:
    judgement = told.judgements[node]
    if judgement.kept:
        return Answer("show", node, Verdict.RELEVANT, "somebody", NOON, judgement.value)
    return Answer("show", node, Verdict.IRRELEVANT, "somebody", NOON)


counts = st.lists(st.integers(1, 30), min_size=1, max_size=6)


def verdict(judging: Judging, n: int, N: int, k: int) -> Verdict:
    """Of a node without declared values."""
    best, *numbers = (np.full((1, 1, 1), count, dtype=np.int32) for count in (0, n, N, k))
    return VERDICTS[int(judging.verdicts(Tally(best, *numbers), (BARE,))[0, 0, 0])]


def of(judging: Judging, numbers: list[int]) -> Verdict:
    return verdict(judging, max(numbers), sum(numbers), len(numbers))


@given(counts, st.integers(1, 8), st.sampled_from([(1, 2), (1, 4), (1, 6)]), st.sampled_from(["narrow", "wide"]))
def test_three_numbers_decide_a_verdict(numbers: list[int], m: int, prior: tuple[int, int], band: str) -> None:
    rule = Rule(m, Fraction(*prior), Band.named(band))
    estimate = weigh({str(i): n for i, n in enumerate(numbers)}, rule)
    assert of(Judging("", "", m, rule.prior, rule.band), numbers) is estimate.verdict


@given(counts, st.integers(1, 8), st.integers(1, 8))
def test_of_m_and_prior_only_their_product_counts(numbers: list[int], m: int, parts: int) -> None:
    """By the learner itself: the same a = m × prior from m and 1/2, and from parts × m and 1 / (2 × parts)."""
    rules = (Rule(m, Fraction(1, 2), NARROW), Rule(m * parts, Fraction(1, 2 * parts), NARROW))
    one, other = (weigh({str(i): n for i, n in enumerate(numbers)}, rule).verdict for rule in rules)
    assert one is other


@given(st.integers(1, 60), st.sampled_from(sorted(RULES)))
def test_no_rule_doubts_what_all_agree_on(N: int, rule: str) -> None:
    assert verdict(RULES[rule], N, N, 1) is Verdict.RELEVANT
    assert verdict(RULES[rule], 0, 0, 0) is Verdict.UNOBSERVED


def test_intersection_forgives_nothing_and_the_paper_little() -> None:
    one_of = {N: (verdict(INTERSECTION, N - 1, N, 2), verdict(PAPER, N - 1, N, 2)) for N in (6, 20, 21)}
    assert {intersection for intersection, _ in one_of.values()} == {Verdict.IRRELEVANT}
    assert [paper for _, paper in one_of.values()] == [Verdict.IRRELEVANT, Verdict.CONFUSING, Verdict.RELEVANT]


def test_the_prior_may_depend_on_how_many_values_there_are() -> None:
    judging = RULES["prior-1/values"]
    assert judging.share(STANDARD_TREE.node("reach.class")) == Fraction(2, 3)
    assert judging.share(BARE) == 1


@pytest.mark.parametrize("part", [CLAUSE, EFFECTS])
@pytest.mark.parametrize("task", STUDY)
def test_a_clause_holds_in_what_it_was_learned_from(task: str, part: str) -> None:
    coded = Coded.of(study_pool(12))
    orders = in_random_order(coded, task, runs=10, seed=3)
    found = learned(orders, coded, INTERSECTION)
    for run in range(10):
        for step in range(orders.shape[1]):
            mask, values = mask_of(found, part)[run, [step]], found.values[run, [step]]
            assert (truths(mask, values, orders[run, : step + 1]) == 1).all()


def test_a_draw_without_demonstrations_of_the_task_is_refused() -> None:
    coded = Coded.of(study_pool(3))
    with pytest.raises(InputError, match="no demonstrations to learn from"):
        in_random_order(coded, "balance", runs=1, seed=0)


def test_orders_are_the_same_for_the_same_seed_and_repeat_no_demonstration() -> None:
    coded = Coded.of(study_pool(12))
    states = [coded.index(f"{ability}.state.{instant}") for ability in ("reach", "see") for instant in (1, 2)]
    once, again, other = (in_random_order(coded, "hide", runs=20, seed=seed)[:, :, states] for seed in (1, 1, 2))
    assert (once == again).all()
    assert not (once == other).all()
    for run in once:
        assert len(np.unique(run, axis=0)) == len(run)


def test_distinct_demonstrations_come_by_turns() -> None:
    """The paper has three demonstrations of *hide*: any three that follow each other in a run's rounds are they."""
    pool = study_pool(18)
    kinds = {each.values: turn(each.number, 3) for each in pool.of("hide", held_out=False)}
    coded = Coded.of(pool)
    for run in in_random_order(coded, "hide", runs=20, seed=1):
        rows = (tuple(None if c < 0 else coded.values[i][c] for i, c in enumerate(row)) for row in run)
        told = [kinds[row] for row in rows]
        assert all(set(told[i : i + 3]) == {0, 1, 2} for i in range(0, 12, 3))
    assert [turn(number, 3) for number in range(9)] == [0, 1, 2, 1, 2, 0, 2, 0, 1]
    for count in (3, 4, 5):
        held = [turn(number, count) for number in range(2, 60, 3)]
        assert max(map(held.count, range(count))) - min(map(held.count, range(count))) <= 1


def test_wrong_demonstrations_are_of_other_tasks() -> None:
    coded = Coded.of(study_pool(12))
    own = {tuple(row) for row in coded.of_task("hide", held_out=False).tolist()}
    clean = in_random_order(coded, "hide", runs=50, seed=1).reshape(-1, len(NODES))
    assert all(tuple(row) in own for row in clean.tolist())
    for share in (0.2, 1.0):
        rows = in_random_order(coded, "hide", runs=50, seed=1, wrong_share=share).reshape(-1, len(NODES))
        wrong = np.mean([tuple(row) not in own for row in rows.tolist()])
        assert wrong == pytest.approx(share, abs=0.06 if share < 1 else 0)
