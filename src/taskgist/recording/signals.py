"""Signals of a recording: numbers over time that are no motion, such as the force of a grip.

They are witnesses: facts do not read them. With one exception: a gaze that was recorded stands above all that is
inferred of it. Where an eye tracker was worn, two signals for each agent tell the angles of the gaze in the head, in
``rad`` or ``deg``:

================== ================================================================
``NAME_gaze_left`` how far the eyes are turned to the left, negative to the right
``NAME_gaze_up``   how far up, negative down
================== ================================================================

Of one that is missing the angle is 0; where one is unknown (NaN), so is the gaze of that frame. Simulated people are
moved with their gaze, without any signals: their heads are aimed, and their eyes look where their heads do.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from taskgist.common.arrays import Array
from taskgist.errors import RecordingError
from taskgist.world.state import AHEAD, HEADS_ALONE, EyeTurn

SIGNAL_DECIMALS = 3
"""Decimals of a signal that are kept in files."""


@dataclass(frozen=True, eq=False)
class Signal:
    """One signal at the frames of a recording.

    Attributes:
        values: (N,), NaN where unknown.
        unit: Unit of the values, such as "N".
    """

    values: Array
    unit: str

    def __post_init__(self) -> None:
        values = np.array(self.values, dtype=np.float64)
        values.flags.writeable = False
        object.__setattr__(self, "values", values)

    def __reduce__(self) -> tuple[object, ...]:
        """Rebuild through the constructor, so that the array stays read-only."""
        return (Signal, (np.array(self.values), self.unit))


def checked_signals(count: int, signals: Mapping[str, Signal]) -> Mapping[str, Signal]:
    """The signals, read-only.

    Raises:
        RecordingError: Values of the wrong shape.
    """
    for name, signal in signals.items():
        if signal.values.shape != (count,):
            hint = f"give one value for each of the {count} frames"
            raise RecordingError("wrong shape", field=f"signals[{name!r}]", value=signal.values.shape, hint=hint)
    return MappingProxyType(dict(signals))


# --- The gaze that a recording names.

DIRECTIONS = ("left", "up")
UNITS: Mapping[str, float] = {"rad": 1.0, "deg": math.pi / 180.0}
"""Units of angles, in radians."""


def gaze_signals(agent: str) -> tuple[str, str]:
    """Names of the signals that tell an agent's gaze: to the left, and up."""
    left, up = (f"{agent}_gaze_{direction}" for direction in DIRECTIONS)
    return left, up


class RecordedGaze:
    """How eyes were turned in the frames of a recording, as far as it says so.

    Args:
        agents: Of whom.
        signals: The recording's signals.
        simulated: Whether a program moved all of them, gaze and all.

    Attributes:
        names: The signals that tell of a gaze.

    Raises:
        RecordingError: A signal of a gaze is in no unit of angles.
    """

    def __init__(self, agents: Collection[str], signals: Mapping[str, Signal], *, simulated: bool) -> None:
        self._simulated = MappingProxyType(dict.fromkeys(agents, AHEAD) if simulated else {})
        self._turns_rad = {}
        for agent in agents:
            named = [signals.get(name) for name in gaze_signals(agent)]
            if any(signal is not None for signal in named):
                given = zip(gaze_signals(agent), named, strict=True)
                self._turns_rad[agent] = [_angles_rad(name, signal) for name, signal in given]
        self.names = tuple(name for agent in self._turns_rad for name in gaze_signals(agent) if name in signals)

    def eyes(self, frame: int) -> Mapping[str, EyeTurn]:
        """How eyes were turned in a frame, by agent; of the others nothing was recorded."""
        if not self._turns_rad:
            return self._simulated or HEADS_ALONE
        found = dict(self._simulated)
        for agent, angles in self._turns_rad.items():
            left_rad, up_rad = (0.0 if each is None else float(each[frame]) for each in angles)
            if math.isfinite(left_rad) and math.isfinite(up_rad):
                found[agent] = EyeTurn(left_rad, up_rad)
        return found


def _angles_rad(name: str, signal: Signal | None) -> Array | None:
    """The angles at the precision of a file, radians, (N,); None where there are none."""
    if signal is None:
        return None
    if signal.unit not in UNITS:
        hint = f"give the angles in {' or '.join(UNITS)}"
        raise RecordingError("a gaze is told in angles", field=f"signals[{name!r}].unit", value=signal.unit, hint=hint)
    return np.round(signal.values, SIGNAL_DECIMALS) * UNITS[signal.unit]
