"""Literals of learned clauses: which sets of values a node has, and what they say."""

from __future__ import annotations

import pytest

from taskgist.facts import REACH_EFFORTS, STANDARD_TREE, UNKNOWN, Observation
from taskgist.facts.values import score_bin, score_bins
from taskgist.learning.literals import Vocabulary, vocabularies
from taskgist.settings import DEFAULT

BY_NODE = {each.node.name: each for each in vocabularies(STANDARD_TREE)}


def told(vocabulary: Vocabulary, *seen: str) -> set[str]:
    return {literal.told for literal in vocabulary.literals(set(seen))}


def test_only_effects_with_declared_or_binned_values() -> None:
    assert "see.effort.2" in BY_NODE
    assert "visibility.score.2" in BY_NODE
    assert not [name for name in BY_NODE if name.endswith(".1") or "state" in name or "action" in name]


def test_values_and_intervals_of_a_ladder_end_at_what_was_seen() -> None:
    ladder = BY_NODE["reach.effort.2"]
    none, arm, torso, *_, impossible = REACH_EFFORTS
    assert told(ladder, arm) == {f"= {arm}", f"≤ {arm}", f"≥ {arm}"}
    assert told(ladder, none) == {f"= {none}"}
    assert told(ladder, impossible) == {f"= {impossible}"}
    assert f"= {arm} to {torso}" in told(ladder, torso, arm)


def test_all_but_one_and_two_of_three() -> None:
    assert told(BY_NODE["placement.status.2"], "In_Hand") == {
        "= In_Hand",
        *(f"≠ {value}" for value in STANDARD_TREE.node("placement.status.2").values if value != "In_Hand"),
    }
    assert "≠ Becomes_Easier" in told(BY_NODE["see.class"], "Remains_Same")
    assert told(BY_NODE["see.nature"], "Supportive") == {"= Supportive"}
    assert not [text for text in told(BY_NODE["placement.class"], "Maintaining(In_Hand)") if "≠" in text]


@pytest.mark.parametrize("name", sorted(BY_NODE))
def test_every_literal_holds_for_some_value_that_was_seen_and_each_is_another(name: str) -> None:
    vocabulary = BY_NODE[name]
    seen = set(vocabulary.values[:3])
    literals = list(vocabulary.literals(seen))
    assert len({(literal.values, literal.but) for literal in literals}) == len(literals)
    for literal in literals:
        assert any(literal.holds({name: Observation(value)}) for value in seen)
        assert literal.bits > 0


def test_holds_is_unknown_where_its_node_is() -> None:
    (literal, *_) = BY_NODE["see.class"].literals({"Remains_Same"})
    assert literal.holds({}) is UNKNOWN
    assert literal.holds({"see.class": Observation(UNKNOWN)}) is UNKNOWN
    assert str(literal) == "(Relative_Effort_Class_to_See = Remains_Same)"


def test_bins_of_scores_are_a_ladder_that_holds_every_score() -> None:
    bins = score_bins(DEFAULT.vision)
    assert len(set(bins)) == len(bins)
    scores = [0.0, 1e-7, 1e-4, 0.0031, 0.02, 0.5, 1.0]
    places = [bins.index(score_bin(score, DEFAULT.vision)) for score in scores]
    assert places == sorted(places)
    assert (places[0], places[-1]) == (0, len(bins) - 1)
