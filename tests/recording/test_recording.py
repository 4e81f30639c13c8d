"""Recordings in memory: states, times, digests, labels, and what is refused."""

from __future__ import annotations

import copy
import pickle
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from taskgist.errors import LabelError, RecordingError, UnknownNameError
from taskgist.recording import Label, Recording, read, write
from taskgist.recording.recording import decimals, label_of_fields, rounded, whole
from tests.importing.recordings import FRAMES, LABEL, recording, room
from tests.scenes import agent, cylinder, scene

SEEDED = settings(derandomize=True, deadline=None, max_examples=30)


def test_states_know_what_was_lost() -> None:
    assert recording().state(0).untracked == {"P1/left_arm"}
    assert recording().state(2).untracked == {"box"}
    assert recording().state(-1).untracked == frozenset()
    assert recording().state(1).time_s == pytest.approx(1 / 30)
    assert len(recording()) == FRAMES
    with pytest.raises(RecordingError, match=r"handover 1: index: no such frame \(got 5\); give an index from 0 to 4"):
        recording().state(FRAMES)


def test_the_nearest_frame() -> None:
    assert recording().at(0.04).time_s == pytest.approx(1 / 30)
    assert recording().at(0.06).time_s == pytest.approx(2 / 30)
    assert recording().at(4 / 30).time_s == pytest.approx(recording().duration_s)
    with pytest.raises(RecordingError, match=r"outside.*got 0.2\); give a time between 0 and 0.133333 s"):
        recording().at(0.2)


def test_arrays_cannot_be_written_to() -> None:
    record = recording()
    copies = (record, pickle.loads(pickle.dumps(record)), copy.deepcopy(record))
    for each in copies:
        assert each.digest == record.digest
        assert each.provenance == record.provenance
        for array in (each.qpos, each.times_s, each.tracked["box"], each.state(0).qpos):
            with pytest.raises(ValueError, match="read-only"):
                array[0] = 0


def test_digest_sees_what_was_recorded_and_nothing_else() -> None:
    digest = recording().digest
    assert re.fullmatch(r"[0-9a-f]{16}", digest)
    assert recording(label=LABEL).digest == digest
    assert recording(seed=1).digest != digest
    assert changed(tracked={}).digest != digest
    assert changed(times_s=recording().times_s + 0.001).digest != digest
    assert changed(name="other").digest == digest
    assert changed(qpos=recording().qpos + 1e-9).digest == digest
    assert changed(tracked={**recording().tracked, "cup": np.ones(FRAMES, bool)}).digest == digest


def changed(**fields: Any) -> Recording:
    given = {name: getattr(recording(), name) for name in ("scene", "times_s", "qpos", "tracked", "name")}
    return Recording(**(given | fields))


def broken(row: int, column: int, value: float) -> np.ndarray[Any, np.dtype[np.float64]]:
    qpos = np.array(recording().qpos)
    qpos[row, column] = value
    return qpos


def without_rotation() -> np.ndarray[Any, np.dtype[np.float64]]:
    qpos = np.array(recording().qpos)
    qpos[2, room().object_slice("cup")] = 0.0
    return qpos


