"""Intentions: which tasks a demonstration fulfils, whatever it was played as.

Who hides something away hides it, and who makes accessible what nobody saw shows it. So a demonstration fulfils the
task that it was played as, and with it every task of the paper whose own check it passes: those of the outcomes, by
straight lines and distances alone. Facts have no say, because they are what is judged.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.errors import SceneError
from taskgist.recording.recording import Label, Pair, Recording
from taskgist.settings import DEFAULT
from taskgist.world.contacts import is_near, object_points
from taskgist.world.geometry.transforms import normalized
from taskgist.world.stage import Stage
from taskgist_lab.generator.outcomes import (
    HIDDEN_SHARE,
    INWARD,
    SHOWN_SHARE,
    check_before_eyes,
    check_comes_into_view,
    check_shown,
)
from taskgist_lab.generator.tasks_that_offer import BETWEEN_M, NEARER_M
from taskgist_lab.generator.tasks_that_remove import (
    check_away_and_hidden,
    check_away_in_view,
    check_from_view_to_hidden,
)
from taskgist_lab.generator.way import Check
from taskgist_lab.simulator.places import SUPPORT_SPACING_M


def fulfilled(recording: Recording) -> tuple[str, ...]:
    """The tasks of a labelled recording: its own, and each one whose check it passes; sorted."""
    assert recording.label is not None
    return tuple(sorted({recording.label.task} | {task for task, check in CHECKS.items() if _passes(check, recording)}))


def _passes(check: Check, recording: Recording) -> bool:
    try:
        check(recording)
    except SceneError:
        return False
    return True


def check_shows(recording: Recording) -> None:
    """Refuse a demonstration in which the thing neither comes into view nor is brought before the eyes.

    Raises:
        SceneError: So it is.
    """
    if not _passes(check_comes_into_view, recording):
        check_before_eyes(recording)


def check_accessible(recording: Recording) -> None:
    """Refuse a demonstration that leaves the thing out of view, or neither nearer to the target agent nor uncovered.

    It is nearer by ``NEARER_M`` or more, or lines from a shoulder to it were blocked before and are free then, and no
    longer than what somebody uncovers for another (``BETWEEN_M``).

    Raises:
        SceneError: So it is.
    """
    check_shown(recording)
    label = _label(recording)
    for pair in label.pairs:
        before, after = (_nearness(recording, pair, time_s) for time_s in (label.start_s, label.end_s))
        uncovered = before.free <= HIDDEN_SHARE and after.free >= SHOWN_SHARE and after.distance_m <= BETWEEN_M[1]
        if not uncovered and before.distance_m - after.distance_m < NEARER_M:
            raise _not("made accessible", recording, pair)


def check_given(recording: Recording) -> None:
    """Refuse a demonstration at whose end the thing is in no hand of the target agent, or was in one before.

    Raises:
        SceneError: So it is.
    """
    label = _label(recording)
    for pair in label.pairs:
        before, after = (_in_hand(recording, pair, time_s) for time_s in (label.start_s, label.end_s))
        if before or not after:
            raise _not("given", recording, pair)


CHECKS: Mapping[str, Check] = MappingProxyType(
    {
        "show": check_shows,
        "hide": check_from_view_to_hidden,
        "make accessible": check_accessible,
        "give": check_given,
        "put away": check_away_in_view,
        "hide away": check_away_and_hidden,
    }
)
"""What each task of the paper is, by geometry."""


@dataclass(frozen=True)
class _Nearness:
    """How near a thing is to somebody's arms.

    Attributes:
        distance_m: From the nearer shoulder.
        free: Share of the lines from a shoulder to the thing that nothing else is on; the freer arm's.
    """

    distance_m: float
    free: float


def _nearness(recording: Recording, pair: Pair, time_s: float) -> _Nearness:
    (agent, thing), scene = pair, recording.scene
    stage = Stage(scene, recording.at(time_s))
    points = object_points(stage, thing, SUPPORT_SPACING_M)
    points = points + INWARD * (points.mean(axis=0) - points)
    others = np.flatnonzero([owner != agent for owner in scene.owners])
    shoulders = [stage.shoulder(arm).position for arm in scene.agent(agent).arms]
    distances = [float(np.linalg.norm(points.mean(axis=0) - shoulder)) for shoulder in shoulders]
    return _Nearness(
        min(distances), max(_free(stage, thing, points - shoulder, shoulder, others) for shoulder in shoulders)
    )


def _free(stage: Stage, thing: str, lines: Array, origin: Array, shapes: Indices) -> float:
    """Share of lines (n, 3) from an origin (3,) on which a thing is the first of the shapes."""
    geoms, _ = stage.cast_at(shapes, origin, normalized(lines))
    return float(np.isin(geoms, stage.scene.seen_geoms(thing)).mean())


def _in_hand(recording: Recording, pair: Pair, time_s: float) -> bool:
    (agent, thing), scene = pair, recording.scene
    stage = Stage(scene, recording.at(time_s))
    return any(is_near(stage, arm, thing, DEFAULT.contact) for arm in scene.agent(agent).arms)


def _label(recording: Recording) -> Label:
    assert recording.label is not None
    return recording.label


def _not(what: str, recording: Recording, pair: Pair) -> SceneError:
    agent, thing = pair
    return SceneError(f"{thing!r} is not {what} for {agent!r}", where=recording.name, hint="try another room")
