"""Proposed labels: handing over, putting down, and what the facts cannot tell."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from taskgist.errors import LabelError
from taskgist.facts import vocabulary as v
from taskgist.observe import Observer
from taskgist.recognition import Grip, Proposal, grips_of, propose, propose_label
from taskgist.recording import Recording
from taskgist.world import Hold, Stage
from taskgist_lab.paper.grip_forces import GRIP_N
from tests.pipeline.small import FRAMES, room, small, still
from tests.recognition.told import Held, Told
from tests.scenes import TABLE, agent, cylinder, scene
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
def test_the_shipped_labels_are_as_proposed_and_end_when_hands_change_by_the_grip_forces(name: str) -> None:
    """In the middle between the moments when the taker presses and when the giver does no longer."""
    proposed = propose_label(recording(name), observer(name))
    assert proposed == label(name)
    giver, taker = (recording(name).signals[f"{who}_grip"].values > GRIP_N for who in ("P1", "P2"))
    changes = [taker.argmax(), (taker & ~giver).argmax()]
    assert proposed.end_s == pytest.approx(recording(name).times_s[changes].mean(), abs=0.1)
    assert Hold("P2", "right", "baton") in observer(name).holds(proposed.end_s)


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
        "task": "bring",
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
    "still": (small(), None, "target_object: no object moves in this recording; name it: --object NAME"),
    "nobody": (carried_by_nobody(), "x", "performing_agent: nobody is seen to hold the object; name it: "),
}


@pytest.mark.parametrize("case", NOTHING)
def test_where_nothing_happens_nothing_is_proposed(case: str) -> None:
    empty, task, message = NOTHING[case]
    with pytest.raises(LabelError, match=re.escape(message)):
        propose_label(empty, Observer(empty.scene, empty), task=task)


def test_a_target_agent_leaves_the_other_to_perform() -> None:
    sliding = carried_by_nobody()
    proposed = propose_label(sliding, Observer(sliding.scene, sliding), task="push", target_agents="P1")
    assert (proposed.performing_agent, proposed.target_agent) == ("P2", "P1")


# --- What counts where, and how sure it is: told by observers that know all.

FROM_P1_TO_P2 = (("P1", 2.0, 5.0), ("P2", 4.6, 8.0))


def told(*held: Held, **changes: Any) -> Proposal:
    """What is proposed for a recording of ten seconds in which these held the cup."""
    spans = {name: changes.pop(name) for name in ("moving", "unknown", "air") if name in changes}
    world = room()
    frames = 301
    long = small(world, times_s=np.arange(frames) / 30, qpos=still(world, frames), label=None)
    observer = Told(held, scene=world, **{"moving": [(2.0, 8.0)], **spans}).observer()
    return propose(long, observer, target_objects="cup", **changes)


def test_it_starts_before_the_cup_is_moved_and_ends_in_the_middle() -> None:
    proposal = told(*FROM_P1_TO_P2)
    label = proposal.label
    assert (label.task, label.performing_agent, label.target_agents) == ("give", "P1", ("P2",))
    assert (label.start_s, label.end_s) == (1.7, 4.8)
    assert "ends in the middle of the 0.40 s in which both have it (P1 gives, P2 takes)" in label.how
    assert label.how.endswith(f"confidence {proposal.confidence:.2f}: {proposal.reason}")
    assert told(*FROM_P1_TO_P2, moving=[(1.5, 8.0)]).label.start_s == 1.2, "it is slid before it is lifted"
    assert told(*FROM_P1_TO_P2, moving=[(0.5, 0.9), (2.0, 8.0)]).label.start_s == 1.7, "somebody knocked at it"


def test_who_puts_it_down_first_gives_nothing() -> None:
    """P1 puts it before P2, who takes it later: it ends with its rest, before it is taken."""
    proposal = told(("P1", 2.0, 4.0), ("P2", 6.0, 8.0), task="put", moving=[(2.0, 4.1), (6.0, 9.0)])
    label = proposal.label
    assert (label.performing_agent, label.target_agents, label.start_s, label.end_s) == ("P1", ("P2",), 1.7, 4.4)
    with pytest.raises(LabelError, match="do not tell which task"):
        told(("P1", 2.0, 4.0), ("P2", 6.0, 8.0), moving=[(2.0, 4.1), (6.0, 9.0)])


def test_what_happens_before_is_another_matter() -> None:
    """P1 tidies it up first, and gives it later."""
    before = ("P1", 0.5, 1.0)
    assert told(before, *FROM_P1_TO_P2, moving=[(0.5, 1.0), (2.0, 8.0)]).label.start_s == 1.7


@pytest.mark.parametrize(
    ("changes", "confidence", "reason"),
    [
        ({"unknown": [(2.5, 3.8)]}, 1.0 - 1.3 / 3.1, "in 42 % of the time from start to end it is unknown who has cup"),
        ({"air": [(2.5, 3.2)]}, 1.0 - 0.7 / 2.8, "in 25 % of the time in which cup moves nobody has it"),
    ],
)
def test_what_is_not_clear_lowers_the_confidence(changes: dict[str, Any], confidence: float, reason: str) -> None:
    proposal = told(*FROM_P1_TO_P2, **changes)
    assert proposal.confidence == pytest.approx(confidence, abs=0.01)
    assert proposal.reason == reason


def test_below_the_least_confidence_nothing_is_proposed() -> None:
    with pytest.raises(
        LabelError, match=r"label: what happens is not clear enough.*in 71 % of the time.*0\.29"
    ) as seen:
        told(*FROM_P1_TO_P2, unknown=[(2.1, 4.3)])
    assert "--performer" in str(seen.value)
    times = {"start_s": 4.4, "end_s": 5.5}
    assert told(*FROM_P1_TO_P2, unknown=[(2.1, 4.3)], **times).confidence == 1.0, "only what lies between them counts"
    roles = {"performing_agent": "P1", "target_agents": "P2", "end_s": 4.8}
    assert told(*FROM_P1_TO_P2, unknown=[(2.1, 4.3)], **roles).confidence == 1.0, "what is given is not in doubt"


def test_who_is_seen_first_may_not_have_been_the_first() -> None:
    """A second in which it is unknown who has the cup, which P2 then puts down."""
    held, seen = ("P2", 3.0, 8.0), {"unknown": [(2.0, 3.0)], "task": "give"}
    with pytest.raises(LabelError, match=r"it is unknown who has cup for 1\.00 s before P2 has it"):
        told(held, **seen)
    proposal = told(held, **seen, performing_agent="P1")
    assert (proposal.label.target_agents, proposal.reason) == (("P2",), "cup does not change hands")


def test_a_thing_that_goes_to_and_fro_is_given_where_it_is_said() -> None:
    held = [(who, 1.0 + k, 2.0 + k) for k, who in enumerate(("P1", "P2", "P1", "P2", "P1", "P2"))]
    with pytest.raises(LabelError, match="P1 gives cup to P2 3 times"):
        told(*held, moving=[(1.0, 7.0)])
    label = told(*held, moving=[(1.0, 7.0)], start_s=3.2, end_s=4.5).label
    assert (label.performing_agent, label.start_s, label.end_s) == ("P1", 3.2, 4.5)


def test_a_recording_that_begins_too_late() -> None:
    proposal = told(("P1", 0.0, 5.0), ("P2", 4.6, 8.0), moving=[(0.0, 8.0)])
    assert proposal.reason == "the recording begins too late: cup is moved 0.00 s after its first frame"
    assert 0.5 <= proposal.confidence < 1.0
    late = told(("P1", 0.15, 5.0), ("P2", 4.6, 8.0), moving=[(0.15, 8.0)])
    assert "cup is moved 0.15 s after its first frame" in late.reason
    assert late.label.start_s == 0.0
    assert told(("P1", 0.25, 5.0), ("P2", 4.6, 8.0), moving=[(0.25, 8.0)]).confidence == 1.0


def test_a_recording_that_ends_too_early() -> None:
    with pytest.raises(LabelError, match="the recording ends before cup has come to rest or changed hands"):
        told(("P1", 2.0, 10.0), task="put", moving=[(2.0, 10.0)])
    assert told(("P1", 2.0, 10.0), task="put", moving=[(2.0, 10.0)], end_s=9.0).label.end_s == 9.0


def test_whose_hand_is_nearer_while_another_has_it_speaks_against_it() -> None:
    """The cup stands before P2, as if a tracker had exchanged the two."""
    world = room()
    frames = 301
    qpos = still(world, frames)
    palm = Stage(world, world.initial).site(world.agent("P2").arm("right").palm_site).position
    qpos[:, world.object_slice("cup").start : world.object_slice("cup").start + 3] = palm
    recording = small(world, times_s=np.arange(frames) / 30, qpos=qpos, label=None)
    observer = Told(FROM_P1_TO_P2, moving=[(2.0, 8.0)], scene=world).observer()
    with pytest.raises(LabelError, match="in 100 % of the time in which P1 has cup, P2's hand is nearer to it"):
        propose(recording, observer, target_objects="cup")


def test_who_is_alone_performs_for_nobody_else() -> None:
    world = scene(TABLE, cylinder("cup", 0.1, 0.0, 0.771), agents=agent("P1", -0.8, 0.0))
    alone = small(world, times_s=np.arange(301) / 30, qpos=still(world, 301), label=None)
    observer = Told([("P1", 2.0, 5.0)], moving=[(2.0, 5.2)], scene=world).observer()
    label = propose_label(alone, observer, task="put away", target_objects="cup")
    assert (label.performing_agent, label.target_agents, label.pairs) == ("P1", (), (("P1", "cup"),))
    assert (label.start_s, label.end_s) == (1.7, 5.5)
