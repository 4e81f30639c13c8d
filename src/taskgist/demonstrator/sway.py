"""Postural sway: nobody sits or stands perfectly still.

Quiet sway is slow (most of its power lies below 0.5 Hz) and moves the upper body by some millimetres [Winter 1995].
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

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
