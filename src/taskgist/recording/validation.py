"""What the arrays of a recording must be."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from taskgist.errors import RecordingError, UnknownNameError
from taskgist.recording.rounding import free_slices, nanoseconds
from taskgist.world import Scene

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


def check_times(times_s: Array) -> None:
    """Refuse times that are too few, negative, not finite, or run backwards.

    Raises:
        RecordingError: They are.
    """
    if times_s.ndim != 1 or len(times_s) < 2:
        hint = "a recording needs at least two frames"
        raise RecordingError("too few frames", field="times_s", value=times_s.shape, hint=hint)
    if not np.isfinite(times_s).all():
        frame = int(np.argmin(np.isfinite(times_s)))
        raise RecordingError(f"frame {frame} has no time", field="times_s", value=float(times_s[frame]))
    if times_s[0] < 0.0:
        hint = "count seconds from the start of the recording"
        raise RecordingError("times are negative", field="times_s", value=float(times_s[0]), hint=hint)
    forwards = np.diff(nanoseconds(times_s)) > 0
    if not forwards.all():
        frame = int(np.argmin(forwards)) + 1
        before, after = float(times_s[frame - 1]), float(times_s[frame])
        problem = "times run backwards" if after < before else "times repeat"
        hint = "sort the frames by time, and drop repeated ones"
        raise RecordingError(f"{problem} at frame {frame}", field="times_s", value=(before, after), hint=hint)


def check_positions(scene: Scene, times_s: Array, qpos: Array) -> None:
    """Refuse positions of the wrong shape, values that are not finite, and quaternions of length zero.

    Raises:
        RecordingError: There are such.
    """
    if qpos.shape != (len(times_s), scene.nq):
        hint = f"{len(times_s)} frames of this scene need the shape {(len(times_s), scene.nq)}"
        raise RecordingError("wrong shape", field="qpos", value=qpos.shape, hint=hint)
    if not np.isfinite(qpos).all():
        frame, column = (int(index) for index in np.argwhere(~np.isfinite(qpos))[0])
        hint = "give any finite filler and say in tracked that it is unknown"
        raise RecordingError(
            f"frame {frame}, column {column} is not finite", field="qpos", value=float(qpos[frame, column]), hint=hint
        )
    for free in free_slices(scene):
        length = np.linalg.norm(qpos[:, free][:, 3:], axis=1)
        if (length < 0.5).any():
            frame = int(np.argmax(length < 0.5))
            problem = f"frame {frame}, columns {free.start + 3} to {free.stop - 1} hold no unit quaternion"
            value = qpos[frame, free][3:].tolist()
            raise RecordingError(problem, field="qpos", value=value, hint="give w, x, y, z of length 1")


def checked_tracking(scene: Scene, count: int, tracked: Mapping[str, Flags]) -> Mapping[str, Flags]:
    """The flags, read-only; without what was always tracked.

    Raises:
        RecordingError: Flags of the wrong shape.
        UnknownNameError: The scene has nothing of that name.
    """
    known = {*scene.agents, *scene.objects, *(f"{a}/{part}" for a in scene.agents for part in scene.parts(a))}
    checked = {}
    for name, flags in sorted(tracked.items()):
        if name not in known:
            raise UnknownNameError("object, agent or part", name, known)
        array = np.array(flags, dtype=np.bool_)
        if array.shape != (count,):
            hint = f"give one flag for each of the {count} frames"
            raise RecordingError("wrong shape", field=f"tracked[{name!r}]", value=array.shape, hint=hint)
        array.flags.writeable = False
        if not array.all():
            checked[name] = array
    return MappingProxyType(checked)
