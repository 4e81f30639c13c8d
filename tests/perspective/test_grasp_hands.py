"""Grasps by the three kinds of hands."""

from dataclasses import replace

import numpy as np
import pytest

from taskgist.perspective import Effort, least_effort
from taskgist.perspective.grasp_sampling import Grasps, grasps_in_object, hand_centers, hand_frames, sample_grasps
from taskgist.settings import DEFAULT
from taskgist.world import HAND_KINDS, Hand, HandKind, Scene, Stage, hand_boxes
from taskgist.world.bodies.profile import builtin_profile_text
from tests.perspective.twin_grasp import hand_poses
from tools.rooms import Person, Room, Thing

HERE_ONLY = replace(DEFAULT, efforts=replace(DEFAULT.efforts, move_radius_m=0.0))
STANDING = Person("P1", (0.0, 0.0))
CUP = Thing("cup", (0.03, 0.05), (0.5, 0.2, 1.2), "cylinder")


def with_hand(kind: HandKind, *things: Thing, opening_m: float = 0.1) -> Stage:
    """A person whose hands are of that kind."""
    profile = builtin_profile_text("human").replace('kind = "human"', f'kind = "{kind}"')
    profile = profile.replace("opening_m = 0.10", f"between_m = 0\nopening_m = {opening_m}")
    assert kind in profile
    bundle = dict(Room(things, (STANDING,)).scene().bundle)
    return Stage(Scene.from_bundle(bundle | {"P1.profile.toml": profile.encode()}))


def hand_of(stage: Stage) -> Hand:
    hand = stage.scene.agent("P1").profile.hand
    assert hand is not None
    return hand


def grasps_of(stage: Stage, name: str) -> Grasps:
    return grasps_in_object(stage, name, hand_of(stage), DEFAULT.grasp)


def effort(stage: Stage, name: str) -> Effort:
    return least_effort(stage, "P1", name, "grasp", HERE_ONLY)


@pytest.mark.parametrize("kind", HAND_KINDS)
def test_every_kind_grasps_a_cup_and_says_so(kind: HandKind) -> None:
    found = effort(with_hand(kind, CUP), "cup")
    assert (found.level, found.evidence_document["hand"]) == (1, kind)
    assert round(found.evidence_document["width_m"], 6) in {0.06, 0.1}  # type: ignore[call-overload]


@pytest.mark.parametrize("kind", HAND_KINDS)
def test_the_arms_ghosts_are_the_hands_boxes(kind: HandKind) -> None:
    stage = with_hand(kind, CUP)
    for arm in stage.scene.agent("P1").arms:
        sizes = stage.scene.model.geom_size[arm.ghosts]
        np.testing.assert_allclose(sizes, [box.half_m for box in hand_boxes(hand_of(stage))])


@pytest.mark.parametrize("kind", HAND_KINDS)
def test_a_narrower_opening_grasps_no_more(kind: HandKind) -> None:
    wide, narrow = (with_hand(kind, CUP, opening_m=opening) for opening in (0.1, 0.05))
    assert len(grasps_of(wide, "cup")) > len(grasps_of(narrow, "cup")) == 0
    assert effort(narrow, "cup").reason == "too wide (0.06 m > 0.05 m)"


def test_narrow_fingers_take_a_knob_between_posts_that_a_human_hand_does_not() -> None:
    """Plates above and below the knob leave a gripper's fingers room, but not four fingers side by side.

    A forearm does not fit between them: only the hand goes in.
    """
    knob = Thing("knob", (0.015, 0.015, 0.015), (0.5, 0.2, 1.2))
    plates = [Thing(f"plate{s}", (0.12, 0.12, 0.005), (0.5, 0.2, 1.2 + 0.03 * s), free=False) for s in (-1, 1)]
    profile_palm = "palm_m = [0.085, 0.028]", "palm_m = [0.04, 0.028]"
    levels = {}
    for kind in ("human", "parallel"):
        stage = with_hand(kind, knob, *plates)
        bundle = dict(stage.scene.bundle)
        text = bundle["P1.profile.toml"].decode()
        if kind == "parallel":
            text = text.replace(*profile_palm)
        levels[kind] = effort(Stage(Scene.from_bundle(bundle | {"P1.profile.toml": text.encode()})), "knob").level
    assert levels == {"human": 5, "parallel": 2}


