"""Proposed labels: handing over, putting down, and what the facts cannot tell."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from taskgist.errors import LabelError
from taskgist.facts import vocabulary as v
from taskgist.observe import Observer
from taskgist.recognition import Grip, grips_of, propose_label
from taskgist.recording import Recording
from taskgist.world import Hold
from tests.pipeline.small import FRAMES, room, small, still
from tests.shipped import label, observer, recording

HANDOVERS = ("handover_1", "handover_2", "handover_3", "handover_4")


@pytest.mark.parametrize("name", HANDOVERS)
def test_a_handover_tells_who_gives_what_to_whom_and_when(name: str) -> None:
    proposed = propose_label(recording(name), observer(name))
    assert (proposed.task, proposed.performing_agent, proposed.target_agent) == ("give", "P1", "P2")
    assert proposed.target_object == "baton"
    motion, placement = observer(name).motion("baton"), observer(name).placement("baton")
    assert motion.at(proposed.start_s) == v.STATIC
    assert v.MOVING in {motion.at(proposed.start_s + later_s) for later_s in np.arange(0.0, 0.7, 0.1)}
    placed = placement.at(proposed.end_s)
    assert placed is not None
    assert placed.symbol == v.IN_HAND
    held = {(grip.agent, grip.start_s <= proposed.end_s < grip.end_s) for grip in grips_of_baton(name)}
    assert ("P2", True) in held
    assert proposed.how.startswith("proposed: ")


def grips_of_baton(name: str) -> tuple[Grip, ...]:
    return grips_of(observer(name), "baton")


@pytest.mark.parametrize("name", HANDOVERS)
def test_the_shipped_labels_begin_where_would_be_proposed_and_end_when_it_has_changed_hands(name: str) -> None:
    """They were set 0.1 s after fingers had opened; proposed is the middle of the time in which both have it."""
    proposed = propose_label(recording(name), observer(name))
    assert proposed.start_s == pytest.approx(label(name).start_s, abs=1 / 60)
    assert 0.0 <= label(name).end_s - proposed.end_s < 0.6
    taken = Hold("P2", "right", "baton")
    assert taken in observer(name).holds(label(name).end_s)
    assert taken in observer(name).holds(proposed.end_s)


@pytest.mark.parametrize("name", ["hide_a", "show_d"])
def test_putting_down_ends_when_the_object_rests(name: str) -> None:
    script = label(name)
    proposed = propose_label(recording(name), observer(name), task=script.task)
    for field in ("task", "performing_agent", "target_agent", "target_object"):
        assert getattr(proposed, field) == getattr(script, field), field
    assert script.start_s < proposed.start_s < proposed.end_s < script.end_s
    motion = observer(name).motion(script.target_object)
    assert motion.at(proposed.start_s) == v.STATIC
    assert {i.value for i in motion.intervals if i.end_s > proposed.end_s} == {v.STATIC}, (
        "it has moved for the last time"
    )
    assert {i.value for i in motion.intervals if proposed.start_s < i.start_s < proposed.end_s} >= {v.MOVING, v.STATIC}
    placed = observer(name).placement(script.target_object).at(proposed.end_s)
    assert placed is not None
    assert placed.symbol == v.ON_SUPPORT
    assert "rest" in proposed.how


def test_what_is_given_is_kept() -> None:
    given: dict[str, Any] = {
        "task": "pass",
        "performing_agent": "P2",
        "target_agents": ("P1",),
        "target_objects": ("baton",),
    }
    proposed = propose_label(recording("handover_1"), observer("handover_1"), **given)
    assert {key: getattr(proposed, key) for key in given} == given


def test_the_task_is_not_made_up() -> None:
    with pytest.raises(LabelError, match=r"task: the facts do not tell which task this is; name it: --task show"):
        propose_label(recording("hide_a"), observer("hide_a"))


def carried_by_nobody() -> Recording:
    """A cup that slides along the table on its own."""
    world = room()
    qpos = still(world)
    qpos[:, world.object_slice("cup").start] += np.clip(np.arange(FRAMES) - 10, 0, 10) / 50
    return small(world, qpos=qpos)


NOTHING = {
    "still": (small(), {}, "target_object: no object moves in this recording; name it: --object NAME"),
    "nobody": (carried_by_nobody(), {"task": "x"}, "performing_agent: nobody is seen to hold the object; name it: "),
}


@pytest.mark.parametrize("case", NOTHING)
def test_where_nothing_happens_nothing_is_proposed(case: str) -> None:
    empty, given, message = NOTHING[case]
    with pytest.raises(LabelError, match=re.escape(message)):
        propose_label(empty, Observer(empty.scene, empty), **given)


def test_a_target_agent_leaves_the_other_to_perform() -> None:
    sliding = carried_by_nobody()
    proposed = propose_label(sliding, Observer(sliding.scene, sliding), task="push", target_agents="P1")
    assert (proposed.performing_agent, proposed.target_agent) == ("P2", "P1")
