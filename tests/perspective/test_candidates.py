"""Candidates come by increasing amount, and their frames are those of MuJoCo's own kinematics."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from taskgist.perspective import Viewpoint
from taskgist.perspective.candidates import DIGITS, Candidates
from taskgist.settings import DEFAULT
from tests.perspective.random_rooms import random_case
from tools.rooms import COARSE, Person, Room, Thing, chair

SEEDS = range(700, 706)
TARGET = np.array((0.9, -0.4, 0.8))


def batches(here: Viewpoint) -> list[Candidates]:
    return [candidates for level in range(1, 5) for candidates in here.candidates.of_level(level, TARGET)]


def amount(candidates: Candidates, index: int) -> tuple[float, ...]:
    of = candidates[index].amount
    return tuple(round(value, DIGITS) for value in (of.moved_m, of.turned_rad, of.torso_rad))


@pytest.mark.parametrize("seed", SEEDS)
def test_amounts_ascend_and_equal_ones_end_together(seed: int) -> None:
    case = random_case(seed)
    here = Viewpoint(case.stage(), case.scene.agents[0], COARSE)
    for candidates in batches(here):
        amounts = [amount(candidates, index) for index in range(len(candidates))]
        assert amounts == sorted(amounts)
        sizes = [len(list(group)) for _, group in itertools.groupby(amounts)]
        ends = [end for end, size in zip(itertools.accumulate(sizes), sizes, strict=True) for _ in range(size)]
        assert candidates.ends.tolist() == ends


@pytest.mark.parametrize("seed", SEEDS)
def test_frames_are_where_kinematics_brings_them(seed: int) -> None:
    case = random_case(seed)
    stage, rng = case.stage(), np.random.default_rng(seed)
    here = Viewpoint(stage, case.scene.agents[0], COARSE)
    for candidates in batches(here):
        for index in rng.choice(len(candidates), min(5, len(candidates)), replace=False).tolist():
            stage.show(candidates[index].state)
            np.testing.assert_allclose(candidates.frames(index)[0], stage.eye_row(here.agent), atol=1e-9)
            for number, arm in enumerate(here.agent.arms):
                ours, theirs = candidates.shoulder(index, number), stage.shoulder(arm)
                np.testing.assert_allclose(ours.position, theirs.position, atol=1e-9)
                np.testing.assert_allclose(ours.matrix, theirs.matrix, atol=1e-9)


def test_every_place_comes_with_every_bend_once() -> None:
    room = Room((chair(0.0), Thing("cup", (0.03, 0.05), (0.5, 0.2, 1.75), "cylinder")), (Person("P1", (0, 0)),))
    fine = replace(DEFAULT, efforts=replace(DEFAULT.efforts, move_radius_m=0.5))
    here = Viewpoint(room.stage(), "P1", fine)
    for candidates in here.candidates.of_level(4, TARGET):
        pairs = set(zip(candidates.table.spot.tolist(), candidates.table.bend.tolist(), strict=True))
        assert len(pairs) == len(candidates) == len(candidates.table.offsets_m) * len(candidates.torso.poses)
