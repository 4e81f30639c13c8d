"""Turning, stacking, pouring, inspecting, tidying: each way plays, and its own check tells when it fails."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from taskgist.errors import SceneError
from taskgist.recording import Recording
from taskgist.world.geometry.transforms import about_z, multiply
from taskgist_lab.evaluation.pool import JUDGING_ONLY, NEUTRAL, SOURCES, UNFAMILIAR
from taskgist_lab.generator import TASKS, WAYS, simulate
from taskgist_lab.generator.intentions import CHECKS
from taskgist_lab.generator.outcomes import check_motion
from tests.moving.motions import assert_smooth

HANDLING = ("turn", "stack", "pour", "inspect", "tidy")
MEANS = [(task, way.name) for task in HANDLING for way in WAYS[task]]
SEED, NUMBERS = 32, {("tidy", "side-by-side"): 1}
"""Demonstrations for which the first room will do; 0 where nothing is said."""
ALOFT = ("pour", "inspect")
"""In which it is what happens in the air that counts, and it is set down where it stood."""


@cache
def played(task: str, means: str) -> Recording:
    return simulate(task, seed=SEED, number=NUMBERS.get((task, means), 0), means=means)


def check_of(task: str, means: str) -> Callable[[Recording], None]:
    return next(way.check for way in WAYS[task] if way.name == means)


def in_the_end(recording: Recording, change: Callable[[np.ndarray], np.ndarray]) -> Recording:
    """The recording, but the pose (7) of the thing is another one from half a second before the label's end on."""
    assert recording.label is not None
    late = np.flatnonzero(recording.times_s >= recording.label.end_s - 0.5)
    column = recording.scene.object_slice(recording.label.target_object)
    qpos = np.array(recording.qpos)
    qpos[late, column] = change(qpos[late[0], column])
    return replace(recording, qpos=qpos)


@pytest.mark.parametrize(("task", "means"), MEANS)
def test_what_is_played_is_sound_and_becomes_what_it_is_called(task: str, means: str) -> None:
    recording = played(task, means)
    assert recording.label is not None
    assert recording.label.task == task
    assert_smooth(recording)
    check_motion(recording)
    check_of(task, means)(recording)


@pytest.mark.parametrize(("task", "means"), MEANS)
def test_who_has_not_done_it_yet_has_not_done_it(task: str, means: str) -> None:
    recording = played(task, means)
    assert recording.label is not None
    early = replace(recording.label, end_s=recording.label.start_s + 0.3)
    with pytest.raises(SceneError, match=f"{recording.label.target_object!r} (is|does)"):
        check_of(task, means)(recording.with_label(early))


@pytest.mark.parametrize(("task", "means"), MEANS)
def test_what_ends_in_the_air_is_not_set_down(task: str, means: str) -> None:
    lifted = in_the_end(played(task, means), lambda pose: pose + (0.0, 0.0, 0.3, 0.0, 0.0, 0.0, 0.0))
    with pytest.raises(SceneError, match=r"would fall|stand where it stood|not tidied|come to stand"):
        check_of(task, means)(lifted)


@pytest.mark.parametrize(("task", "means"), [each for each in MEANS if each[0] in (*ALOFT, "turn")])
def test_what_is_put_elsewhere_is_moved(task: str, means: str) -> None:
    aside = in_the_end(played(task, means), lambda pose: pose + (0.0, 0.08, 0.0, 0.0, 0.0, 0.0, 0.0))
    with pytest.raises(SceneError, match="does not stand where it stood"):
        check_of(task, means)(aside)


@pytest.mark.parametrize("means", [way.name for way in WAYS["turn"]])
def test_what_is_turned_back_is_not_turned(means: str) -> None:
    recording = played("turn", means)
    assert recording.label is not None
    first = recording.qpos[0, recording.scene.object_slice(recording.label.target_object)]
    with pytest.raises(SceneError, match="is hardly turned"):
        check_of("turn", means)(in_the_end(recording, lambda _pose: first))
    round_once = in_the_end(recording, lambda _pose: np.array((*first[:3], *multiply(about_z(math.tau), first[3:]))))
    with pytest.raises(SceneError, match="is hardly turned"):
        check_of("turn", means)(round_once)


@pytest.mark.parametrize("means", [way.name for way in WAYS["pour"]])
def test_what_is_only_carried_to_and_fro_is_not_poured(means: str) -> None:
    recording = played("pour", means)
    assert recording.label is not None
    column = recording.scene.object_slice(recording.label.target_object)
    upright = np.array(recording.qpos)
    upright[:, column.start + 3 : column.stop] = upright[0, column.start + 3 : column.stop]
    with pytest.raises(SceneError, match="is hardly tilted"):
        check_of("pour", means)(replace(recording, qpos=upright))
    beside = np.array(recording.qpos)
    beside[:, column.start + 1] += 3.0
    with pytest.raises(SceneError, match="is tilted over nothing"):
        check_of("pour", means)(replace(recording, qpos=beside))


def test_what_is_judged_by_is_in_no_background() -> None:
    assert len(JUDGING_ONLY) >= 3
    assert not set(JUDGING_ONLY) & set(NEUTRAL)
    assert {*JUDGING_ONLY, *NEUTRAL, *CHECKS} == set(TASKS)
    assert SOURCES["neutral"].tasks == NEUTRAL
    assert SOURCES[UNFAMILIAR].tasks == JUDGING_ONLY
