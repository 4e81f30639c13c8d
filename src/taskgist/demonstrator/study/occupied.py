"""Onlookers who are occupied: what moves draws their eyes, but then they return to what they were busy with."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from taskgist.demonstrator.gaze import TURN_S, aimed, subject_places
from taskgist.demonstrator.motion import minimum_jerk
from taskgist.demonstrator.studies import Demonstration
from taskgist.recording import Recording

Array = NDArray[np.float64]

LINGERING_S = 0.5
"""How long the eyes stay with what has come to rest."""


@dataclass(frozen=True)
class Occupied(Demonstration):
    """A demonstration whose target agent is busy with something else.

    Attributes:
        busy_with: What it looks at again when the thing lies still, as a subject of ``gaze``.
    """

    busy_with: str

    def record(self, seed: int, *, distance_m: float = 0.0, angle_rad: float = 0.0) -> Recording:
        """Play and record it; the target agent looks away in the end.

        Args:
            seed: Seed of all variation.
            distance_m: How far people and things are displaced at most, in x and y.
            angle_rad: How far they are turned at most.

        Raises:
            SceneError: The displaced arrangement leaves no way to do it.
            UnknownNameError: There is nothing to be busy with of that name.
        """
        return _looking_back(super().record(seed, distance_m=distance_m, angle_rad=angle_rad), self.busy_with)


def _looking_back(recording: Recording, subject: str) -> Recording:
    """The recording in which the target agent turns its head to a subject after the thing has come to rest."""
    label, scene = recording.label, recording.scene
    assert label is not None
    profile, joints = scene.agent(label.target_agent).profile, scene.agent(label.target_agent).joints
    assert profile.pan is not None
    assert profile.tilt is not None
    columns = [joints[profile.pan.joint], joints[profile.tilt.joint]]
    frames = np.array(recording.qpos)
    wanted = aimed(scene, scene.agent(label.target_agent), frames, subject_places(scene, frames, subject))
    since_s = recording.times_s - _at_rest_s(recording, label.target_object) - LINGERING_S
    turned = minimum_jerk(since_s / TURN_S)[:, None]
    frames[:, columns] = (1.0 - turned) * frames[:, columns] + turned * wanted
    return replace(recording, qpos=frames)


def _at_rest_s(recording: Recording, thing: str) -> float:
    """When a thing has moved for the last time."""
    poses = recording.qpos[:, recording.scene.object_slice(thing)]
    moving = np.flatnonzero(np.abs(np.diff(poses, axis=0)).max(axis=1) > 0.0)
    return float(recording.times_s[moving[-1] + 1])
