"""What noise does to recordings, and what it leaves alone."""

from __future__ import annotations

import math

import numpy as np
import pytest

from taskgist.pipeline import label_of
from taskgist.recording import Recording
from taskgist_lab.evaluation.noise import CONDITIONS, SMOOTHING_S, calmed, gapped, mistimed, shaken, thinned
from taskgist_lab.evaluation.values import CLEAN
from tests.lab.evaluation.standing import FRAMES, still


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def positions(recording: Recording) -> np.ndarray:
    """Of all things and people, (frames, bodies, 3)."""
    scene = recording.scene
    poses = [*map(scene.object_slice, scene.objects), *map(scene.base_slice, scene.agents)]
    return np.stack([recording.qpos[:, pose][:, :3] for pose in poses], axis=1)


def angles_rad(recording: Recording) -> np.ndarray:
    """How far each thing is turned from the recording's true orientation, (frames, things)."""
    scene, true = recording.scene, still()
    cosines = [
        np.abs(np.sum(recording.qpos[:, pose][:, 3:] * true.qpos[:, pose][:, 3:], axis=1))
        for pose in map(scene.object_slice, scene.objects)
    ]
    return np.asarray(2 * np.arccos(np.clip(np.stack(cosines, axis=1), 0.0, 1.0)))


def test_no_noise_changes_nothing() -> None:
    true = still()
    label = label_of(true)
    for same in (
        shaken(true, rng(), position_m=0.0, angle_rad=0.0),
        calmed(true, 0.0),
        thinned(true, rng(), share=0.0),
        gapped(true, rng(), gap_s=0.0),
        mistimed(true, rng(), offset_s=0.0),
        CONDITIONS[CLEAN].applied(true, seed=0, number=0),
    ):
        assert same.digest == true.digest
        assert label_of(same) == label


@pytest.mark.parametrize("name", CONDITIONS)
def test_a_condition_is_the_same_for_the_same_seed_and_number(name: str) -> None:
    once, again = (CONDITIONS[name].applied(still(), seed=3, number=4) for _ in range(2))
    assert (once.digest, once.label) == (again.digest, again.label)
    others = [CONDITIONS[name].applied(still(), seed=3, number=number) for number in range(5, 12)]
    same = [(each.digest, each.label) == (once.digest, once.label) for each in others]
    assert all(same) if name == CLEAN else not all(same)


def test_noise_is_as_strong_as_said_and_half_of_it_slow() -> None:
    errors = np.concatenate(
        [
            positions(shaken(still(), rng(seed), position_m=0.03, angle_rad=0.0)) - positions(still())
            for seed in range(30)
        ],
        axis=1,
    )
    assert errors.std() == pytest.approx(0.03, rel=0.05)
    steps = np.diff(errors, axis=0)
    assert steps.std() == pytest.approx(0.03, rel=0.1)  # √2 of the quick half, and hardly any of the slow one


def test_things_turn_as_far_as_said() -> None:
    turned = [angles_rad(shaken(still(), rng(seed), position_m=0.0, angle_rad=math.radians(6))) for seed in range(30)]
    assert math.degrees(np.sqrt(np.mean(np.square(turned)) / 3)) == pytest.approx(6.0, rel=0.05)


def test_joints_stay_within_their_limits() -> None:
    noisy = shaken(still(), rng(), position_m=0.0, angle_rad=math.radians(20))
    model = noisy.scene.model
    moved = 0
    for agent in noisy.scene.agents:
        for index in noisy.scene.joint_indices(agent):
            joint = int(np.flatnonzero(model.jnt_qposadr == index)[0])
            true = still().qpos[0, index]
            if model.jnt_limited[joint]:
                low, high = model.jnt_range[joint]
                assert noisy.qpos[:, index].min() >= min(low, true)
                assert noisy.qpos[:, index].max() <= max(high, true)
            moved += bool((noisy.qpos[:, index] != true).any())
    assert moved > 10


def test_other_joints_of_the_room_stay() -> None:
    noisy = shaken(still(), rng(), position_m=0.03, angle_rad=0.1)
    model = noisy.scene.model
    hinge = model.jnt_qposadr[next(j for j in range(model.njnt) if model.joint(j).name == "hinge")]
    assert (noisy.qpos[:, hinge] == still().qpos[:, hinge]).all()


def test_smoothing_takes_the_quick_half_away() -> None:
    noisy = shaken(still(), rng(), position_m=0.03, angle_rad=0.1)
    calm = calmed(noisy, SMOOTHING_S)
    speeds = [np.abs(np.diff(positions(each), axis=0)).mean() for each in (noisy, calm)]
    assert speeds[1] < speeds[0] / 3
    assert np.abs(positions(calm) - positions(still())).mean() < np.abs(positions(noisy) - positions(still())).mean()
    assert angles_rad(calm).mean() < angles_rad(noisy).mean()


@pytest.mark.parametrize("share", [0.1, 0.3])
def test_so_many_frames_are_lost(share: float) -> None:
    lost = [1 - len(thinned(still(), rng(seed), share=share)) / FRAMES for seed in range(20)]
    assert np.mean(lost) == pytest.approx(share, abs=0.02)
    thin = thinned(still(), rng(), share=share)
    assert (thin.times_s[0], thin.times_s[-1]) == (still().times_s[0], still().times_s[-1])
    known = np.isin(still().times_s, thin.times_s)
    assert (thin.tracked["box"] == still().tracked["box"][known]).all()


def test_a_recording_of_which_all_is_lost_keeps_its_ends() -> None:
    assert thinned(still(), rng(), share=1.0).times_s.tolist() == still().times_s[[0, -1]].tolist()


def test_a_gap_is_one_piece_within_the_label() -> None:
    label = label_of(still())
    for seed in range(10):
        gaps_s = np.diff(gapped(still(), rng(seed), gap_s=1.0).times_s)
        widest = int(gaps_s.argmax())
        assert (gaps_s > 1.5 / 30).sum() == 1
        assert gaps_s[widest] <= 1.0 + 2 / 30
        start_s = gapped(still(), rng(seed), gap_s=1.0).times_s[widest]
        assert label.start_s - 0.5 - 1 / 30 <= start_s <= label.end_s - 0.5


def test_each_end_of_a_label_is_off_within_the_recording() -> None:
    label, offsets = label_of(still()), set()
    for seed in range(20):
        off = label_of(mistimed(still(), rng(seed), offset_s=0.3))
        offsets.add((round(off.start_s - label.start_s, 6), round(off.end_s - label.end_s, 6)))
    assert offsets == {(a, b) for a in (-0.3, 0.3) for b in (-0.3, 0.3)}
    far = label_of(mistimed(still(), rng(2), offset_s=3.0))
    assert 0.0 <= far.start_s < far.end_s <= still().times_s[-1]
