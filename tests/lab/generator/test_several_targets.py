"""Hide from two, show to two, give two things: played, explained pair by pair, learned as said of each."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from taskgist.facts import UNKNOWN
from taskgist.language import meaning
from taskgist.learning import Explanation, Knowledge, clause_of, explanation_from_json, questions_of
from taskgist.pipeline import explain_recording
from taskgist.pipeline.explain import episodes_of
from taskgist.recording import Label, Recording
from taskgist.world import Stage
from taskgist_lab.generator import SEVERAL, WAYS, note, simulate
from taskgist_lab.generator.outcomes import share_in_view
from taskgist_lab.generator.simulation import ways_of

SEED = 21
NUMBERS = {"behind-from-both": 1, "inside-from-both": 1, "hold-up-to-both": 1, "one-after-the-other": 3}
"""Demonstrations for which few rooms are tried; 0 where nothing is said."""
MEANS = [(task, way.name) for task, ways in SEVERAL.items() for way in ways]
CLASSES = {"hide": ("see.class", "Becomes_Difficult"), "show": ("see.nature", "Supportive")}
CLASSES["give"] = ("hands.class", "Manip_Gained")


@cache
def demonstration(task: str, means: str, number: int | None = None) -> Recording:
    return simulate(task, seed=SEED, number=NUMBERS.get(means, 0) if number is None else number, means=means)


@cache
def explained(task: str, means: str, number: int | None = None) -> Explanation:
    return explain_recording(demonstration(task, means, number), predicates=())


def label_of(recording: Recording) -> Label:
    assert recording.label is not None
    return recording.label


@pytest.mark.parametrize(("task", "means"), MEANS)
def test_it_comes_out_for_each(task: str, means: str) -> None:
    whole = explained(task, means)
    node, value = CLASSES[task]
    assert len(whole.parts) == 2
    assert [part.nodes[node].value for part in whole.parts] == [value, value]
    assert whole.nodes[node].value == value


@pytest.mark.parametrize("means", [way.name for way in SEVERAL["hide"]])
def test_what_is_hidden_was_seen_by_both_and_is_seen_by_neither(means: str) -> None:
    recording = demonstration("hide", means)
    label, stage = label_of(recording), Stage(recording.scene)
    for agent in label.target_agents:
        stage.show(recording.at(label.start_s))
        assert share_in_view(stage, agent, label.target_object) > 0.0
        stage.show(recording.at(label.end_s))
        assert share_in_view(stage, agent, label.target_object) == 0.0


def test_both_look_at_what_is_held_up() -> None:
    recording = demonstration("show", "hold-up-to-both")
    label, stage = label_of(recording), Stage(recording.scene)
    stage.show(recording.at(label.end_s))
    for agent in label.target_agents:
        eye = stage.eye(recording.scene.agent(agent))
        line = stage.body_position(recording.scene.object_body(label.target_object)) - eye.position
        assert np.degrees(np.arccos(line @ eye.matrix[:, 0] / np.linalg.norm(line))) < 35.0


def test_each_thing_is_given_into_a_hand_of_its_own() -> None:
    whole = explained("give", "one-after-the-other")
    statuses = [str(part.nodes["hands.status.2"].value) for part in whole.parts]
    assert sorted(statuses) == [
        "left: Holding_Object, right: Holding_Other_Object",
        "left: Holding_Other_Object, right: Holding_Object",
    ]
    recording = demonstration("give", "one-after-the-other")
    jumps = np.abs(np.diff(np.array(recording.qpos), axis=0)).max(axis=0)
    for name in label_of(recording).target_objects:
        assert jumps[recording.scene.object_slice(name)][:3].max() < 0.08, "metres from frame to frame"


@pytest.mark.parametrize(("task", "means"), MEANS)
def test_a_pair_explained_alone_is_the_pairs_part(task: str, means: str) -> None:
    recording, whole = demonstration(task, means), explained(task, means)
    label = label_of(recording)
    for agent, name in label.pairs:
        alone = explain_recording(
            recording, label=replace(label, target_agents=(agent,), target_objects=(name,)), predicates=()
        )
        assert alone.to_json() == whole.part(agent, name).to_json()


@pytest.mark.parametrize(("task", "means"), MEANS)
def test_the_order_in_which_targets_are_named_changes_nothing(task: str, means: str) -> None:
    recording = demonstration(task, means)
    label = label_of(recording)
    turned = replace(label, target_agents=label.target_agents[::-1], target_objects=label.target_objects[::-1])
    assert turned != label
    again = explain_recording(recording.with_label(turned), predicates=())
    assert again.to_json() == explained(task, means).to_json()


@pytest.mark.parametrize("task", SEVERAL)
def test_knowledge_of_several_comes_back(task: str) -> None:
    whole = explained(task, SEVERAL[task][0].name)
    assert explanation_from_json(whole.to_json()) == whole


def test_hide_from_each_is_learned() -> None:
    knowledge = Knowledge().add(*(explained("hide", way.name) for way in SEVERAL["hide"]))
    understanding = knowledge.understand("hide")
    clause = clause_of(understanding)
    assert clause.each_of == ("target agents",)
    assert (understanding.judgements["see.class"].kept, understanding.judgements["see.class"].value) == (
        True,
        "Becomes_Difficult",
    )
    sentence = meaning(understanding)
    assert sentence.startswith("“hide” means for each of the target agents: seeing the object ")
    assert len(questions_of(understanding)) < 8


def test_single_and_several_targets_are_learned_from_together() -> None:
    single = [explain_recording(simulate("hide", seed=1, number=6, means="behind-back"), predicates=())]
    both = [explained("hide", way.name) for way in SEVERAL["hide"]]
    alone, mixed = (Knowledge().add(*each).understand("hide") for each in (both, [*single, *both]))
    assert clause_of(mixed).each_of == ("target agents",)
    assert mixed.judgements["see.class"].kept
    assert {each.node.name for each in mixed.kept} <= {each.node.name for each in alone.kept}


def test_give_both_is_learned() -> None:
    understanding = Knowledge().add(explained("give", "one-after-the-other")).understand("give")
    assert clause_of(understanding).each_of == ("target objects",)
    assert understanding.judgements["hands.class"].value == "Manip_Gained"
    assert "for the target agent: " in meaning(understanding)
    assert "each of the objects" in meaning(understanding)
    asked = {question.node.name for question in questions_of(understanding)}
    assert "hands.status.2" in asked, "which hand holds which thing is not the same for both"


def test_episodes_come_in_the_order_of_the_label() -> None:
    recording = demonstration("give", "one-after-the-other")
    pairs = [(each.target_agent, each.target_object) for each in episodes_of(recording)]
    assert tuple(pairs) == label_of(recording).pairs


def test_what_differs_is_unknown_and_says_for_whom() -> None:
    whole = explained("hide", "inside-from-both")
    differing = [name for name in whole.nodes if whole.differing(name)]
    assert "see.state.1" in differing
    for name in differing:
        assert whole.nodes[name].value is UNKNOWN
        reason = str(whole.nodes[name].evidence["reason"])
        assert all(agent in reason for agent in whole.target_agents)


def test_they_are_drawn_by_name_only() -> None:
    for task, ways in SEVERAL.items():
        names = {way.name for way in ways}
        assert names.isdisjoint(way.name for way in ways_of(task))
        assert names.isdisjoint(way.name for way in WAYS[task])
        assert [ways_of(task, name)[0].name for name in names] == list(names)
    assert note(demonstration("hide", "inside-from-both"), "means") == "inside-from-both"
