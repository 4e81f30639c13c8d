"""Grasps tried many at once are free where measuring every shape of the hand says so."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from taskgist.perspective import Viewpoint
from taskgist.perspective.grasp_sampling import TOUCH_M, Grasps, grasps_in_object
from taskgist.perspective.grasp_trials import GraspTrials
from taskgist.world import Hand, Stage
from tests.perspective.random_rooms import random_case
from tests.perspective.twin_grasp import hand_poses, something_between

MOST = 60
"""Grasps of one object that are measured."""


def trials_of(here: Viewpoint, name: str, hand: Hand) -> tuple[GraspTrials, Grasps]:
    stage = here.stage
    grasps, pose = grasps_in_object(stage, name, hand, here.settings.grasp), stage.body(stage.scene.object_body(name))
    return GraspTrials(stage, here.agent, pose, grasps, hand, here.collisions), grasps.placed(pose)


def measured_free(stage: Stage, here: Viewpoint, grasps: Grasps, index: int, hand: Hand) -> bool:
    poses, arm = hand_poses(grasps, index, hand), here.agent.arms[0]
    stage.place(arm.ghosts, np.array([pose.position for pose in poses]), poses[0].matrix.reshape(9))
    around = np.setdiff1d(np.union1d(here.collisions.obstacles, here.agent.core_geoms), grasps.solids)
    pairs = itertools.product(arm.ghosts.tolist(), around.tolist())
    others = np.setdiff1d(here.collisions.obstacles, grasps.solids)
    return (
        not grasps.in_itself[index]
        and all(-stage.distance(ghost, other, limit_m=0.0) <= TOUCH_M for ghost, other in pairs)
        and not something_between(stage, grasps, index, others)
    )


@pytest.mark.parametrize("seed", range(6))
def test_tried_grasps_are_free_where_measuring_says_so(seed: int) -> None:
    case, rng = random_case(seed), np.random.default_rng(seed)
    stage = Stage(case.scene, case.state)
    for agent in case.scene.agents:
        here = Viewpoint(stage, agent)
        hand = here.agent.profile.hand
        if hand is None:
            continue
        for name in case.scene.objects:
            if not len(grasps_in_object(stage, name, hand, here.settings.grasp)):
                continue
            trials, grasps = trials_of(here, name, hand)
            some = rng.permutation(len(grasps))[:MOST]
            free = [int(index) for index in some if measured_free(stage, here, grasps, int(index), hand)]
            stage.show(case.state)
            assert trials.first_free(some, here.agent.arms[0].ghosts) == (free[0] if free else None)
            assert [
                each for each in some if trials.first_free(np.array([each]), here.agent.arms[0].ghosts) == each
            ] == free
