"""Outcomes: what a performer sees to when all is done. Was it shown, hidden, put farther off?"""

from __future__ import annotations

from typing import Literal

import numpy as np

from taskgist.demonstrator.generator.sight import SHOWN_SHARE, share_in_view
from taskgist.demonstrator.removing import FARTHER_M
from taskgist.errors import SceneError
from taskgist.recording import Recording
from taskgist.world import Stage

HIDDEN_SHARE = 0.2
"""What comes into view was in view to no more before."""
NEARER_SHARE = 0.6
"""What is held before the eyes is at most this share as far from them as it was."""
When = Literal["beginning", "end"]
"""Of the labelled task."""


def check_shown(recording: Recording) -> None:
    """Refuse a demonstration at whose end the target agent has no free line of sight to the thing.

    Raises:
        SceneError: It has none.
    """
    _check_in_view(recording, "end")


def check_comes_into_view(recording: Recording) -> None:
    """Refuse a demonstration in which the thing is not hidden, mostly, at first and in view in the end.

    Raises:
        SceneError: So it is.
    """
    before = _share_at(recording, "beginning")
    if before > HIDDEN_SHARE:
        raise _missed(recording, "is in view in the beginning", before)
    check_shown(recording)


def check_hidden(recording: Recording) -> None:
    """Refuse a demonstration at whose end the target agent has a line of sight to the thing.

    Raises:
        SceneError: It has one.
    """
    share = _share_at(recording, "end")
    if share > 0.0:
        raise _missed(recording, "is not hidden in the end", share)


def check_seen_before(recording: Recording) -> None:
    """Refuse a demonstration at whose beginning the target agent has no line of sight to the thing.

    Raises:
        SceneError: It has none.
    """
    _check_in_view(recording, "beginning")


def check_before_eyes(recording: Recording) -> None:
    """Refuse a demonstration in which the thing is not brought much nearer to the target agent's eye, and in view.

    Raises:
        SceneError: It is not.
    """
    label = recording.label
    assert label is not None
    check_shown(recording)
    before, after = (_from_eye_m(recording, time) for time in (label.start_s, label.end_s))
    if after > NEARER_SHARE * before:
        raise _missed(recording, "is not brought before the eyes", after / before)


def _from_eye_m(recording: Recording, time_s: float) -> float:
    """Distance of the thing from the target agent's eye."""
    label, scene = recording.label, recording.scene
    assert label is not None
    stage = Stage(scene, recording.at(time_s))
    place = stage.body_position(scene.object_body(label.target_object))
    return float(np.linalg.norm(place - stage.eye(scene.agent(label.target_agent)).position))


def check_farther(recording: Recording) -> None:
    """Refuse a demonstration at whose end the thing is not ``FARTHER_M`` farther from the target agent than before.

    Raises:
        SceneError: It is not.
    """
    label, scene = recording.label, recording.scene
    assert label is not None
    places = [
        recording.at(time).qpos[scene.object_slice(label.target_object)][:2] for time in (label.start_s, label.end_s)
    ]
    pelvis = scene.initial.qpos[scene.base_slice(label.target_agent)][:2]
    before, after = (float(np.linalg.norm(place - pelvis)) for place in places)
    if after - before < FARTHER_M:
        raise _missed(recording, "is not farther off in the end", after - before)


def _check_in_view(recording: Recording, when: When) -> None:
    share = _share_at(recording, when)
    if share < SHOWN_SHARE:
        raise _missed(recording, f"is not in view in the {when}", share)


def _share_at(recording: Recording, when: When) -> float:
    label = recording.label
    assert label is not None
    state = recording.at(label.start_s if when == "beginning" else label.end_s)
    return share_in_view(Stage(recording.scene, state), label.target_agent, label.target_object)


def _missed(recording: Recording, what: str, share: float) -> SceneError:
    label = recording.label
    assert label is not None
    return SceneError(
        f"{label.target_object!r} {what}", where=recording.name, value=round(share, 2), hint="draw another room"
    )
