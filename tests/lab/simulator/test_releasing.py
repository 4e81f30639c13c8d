"""Dropping, throwing, tapping and holding from the beginning, in one small room."""

import math
from dataclasses import dataclass

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from taskgist.errors import SceneError
from taskgist.moving import HoldUp, Take, Withdraw
from taskgist.moving.steps import Held
from taskgist.recording import Recording
from taskgist.world import Scene, Stage, hand_gap_m
from taskgist.world.dynamics import GRAVITY_M_S2
from taskgist.world.geometry.transforms import about_z, multiply, normalized
from taskgist_lab.simulator import Person, Room, Script, Step, Table, Thing, demonstrate
from taskgist_lab.simulator.throwing import LetFall, Swing, Tap, Throw, velocities, velocity_to

TABLE = Table("table")
GOAL = (1.3, -0.5, 0.0)
ROLLING = (0.5, 0.0003, 0.0003)


@dataclass(frozen=True)
class Ball(Thing):
    def add_shapes(self, body: mujoco.MjsBody) -> None:
        size = (self.size_m[0] / 2, 0.0, 0.0)
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=size, friction=ROLLING, condim=6, priority=1)


@pytest.fixture(scope="module")
def room() -> Scene:
    people = (
        Person("P1", 1.8, (-0.60, 0.0), 0.0, "standing"),
        Person("P2", 1.7, (1.1, 0.6), math.pi, "standing"),
    )
    things = (Thing("cube", (0.07, 0.07, 0.07), (-0.2, -0.1, 0.72)), Ball("ball", (0.08, 0.08), (-0.15, 0.2, 0.72)))
    return Room("room", people, things, TABLE).scene()


def played(room: Scene, thing: str, *steps: Step) -> Recording:
    return demonstrate(Script("task", "P1", "P2", thing, steps, means="test"), room, seed=1)


@pytest.fixture(scope="module")
def dropped(room: Scene) -> Recording:
    return played(
        room, "cube", Take("cube", "right"), HoldUp((-0.15, -0.25, 1.35), 0.3), LetFall(dropped=True), Withdraw()
    )


@pytest.fixture(scope="module")
def thrown(room: Scene) -> Recording:
    return played(room, "cube", Take("cube", "right"), Throw(GOAL, 0.6), Withdraw())


@pytest.fixture(scope="module")
def tapped(room: Scene) -> Recording:
    return played(room, "ball", Tap("ball", "left", 0.8), Withdraw())


def places(recording: Recording) -> np.ndarray:
    assert recording.label is not None
    return recording.qpos[:, recording.scene.object_slice(recording.label.target_object)][:, :3]


def end_index(recording: Recording) -> int:
    assert recording.label is not None
    return int(np.searchsorted(recording.times_s, recording.label.end_s))


def in_flight(recording: Recording) -> slice:
    """Frames around the end of the label in which nothing but gravity acts."""
    return slice(end_index(recording) - 4, end_index(recording) + 3)


@pytest.mark.parametrize("which", ["dropped", "thrown"])
def test_in_the_air_only_gravity_acts(which: str, request: pytest.FixtureRequest) -> None:
    recording = request.getfixturevalue(which)
    flying = places(recording)[in_flight(recording)]
    step_s = recording.times_s[1] - recording.times_s[0]
    accelerations = np.diff(flying, 2, axis=0) / step_s**2
    assert accelerations == pytest.approx(np.tile((0.0, 0.0, -GRAVITY_M_S2), (len(accelerations), 1)), abs=0.05)


def test_what_is_dropped_falls_from_where_it_was_held_and_comes_to_rest(dropped: Recording) -> None:
    cube = places(dropped)
    assert cube[:, 2].max() == pytest.approx(1.35, abs=0.01)
    assert cube[end_index(dropped), 2] < 1.30
    assert cube[-1, 2] == pytest.approx(0.72 + 0.035, abs=0.002)
    assert np.linalg.norm(cube[-1, :2] - (-0.15, -0.25)) < 0.12
    assert dropped.label is not None
    assert "still moves" in str(dropped.label.how)


def test_a_throw_comes_down_near_its_goal(thrown: Recording) -> None:
    cube = places(thrown)
    landed = int(np.flatnonzero(cube[:, 2] < 0.10)[0])
    assert np.linalg.norm(cube[landed, :2] - GOAL[:2]) < 0.15


def test_a_thing_leaves_the_hand_with_the_hands_velocity(thrown: Recording) -> None:
    steps = np.diff(places(thrown), axis=0) * 30.0
    until = end_index(thrown)
    assert np.linalg.norm(np.diff(steps[:until], axis=0), axis=1).max() < 1.5  # m/s from frame to frame
    assert np.linalg.norm(steps[until]) > 1.5


def test_a_ball_lies_still_until_the_hand_meets_it_and_then_rolls_ahead_of_it(tapped: Recording) -> None:
    ball, scene = places(tapped), tapped.scene
    moving = int(np.flatnonzero(np.linalg.norm(np.diff(ball, axis=0), axis=1) > 1e-4)[0])
    stage, arm = Stage(scene), scene.agent("P1").arm("left")
    gaps = [
        hand_gap_m(stage.show(tapped.state(index)), arm, "ball", limit_m=0.2) for index in range(moving, len(tapped))
    ]
    assert gaps[0] < 0.03
    assert min(gaps) > -0.01
    assert gaps[end_index(tapped) - moving] > gaps[0]


