"""What every recorded demonstration must be: smooth, within limits, and through nothing."""

from __future__ import annotations

import numpy as np

from taskgist.recording import Recording
from taskgist.world import Stage

RATE_HZ = 30.0
SLOWEST_RAD_S = 8.0  # peak joint speeds of unhurried people stay below
JERKIEST_RAD_S2 = 150.0
OVERLAP_M = 0.01


def assert_smooth(recording: Recording) -> None:
    """Joints move within their limits and without jerks."""
    scene = recording.scene
    for agent in scene.agents:
        ranges = np.array([scene.model.joint(f"{agent}/{joint}").range for joint in scene.joints(agent)])
        angles = recording.qpos[:, scene.joint_indices(agent)]
        assert np.all(angles > ranges[:, 0] - 0.01)
        assert np.all(angles < ranges[:, 1] + 0.01)
        assert np.abs(np.diff(angles, axis=0)).max() * RATE_HZ < SLOWEST_RAD_S
        assert np.abs(np.diff(angles, 2, axis=0)).max() * RATE_HZ**2 < JERKIEST_RAD_S2


def assert_through_nothing(recording: Recording) -> None:
    """The performer's body, and what it carries, do not pass through what is around."""
    scene, label = recording.scene, recording.label
    assert label is not None
    stage, performer = Stage(scene), scene.agent(label.performing_agent)
    own = {performer.name, label.target_object}
    around = [g for g in stage.solid_geoms() if scene.owners[g] not in own]
    far = [g for g in around if scene.owners[g] not in (f"chair_{performer.name}", "floor")]
    arms = np.concatenate([arm.geoms for arm in performer.arms])
    for index in range(0, len(recording), 6):
        stage.show(recording.state(index))
        assert stage.closest(arms, around, limit_m=0.1)[0] > -OVERLAP_M
        assert stage.closest(performer.core_geoms, far, limit_m=0.1)[0] > -OVERLAP_M
        assert stage.closest(scene.geoms_of(label.target_object), around, limit_m=0.1)[0] > -0.001
