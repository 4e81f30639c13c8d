from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from taskgist.errors import UnknownNameError
from taskgist.moving.gaze import (
    CLEAR_M,
    COMFORTABLE_PAN_RAD,
    COMFORTABLE_TILT_RAD,
    TURN_S,
    Fixation,
    Onlooker,
    aimed,
    looked,
    subject_place,
)
from taskgist.moving.motion import minimum_jerk
from taskgist.world import Scene, Stage, State
from taskgist_lab.simulator import Room
from taskgist_lab.simulator.room import TABLE, left, on_table, right

Array = NDArray[np.float64]
TIMES = np.arange(0.0, 3.0, 1 / 30)
ONLOOKER = Onlooker("P2", "P1", "P1/right_arm", "cup")


@pytest.fixture(scope="module")
def scene() -> Scene:
    things = (on_table("cup", -0.1, 0.1), on_table("white_box", 0.15, -0.4), on_table("book", 0.2, 0.4))
    return Room("gaze", (left(1.80, 0.67), right(1.66, 0.67)), things, TABLE).scene()


def _frames(scene: Scene, cup: Array) -> Array:
    """Frames in which only the cup moves, through places (n, 3)."""
    frames = np.tile(scene.initial.qpos, (len(cup), 1))
    frames[:, scene.object_slice("cup")][:, :3] = cup
    return frames


def _off_rad(scene: Scene, frame: Array, name: str, angles: Array, subject: str) -> float:
    """Angle between an agent's face and a subject, with its head at some pan and tilt."""
    agent = scene.agent(name)
    turned = State(frame).replace({agent.joints["head_pan"]: angles[0], agent.joints["head_tilt"]: angles[1]})
    stage = Stage(scene, turned)
    eye = stage.eye(agent)
    line = subject_place(stage, subject) - eye.position
    return float(np.arccos(line @ eye.matrix[:, 0] / np.linalg.norm(line)))


@pytest.mark.parametrize("subject", ["P1", "cup", "book"])
def test_an_aimed_head_faces_its_subject(scene: Scene, subject: str) -> None:
    frame = scene.initial.qpos[None]
    place = subject_place(Stage(scene), subject)
    angles = aimed(Stage(scene), scene.agent("P2"), frame, place[None])[0]
    off = _off_rad(scene, frame[0], "P2", angles, subject)
    assert off < 0.01 or angles[1] == pytest.approx(-COMFORTABLE_TILT_RAD)


def test_heads_stay_within_a_comfortable_range(scene: Scene) -> None:
    behind = np.array([[2.0, 1.0, 0.0]])
    angles = aimed(Stage(scene), scene.agent("P2"), scene.initial.qpos[None], behind)[0]
    assert abs(angles[0]) == pytest.approx(COMFORTABLE_PAN_RAD)


def test_heads_turn_smoothly_from_subject_to_subject(scene: Scene) -> None:
    frames = np.tile(scene.initial.qpos, (len(TIMES), 1))
    angles = looked(scene, "P2", TIMES, frames, [Fixation(0.0, "P1"), Fixation(1.0, "book")])
    assert np.ptp(angles[TIMES < 1.0], axis=0) == pytest.approx((0.0, 0.0))
    assert np.ptp(angles[TIMES > 1.0 + TURN_S], axis=0) == pytest.approx((0.0, 0.0))
    steps = np.abs(np.diff(angles, axis=0)).max(axis=0)
    assert steps == pytest.approx(np.ptp(angles, axis=0) * 1.875 / (TURN_S * 30), rel=0.05)


