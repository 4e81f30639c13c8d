"""Signals: numbers over time that are no motion, such as the force of a grip. Witnesses; facts do not read them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from taskgist.errors import RecordingError

DECIMALS = 3


@dataclass(frozen=True, eq=False)
class Signal:
    """One signal at the frames of a recording.

    Attributes:
        values: (N,), NaN where unknown.
        unit: Unit of the values, such as "N".
    """

    values: NDArray[np.float64]
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


def encode_signals(signals: Mapping[str, Signal], frame: int) -> dict[str, float | None]:
    """The message of one frame: value by name, null where unknown."""
    values = {name: round(float(signal.values[frame]), DECIMALS) for name, signal in signals.items()}
    return {name: None if np.isnan(value) else value for name, value in values.items()}


def decode_signals(units: Mapping[str, str], messages: tuple[Mapping[str, float | None], ...]) -> dict[str, Signal]:
    """The signals of all frames."""
    return {
        name: Signal(np.array([np.nan if m[name] is None else m[name] for m in messages], dtype=float), unit)
        for name, unit in units.items()
    }


SIGNALS_SCHEMA = {
    "title": "taskgist.Signals",
    "description": "Value of each signal, in the unit that the metadata taskgist.recording gives; null: unknown.",
    "type": "object",
    "additionalProperties": {"type": ["number", "null"]},
}
