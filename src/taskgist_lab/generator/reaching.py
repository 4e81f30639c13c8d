"""What a performer sees to with what another's arms shall get: is it within their reach, is it free, is it in a hand?

Distances and straight lines from shoulders are all that is used; with which effort somebody would reach it is for facts
to find out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.errors import SceneError
from taskgist.recording.recording import Label, Pair, Recording
from taskgist.settings import DEFAULT
from taskgist.world.contacts import is_near, object_points
from taskgist.world.geometry.transforms import normalized
from taskgist.world.stage import Stage
from taskgist_lab.generator.outcomes import HIDDEN_SHARE, INWARD, SHOWN_SHARE, check_shown
from taskgist_lab.simulator.places import SUPPORT_SPACING_M

WITHIN_M = 0.90
"""How far from a shoulder things are that are within reach: an arm's length [0.7 m, Winter 2009] and a lean (ours)."""
NEARER_M = 0.30
"""How much nearer to a shoulder something comes that is made accessible, if it was not in the arm's way before."""


def check_accessible(recording: Recording) -> None:
    """Refuse a demonstration that does not leave the thing accessible to the target agent, and more so than before.

    It is left in view, in nobody's hand, within ``WITHIN_M`` of a shoulder. It is nearer by ``NEARER_M`` or more than
    before, or the lines from the shoulders to it were blocked before and are free then.

    Raises:
        SceneError: So it is not.
    """
    check_shown(recording)
    label = _label(recording)
    for agent, thing in label.pairs:
        pair = agent, thing
        before, after = (_nearness(recording, pair, time_s) for time_s in (label.start_s, label.end_s))
        uncovered = before.free <= HIDDEN_SHARE and after.free >= SHOWN_SHARE
        better = uncovered or before.distance_m - after.distance_m >= NEARER_M
        holders = (label.performing_agent, agent)
        held = any(_in_hand(recording, (holder, thing), label.end_s) for holder in holders)
        if held or not better or after.distance_m > WITHIN_M:
            raise _not("made accessible", recording, pair, after.distance_m)


def check_given(recording: Recording) -> None:
    """Refuse a demonstration at whose end the thing is in no hand of the target agent, or was in one before.

    Raises:
        SceneError: So it is.
    """
    label = _label(recording)
    for pair in label.pairs:
        before, after = (_in_hand(recording, pair, time_s) for time_s in (label.start_s, label.end_s))
        if before or not after:
            raise _not("given", recording, pair, _nearness(recording, pair, label.end_s).distance_m)


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


def _not(what: str, recording: Recording, pair: Pair, value: float) -> SceneError:
    agent, thing = pair
    return SceneError(
        f"{thing!r} is not {what} for {agent!r}", where=recording.name, value=round(value, 2), hint="try another room"
    )
