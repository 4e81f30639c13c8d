"""Tracked motion: what a mapping makes of someone's tables, in our axes, units and frames.

Nothing is invented here. Where a tracker knew nothing there is NaN, and a part that the mapping calls unknown is not
read at all; how a body fits these points is decided later, and reported.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskgist.recording.mapping.model import Shape, Support
from taskgist.recording.signals import Signal

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PersonTrack:
    """One person over time.

    Attributes:
        points: Positions by landmark, (N, 3) each; NaN where unknown.
        directions: Unit vectors in the world by name ("face", "left_hand", ...), (N, 3) each; NaN where unknown.
        unknown: Parts of the body that are not to be believed, and why. None of their landmarks is in ``points``.
        stature_m: Height of the person, if the mapping gives it.
    """

    points: Mapping[str, Array]
    directions: Mapping[str, Array]
    unknown: Mapping[str, str]
    stature_m: float | None


@dataclass(frozen=True, eq=False)
class ObjectTrack:
    """One object over time.

    Attributes:
        position_m: Origin of its frame, (N, 3); NaN where unknown.
        wxyz: Orientation of its frame, (N, 4); NaN where unknown; the identity where the source has no orientations.
        known: Frames in which position and orientation are known, (N,).
        shapes: What it consists of, in its frame.
        estimated: Whether shape or place are an estimate.
        note: How they were estimated.
    """

    position_m: Array
    wxyz: Array
    known: NDArray[np.bool_]
    shapes: tuple[Shape, ...]
    estimated: bool
    note: str


@dataclass(frozen=True, eq=False)
class Tracks:
    """Everything that a mapping brings in.

    Attributes:
        times_s: Frames, (N,), from 0 at a fixed rate.
        start_s: Time of the first frame in the time of the sources.
        people: By name.
        objects: By name.
        supports: Furniture that nobody tracked.
        signals: Numbers over time that are no motion, by name.
        notes: What a user should know: parts that are unknown, shapes that are estimated.
    """

    times_s: Array
    start_s: float
    people: Mapping[str, PersonTrack]
    objects: Mapping[str, ObjectTrack]
    supports: tuple[Support, ...]
    signals: Mapping[str, Signal]
    notes: tuple[str, ...]
