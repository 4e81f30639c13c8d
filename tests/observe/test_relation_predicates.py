"""Sight and distance as subtrees: the standard tree stays as it is, and an extended one learns from them."""

from __future__ import annotations

import pytest

from taskgist.facts import STANDARD_TREE
from taskgist.facts.predicates import with_predicates
from taskgist.learning import explain
from taskgist.observe import DISTANCE, SIGHT
from taskgist.observe.relation_predicates import compare_distances
from taskgist.pipeline import episode_of
from taskgist.settings import DEFAULT
from tests.shipped import explanation, observer, recording


def test_the_standard_tree_knows_neither() -> None:
    assert not {"sight", "distance"} & set(STANDARD_TREE.attributes)
    extended = with_predicates(STANDARD_TREE, (SIGHT, DISTANCE))
    assert {"sight", "distance"} < set(extended.attributes)
    assert [each.name for each in extended.nodes][: len(STANDARD_TREE.nodes)] == [n.name for n in STANDARD_TREE.nodes]


def test_what_is_hidden_loses_its_free_sight() -> None:
    chosen = (SIGHT, DISTANCE)
    tree = with_predicates(STANDARD_TREE, chosen)
    episode = episode_of(recording("hide_a"), predicates=chosen, observer=observer("hide_a"))
    found = explain(episode, tree, DEFAULT)
    assert found.nodes["sight.class"].value == "Gaining(blocked) & Losing(free)"
    assert found.nodes["distance.class"].value == "same"
    standard = explanation("hide_a")
    assert {name: found.nodes[name].value for name in standard.nodes} == {
        name: node.value for name, node in standard.nodes.items()
    }


@pytest.mark.parametrize(
    ("before", "after", "change"),
    [("near", "near", "same"), ("far", "near", "nearer"), ("near", "far", "farther"), ("far", "far", "same")],
)
def test_how_a_class_of_distance_changes(before: str, after: str, change: str) -> None:
    assert compare_distances(before, after, DEFAULT) == change


def test_their_versions_name_their_thresholds() -> None:
    assert SIGHT.subtree.version != DISTANCE.subtree.version
    assert f"{DEFAULT.relations.near_m:g} m" in DISTANCE.subtree.version
    assert f"{DEFAULT.relations.free_share:g}" in SIGHT.subtree.version