def test_each_fixation_turns_the_head_from_where_the_ones_before_had_it(scene: Scene) -> None:
    """The slow twin: every subject followed through all frames, one turn after the other; turns may overlap."""
    way = np.linspace((-0.1, 0.1, 0.8), (0.1, -0.1, 1.1), len(TIMES))
    frames, stage, agent = _frames(scene, way), Stage(scene), scene.agent("P2")
    fixations = [Fixation(0.0, "P1"), Fixation(0.8, "cup"), Fixation(1.0, "book"), Fixation(2.0, "cup")]
    expected = np.zeros((len(TIMES), 2))
    for number, fixation in enumerate(fixations):
        places = np.array([subject_place(stage.show(State(frame)), fixation.subject) for frame in frames])
        turned = minimum_jerk((TIMES - fixation.from_s) / TURN_S)[:, None] if number else 1.0
        expected = (1.0 - turned) * expected + turned * aimed(stage, agent, frames, places)
    assert looked(scene, "P2", TIMES, frames, fixations) == pytest.approx(expected, abs=1e-12)


def test_faces_things_and_hands_are_subjects(scene: Scene) -> None:
    stage = Stage(scene)
    assert subject_place(stage, "cup") == pytest.approx((-0.1, 0.1, TABLE.height_m + 0.05))
    assert subject_place(stage, "P1")[2] > 1.2
    assert subject_place(stage, "P1/right_arm")[2] < TABLE.height_m
    with pytest.raises(UnknownNameError, match="did you mean 'cup'"):
        subject_place(stage, "cop")


def test_what_moves_in_view_draws_the_eyes(scene: Scene) -> None:
    way = np.linspace((-0.1, 0.1, 0.8), (-0.1, 0.1, 1.2), len(TIMES))
    subjects = [f.subject for f in ONLOOKER.fixations(Stage(scene), TIMES, _frames(scene, way), "P1")]
    assert subjects == ["P1", "cup"]


def test_a_tall_thing_that_is_seen_from_above_is_in_view() -> None:
    """The line to its middle ends at its top, far before the middle."""
    things = (on_table("bottle", 0.2, 0.0), on_table("cup", -0.2, 0.4), on_table("book", 0.2, 0.4))
    near = Room("tall", (left(1.80, 0.67), right(1.80, 0.63, posture="standing")), things, TABLE).scene()
    frames = np.tile(near.initial.qpos, (len(TIMES), 1))
    frames[:, near.object_slice("bottle")][:, 0] += 0.1 * np.sin(2 * TIMES)
    onlooker = Onlooker("P2", "P1", "P1/right_arm", "bottle")
    stage = Stage(near)
    line = subject_place(stage, "bottle") - stage.eye(near.agent("P2")).position
    away = np.linalg.norm(line)
    assert stage.cast(stage.eye(near.agent("P2")).position, (line / away)[None])[1][0] < away - CLEAR_M
    assert [f.subject for f in onlooker.fixations(stage, TIMES, frames, "book")] == ["book", "bottle"]


def test_what_moves_behind_the_box_draws_nobody(scene: Scene) -> None:
    way = np.linspace((-0.05, -0.62, 0.77), (-0.05, -0.55, 0.77), len(TIMES))
    way[:, 1] += 0.08 * np.sin(4 * TIMES)
    subjects = [f.subject for f in ONLOOKER.fixations(Stage(scene), TIMES, _frames(scene, way), "book")]
    assert subjects == ["book"]


def test_what_vanishes_is_left_for_the_face(scene: Scene) -> None:
    way = np.linspace((-0.05, -0.1, 0.77), (-0.05, -0.6, 0.77), len(TIMES))
    fixations = ONLOOKER.fixations(Stage(scene), TIMES, _frames(scene, way), "P1")
    assert [f.subject for f in fixations] == ["P1", "cup", "P1"]
    assert all(a.from_s < b.from_s for a, b in pairwise(fixations))


def test_what_rests_again_in_view_keeps_the_eyes(scene: Scene) -> None:
    way = np.concatenate((np.linspace((-0.1, 0.1, 0.8), (0.0, 0.1, 1.2), 30), np.tile((0.0, 0.1, 1.2), (60, 1))))
    subjects = [f.subject for f in ONLOOKER.fixations(Stage(scene), TIMES, _frames(scene, way), "book")]
    assert subjects == ["book", "cup"]