MISTAKES: dict[str, tuple[dict[str, Any], str]] = {
    "one frame": ({"times_s": [0.0], "qpos": recording().qpos[:1], "tracked": {}}, "too few frames"),
    "backwards": ({"times_s": [0, 1, 3, 2, 4]}, r"times run backwards at frame 3 \(got \(3.0, 2.0\)"),
    "repeated": ({"times_s": [0, 1, 1, 2, 4]}, r"times repeat at frame 2 \(got \(1.0, 1.0\)"),
    "negative": ({"times_s": [-1, 0, 1, 2, 3]}, r"times are negative \(got -1.0\)"),
    "no time": ({"times_s": [0, 1, np.nan, 2, 3]}, "frame 2 has no time"),
    "shape": ({"qpos": recording().qpos[:, :-1]}, r"qpos: wrong shape .* need the shape \(5, \d+\)"),
    "nan": ({"qpos": broken(3, 7, np.nan)}, r"frame 3, column 7 is not finite \(got nan\)"),
    "far": ({"qpos": broken(1, 0, 1e7)}, r"frame 1, column 0 is beyond 1,000,000 metres or radians"),
    "without end": ({"times_s": [0, 1, 1e10, 3, 4]}, "times are too large"),
    "infinite": ({"qpos": broken(1, 0, np.inf)}, r"frame 1, column 0 is not finite \(got inf\)"),
    "no rotation": ({"qpos": without_rotation()}, r"frame 2, columns \d+ to \d+ hold no unit quaternion"),
    "flags": ({"tracked": {"box": [True]}}, r"tracked\['box'\]: wrong shape .* each of the 5 frames"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistakes(mistake: str) -> None:
    fields, expected = MISTAKES[mistake]
    with pytest.raises(RecordingError, match=expected):
        changed(**fields)


def test_unknown_names() -> None:
    with pytest.raises(UnknownNameError, match=r"no object, agent or part 'P1/left_leg'; did you mean 'P1/left_arm'"):
        changed(tracked={"P1/left_leg": np.ones(FRAMES, bool)})
    with pytest.raises(UnknownNameError, match=r"no agent 'P3'; did you mean 'P2'\? \(known: P1, P2\)"):
        recording().with_label(Label("give", "P1", "P3", "cup", 0.0, 0.1))
    with pytest.raises(UnknownNameError, match=r"no object 'cap'; did you mean 'cup'"):
        recording().with_label(Label("give", "P1", "P2", "cap", 0.0, 0.1))


GOOD = {"task": "give", "performing_agent": "P1", "target_agents": "P2", "target_objects": "cup"}
TIMES = {"start_s": 0.0, "end_s": 0.1}
LABELS: dict[str, tuple[dict[str, Any], str]] = {
    "several tasks": ({"task": ["give", "show"]}, r"task: must be a name \(got \['give', 'show'\]\); give a text"),
    "nobody": ({"target_agents": []}, r"target_agent: no target agent \(got \[\]\); name at least one"),
    "nothing": ({"target_objects": []}, r"target_object: no target object \(got \[\]\); name at least one"),
    "a set": ({"target_agents": {"P2"}}, r"target_agent: must be a name or a list of names \(got \{'P2'\}\)"),
    "a number": ({"target_objects": ["cup", 7]}, r"target_object: must be a name \(got 7\)"),
    "an empty one": ({"target_objects": ["cup", " "]}, r"target_object: is empty \(got ' '\)"),
    "twice": ({"target_agents": ["P2", "P3", " P2"]}, r"target_agent: one target agent stands twice \(got 'P2'\)"),
    "among them": ({"target_agents": ["P2", "P1"]}, r"target_agent: performing and target agent are the same"),
    "no task": ({"task": " "}, r"task: is empty"),
    "unseen": ({"task": "gi\x1b[2Jve"}, r"task: holds a character that is not seen"),
    "turned": ({"target_objects": "\u202epuc"}, r"target_object: holds a character that is not seen"),
    "alone": ({"target_agents": "P1"}, r"target_agent: performing and target agent are the same \(got 'P1'\)"),
    "reversed": ({"start_s": 0.1, "end_s": 0.05}, r"end_s: the label ends before it starts \(got 0.05\)"),
    "no time": ({"start_s": float("nan")}, r"start_s: must be a time \(got nan\)"),
    "text": ({"end_s": "late"}, r"end_s: must be a time \(got 'late'\)"),
}


@pytest.mark.parametrize("mistake", LABELS)
def test_labels_that_contradict_themselves(mistake: str) -> None:
    fields, expected = LABELS[mistake]
    with pytest.raises(LabelError, match=expected):
        Label(**(GOOD | TIMES | fields))


def test_one_target_in_a_list_is_that_target() -> None:
    assert Label("give", "P1", ["P2"], ("cup",), 0.0, 0.1) == Label("give", "P1", "P2", "cup", 0.0, 0.1)


def test_who_is_alone_performs_for_nobody_else(tmp_path: Path) -> None:
    """What changes for the performer itself is then explained, and files keep that nobody is named."""
    label = Label("drink", "P1", None, "cup", 0.0, 0.1)
    assert label == Label("drink", "P1", (), "cup", 0.0, 0.1)
    assert (label.target_agents, label.pairs, label.target_agent) == ((), (("P1", "cup"),), "P1")
    assert replace(label, end_s=0.05).pairs == label.pairs
    assert label.as_dict()["target_agent"] is None
    write(recording().with_label(label), tmp_path / "alone.mcap")
    assert read(tmp_path / "alone.mcap").label == label


def test_several_targets() -> None:
    label = Label("give", "P1", ["P3", "P2"], ("pen", "paper"), 0.0, 0.1)
    assert label.pairs == (("P3", "pen"), ("P3", "paper"), ("P2", "pen"), ("P2", "paper"))
    assert label_of_fields(label.as_dict()) == label == replace(label)
    with pytest.raises(LabelError, match=r"target_object: the label has several target objects \(got \('pen', 'paper"):
        _ = label.target_object
    with pytest.raises(LabelError, match="several target agents"):
        _ = label.target_agent
    with pytest.raises(UnknownNameError, match="no object 'paper'"):
        label.check(agents=("P1", "P2", "P3"), objects=("pen",))
    with pytest.raises(UnknownNameError, match="no agent 'P2'"):
        label.check(agents=("P1", "P3"), objects=("pen", "paper"))


def test_labels_outside_of_the_recording() -> None:
    with pytest.raises(LabelError, match=r"end_s: .*outside.*got 5.0\); give a time between 0 and 0.133333 s"):
        recording().with_label(Label("give", "P1", "P2", "cup", 0.0, 5.0))
    assert recording().with_label(LABEL).label == LABEL
    assert recording(label=LABEL).with_label(None).label is None


def test_one_name_has_one_spelling() -> None:
    label = Label("  caf\u0065\u0301 ", " P1", "P2 ", "cup", 0.0, 0.1)
    assert (label.task, label.performing_agent, label.target_agent) == ("caf\u00e9", "P1", "P2")
    assert label == Label("caf\u00e9", "P1", "P2", "cup", 0.0, 0.1)


def test_a_scene_may_write_accents_apart() -> None:
    """What an editor has decomposed is found by its name, and called as the scene calls it."""
    apart = "the\u0301ie\u0300re"
    world = scene(cylinder(apart, 0.1, 0.0, 0.771), agents=agent("P1", -0.8, 0.0) + agent("P2", 0.8, 0.0))
    given = Recording(world, np.arange(2) / 10, np.tile(world.initial.qpos, (2, 1)))
    labelled = given.with_label(Label("give", "P1", "P2", "th\u00e9i\u00e8re", 0.0, 0.1))
    assert labelled.label
    assert labelled.label.target_object == apart


@SEEDED
@given(qpos=arrays(np.float64, room().nq, elements=st.floats(-50, 50)))
def test_rounding_once_is_enough(qpos: np.ndarray[Any, np.dtype[np.float64]]) -> None:
    once = rounded(qpos, room())
    np.testing.assert_array_equal(rounded(once, room()), once)
    np.testing.assert_array_equal(whole(once, room()), whole(qpos, room()))
    assert (np.abs(once - qpos) <= 0.5000001 * 10.0 ** -decimals(room())).all()
