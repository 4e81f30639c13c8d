"""Bayesian clause learning: its laws, and what it says of the paper's study."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from itertools import combinations, product

import pytest

from taskgist.common.frozen import FrozenMap
from taskgist.errors import UnknownNameError
from taskgist.facts import STANDARD_TREE, UNKNOWN, Observation
from taskgist.learning import Experience
from taskgist.learning.clauses import (
    COVERAGE,
    FOLLOWING_BITS,
    SLIPS,
    ClausePosterior,
    Support,
    Told,
    clause_score,
    learn_clauses,
    ln_beta,
)
from taskgist.learning.evidence import Effects, Evidence, effects_of, evidence_of
from taskgist.learning.literals import SetLiteral, vocabularies
from tests.learning.learning_samples import STUDY, explained, study

RARE = {"see.effort.2": "No_Possible_Known_Effort", "placement.status.2": "On_Support"}
USUAL = {"see.effort.2": "No_Effort_Required", "placement.status.2": "On_Support"}


def mixed(rng: random.Random, count: int) -> list[dict[str, str]]:
    """Demonstrations with random values in a few nodes, some of them unknown."""
    nodes = [STANDARD_TREE.node(name) for name in ("see.effort.2", "reach.class", "placement.status.2", "hands.class")]
    return [{node.name: rng.choice(node.values) for node in nodes if rng.random() < 0.8} for _ in range(count)]


def learned(own: Sequence[Effects], *others: Sequence[Effects]) -> ClausePosterior:
    return learn_clauses(Evidence.of({"task": own, **{f"other {i}": each for i, each in enumerate(others)}}), "task")


def with_score(posterior: ClausePosterior, text: str) -> float:
    return next(clause.score for clause in posterior.clauses if str(clause) == text)


@pytest.mark.parametrize("seed", range(5))
def test_order_of_demonstrations_tasks_and_merging_does_not_matter(seed: int) -> None:
    rng = random.Random(seed)
    experiences = [study(task) for task in STUDY]
    before = learn_clauses(evidence_of(experiences), "hide")
    shuffled = []
    for experience in rng.sample(experiences, len(experiences)):
        demonstrations = rng.sample(list(experience.explanations.values()), len(experience.explanations))
        cut = rng.randrange(len(demonstrations) + 1)
        halves = [
            Experience.of(experience.task, part) for part in (demonstrations[:cut], demonstrations[max(cut - 1, 0) :])
        ]
        shuffled.append(halves[1].merge(halves[0]))
    assert learn_clauses(evidence_of(shuffled), "hide") == before


@pytest.mark.parametrize("seed", range(5))
def test_counts_are_those_that_one_counts_one_by_one(seed: int) -> None:
    rng = random.Random(seed)
    own, others = mixed(rng, 8), [mixed(rng, rng.randrange(3, 9)) for _ in range(3)]
    for clause in learned(own, *others).clauses:

        def counted(rows: list[dict[str, str]], literals: tuple[SetLiteral, ...] = clause.literals) -> tuple[int, int]:
            nodes = [{name: Observation(value) for name, value in row.items()} for row in rows]
            failed = sum(any(literal.holds(each) is False for literal in literals) for each in nodes)
            return sum(all(literal.holds(each) is True for literal in literals) for each in nodes), failed

        hits, failed = counted(own)
        shares = [(h + 0.5) / (h + f + 1) for h, f in map(counted, others)]
        assert (clause.support.k, clause.support.n) == (hits, hits + failed)
        assert clause.support.chance == pytest.approx(sum(shares) / len(shares))
        bits = sum(FOLLOWING_BITS + literal.bits for literal in clause.literals)
        assert clause.score == pytest.approx(clause_score(clause.support, bits))
        assert clause.support.k >= COVERAGE * clause.support.n


@pytest.mark.parametrize("seed", range(3))
def test_no_conjunction_of_up_to_three_literals_is_better_than_what_the_beam_finds(seed: int) -> None:
    rng = random.Random(seed)
    own = [{**row, "hands.class": "Manip_Gained"} for row in mixed(rng, 6)]
    others = [mixed(rng, 6) for _ in range(2)]
    evidence = Evidence.of({"task": own, "a": others[0], "b": others[1]})
    everything = [
        literal
        for vocabulary in vocabularies(STANDARD_TREE)
        for literal in vocabulary.literals(evidence.seen(vocabulary.node.name, "task"))
    ]
    best = -math.inf
    for size in (1, 2, 3):
        for literals in combinations(everything, size):
            if len({literal.node for literal in literals}) < size:
                continue
            truths = [evidence.truth(literal) for literal in literals]
            true, false = truths[0]
            for holds, fails in truths[1:]:
                true, false = true & holds, false | fails
            counts = {
                name: (kind.of(true).bit_count(), kind.of(false).bit_count()) for name, kind in evidence.kinds.items()
            }
            hits, failed = counts.pop("task")
            if hits and hits >= COVERAGE * (hits + failed):
                chance = sum((h + 0.5) / (h + f + 1) for h, f in counts.values()) / len(counts)
                bits = sum(FOLLOWING_BITS + literal.bits for literal in literals)
                if chance < hits / (hits + failed):
                    best = max(best, clause_score(Support(hits, hits + failed, chance), bits))
    assert learned(own, *others).best.score >= best - 1e-9


def test_a_demonstration_that_a_clause_contradicts_lowers_it() -> None:
    for k, misses, chance in product((1, 5, 20), (0, 2), (0.01, 0.3, 0.7)):
        before, after = (Support(k, k + failed, chance) for failed in (misses, misses + 1))
        assert clause_score(after, 4.0) < clause_score(before, 4.0)


def test_a_contradicting_demonstration_lowers_the_literal_in_what_is_learned() -> None:
    text = "(Effort_to_See = No_Possible_Known_Effort)"
    agreed = learned([RARE] * 4, [USUAL] * 6)
    contested = learned([RARE] * 4 + [USUAL], [USUAL] * 6)
    assert with_score(agreed, text) > with_score(contested, text)


def test_size_principle() -> None:
    """What is rarer by chance gains more by each demonstration, almost −ln θ."""
    rare, frequent = 0.02, 0.5
    gains = {
        chance: clause_score(Support(9, 9, chance), 0.0) - clause_score(Support(8, 8, chance), 0.0)
        for chance in (rare, frequent)
    }
    assert gains[rare] > gains[frequent] > 0
    assert gains[rare] == pytest.approx(-math.log(rare) + math.log(98 / 108))


def test_what_usually_is_so_says_little() -> None:
    best = learned([RARE] * 5, [USUAL] * 10).best
    assert {literal.node for literal in best.literals} == {"see.effort.2"}


def test_unknown_counts_neither_way() -> None:
    rows = [[RARE] * 3, [USUAL] * 6]
    blind: list[Effects] = [{"posture.value.2": "Sitting"}]
    before, after = learned(*rows), learned(rows[0] + blind, rows[1] + blind)
    text = "(Effort_to_See = No_Possible_Known_Effort)"
    assert with_score(before, text) == with_score(after, text)
    assert after.best.support.n == 3


def test_without_background_nothing_is_learned() -> None:
    posterior = learned([RARE] * 5)
    assert [str(clause) for clause in posterior.clauses] == ["nothing in common"]
    assert posterior.best.holds({}) is True


def test_one_wrong_in_ten_changes_no_clear_meaning() -> None:
    right = [effects_of(explained("give", i, STUDY["give"][i % 3])) for i in range(9)]
    wrong = effects_of(explained("hide", 0, STUDY["hide"][0]))
    others = [
        [effects_of(explained(task, i, told)) for i, told in enumerate(STUDY[task])] for task in STUDY if task != "give"
    ]
    assert "Manip" in str(learned(right, *others).best)
    contested = learned([*right, wrong], *others)
    assert contested.best.literals == learned(right, *others).best.literals
    assert (contested.best.support.k, contested.best.support.n) == (9, 10)


def test_probability_is_a_vote_of_the_clauses_that_know() -> None:
    posterior = learned([RARE] * 5, [USUAL] * 10)
    rare, usual = ({name: Observation(value) for name, value in each.items()} for each in (RARE, USUAL))
    assert posterior.probability(rare) > 0.9
    assert posterior.probability(usual) < 0.1
    assert posterior.probability({"see.effort.2": Observation(UNKNOWN)}) == 0.5
    assert math.fsum(clause.weight for clause in posterior.clauses) == pytest.approx(1.0)


def test_literals_alone_and_what_was_compared() -> None:
    posterior = learned([RARE] * 5, [USUAL] * 10, [USUAL] * 3)
    assert posterior.compared == {"other 0": 10, "other 1": 3}
    assert tuple(each.literal for each in posterior.alone) == posterior.best.literals
    assert [each.support.k for each in posterior.alone] == [5] * len(posterior.best.literals)


def test_what_always_was_so_but_usually_is_stands_apart() -> None:
    posterior = learned([RARE] * 5, [USUAL] * 10)
    assert [str(each.literal) for each in posterior.usual] == ["(Object_Final_Status = On_Support)"]
    assert posterior.usual[0].support.chance == pytest.approx(10.5 / 11)
    unlike = learned([RARE] * 5 + [{**RARE, "placement.status.2": "In_Hand"}], [USUAL] * 10)
    assert not unlike.usual


def test_what_else_was_always_so_is_told_once_and_never_of_what_is_said_or_usual() -> None:
    """Of a branch the deepest: that it becomes harder to see is said by the effort, and not by the nature above."""
    constant = {"see.nature": "Not_Supportive", "motion.status.2": "Static", "posture.class": "Maintained"}
    others = [{**USUAL, **constant, "see.nature": "Supportive"}, {**USUAL, "motion.status.2": "Moving"}] * 2
    others += [{**USUAL, "posture.class": "Changed"}] * 2
    posterior = learned([{**RARE, **constant}] * 5, others)
    assert [each.node for each in posterior.best.literals] == ["see.effort.2"]
    assert [each.literal.node for each in posterior.usual] == ["placement.status.2"]
    assert [each.literal.node for each in posterior.always] == ["posture.class", "motion.status.2"]
    assert all(each.support.k == each.support.n == 5 for each in posterior.always)
    varied = learned([{**RARE, **constant}] * 5 + [{**RARE, "motion.status.2": "Moving"}], others)
    assert [each.literal.node for each in varied.always] == ["posture.class"]


def test_what_was_told_to_be_irrelevant_is_in_no_clause() -> None:
    evidence = Evidence.of({"task": [RARE] * 5, "other": [USUAL] * 10})
    posterior = learn_clauses(evidence, "task", told=Told(irrelevant=frozenset({"see.effort.2"})))
    assert not [one for one in posterior.clauses for each in one.literals if each.node == "see.effort.2"]


@pytest.mark.parametrize("value", ["On_Support", "In_Hand"])
def test_what_was_told_to_be_relevant_is_in_every_clause_seen_or_not(value: str) -> None:
    evidence = Evidence.of({"task": [RARE] * 5, "other": [USUAL] * 10})
    posterior = learn_clauses(evidence, "task", told=Told(relevant=FrozenMap({"placement.status.2": value})))
    for one in posterior.clauses:
        assert [each.values for each in one.literals if each.node == "placement.status.2"] == [(value,)]


def test_an_unknown_task_is_named() -> None:
    with pytest.raises(UnknownNameError, match="hied"):
        learn_clauses(Evidence.of({"hide": [RARE]}), "hied")


def test_score_is_the_formula() -> None:
    a, b = SLIPS
    for k, n in ((1, 1), (9, 10), (30, 50)):
        lnB = math.lgamma(k + b) + math.lgamma(n - k + a) - math.lgamma(n + a + b)
        ln_prior = math.lgamma(a) + math.lgamma(b) - math.lgamma(a + b)
        expected = lnB - ln_prior - k * math.log(0.2) - (n - k) * math.log(0.8) - math.log(2) * 7
        assert clause_score(Support(k, n, 0.2), 7.0) == pytest.approx(expected)
    assert ln_beta(2, 3) == pytest.approx(math.log(1 / 12))


@pytest.mark.parametrize(("slips", "chance", "dissent"), [((2000, 18000), 0.60, 0.30), ((1000, 19000), 0.86, 0.10)])
def test_the_papers_band_is_this_score_with_guessed_chance_and_slips(
    slips: tuple[int, int], chance: float, dissent: float
) -> None:
    """For one node: the verdict turns where dissenting demonstrations are that share of agreeing ones (Eq. 34, 35)."""
    agreeing = 200
    turning = next(
        dissenting
        for dissenting in range(agreeing)
        if clause_score(Support(agreeing, agreeing + dissenting, chance), 0.0, slips) < 0
    )
    assert turning / agreeing == pytest.approx(dissent, abs=0.02)
