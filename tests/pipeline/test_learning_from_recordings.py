"""What the shipped recordings teach: the clauses of the paper; and knowledge that is a set, however it was gathered."""

from __future__ import annotations

import itertools
from dataclasses import replace
from pathlib import Path

import pytest

from taskgist.errors import LabelError, RecordingError, UnknownNameError
from taskgist.facts import UNKNOWN, Predicate, predicate_subtree
from taskgist.facts.tree import TreeOf
from taskgist.learning import Experience, Knowledge, clause_of, understand
from taskgist.pipeline import episode_of, explain_all, explain_recording, label_of, learn, shipped_recordings
from taskgist.pipeline.explain import announced
from taskgist.settings import DEFAULT
from taskgist.store import load, save, update
from tests.learning.test_paper_clauses import predicates
from tests.pipeline.small import LABEL, room, small
from tests.scenes import box
from tests.shipped import NAMES, PATHS, STUDY, TASKS, excerpt, explanation, knowledge, names_of, recording

GIVE = {
    "Initial_Action_to_Reach": "Lean_Torso + Stretch_Out_Arm(left)",
    "Initial_Effort_to_Grasp": "Arm_Torso_Effort",
    "Action_to_Reach": "No_Action_Required",
    "Initial_Posture": "Standing",
    "Final_Posture": "Standing",
    "Action_to_Grasp": "No_Action_Required",
    "Object_Initial_Motion_Status": "Static",
    "Object_Final_Motion_Status": "Moving",
    "Nature_Visibility_Score": "Supportive",
    "Action_to_See": "No_Action_Required",
    "Initial_Action_to_See": "No_Action_Required",
    "Initial_Hand_Status": "Free_of_Object",
    "Final_Hand_Status": "left: Free_of_Object, right: Holding_Object",
    "Object_Initial_Status": "On_Support",
    "Object_Final_Status": "In_Hand",
}
"""Measured, not the paper's: all five people stood, would have had to lean for the baton, and took it with the right
hand while it moved. All looked at it before, and their eyes were at it in the end, in the middle of a flat image: two
saw no more of it."""


def test_real_handovers_teach_to_give() -> None:
    assert predicates(clause_of(knowledge("give").understand("give"))) == GIVE


TRACKED = names_of("give")[:4]
"""Handovers whose right hands, which take and give, were tracked."""


@pytest.mark.parametrize("held_out", TRACKED)
def test_effects_that_three_handovers_teach_hold_in_the_fourth(held_out: str) -> None:
    """Together with the three simulated ones, which differ more, the whole clause does."""
    real = [explanation(name) for name in TRACKED if name != held_out]
    simulated = [explanation(name) for name in STUDY["give"]]
    nodes = explanation(held_out).nodes
    effects = clause_of(understand(Experience.of("give", real))).effects
    assert [each for each in effects if each.holds(nodes) is not True] == []
    assert clause_of(understand(Experience.of("give", [*real, *simulated]))).holds(nodes) is True


@pytest.mark.parametrize("task", TASKS)
def test_a_clause_holds_in_its_demonstrations_and_in_no_others(task: str) -> None:
    clause = clause_of(knowledge(task).understand(task))
    for name in NAMES:
        holds = clause.holds(explanation(name).nodes)
        if (task, name) == ("give", "handover_5"):
            assert holds is UNKNOWN, "right hands were not tracked"
        else:
            assert holds is (name in names_of(task)), name


@pytest.mark.parametrize("name", ["handover_1", "hide_a"])
def test_which_explanation_it_will_be_is_known_beforehand(name: str) -> None:
    made, before = explanation(name), announced(recording(name), predicates=())
    assert before.digest == made.digest
    assert before.recording == made.recording
    assert before.marked_wrong().is_rival_of(made)


@pytest.mark.parametrize("of", ["target", "performer"])
@pytest.mark.parametrize("objects", [("cup",), ("cup", "box")])
def test_it_is_known_for_whom_and_with_what_they_may_be(of: TreeOf, objects: tuple[str, ...]) -> None:
    world = room(box("box", 0.0, 0.4, 0.8, (0.05, 0.05, 0.05)))
    shown = small(world, label=replace(LABEL, target_objects=objects))
    made, before = (each(shown, of=of, predicates=()) for each in (explain_recording, announced))
    assert (before.digest, before.tree_of) == (made.digest, of)
    assert (before.target_agents, before.target_objects) == (made.target_agents, made.target_objects)


