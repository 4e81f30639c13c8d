"""What stands still is equal number by number, however a tracker trembles; what moves is followed at once."""

import math

import numpy as np
import pytest

from taskgist.settings import DEFAULT, Following
from taskgist.world import Stage, State
from taskgist.world.steadied import Steadied
from tools.rooms import Person, Room, Thing

CUP = Thing("cup", (0.03, 0.05), (0.5, 0.1, 1.1), "cylinder")
SCENE = Room((CUP,), (Person("P1", (0.0, 0.0)),), (48, 36)).scene()
NOISE_RAD = math.radians(0.2)


def trembled(state: State, rng: np.random.Generator, time_s: float = 0.0) -> State:
    """A state with half a millimetre and 0.2 degrees of noise on everything."""
    qpos = np.array(state.qpos)
    qpos[SCENE.joint_indices("P1")] += rng.normal(0.0, NOISE_RAD, len(SCENE.joints("P1")))
    for at in (SCENE.base_slice("P1"), SCENE.object_slice("cup")):
        qpos[at][:3] += rng.normal(0.0, 0.0005, 3)
        qpos[at][3:] += rng.normal(0.0, NOISE_RAD / 2, 4)
        qpos[at][3:] /= np.linalg.norm(qpos[at][3:])
    return State(qpos, time_s)


def moved(state: State, by_m: float, part: slice) -> State:
    """Something somewhere else, along x."""
    place = np.array(state.qpos[part])
    place[0] += by_m
    return state.replace(at=part, to=place)


def test_what_trembles_stands_still() -> None:
    rng, steadied = np.random.default_rng(0), Steadied(Stage(SCENE), SCENE.initial)
    states = [steadied.follow(trembled(SCENE.initial, rng, frame / 30)) for frame in range(60)]
    assert all(np.array_equal(state.qpos, SCENE.initial.qpos) for state in states)
    assert [state.time_s for state in states] == [frame / 30 for frame in range(60)]


def test_what_is_off_by_less_everywhere_may_still_have_moved() -> None:
    """Each joint of an arm turns by less than the tolerance, the hand moves by several centimetres."""
    indices = [
        i for n, i in SCENE.agent("P1").joints.items() if (n.startswith("right_") and "shoulder" in n) or "elbow" in n
    ]
    state = SCENE.initial.replace({index: SCENE.initial.qpos[index] + math.radians(0.9) for index in indices})
    steadied = Steadied(Stage(SCENE), SCENE.initial)
    for _ in range(DEFAULT.following.frames * 4):
        found = steadied.follow(state)
    assert not np.array_equal(
        found.qpos[SCENE.agent("P1").arm_positions], SCENE.initial.qpos[SCENE.agent("P1").arm_positions]
    )
    assert np.array_equal(found.qpos[SCENE.object_slice("cup")], SCENE.initial.qpos[SCENE.object_slice("cup")])


@pytest.mark.parametrize("step_m", [0.005, 0.02, 0.04])
def test_what_moves_is_followed(step_m: float) -> None:
    rng, steadied = np.random.default_rng(0), Steadied(Stage(SCENE), SCENE.initial)
    at = SCENE.object_slice("cup")
    most_m = (DEFAULT.following.motion + 1) * DEFAULT.following.place_m + 0.002
    for frame in range(1, 40):
        state = trembled(moved(SCENE.initial, step_m * frame, at), rng)
        found = steadied.follow(state)
        assert abs(found.qpos[at][0] - state.qpos[at][0]) <= most_m
        assert np.array_equal(found.qpos[SCENE.base_slice("P1")], SCENE.initial.qpos[SCENE.base_slice("P1")])
    for _ in range(4 * DEFAULT.following.frames):
        found = steadied.follow(state)
    assert abs(found.qpos[at][0] - state.qpos[at][0]) <= DEFAULT.following.place_m


def test_who_moves_an_arm_stands_still_otherwise() -> None:
    rng, steadied = np.random.default_rng(0), Steadied(Stage(SCENE), SCENE.initial)
    agent = SCENE.agent("P1")
    others = np.setdiff1d(np.arange(SCENE.nq), agent.arm_positions)
    elbow = agent.joints["right_elbow"]
    for frame in range(1, 20):
        state = SCENE.initial.replace({elbow: SCENE.initial.qpos[elbow] + 0.05 * frame})
        found = steadied.follow(trembled(state, rng))
        assert np.array_equal(found.qpos[others], SCENE.initial.qpos[others])
    assert abs(found.qpos[elbow] - state.qpos[elbow]) < 0.1


def test_without_tolerance_every_state_is_taken_as_it_is() -> None:
    rng = np.random.default_rng(0)
    steadied = Steadied(Stage(SCENE), SCENE.initial, Following(place_m=0.0, turn_rad=0.0))
    for _ in range(3):
        state = trembled(SCENE.initial, rng)
        assert steadied.follow(state) is state


def test_of_whom_other_parts_are_tracked_is_taken_as_he_is() -> None:
    rng, steadied = np.random.default_rng(0), Steadied(Stage(SCENE), SCENE.initial)
    state = trembled(SCENE.initial, rng).without(["P1/left_arm"])
    found = steadied.follow(state)
    assert found.untracked == {"P1/left_arm"}
    assert np.array_equal(found.qpos[SCENE.base_slice("P1")], state.qpos[SCENE.base_slice("P1")])
    assert np.array_equal(found.qpos[SCENE.object_slice("cup")], SCENE.initial.qpos[SCENE.object_slice("cup")])
