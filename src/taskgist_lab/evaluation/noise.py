"""What trackers and operators do to recordings: shaking and drifting poses, lost frames, labels that are off.

Each takes a recording and a random generator and gives the recording that a worse tracker, or a hastier operator,
would have delivered. With an amount of zero nothing changes.

**Tracker noise.** The data sheet of a tracker tells a standard deviation per frame. Half of the variance of *noise* is
independent from frame to frame, as the data sheet means it; the other half drifts (a first-order Gauss-Markov process
with a time constant of 2 s), for bias of calibration and occlusion is slow, and no filter removes it. *White* noise is
independent alone, *drift* is slow alone. Things and the pelvis of each person shift by ``position_m`` in each axis and
turn by ``angle_rad`` about each; every joint of a person is off by ``angle_rad``: 3 cm at the end of a segment of 30 cm
are 6 degrees. Joints stay within their limits, as every fit keeps them.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from taskgist.common.arrays import Array, Mask
from taskgist.importing.table_values import Track, smoothed
from taskgist.pipeline.explain import label_of
from taskgist.recording.recording import Recording
from taskgist.world.geometry.transforms import multiply, wxyz_from_rotation_vector
from taskgist.world.scene import Scene
from taskgist_lab.evaluation.values import CLEAN

DRIFT_S = 2.0
"""Time constant of the slow part of the noise."""
WHITE, HALF, DRIFT = 0.0, 0.5, 1.0
"""Shares of the variance that are slow."""


def shaken(
    recording: Recording, rng: np.random.Generator, *, position_m: float, angle_rad: float, slow: float = HALF
) -> Recording:
    """The recording as a noisy tracker would have made it.

    Args:
        recording: A recording.
        rng: Random generator.
        position_m: Standard deviation of positions along each axis.
        angle_rad: Standard deviation of orientations about each axis, and of joint angles.
        slow: Share of the variance that drifts; the rest is independent from frame to frame.
    """
    scene, qpos = recording.scene, np.array(recording.qpos)
    for pose in _poses(scene):
        error = _errors(recording.times_s, 6, rng, slow)
        qpos[:, pose.start : pose.start + 3] += position_m * error[:, :3]
        turn = wxyz_from_rotation_vector(angle_rad * error[:, 3:])
        qpos[:, pose.start + 3 : pose.stop] = multiply(turn, qpos[:, pose.start + 3 : pose.stop])
    for agent in scene.agents:
        joints = scene.joint_indices(agent)
        qpos[:, joints] += angle_rad * _errors(recording.times_s, len(joints), rng, slow)
    return replace(recording, qpos=_within_limits(scene, qpos, recording.qpos))


def calmed(recording: Recording, window_s: float) -> Recording:
    """The recording smoothed as the importer smooths the tables of noisy trackers."""
    scene, times_s, qpos = recording.scene, recording.times_s, np.array(recording.qpos)
    for pose in _poses(scene):
        place, turn = slice(pose.start, pose.start + 3), slice(pose.start + 3, pose.stop)
        track = _smoothed(times_s, qpos[:, place], qpos[:, turn], window_s)
        assert track.wxyz is not None
        qpos[:, place], qpos[:, turn] = track.position_m, track.wxyz
    for agent in scene.agents:
        joints = scene.joint_indices(agent)
        qpos[:, joints] = _smoothed(times_s, qpos[:, joints], None, window_s).position_m
    return replace(recording, qpos=qpos)


def thinned(recording: Recording, rng: np.random.Generator, *, share: float) -> Recording:
    """The recording without a share of its frames, lost independently; the first and the last one are there."""
    kept = rng.random(len(recording)) >= share
    return _with_frames(recording, kept)


def gapped(recording: Recording, rng: np.random.Generator, *, gap_s: float) -> Recording:
    """The recording without the frames of one stretch whose middle is anywhere within the label, its ends included."""
    label = label_of(recording)
    start_s = rng.uniform(label.start_s, label.end_s) - gap_s / 2
    within = (recording.times_s >= start_s) & (recording.times_s < start_s + gap_s)
    return _with_frames(recording, ~within)


def mistimed(recording: Recording, rng: np.random.Generator, *, offset_s: float) -> Recording:
    """The recording with each end of its label so much too early or too late, within what was recorded."""
    label = label_of(recording)
    first_s, last_s = float(recording.times_s[0]), float(recording.times_s[-1])
    start_s, end_s = (
        float(np.clip(time_s + offset_s * rng.choice((-1, 1)), first_s, last_s))
        for time_s in (label.start_s, label.end_s)
    )
    return recording.with_label(replace(label, start_s=start_s, end_s=end_s))


def _poses(scene: Scene) -> list[slice]:
    """Where the poses (7) of things and of people's roots are."""
    return [*map(scene.object_slice, scene.objects), *map(scene.base_slice, scene.agents)]


def _errors(times_s: Array, count: int, rng: np.random.Generator, slow_share: float) -> Array:
    """Errors of unit variance, a share of it slow, (n, count)."""
    quick, steps = rng.standard_normal((2, len(times_s), count))
    remembered = np.exp(-np.diff(times_s) / DRIFT_S)
    slow = np.empty_like(steps)
    slow[0] = steps[0]
    for i, share in enumerate(remembered, start=1):
        slow[i] = share * slow[i - 1] + np.sqrt(1.0 - share**2) * steps[i]
    return np.asarray(np.sqrt(1.0 - slow_share) * quick + np.sqrt(slow_share) * slow)


