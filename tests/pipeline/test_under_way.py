"""What is under way in a recording is told from what has come so far."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from taskgist.errors import LabelError, RecordingError
from taskgist.facts.standard import STANDARD_TREE
from taskgist.pipeline.recognise import TaskRecogniser
from taskgist.pipeline.under_way import Moment, foresee_recording, moment_of, until
from tests.shipped import knowledge, label, recording


@cache
def recogniser() -> TaskRecogniser:
    return TaskRecogniser.of(knowledge("give", "show", "hide"))


@cache
def moment(name: str, time_s: float) -> Moment:
    own = label(name)
    pair = (own.target_agent, own.target_object)
    return moment_of(recording(name), (own.start_s, time_s), own.performing_agent, *pair, STANDARD_TREE)


def test_a_handover_goes_through_its_stages() -> None:
    stages = []
    for time_s in (1.65, 2.7, 3.4):
        cues = moment("handover_1", time_s).cues
        assert cues is not None
        stages.append(cues.stage)
    assert stages[0] in ("untouched", "grasped")
    assert stages[1:] == ["carried", "taken"]
    before, later = (moment("handover_1", time_s).cues for time_s in (2.2, 2.9))
    assert before is not None
    assert later is not None
    assert later.nearing_m > before.nearing_m
    assert later.target_hand_m < before.target_hand_m


def test_a_cup_that_is_put_behind_a_box_is_hidden_there() -> None:
    own = label("hide_a")
    cues = moment("hide_a", own.end_s).cues
    assert cues is not None
    assert (cues.stage, cues.blocked) == ("let go", True)


def test_nothing_after_the_moment_is_looked_at() -> None:
    whole = recording("handover_1")
    time_s = float(whole.times_s[80])
    qpos = np.array(whole.qpos)
    qpos[81:] = qpos[0]
    changed = replace(whole, qpos=qpos)
    one, other = (foresee_recording(recogniser(), each, time_s) for each in (whole, changed))
    assert one == other
    assert len(until(whole, time_s)) == 81
    assert until(whole, time_s).label is None


def test_who_does_what_is_found_where_no_label_says_so() -> None:
    bare = recording("handover_1").with_label(None)
    (found,) = foresee_recording(recogniser(), bare, 3.0)
    assert (found.moment.performing_agent, found.moment.target_agent, found.moment.thing) == ("P1", "P2", "baton")
    assert found.moment.start_s == pytest.approx(label("handover_1").start_s, abs=0.05)


def test_before_anything_has_begun_nothing_is_foreseen() -> None:
    with pytest.raises(LabelError, match="nothing has begun yet"):
        foresee_recording(recogniser(), recording("show_a"), 0.3)
    with pytest.raises(LabelError, match="nothing is handled yet"):
        foresee_recording(recogniser(), recording("show_a").with_label(None), 1.0)
    with pytest.raises(RecordingError, match="outside of the recording"):
        foresee_recording(recogniser(), recording("show_a"), 99.0)
