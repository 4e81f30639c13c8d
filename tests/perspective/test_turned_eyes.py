"""What turned eyes see: the image and the gaze cone turn with them, and turning the head brings them back."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from taskgist.language.efforts import why
from taskgist.perspective import SceneEfforts, least_effort, view_of, visibility
from taskgist.perspective.effort import LOOK, NO_ACTION
from taskgist.settings import DEFAULT
from taskgist.world import Stage
from taskgist.world.state import AHEAD, EyeTurn
from tools.rooms import Person, Room, Thing, random_room

ME = Person("P1", (0.0, 0.0))
AHEAD_M, EYE_M = 2.0, 1.64


def ball(name: str, left_deg: float) -> Thing:
    """At the height of the eyes, 2 m away, so far to the left."""
    left = math.radians(left_deg)
    return Thing(name, (0.1,), (AHEAD_M * math.cos(left), AHEAD_M * math.sin(left), EYE_M), "sphere")


def looking(left_deg: float, *things: Thing, towards: str | None = "left") -> Stage:
    stage = Room(things or (ball("ahead", 0), ball("left", 50)), (ME,)).stage()
    return stage.show(stage.state.with_eyes({"P1": EyeTurn(math.radians(left_deg), 0.0, towards)}))


def test_what_eyes_turn_to_is_seen_without_effort_and_what_is_told_says_so() -> None:
    assert least_effort(looking(0), "P1", "left", "see").level == 1
    effort = least_effort(looking(35), "P1", "left", "see")
    assert (effort.level, effort.actions) == (0, (NO_ACTION,))
    assert effort.reason == "in the gaze cone, the eyes assumed to turn 35° towards the left"
    assert "(the eyes assumed to turn 35° towards the left)" in why(effort)
    assert effort.evidence_document["eyes_towards"] == "left"


def test_a_recorded_turn_is_nothing_assumed() -> None:
    effort = least_effort(looking(35, towards=None), "P1", "left", "see")
    assert (effort.level, effort.reason) == (0, "in the gaze cone")
    assert not {"eyes_towards", "eyes_rad"} & set(effort.evidence_document)


def test_what_the_head_points_to_takes_turning_the_eyes_back() -> None:
    effort = least_effort(looking(35), "P1", "ahead", "see")
    assert (effort.level, effort.actions) == (1, (LOOK,))
    assert effort.amount is not None
    assert effort.amount.head_rad == 0.0
    assert effort.reason == "in view, but 35° beside the gaze (cone 30°), the eyes assumed to turn 35° towards the left"
    assert why(effort).startswith("P1 sees the ahead by turning the eyes ahead; with less: in view")
    assert SceneEfforts(looking(35)).efforts_with("P1", "see", ())["ahead"].level != 1, "without any action it is not"


@pytest.mark.parametrize("turned_deg", [-35, -20, 20, 35])
def test_with_effort_it_does_not_matter_where_eyes_were(turned_deg: float) -> None:
    behind = ball("behind", 170)
    turned, ahead = (least_effort(looking(each, behind), "P1", "behind", "see") for each in (turned_deg, 0))
    assert (turned.level, turned.actions, turned.amount) == (ahead.level, ahead.actions, ahead.amount)


@pytest.mark.parametrize("left_deg", [-30, -10, 15, 35])
def test_turning_the_eyes_shows_what_turning_the_head_as_far_does(left_deg: float) -> None:
    """But for the eyes' own place, which the neck moves by some centimetres."""
    far = Thing("far", (2.0,), (80.0, 20.0, EYE_M), "sphere")
    eyes = visibility(looking(left_deg, far), "P1", "far")
    head = visibility(Room((far,), (replace(ME, joints_deg=(("head_pan", left_deg),)),)).stage(), "P1", "far")
    assert eyes is not None
    assert head is not None
    assert eyes.off_gaze_rad == pytest.approx(head.off_gaze_rad, abs=0.005)
    assert eyes.score == pytest.approx(head.score, rel=0.02)


@pytest.mark.parametrize("number", range(6))
def test_the_whole_image_and_the_pixels_of_one_thing_agree(number: int) -> None:
    stage = random_room(number).stage()
    for agent in stage.scene.agents:
        stage.show(stage.state.with_eyes({agent: EyeTurn(0.4, -0.3)}))
        pixels = view_of(stage, agent).pixels()
        for name in stage.scene.objects:
            seen = visibility(stage, agent, name)
            assert seen is not None
            if seen.visible_px >= 100:
                assert seen.visible_px == pytest.approx(pixels.get(name, 0), rel=0.05)


def test_eyes_that_are_known_to_look_ahead_change_nothing() -> None:
    stage = random_room(3).stage()
    plain = {question: effort.level for question, effort in SceneEfforts(stage).all().items()}
    stage.show(stage.state.with_eyes(dict.fromkeys(stage.scene.agents, AHEAD)))
    assert {question: effort.level for question, effort in SceneEfforts(stage).all().items()} == plain


def test_who_is_followed_is_asked_anew_when_the_eyes_turn() -> None:
    stage = looking(0)
    efforts, still = SceneEfforts(stage, DEFAULT), stage.state
    for left_deg, levels in ((0, (0, 1)), (35, (1, 0)), (0, (0, 1))):
        efforts.update(still.with_eyes({"P1": EyeTurn(math.radians(left_deg), 0.0, "left")}))
        assert tuple(efforts.effort("P1", name, "see").level for name in ("ahead", "left")) == levels
