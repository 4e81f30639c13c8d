"""Who is after which thing at a moment: real takers, people who stand still, and what comes later."""

from __future__ import annotations

import math

import numpy as np

from taskgist.pipeline.under_way import until
from taskgist.recognition import Intention
from taskgist.recognition.intentions import intentions_at_the_end
from taskgist.recording import Recording
from tests.pipeline.small import FRAMES, room, small, still
from tests.shipped import excerpt


def after(recording: Recording, time_s: float) -> tuple[Intention, ...]:
    return intentions_at_the_end(until(recording, time_s))


def test_who_takes_in_a_real_handover_reaches_for_the_thing() -> None:
    handover = excerpt("handover_2", 0.2, 3.4)
    (found,) = after(handover, 2.25)
    assert (found.agent, found.thing, found.behaviour, found.ability) == ("P2", "baton", "reaching", "reach")


def test_who_has_the_thing_reaches_for_nothing() -> None:
    handover = excerpt("handover_2", 0.2, 3.4)
    for time_s in (1.8, 2.25, 2.6):
        assert "P1" not in {each.agent for each in after(handover, time_s)}


def test_nothing_after_the_moment_is_looked_at() -> None:
    whole, part = excerpt("handover_2", 0.2, 3.4), until(excerpt("handover_2", 0.2, 3.4), 2.25)
    assert after(whole, 2.25) == intentions_at_the_end(part)


def test_who_stands_still_is_after_nothing() -> None:
    for time_s in (0.1, 0.5, 1.0):
        assert after(small(), time_s) == ()


def walking(speed_m_s: float) -> Recording:
    """P1 goes straight ahead, from where the cup is 1.9 m away or a second's walk nearer."""
    world = room()
    qpos, along = still(world), world.agent("P1").base.start
    qpos[:, world.agent("P1").joints["head_tilt"]] = math.radians(-30)  # looks down at it
    qpos[:, along] += speed_m_s * (np.arange(FRAMES) / 30 - 1.0)
    return small(world, qpos=qpos)


def test_who_walks_up_to_a_thing_and_looks_at_it_is_after_it_and_who_walks_away_is_not() -> None:
    (found,) = after(walking(1.0), 0.9)
    assert (found.agent, found.thing, found.behaviour) == ("P1", "cup", "walking")
    assert after(walking(-1.0), 0.9) == ()
    assert after(walking(0.05), 0.9) == ()
