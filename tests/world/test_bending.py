"""Bending and crouching: feet stay, the body balances, joints stay within their ranges, and people get to the floor."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest

from taskgist.settings import DEFAULT
from taskgist.world import Stage
from taskgist.world.bending import BALANCED_M, bent, legs_of
from tests.bodies import needs, room, standing

LEGGED = [pytest.param(name, marks=needs(name)) for name in ("human", "hrp2", "talos")]
BENDS = [*DEFAULT.efforts.bends, (0.0, 0.0), (0.05, 0.3)]


def stage_of(profile: str, yaw_deg: float = 0.0) -> Stage:
    return Stage(room(standing("A", profile, 0.3, -0.2, yaw_deg)))


def feet(stage: Stage) -> np.ndarray:
    """Poses of what the ankles carry."""
    agent, model = stage.scene.agent("A"), stage.scene.model
    bodies = [int(model.joint(f"A/{name}").bodyid[0]) for name in agent.profile.legs.ankles]
    return np.concatenate([(*stage.body(body).position, *stage.body(body).matrix.ravel()) for body in bodies])


def hips_m(stage: Stage) -> float:
    """Height of the hips."""
    names = stage.scene.agent("A").profile.legs.hips
    return float(np.mean([stage.screw(int(stage.scene.model.joint(f"A/{name}").id))[0][2] for name in names]))


@pytest.mark.parametrize("profile", LEGGED)
@pytest.mark.parametrize("yaw_deg", [0.0, 130.0])
def test_feet_stay_and_the_body_balances(profile: str, yaw_deg: float) -> None:
    stage = stage_of(profile, yaw_deg)
    agent, start = stage.scene.agent("A"), stage.state
    before, height, center = feet(stage), hips_m(stage), stage.center_of_mass(agent.bodies)
    ahead = np.array([math.cos(math.radians(yaw_deg)), math.sin(math.radians(yaw_deg)), 0.0])
    done = 0
    legs = legs_of(stage, agent)
    for share, pitch_rad in BENDS:
        state = bent(stage, agent, start, legs, lowered_m=share * agent.stature_m, pitch_rad=pitch_rad)
        if state is None:
            continue
        done += 1
        np.testing.assert_allclose(feet(stage.show(state)), before, atol=1e-6)
        off = stage.center_of_mass(agent.bodies) - center
        assert abs(off @ ahead) <= BALANCED_M
        assert height - hips_m(stage) >= share * agent.stature_m - 1e-6
        model = stage.scene.model
        for joint, index in agent.joints.items():
            low, high = model.joint(f"A/{joint}").range
            if model.joint(f"A/{joint}").limited[0]:
                assert min(low, start.qpos[index]) - 1e-6 <= state.qpos[index] <= max(high, start.qpos[index]) + 1e-6
    assert done >= 5


def test_the_center_of_mass_is_that_of_mujoco() -> None:
    stage = stage_of("human")
    model, data = stage.scene.model, mujoco.MjData(stage.scene.model)
    data.qpos[:] = stage.state.qpos
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    agent = stage.scene.agent("A")
    np.testing.assert_allclose(stage.center_of_mass(agent.bodies), data.subtree_com[agent.root_body], atol=1e-9)


def test_straight_legs_alone_fall_over_so_that_hips_go_back() -> None:
    stage = stage_of("human")
    agent, start = stage.scene.agent("A"), stage.state
    state = bent(stage, agent, stage.state, legs_of(stage, agent), lowered_m=0.0, pitch_rad=math.radians(60))
    assert state is not None
    assert start.qpos[agent.base][0] - state.qpos[agent.base][0] > 0.1


@pytest.mark.parametrize("stature_m", [1.55, 1.75, 1.95])
def test_the_bends_come_down_to_the_floor_step_by_step(stature_m: float) -> None:
    """With the lean of the torso: the lowest point that an arm's length below the shoulder is."""
    stage = Stage(room(standing("A", "human") + f"body = {{ stature_m = {stature_m} }}\n"))
    agent, start = stage.scene.agent("A"), stage.state
    lean, arm = agent.joints["torso_lean"], agent.arms[0]
    lowest, legs = [], legs_of(stage, agent)
    for share, pitch_rad in ((0.0, 0.0), *DEFAULT.efforts.bends):
        state = bent(stage, agent, start, legs, lowered_m=share * stature_m, pitch_rad=pitch_rad)
        assert state is not None, "people do all of them"
        leaned = stage.show(state.replace({lean: math.radians(60)}))
        lowest.append(float(leaned.shoulder(arm).position[2]) - arm.profile.length_m)
    reached = sorted(lowest, reverse=True)
    assert reached[-1] < 0.0
    above = [height for height in reached if height > 0] + [0.0]
    assert max(np.diff(above) * -1) < 0.2


def test_who_has_no_legs_does_not_bend() -> None:
    stage = stage_of("jido")
    assert legs_of(stage, stage.scene.agent("A")) == []
