"""A recording: what perception delivered of a demonstration, and the operator's label."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from taskgist.errors import RecordingError
from taskgist.recording.label import Label
from taskgist.recording.provenance import Provenance
from taskgist.recording.rounding import nanoseconds, whole
from taskgist.recording.signals import Signal, checked_signals
from taskgist.recording.validation import Flags, check_positions, check_times, checked_tracking
from taskgist.world import Scene, State

Array = NDArray[np.float64]

_TIME_TOLERANCE_S = 1e-6


@dataclass(frozen=True, eq=False)
class Recording:
    """States of one scene over time.

    Attributes:
        scene: Room, objects and agents.
        times_s: Times of the frames, (N,), seconds since the recording's origin, not negative, strictly increasing.
        qpos: Positions of each frame, (N, nq), in the scene's order.
        tracked: Frames in which something was tracked, (N,), by its name as in ``State.untracked`` ("box", "P1",
            "P1/left_arm"). What is not named was always tracked.
        label: What it demonstrates, if someone said so.
        provenance: Where it comes from.
        name: What it is called.
        signals: Numbers over time that are no motion, by name: witnesses, such as the force of a grip.

    Raises:
        RecordingError: Arrays of the wrong shape, fewer than two frames, times that run backwards, values that are
            not finite, quaternions of length zero.
        UnknownNameError: ``tracked`` or the label name something that is not in the scene.
        LabelError: The label reaches outside of the recording.
    """

    scene: Scene
    times_s: Array
    qpos: Array
    tracked: Mapping[str, Flags] = field(default_factory=dict)
    label: Label | None = None
    provenance: Provenance = field(default_factory=Provenance)
    name: str = ""
    signals: Mapping[str, Signal] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "times_s", _read_only(self.times_s))
        object.__setattr__(self, "qpos", _read_only(self.qpos))
        check_times(self.times_s)
        check_positions(self.scene, self.times_s, self.qpos)
        object.__setattr__(self, "tracked", checked_tracking(self.scene, len(self.times_s), self.tracked))
        object.__setattr__(self, "signals", checked_signals(len(self.times_s), self.signals))
        if self.label is not None:
            self.label.check(
                agents=self.scene.agents,
                objects=self.scene.objects,
                first_s=float(self.times_s[0]),
                last_s=float(self.times_s[-1]),
            )

    def __reduce__(self) -> tuple[object, ...]:
        """Rebuild through the constructor: arrays stay read-only, and a read-only mapping cannot be pickled."""
        tracked = {name: np.array(flags) for name, flags in self.tracked.items()}
        fields = (self.scene, np.array(self.times_s), np.array(self.qpos), tracked, self.label, self.provenance)
        return (Recording, (*fields, self.name, dict(self.signals)))

    def __len__(self) -> int:
        """Number of frames."""
        return len(self.times_s)

    @property
    def duration_s(self) -> float:
        """Time from the first frame to the last, seconds."""
        return float(self.times_s[-1] - self.times_s[0])

    def state(self, index: int) -> State:
        """The state in a frame.

        Raises:
            RecordingError: There is no such frame.
        """
        if not -len(self) <= index < len(self):
            hint = f"give an index from 0 to {len(self) - 1}"
            raise RecordingError("no such frame", where=self.name, field="index", value=index, hint=hint)
        untracked = frozenset(name for name, flags in self.tracked.items() if not flags[index])
        return State(self.qpos[index], float(self.times_s[index]), untracked)

    def index_at(self, time_s: float) -> int:
        """Index of the frame nearest to a time.

        Raises:
            RecordingError: The time is outside of the recording.
        """
        first_s, last_s = float(self.times_s[0]), float(self.times_s[-1])
        if not first_s - _TIME_TOLERANCE_S <= time_s <= last_s + _TIME_TOLERANCE_S:
            hint = f"give a time between {first_s:g} and {last_s:g} s"
            problem = "the time is outside of the recording"
            raise RecordingError(problem, where=self.name, field="time_s", value=time_s, hint=hint)
        return int(np.argmin(np.abs(self.times_s - time_s)))

    def at(self, time_s: float) -> State:
        """The state in the frame nearest to a time.

        Raises:
            RecordingError: The time is outside of the recording.
        """
        return self.state(self.index_at(time_s))

    def with_label(self, label: Label | None) -> Recording:
        """The same recording with another label.

        Raises:
            UnknownNameError: An agent or the object is not in it.
            LabelError: The label reaches outside of it.
        """
        return dataclasses.replace(self, label=label)

    @property
    def digest(self) -> str:
        """Digest of what was recorded, 16 hexadecimal digits; label, name, provenance, signals left aside."""
        content = hashlib.sha256()
        for name in sorted(self.scene.bundle):
            data = self.scene.bundle[name]
            content.update(f"{name}\0{len(data)}\0".encode())
            content.update(data)
        content.update(nanoseconds(self.times_s).astype("<i8").tobytes())
        content.update(whole(self.qpos, self.scene).astype("<i8").tobytes())
        untracked = {name: np.flatnonzero(~flags).tolist() for name, flags in self.tracked.items()}
        content.update(json.dumps(untracked, sort_keys=True).encode())
        return content.hexdigest()[:16]


def _read_only(values: ArrayLike) -> Array:
    array = np.array(values, dtype=np.float64)
    array.flags.writeable = False
    return array
