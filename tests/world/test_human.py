import math

import mujoco
import numpy as np
import pytest

from taskgist.errors import SceneError
from taskgist.settings import DEFAULT
from taskgist.world import HumanSize, Stage, posture_of, with_posture
from tests.scenes import CHAIR, agent, scene

STATURES = (1.2, 1.55, 1.75, 1.95)


@pytest.mark.parametrize("stature", STATURES)
def test_stature_scales_the_body(stature: float) -> None:
    room = scene(agents=agent("P1", 0, 0, extra=f"body = {{ stature_m = {stature} }}"))
    stage = Stage(room)
    eye = stage.eye(room.agent("P1")).position[2]
    assert eye == pytest.approx(0.936 * stature, abs=0.01)  # Winter's eye height
    crown = stage.site(room.model.site("P1/head_top").id).position[2]
    assert crown == pytest.approx(stature, abs=1e-4)


def test_standing_soles_touch_the_floor() -> None:
    room = scene(agents=agent("P1", 0, 0))
    stage = Stage(room)
    foot, floor = room.model.geom("P1/left_foot").id, room.model.geom("floor").id
    assert stage.distance(foot, floor, limit_m=1.0) == pytest.approx(0.0, abs=1e-6)


def test_measured_segments_replace_shares() -> None:
    size = HumanSize.from_stature(1.75, upper_arm_m=0.40)
    assert size.upper_arm_m == 0.40
    assert size.forearm_m == pytest.approx(0.146 * 1.75)


@pytest.mark.parametrize(("stature", "segments"), [(170.0, {}), (1.7, {"forearm_m": 25.0}), (1.7, {"tail_m": 0.3})])
def test_impossible_bodies_are_refused(stature: float, segments: dict[str, float]) -> None:
    with pytest.raises(SceneError, match=r"stature_m|forearm_m|tail_m"):
        HumanSize.from_stature(stature, **segments)


def test_mirrored_body_has_mirrored_landmarks() -> None:
    room = scene(agents=agent("P1", 0, 0))
    stage = Stage(room)
    raised = {"shoulder_flexion": 0.7, "shoulder_abduction": 0.4, "shoulder_rotation": 0.3, "elbow": 0.9}
    more = {
        "forearm_rotation": 0.5,
        "wrist_flexion": 0.4,
        "wrist_deviation": 0.2,
        "hip_flexion": 0.5,
        "hip_abduction": 0.2,
    }
    body = room.agent("P1")
    both = {body.joints[f"{side}_{j}"]: a for side in ("left", "right") for j, a in (raised | more).items()}
    stage.show(room.initial.replace(both))
    for name in ("fingertip", "wrist", "elbow", "thumb", "toe", "palm"):
        left = stage.site(room.model.site(f"P1/left_{name}").id).position
        right = stage.site(room.model.site(f"P1/right_{name}").id).position
        np.testing.assert_allclose(left * (1, -1, 1), right, atol=1e-9)


def test_sitting_is_seen_in_the_thighs_and_standing_up_keeps_the_feet() -> None:
    room = scene(CHAIR, agents=agent("P1", -0.95, 0, posture="sitting"))
    body, stage = room.agent("P1"), Stage(room)
    assert posture_of(stage, body, DEFAULT.contact) == "sitting"
    foot = room.model.body("P1/left_foot").id
    before = stage.body_position(foot)
    stage.show(with_posture(stage, body, "standing"))
    assert posture_of(stage, body, DEFAULT.contact) == "standing"
    np.testing.assert_allclose(stage.body_position(foot), before, atol=1e-6)
    pelvis = stage.body_position(body.root_body)
    assert pelvis[0] + 0.95 == pytest.approx(0.245 * 1.75, abs=0.02)  # by about a thigh forward
    stage.show(with_posture(stage, body, "sitting", seat_height_m=0.45))
    np.testing.assert_allclose(stage.state.qpos, room.initial.qpos, atol=1e-6)


def test_untracked_legs_have_no_posture() -> None:
    room = scene(agents=agent("P1", 0, 0))
    stage = Stage(room)
    hidden = type(room.initial)(room.initial.qpos, 0.0, frozenset({"P1/legs"}))
    assert posture_of(stage.show(hidden), room.agent("P1"), DEFAULT.contact) is None


def test_joint_signs_are_as_documented() -> None:
    room = scene(agents=agent("P1", 0, 0))
    body, stage = room.agent("P1"), Stage(room)

    def moved(joint: str, site: str) -> np.ndarray:
        at = room.model.site(f"P1/{site}").id
        rest = stage.show(room.initial).site(at).position
        return np.asarray(stage.show(room.initial.replace({body.joints[joint]: 0.3})).site(at).position - rest)

    assert moved("head_pan", "nose")[1] > 0
    assert moved("head_tilt", "nose")[2] > 0
    assert moved("torso_lean", "head")[0] > 0
    assert moved("torso_turn", "left_shoulder")[0] < 0
    assert moved("left_shoulder_flexion", "left_wrist")[0] > 0
    assert moved("left_shoulder_abduction", "left_wrist")[1] > 0
    assert moved("right_shoulder_abduction", "right_wrist")[1] < 0
    assert moved("right_elbow", "right_wrist")[0] > 0
    assert moved("left_knee", "left_ankle")[0] < 0
    assert moved("right_hip_flexion", "right_knee")[0] > 0


def test_kinematics_alone_equal_a_full_forward_pass() -> None:
    room = scene(CHAIR, agents=agent("P1", -0.95, 0, posture="sitting"))
    stage, data = Stage(room), mujoco.MjData(room.model)
    data.qpos[:] = room.initial.qpos
    mujoco.mj_forward(room.model, data)
    rays = np.array([[math.cos(a), math.sin(a), -0.3] for a in np.linspace(0, 6, 200)]) / math.hypot(1, 0.3)
    geoms, distances = stage.cast((0.5, 0.2, 1.0), rays)
    for ray, geom, distance in zip(rays, geoms, distances, strict=True):
        hit = np.zeros(1, np.int32)
        expected = mujoco.mj_ray(room.model, data, np.array([0.5, 0.2, 1.0]), ray, None, 1, -1, hit)
        assert (geom, distance) == (hit[0], pytest.approx(expected))


def test_standing_up_on_a_platform_stays_on_it() -> None:
    room = scene(CHAIR, agents=agent("P1", -0.95, 0, posture="sitting"))
    body, stage = room.agent("P1"), Stage(room)
    base = np.array(room.initial.qpos[body.base])
    base[2] += 0.3
    stage.show(room.initial.replace(at=body.base, to=base))
    foot = room.model.body("P1/left_foot").id
    before = stage.body_position(foot)
    stage.show(with_posture(stage, body, "standing"))
    np.testing.assert_allclose(stage.body_position(foot), before, atol=1e-6)