def test_a_tap_ends_while_the_ball_rolls_on_the_table(tapped: Recording) -> None:
    ball, end = places(tapped), end_index(tapped)
    assert np.linalg.norm(ball[end + 1] - ball[end]) * 30.0 > 0.15
    assert ball[end, 2] == pytest.approx(0.72 + 0.04, abs=0.002)


def test_nothing_goes_through_the_table(dropped: Recording, tapped: Recording) -> None:
    for recording, thing in ((dropped, "cube"), (tapped, "ball")):
        scene, stage = recording.scene, Stage(recording.scene)
        for index in range(0, len(recording), 2):
            stage.show(recording.state(index))
            own, table = scene.solid_geoms_of(thing), scene.solid_geoms_of("table")
            assert stage.closest(own, table, limit_m=0.1)[0] > -0.004


def test_who_holds_something_from_the_beginning_holds_it(room: Scene) -> None:
    held = played(room, "cube", Held("cube", "right", (-0.25, -0.15, 1.25)), HoldUp((0.0, -0.1, 1.3), 0.5))
    cube = places(held)
    assert cube[0] == pytest.approx((-0.25, -0.15, 1.25), abs=0.01)
    stage, arm = Stage(room), room.agent("P1").arm("right")
    gaps = [hand_gap_m(stage.show(held.state(i)), arm, "cube", limit_m=0.1) for i in range(0, len(held), 5)]
    assert max(gaps) < 0.02


def test_a_hand_that_held_something_at_first_returns_to_rest(room: Scene) -> None:
    hold, fall = Held("cube", "right", (-0.25, -0.15, 1.35)), LetFall(dropped=False)
    recording = played(room, "cube", hold, HoldUp((-0.15, -0.2, 1.3), 0.0), fall, Withdraw())
    columns = room.joint_indices("P1")
    arm = [index for index, joint in zip(columns, room.joints("P1"), strict=True) if joint.startswith("right_")]
    assert recording.qpos[-1, arm] == pytest.approx(room.initial.qpos[arm], abs=1e-6)
    assert np.abs(recording.qpos[0, arm] - room.initial.qpos[arm]).max() > 0.3


def test_too_low_a_drop_is_refused(room: Scene) -> None:
    with pytest.raises(SceneError, match=r"in the air for less than 0.3 s .*let it go from higher up"):
        played(room, "cube", Take("cube", "right"), HoldUp((-0.15, -0.25, 0.95), 0.0), LetFall(dropped=True))


def test_what_lies_fast_cannot_be_tapped(room: Scene) -> None:
    with pytest.raises(SceneError, match=r"cube: it moves on for less than 0.3 s .*tap it faster"):
        played(room, "cube", Tap("cube", "right", 0.8))


def test_who_holds_nothing_lets_nothing_fall(room: Scene) -> None:
    with pytest.raises(SceneError, match="nothing has been taken"):
        played(room, "cube", LetFall(dropped=True))


VECTORS = st.tuples(*[st.floats(-3.0, 3.0)] * 3).map(np.array)


@given(VECTORS, VECTORS, st.floats(-1.0, 1.0))
def test_velocities_are_those_that_make_the_difference(linear: np.ndarray, turn: np.ndarray, yaw_rad: float) -> None:
    seconds, angle = 0.01, float(np.linalg.norm(turn)) * 0.01
    before = np.concatenate((linear, multiply(about_z(yaw_rad), normalized((0.8, 0.2, -0.3, 0.4)))))
    axis = turn / max(float(np.linalg.norm(turn)), 1e-12)
    quaternion = np.concatenate(([math.cos(angle / 2)], math.sin(angle / 2) * axis))
    after = np.concatenate((before[:3] + seconds * linear, -multiply(quaternion, before[3:])))
    found_linear, found_angular = velocities(before, after, seconds)
    assert found_linear == pytest.approx(linear, abs=1e-9)
    assert found_angular == pytest.approx(turn, abs=1e-6)


GOALS = st.tuples(st.floats(0.8, 2.5), st.floats(-2.0, 2.0), st.floats(0.0, 0.8)).map(np.array)


@given(GOALS, st.floats(0.45, 0.9), st.sampled_from(["left", "right"]))
def test_a_swing_sends_things_to_the_goal(goal: np.ndarray, flight_s: float, side: str) -> None:
    swing = Swing.to(goal, flight_s=flight_s, shoulder=np.array((0.0, 0.2, 1.4)), radius_m=0.5, side=side)
    released = swing.hand(0.0).palm
    velocity = swing.speed_m_s * normalized(swing.hand(1e-4).palm - swing.hand(-1e-4).palm)
    comes_to = released + flight_s * velocity - np.array((0.0, 0.0, GRAVITY_M_S2 / 2)) * flight_s**2
    assert comes_to == pytest.approx(goal, abs=0.03)
    assert velocity == pytest.approx(velocity_to(released, goal, flight_s), abs=0.05)
