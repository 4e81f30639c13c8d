"""The hypothesis tree: the shape of Fig. 11, ablations, extension, versions, instantiation."""

from __future__ import annotations

import dataclasses
import pickle
from collections.abc import Callable

import pytest

from taskgist.errors import FactsError, UnknownNameError
from taskgist.facts import STANDARD_TREE, UNKNOWN, HypothesisTree, Observation, predicate_subtree
from taskgist.settings import DEFAULT

ABILITY_PARTS = [
    "nature",
    "class",
    "effort.1",
    "state.1",
    "action.1",
    "effort.2",
    "state.2",
    "action.2",
]  # nature, class, then each instant
PLAIN = {
    "posture": ["class", "value.1", "value.2"],
    "motion": ["class", "status.1", "status.2"],
    "visibility": ["nature", "class", "score.1", "score.2"],
    "hands": ["nature", "class", "status.1", "status.2"],
    "placement": ["nature", "class", "status.1", "status.2"],
}
ORDER = ["reach", "posture", "grasp", "motion", "visibility", "see", "hands", "placement"]


def test_the_standard_tree_is_that_of_figure_11() -> None:
    expected = [f"{subtree}.{part}" for subtree in ORDER for part in PLAIN.get(subtree, ABILITY_PARTS)]
    assert [node.name for node in STANDARD_TREE.nodes] == expected


def test_parents_come_first_and_effort_has_state_and_action_below() -> None:
    seen: set[str] = set()
    for node in STANDARD_TREE.nodes:
        assert node.parent is None or node.parent in seen
        seen.add(node.name)
    assert [node.name for node in STANDARD_TREE.children("see.effort.2")] == ["see.state.2", "see.action.2"]
    assert [node.name for node in STANDARD_TREE.ancestors("see.action.2")] == [
        "see.effort.2",
        "see.class",
        "see.nature",
    ]


def test_titles_are_the_papers_and_differ_from_each_other() -> None:
    titles = [node.title for node in STANDARD_TREE.nodes]
    assert len(set(titles)) == len(titles)
    # Eq. 37-39
    assert {
        "Relative_Posture",
        "Object_Initial_Motion_Status",
        "Object_Final_Motion_Status",
        "Object_Relative_Visibility_Score",
        "Object_Final_Visibility_Score",
        "Action_to_See",
        "Initial_Hand_Status",
        "Final_Hand_Status",
        "Relative_Effort_Class_to_See",
        "Nature_Effort_Class_to_See",
        "Object_Initial_Status",
        "Object_Final_Status",
    } <= set(titles)


def test_without_the_action_level_efforts_states_and_actions_go_and_the_rest_stays() -> None:
    names = {node.name for node in STANDARD_TREE.without(levels=["action"]).nodes}
    gone = {node.name for node in STANDARD_TREE.nodes} - names
    assert {name.split(".")[1] for name in gone} == {"effort", "state", "action"}
    assert len(gone) == 3 * 6


def test_without_the_nature_level_classes_are_roots() -> None:
    tree = STANDARD_TREE.without(levels=["nature"])
    assert not [node for node in tree.nodes if node.level == 1]
    assert tree.node("see.class").parent is None


def test_leaving_out_changes_no_value_of_what_stays() -> None:
    start, end = {"see.effort": Observation("Head_Effort")}, {"see.effort": Observation("No_Effort_Required")}
    whole = STANDARD_TREE.instantiate(start, end)
    for tree in (STANDARD_TREE.without(levels=["action", "nature"]), STANDARD_TREE.without(subtrees=["posture"])):
        part = tree.instantiate(start, end)
        assert part == {name: whole[name] for name in part}
        assert list(part) == [node.name for node in tree.nodes]


@pytest.mark.parametrize(
    ("wrong", "call"),
    [
        ("no subtree 'sea'; did you mean 'see'?", lambda tree: tree.without(subtrees=["sea"])),
        ("no level 'natur'; did you mean 'nature'?", lambda tree: tree.without(levels=["natur"])),
        ("no node 'see.clas'; did you mean 'see.class'?", lambda tree: tree.children("see.clas")),
        (
            "no attribute 'postur'; did you mean 'posture'?",
            lambda tree: tree.instantiate({"postur": Observation("Sitting")}, {}),
        ),
    ],
)
def test_unknown_names_are_refused(wrong: str, call: Callable[[HypothesisTree], object]) -> None:
    with pytest.raises(UnknownNameError) as caught:
        call(STANDARD_TREE)
    assert wrong in str(caught.value)


def test_versions_tell_trees_apart() -> None:
    extended = STANDARD_TREE.extended(predicate_subtree("on_box"))
    raised = STANDARD_TREE.extended(predicate_subtree("on_box", version="2"))
    trees = [
        STANDARD_TREE,
        extended,
        raised,
        STANDARD_TREE.without(subtrees=["see"]),
        STANDARD_TREE.without(levels=["action"]),
        STANDARD_TREE.without(levels=["nature"]),
        dataclasses.replace(STANDARD_TREE, edition="1"),
    ]
    assert len({tree.version for tree in trees}) == len(trees)
    assert HypothesisTree(STANDARD_TREE.subtrees, edition="2").version == STANDARD_TREE.version
    assert pickle.loads(pickle.dumps(STANDARD_TREE)) == STANDARD_TREE


def test_names_must_differ() -> None:
    with pytest.raises(FactsError, match="give each subtree its own name"):
        STANDARD_TREE.extended(STANDARD_TREE.subtrees[0])
    with pytest.raises(FactsError, match="posture: two attributes of one name"):
        STANDARD_TREE.extended(predicate_subtree("posture"))


def test_evidence_and_raw_values_reach_the_nodes() -> None:
    start = {"visibility.score": Observation(0.01, {"occluders": ["box"]})}
    nodes = STANDARD_TREE.instantiate(start, {"visibility.score": Observation(0.0)}, DEFAULT)
    assert nodes["visibility.score.1"].value == "0.64-1.3 %"
    assert nodes["visibility.score.1"].evidence == {"occluders": ("box",), "raw": 0.01}
    assert nodes["visibility.class"].evidence == {"initial": 0.01, "final": 0.0}
    assert nodes["visibility.nature"].evidence == {"class": "Decreased"}


def test_nothing_observed_gives_a_tree_of_unknowns_that_keeps_its_reasons() -> None:
    nodes = STANDARD_TREE.instantiate({"posture": Observation(UNKNOWN, {"why": "legs untracked"})}, {})
    assert {node.value for node in nodes.values()} == {UNKNOWN}
    assert nodes["posture.value.1"].evidence == {"why": "legs untracked"}