def test_three_fingers_know_their_sides_and_need_something_for_both_fingers() -> None:
    three, two = (with_hand(kind, CUP) for kind in ("three_finger", "parallel"))
    closings = grasps_of(three, "cup").closings.round(6)
    assert {tuple(row) for row in closings + 0.0} == {tuple(row) for row in -closings + 0.0}
    assert {tuple(row) for row in grasps_of(two, "cup").closings.round(6) + 0.0} < {
        tuple(row) for row in closings + 0.0
    }
    marble = Thing("marble", (0.012,), (0.5, 0.2, 1.2), "sphere")
    found = effort(with_hand("three_finger", marble), "marble")
    assert (found.level, found.reason) == (5, "too narrow for both fingers to meet it")
    assert effort(with_hand("parallel", marble), "marble").level == 1


def test_a_stick_is_taken_across_both_fingers() -> None:
    stick = Thing("stick", (0.01, 0.01, 0.1), (0.5, 0.2, 1.2))
    stage = with_hand("three_finger", stick)
    grasps = grasps_of(stage, "stick")
    across = hand_frames(grasps)[:, :, 2]
    assert len(grasps)
    assert (np.abs(across[:, 2]) > 0.99).all()


@pytest.mark.parametrize("kind", HAND_KINDS)
def test_boxes_stand_beside_the_points_and_all_at_once_is_one_by_one(kind: HandKind) -> None:
    stage = with_hand(kind, replace(CUP, yaw=0.7))
    hand = hand_of(stage)
    grasps = sample_grasps(stage, "cup", hand, DEFAULT.grasp)
    centers, frames = hand_centers(grasps, hand), hand_frames(grasps)
    np.testing.assert_allclose(np.linalg.det(frames), 1.0)
    for index in range(0, len(grasps), 37):
        poses = hand_poses(grasps, index, hand)
        np.testing.assert_allclose([pose.position for pose in poses], centers[index])
        for pose, box in zip(poses, hand_boxes(hand), strict=True):
            np.testing.assert_array_equal(pose.matrix, frames[index])
            beside = (pose.position - grasps.centers[index]) @ grasps.closings[index]
            inner_m = abs(beside) - hand.finger_thickness_m / 2
            assert box.side == 0 or inner_m == pytest.approx(grasps.widths_m[index] / 2 + grasps.gaps_m[index])


@pytest.mark.parametrize("kind", HAND_KINDS)
@pytest.mark.parametrize("size", [(0.03, 0.03, 0.05), (0.03, 0.04, 0.09), (0.15, 0.1, 0.004)])
def test_what_is_in_the_object_is_what_measuring_every_pair_finds(
    kind: HandKind, size: tuple[float, float, float]
) -> None:
    stage = with_hand(kind, Thing("cup", size, (0.5, 0.2, 1.2)))
    hand, arm = hand_of(stage), stage.scene.agent("P1").arm("left")
    grasps = sample_grasps(stage, "cup", hand, DEFAULT.grasp)
    (cup,) = stage.scene.object_geoms("cup")
    for index in range(0, len(grasps), 5):
        stage.place(arm.ghosts, hand_centers(grasps, hand)[index], hand_frames(grasps)[index].reshape(9))
        palm_gap_m = stage.distance(int(arm.ghosts[0]), int(cup), limit_m=0.01)
        assert abs(palm_gap_m + 1e-4) < 1e-5 or grasps.in_itself[index] == (palm_gap_m < -1e-4)
