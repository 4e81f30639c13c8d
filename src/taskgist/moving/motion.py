"""Motion: how a body gets from one posture to another, and sways at rest.

People's arm movements follow a minimum-jerk profile: a bell-shaped speed along the path, at rest at both ends
[Flash & Hogan 1985]. A ``Motion`` runs along a smooth curve through given postures with that profile.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline

from taskgist.common.arrays import Array


def minimum_jerk(share: ArrayLike) -> Array:
    """Share of the way that is covered after a share of the time; flat outside of 0 to 1 [Flash & Hogan 1985].

    Args:
        share: Elapsed time over duration, any shape.
    """
    s = np.clip(np.asarray(share, dtype=float), 0.0, 1.0)
    return np.asarray(s**3 * (10.0 + s * (6.0 * s - 15.0)))


@dataclass(frozen=True, eq=False)
class Motion:
    """A movement through postures, at rest at both ends.

    Attributes:
        knots: Postures to pass through, (k, n), k ≥ 2; any units.
        places: Where along the way each knot lies, (k,), increasing from 0 to 1.
        start_s: When it begins.
        duration_s: How long it takes.
    """

    knots: Array
    places: Array
    start_s: float
    duration_s: float

    def __post_init__(self) -> None:
        for name in ("knots", "places"):
            array = np.array(getattr(self, name), dtype=float)
            array.flags.writeable = False
            object.__setattr__(self, name, array)
        assert len(self.knots) == len(self.places) >= 2
        assert self.duration_s > 0
        assert np.all(np.diff(self.places) > 0)

    def __reduce__(self) -> tuple[object, ...]:
        return Motion, (np.array(self.knots), np.array(self.places), self.start_s, self.duration_s)

    @property
    def end_s(self) -> float:
        """When it ends."""
        return self.start_s + self.duration_s

    def at(self, times_s: Array) -> Array:
        """Postures at some times, (t, n); the first knot before the start, the last one after the end."""
        way = minimum_jerk((times_s - self.start_s) / self.duration_s)
        return through(self.knots, self.places, way)


def through(knots: Array, places: Array, wanted: ArrayLike) -> Array:
    """Values of the natural cubic spline through knots (k, n) at ``places`` (k,), where ``wanted`` (t,), as (t, n)."""
    return np.asarray(CubicSpline(places, knots, bc_type="natural")(wanted))


# --- Moving: whose body makes which motion.


@dataclass(frozen=True, eq=False)
class Moving:
    """A motion of somebody's body.

    Attributes:
        agent: Whose.
        motion: The motion; its postures are those of that agent's ``Body``.
    """

    agent: str
    motion: Motion

    @property
    def start_s(self) -> float:
        """When it begins."""
        return self.motion.start_s

    @property
    def end_s(self) -> float:
        """When it ends."""
        return self.motion.end_s


# --- Postural sway: nobody sits or stands perfectly still.
#
# Quiet sway is slow (most of its power lies below 0.5 Hz) and moves the upper body by some millimetres [Winter 1995].

SWAYING = ("torso_turn", "torso_side")
"""Joints that sway. The torso's lean does not: it would push hands through what they rest on."""
AMPLITUDE_RAD = 0.002
"""Amplitude of each component: about a millimetre at the shoulders, two in all."""
FREQUENCIES_HZ = ((0.10, 0.25), (0.25, 0.50))
"""Range of each component's frequency."""


def sway(times_s: Array, rng: np.random.Generator) -> Mapping[str, Array]:
    """Offsets of the swaying joints over time.

    Args:
        times_s: Times, (n,).
        rng: Source of frequencies and phases.

    Returns:
        Radians, (n,), by the joint's name.
    """
    return {joint: _wander(times_s, rng) for joint in SWAYING}


def _wander(times_s: Array, rng: np.random.Generator) -> Array:
    offset = np.zeros_like(times_s)
    for low, high in FREQUENCIES_HZ:
        frequency, phase = rng.uniform(low, high), rng.uniform(0.0, 2.0 * np.pi)
        offset += AMPLITUDE_RAD * np.sin(2.0 * np.pi * frequency * times_s + phase)
    return offset