def _smoothed(times_s: Array, values: Array, wxyz: Array | None, window_s: float) -> Track:
    """Columns of any kind, and orientations, smoothed; what is further apart than the window has no say."""
    return smoothed(Track(times_s, values, wxyz, np.ones(3), ""), window_s, max_gap_s=window_s)


def _within_limits(scene: Scene, qpos: Array, true_qpos: Array) -> Array:
    """Joint angles within their limits, or no further outside than they truly are."""
    model = scene.model
    scalar = {int(address): joint for joint, address in enumerate(model.jnt_qposadr) if model.jnt_limited[joint]}
    for agent in scene.agents:
        for index in scene.joint_indices(agent):
            if (joint := scalar.get(int(index))) is not None:
                low, high = model.jnt_range[joint]
                true = true_qpos[:, index]
                qpos[:, index] = np.clip(qpos[:, index], np.minimum(low, true), np.maximum(high, true))
    return qpos


def _with_frames(recording: Recording, kept: Mask) -> Recording:
    """The recording of some frames, its first and last among them."""
    kept = kept.copy()
    kept[[0, -1]] = True
    return replace(
        recording,
        times_s=recording.times_s[kept],
        qpos=recording.qpos[kept],
        tracked={name: flags[kept] for name, flags in recording.tracked.items()},
        signals={name: replace(each, values=each.values[kept]) for name, each in recording.signals.items()},
    )


# --- Conditions under which demonstrations are watched: a name, what it means, and what it does to a recording.

SMOOTHING_S = 0.5
"""Window of the smoothing conditions: what removes most of the shaking and still keeps a hand's motion."""
GAP_S = 1.0
OFFSETS_S = {"label-off": 0.3, "label-off-1s": 1.0}


@dataclass(frozen=True)
class Condition:
    """A way in which recordings are worse than they could be.

    Args:
        name: Its name.
        text: What it means, in a few words.
        spoil: What it does to a recording.
    """

    name: str
    text: str
    spoil: Callable[[Recording, np.random.Generator], Recording]

    def applied(self, recording: Recording, *, seed: int, number: int) -> Recording:
        """The recording under this condition; the same for the same task, seed and number."""
        task = recording.label.task if recording.label else ""
        return self.spoil(recording, np.random.default_rng([seed, number, *_words(task), *_words(self.name)]))


def _shaken(
    position_m: float, angle_deg: float, *, slow: float = HALF, smoothing_s: float = 0.0
) -> Callable[..., Recording]:
    def spoil(recording: Recording, rng: np.random.Generator) -> Recording:
        noisy = shaken(recording, rng, position_m=position_m, angle_rad=math.radians(angle_deg), slow=slow)
        return calmed(noisy, smoothing_s)

    return spoil


def _mistimed(offset_s: float) -> Callable[..., Recording]:
    return lambda recording, rng: mistimed(recording, rng, offset_s=offset_s)


def _all() -> tuple[Condition, ...]:
    smoothing = f"smoothed over {SMOOTHING_S:g} s"
    return (
        Condition(CLEAN, "as demonstrated", lambda recording, _: recording),
        Condition("noise-1cm", "tracker noise of 1 cm and 2°", _shaken(0.01, 2.0)),
        Condition("noise-3cm", "tracker noise of 3 cm and 6°", _shaken(0.03, 6.0)),
        Condition("noise-1cm-smoothed", f"1 cm and 2°, {smoothing}", _shaken(0.01, 2.0, smoothing_s=SMOOTHING_S)),
        Condition("noise-3cm-smoothed", f"3 cm and 6°, {smoothing}", _shaken(0.03, 6.0, smoothing_s=SMOOTHING_S)),
        Condition("white-1cm", "white noise of 1 cm and 2°", _shaken(0.01, 2.0, slow=WHITE)),
        Condition("white-3cm", "white noise of 3 cm and 6°", _shaken(0.03, 6.0, slow=WHITE)),
        Condition("drift-1cm", "slow noise of 1 cm and 2°", _shaken(0.01, 2.0, slow=DRIFT)),
        Condition("drift-3cm", "slow noise of 3 cm and 6°", _shaken(0.03, 6.0, slow=DRIFT)),
        Condition("lost-10", "10 % of the frames lost", lambda recording, rng: thinned(recording, rng, share=0.10)),
        Condition("lost-30", "30 % of the frames lost", lambda recording, rng: thinned(recording, rng, share=0.30)),
        Condition("gap", f"{GAP_S:g} s lost in one piece", lambda recording, rng: gapped(recording, rng, gap_s=GAP_S)),
        *(
            Condition(name, f"label ends off by ±{offset_s:g} s, within what was recorded", _mistimed(offset_s))
            for name, offset_s in OFFSETS_S.items()
        ),
    )


CONDITIONS: Mapping[str, Condition] = MappingProxyType({each.name: each for each in _all()})
"""All conditions by name, the clean one first."""


def _words(text: str) -> tuple[int]:
    return (zlib.crc32(text.encode()),)
