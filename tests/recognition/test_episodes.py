"""Episodes of recordings without a label: what is told of a thing gives its handlings."""

from __future__ import annotations

import numpy as np
import pytest

from taskgist.errors import LabelError
from taskgist.recognition import Handling, handlings_of, propose_label
from taskgist.recording import Recording
from tests.pipeline.small import room, small, still
from tests.recognition.told import Told
from tests.shipped import label, observer, recording

WORLD = room()
LONG = small(WORLD, times_s=np.arange(101) / 10, qpos=still(WORLD, 101), label=None)


def handlings(recorded: Recording = LONG, **told: object) -> tuple[Handling, ...]:
    return handlings_of(recorded, Told(scene=WORLD, **told).observer())  # type: ignore[arg-type]


def brief(found: tuple[Handling, ...]) -> list[tuple[str | None, float, float, str]]:
    return [(each.performing_agent, round(each.start_s, 2), round(each.end_s, 2), each.ending) for each in found]


def test_each_time_that_a_thing_is_picked_up_and_put_down_is_one() -> None:
    found = handlings(held=(("P1", 2, 3), ("P2", 6, 8)), moving=((2, 3), (6, 8)))
    assert brief(found) == [("P1", 1.7, 3.3, "rests"), ("P2", 5.7, 8.3, "rests")]
    assert [each.target_agents for each in found] == [("P2",), ("P1",)]
    assert {each.confidence for each in found} == {1.0}


def test_nothing_is_handled_where_nothing_moves() -> None:
    assert handlings() == ()
    assert handlings(held=(("P1", 2, 4),)) == (), "who only has a hand at a thing has not done anything with it"


def test_a_thing_that_changes_hands_is_given_and_then_put_down() -> None:
    found = handlings(held=(("P1", 2, 5), ("P2", 4, 8)), moving=((2, 7.5),))
    given, put = found
    assert (given.taker, put.taker) == ("P2", None)
    assert brief(found) == [("P1", 1.7, 4.5, "changes hands"), ("P2", 4.5, 7.8, "held still")]
    assert given.end_s == put.start_s


def test_who_takes_a_thing_and_keeps_it_still_has_done_nothing() -> None:
    (given,) = handlings(held=(("P1", 2, 5), ("P2", 4, 10)), moving=((2, 3.5),))
    assert given.ending == "changes hands"


def test_what_is_held_still_and_moved_on_may_have_been_shown() -> None:
    found = handlings(held=(("P1", 2, 8),), moving=((2, 4), (6, 8)))
    assert brief(found) == [("P1", 1.7, 4.3, "held still"), ("P1", 1.7, 8.3, "rests")]
    assert [each.confidence for each in found] == [0.5, 1.0]
    assert found[0].reason == "P1 holds cup still for a while, and moves it on"


def test_what_is_offered_and_then_taken_is_one_handling() -> None:
    found = handlings(held=(("P1", 2, 6), ("P2", 5.5, 8)), moving=((2, 4), (6.5, 8)))
    assert [(each.performing_agent, each.ending) for each in found] == [("P1", "changes hands"), ("P2", "rests")]


def test_who_has_it_again_at_once_had_never_done_with_it() -> None:
    found = handlings(held=(("P1", 2, 4), ("P1", 4.3, 6)), moving=((2, 4), (4.4, 6)))
    assert brief(found) == [("P1", 1.7, 6.3, "rests")]


def test_what_moves_and_nobody_has_is_nobodys() -> None:
    qpos = still(WORLD, 101)
    qpos[:, WORLD.object_slice("cup").start] += np.clip(np.arange(101) - 40, 0, 20) / 100
    (found,) = handlings(small(WORLD, times_s=np.arange(101) / 10, qpos=qpos, label=None), moving=((4, 6),))
    assert (found.performing_agent, found.confidence) == (None, 0.0)
    assert (found.start_s, found.end_s) == pytest.approx((3.7, 6.3))
    with pytest.raises(LabelError, match="performing_agent"):
        found.label("P2")


def test_a_recording_that_ends_before_the_thing_rests_says_so() -> None:
    (found,) = handlings(held=(("P1", 6, 10),), moving=((6, 10),))
    assert found.ending == "recording ends"
    assert found.confidence < 0.5
    assert "ends before cup has come to rest" in found.reason


@pytest.mark.parametrize("name", ["handover_1", "handover_3"])
def test_a_real_handover_is_given_as_its_label_says_and_then_put_down(name: str) -> None:
    found = handlings_of(recording(name).with_label(None), observer(name))
    given = next(each for each in found if each.taker)
    assert (given.thing, given.performing_agent, given.taker) == ("baton", "P1", "P2")
    assert (given.start_s, given.end_s) == pytest.approx((label(name).start_s, label(name).end_s), abs=0.01)
    put = next(each for each in found if each.performing_agent == "P2")
    assert put.start_s == given.end_s
    assert put.ending == "rests"


def test_a_handling_is_labelled_as_a_proposal_would_be() -> None:
    name = "hide_a"
    (found,) = handlings_of(recording(name).with_label(None), observer(name))
    made, proposed = found.label("P2", task="hide"), propose_label(recording(name), observer(name), task="hide")
    assert (made.performing_agent, made.target_agents, made.target_objects) == (
        proposed.performing_agent,
        proposed.target_agents,
        proposed.target_objects,
    )
    assert (made.start_s, made.end_s) == pytest.approx((proposed.start_s, proposed.end_s), abs=0.002)