@pytest.mark.parametrize("task", TASKS)
def test_order_does_not_matter(task: str) -> None:
    explanations = [explanation(name) for name in names_of(task)]
    for order in itertools.islice(itertools.permutations(explanations), 6):
        assert Knowledge().add(*order) == knowledge(task)


@pytest.mark.parametrize("name", NAMES)
def test_removing_and_adding_again_changes_nothing(name: str) -> None:
    known, again = knowledge(*TASKS), explanation(name)
    assert known.remove(again.task, again.digest) != known
    assert known.remove(again.task, again.digest).add(again) == known
    assert known.add(again) == known


def test_the_union_of_knowledge_files_is_what_all_would_have_taught(tmp_path: Path) -> None:
    parts = [Knowledge().add(*(explanation(name) for name in NAMES[start : start + 6])) for start in (0, 3, 6)]
    files = [tmp_path / f"{number}.db" for number in range(3)]
    for part, file in zip(parts, files, strict=True):
        save(part, file)
    for number, order in enumerate(itertools.permutations(files)):
        merged = Knowledge()
        for file in order:
            merged = merged.merge(load(file))
        assert merged == knowledge(*TASKS)
        update(tmp_path / f"union{number}.db", merged.explanations[:7])
        update(tmp_path / f"union{number}.db", merged.explanations[5:])
        assert load(tmp_path / f"union{number}.db") == merged


def test_learning_from_recordings_is_explaining_each() -> None:
    short = [excerpt(name, 1.2, 4.2, every=2) for name in ("handover_1", "handover_2")]
    told: list[tuple[str, float]] = []
    known = learn(short, progress=lambda what, share: told.append((what, share)))
    assert known == Knowledge().add(*explain_all(reversed(short)))
    assert [share for _, share in told] == sorted(share for _, share in told)
    assert told[-1] == ("done", 1.0)
    assert {what.partition(":")[0] for what, _ in told} == {*(each.name for each in short), "done"}


def test_the_performing_agents_own_tree_is_that_of_who_is_alone() -> None:
    """What a label without a target agent is explained by; from Python by the same word as on the command line."""
    short = excerpt("handover_1", 1.2, 4.2, every=2)
    (own,) = learn([short], of="performer").explanations
    assert own == explain_recording(short, label=label_of(short).alone)
    assert (own.tree_of, own.target_agents) == ("performer", ("P1",))
    assert episode_of(short, of="performer").target_agent == "P1"
    with pytest.raises(UnknownNameError, match=r"no tree of 'giver' \(known: performer, target\)"):
        learn([short], of="giver")  # type: ignore[arg-type]


def test_own_predicates_are_learned_too() -> None:
    early = Predicate(predicate_subtree("early"), lambda stage, _agent, _name: stage.state.time_s < 0.5)
    (explained,) = explain_all([small()], predicates=[early])
    assert explained.nodes["early.class"].value == "Gaining(False) & Losing(True)"
    assert explained.context.settings_digest == DEFAULT.digest


def test_nothing_can_be_learned_from_nothing() -> None:
    with pytest.raises(RecordingError, match="no demonstrations to learn from; name at least one labelled recording"):
        learn([])
    with pytest.raises(LabelError, match="small: the recording has no label; set one: taskgist label"):
        learn([small(label=None)])
    with pytest.raises(LabelError, match="elsewhere: the recording has no label"):
        label_of(small(label=None), "elsewhere")


def test_shipped_recordings() -> None:
    assert set(NAMES) < set(PATHS)
    assert all(recording(name).label is not None for name in NAMES)
    assert not any(recording(name).provenance.simulated for name in names_of("give"))
    known = ".*put away, show and 1 more"
    with pytest.raises(UnknownNameError, match=rf"no shipped task 'shw'; did you mean 'show'\? \(known: {known}\)"):
        shipped_recordings("shw")
