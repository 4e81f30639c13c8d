"""The messages of taskgist in a recording: one JSON object per frame, by names, so that any program can read it.

They are written frame by frame, and read into columns as they come: nobody holds the JSON of all frames.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.common.documents import DocumentError, parse_json
from taskgist.errors import RecordingError, UnknownNameError
from taskgist.recording.columns import Columns, PackedRows
from taskgist.recording.container import Message
from taskgist.recording.recording import decimals, free_slices, trackable
from taskgist.recording.signals import SIGNAL_DECIMALS, Signal
from taskgist.settings import Limits
from taskgist.world.scene import Scene

Document = dict[str, Any]

STATE_TOPIC, SIGNALS_TOPIC = "/taskgist/state", "/taskgist/signals"
HINT = "the file was changed, or not written by taskgist"

_NUMBERS: Document = {"type": "array", "items": {"type": "number"}}
_POSE = _NUMBERS | {
    "minItems": 7,
    "maxItems": 7,
    "description": "x, y, z in metres and the quaternion w, x, y, z, in the world (z up)",
}
STATE_SCHEMA: Document = {
    "title": "taskgist.State",
    "description": "Where everything in the scene is. The scene itself is attached to the file.",
    "type": "object",
    "properties": {
        "objects": {"type": "object", "description": "Pose of each object", "additionalProperties": _POSE},
        "agents": {
            "type": "object",
            "description": "Each agent's root, and its joints in the order of the metadata record taskgist.recording",
            "additionalProperties": {
                "type": "object",
                "properties": {
                    "base": _POSE,
                    "joints": _NUMBERS | {"description": "Angles in radians (metres for sliding joints)"},
                },
                "required": ["base", "joints"],
            },
        },
        "others": _NUMBERS | {"description": "What else moves in the scene, in the order of its model"},
        "untracked": {
            "type": "array",
            "items": {"type": "string"},
            "description": 'Objects ("box"), agents ("P1") and parts ("P1/left_arm") whose numbers are fillers',
        },
    },
    "required": ["objects", "agents", "untracked"],
}
SIGNALS_SCHEMA: Document = {
    "title": "taskgist.Signals",
    "description": "Value of each signal, in the unit that the metadata taskgist.recording gives; null: unknown.",
    "type": "object",
    "additionalProperties": {"type": ["number", "null"]},
}

Keys = tuple[str, ...]
"""Where in a message the numbers of one thing stand: ("agents", "P1", "base")."""


class StateMessages:
    """The states of one scene as messages.

    Args:
        scene: The scene.
    """

    def __init__(self, scene: Scene) -> None:
        self._objects = {name: _columns(scene.object_slice(name)) for name in scene.objects}
        self._agents = {name: (_columns(scene.base_slice(name)), scene.joint_indices(name)) for name in scene.agents}
        self._others = _other_columns(scene)
        self._parts = self._listed()
        self._order = np.concatenate([columns for _, columns in self._parts] or [self._others])
        self._trackable = trackable(scene)

    def encode(self, row: Array, untracked: frozenset[str]) -> Document:
        """The message of a frame.

        Args:
            row: Its positions, (nq,).
            untracked: What was not tracked in it.
        """
        message: Document = {
            "objects": {name: row[columns].tolist() for name, columns in self._objects.items()},
            "agents": {
                name: {"base": row[base].tolist(), "joints": row[joints].tolist()}
                for name, (base, joints) in self._agents.items()
            },
            "untracked": sorted(untracked),
        }
        return message | ({"others": row[self._others].tolist()} if len(self._others) else {})

    def decode(self, message: Document, row: Array) -> list[str]:
        """Fill in the positions of a frame, (nq,), and tell what was not tracked in it.

        Raises:
            RecordingError: The message lacks something that the scene has, or holds other than finite numbers for it;
                ``field`` names it.
            UnknownNameError: It calls untracked what the scene does not have.
        """
        try:
            flat: list[Any] = []
            for keys, columns in self._parts:
                numbers = _at(message, keys)
                if type(numbers) is not list or len(numbers) != len(columns):
                    raise TypeError
                flat += numbers
            if not _REAL.issuperset(map(type, flat)):
                raise TypeError
            row[self._order] = flat
            if not np.isfinite(row).all():
                raise TypeError
            untracked = message["untracked"]
            if type(untracked) is not list:
                raise TypeError
        except (KeyError, TypeError, OverflowError):
            raise self._refusal(message) from None
        for name in untracked:
            if type(name) is not str or name not in self._trackable:
                raise UnknownNameError("object, agent or part", str(name), self._trackable)
        return untracked

    def _listed(self) -> list[tuple[Keys, Indices]]:
        """Where in a message everything stands, and in which columns, in one order."""
        parts: list[tuple[Keys, Indices]] = [(("objects", name), columns) for name, columns in self._objects.items()]
        for name, (base, joints) in self._agents.items():
            parts += [(("agents", name, "base"), base), (("agents", name, "joints"), joints)]
        return [*parts, (("others",), self._others)] if len(self._others) else parts

    def _refusal(self, message: Document) -> RecordingError:
        """Which part of a message it is that does not fit."""
        for keys, columns in self._parts:
            name, problem = ".".join(keys), f"{len(columns)} numbers are expected"
            try:
                numbers = _at(message, keys)
            except (KeyError, TypeError):
                return RecordingError("is missing", field=name, hint=HINT)
            if type(numbers) is not list or len(numbers) != len(columns):
                return RecordingError(problem, field=name, value=numbers, hint=HINT)
            for number in numbers:
                if not _is_finite(number):
                    return RecordingError("is no finite number", field=name, value=number, hint=HINT)
        return RecordingError("must be a list of names", field="untracked", value=message.get("untracked"), hint=HINT)


_REAL = frozenset({int, float})


def _is_finite(value: Any) -> bool:
    return type(value) in _REAL and abs(value) < 2**1023


class FrameColumns:
    """The frames of a recording as they are read: times, positions, what was not tracked, and signals.

    Args:
        scene: Their scene.
        units: Unit of each signal.
        path: Name of the file, for messages.
        limits: Of all frames together.
    """

    def __init__(self, scene: Scene, units: Mapping[str, str], path: Path, limits: Limits) -> None:
        self._states, self._path, self._limits = StateMessages(scene), path, limits
        self._names, self._units = sorted(trackable(scene)), dict(units)
        self._row = np.empty(scene.nq)
        self._times_s = Columns(None, np.float64)
        self._qpos = PackedRows(np.power(10.0, decimals(scene)))
        self._lost = Columns(len(self._names), np.bool_)
        self._signals = Columns(len(self._units), np.float64)
        self._most = limits.frame_bytes // (8 * (1 + scene.nq + len(self._units)) + len(self._names))

    def add(self, message: Message) -> None:
        """Take the next message.

        Raises:
            RecordingError: It does not fit the scene, or there are more frames than are held; it names the frame.
            UnknownNameError: It calls untracked what the scene does not have.
        """
        of_states = message.topic == STATE_TOPIC
        frame = len(self._times_s if of_states else self._signals)
        try:
            self._check_room(frame)
            document = parse_json(message.data, any_number=True)
            if type(document) is not dict:
                raise DocumentError("no JSON object")
            if of_states:
                self._add_state(message.time_ns, document)
            else:
                self._signals.append([self._signal(document, name) for name in self._units])
        except DocumentError as problem:
            field = f"{message.topic}, frame {frame}"
            raise RecordingError(str(problem), where=self._path, field=field, hint=HINT) from None
        except (RecordingError, UnknownNameError) as problem:
            inner = f": {problem.field}" if problem.field else ""
            problem.where, problem.field = str(self._path), f"{message.topic}, frame {frame}{inner}"
            raise

    def _add_state(self, time_ns: int, document: Document) -> None:
        untracked = self._states.decode(document, self._row)
        self._times_s.append(time_ns / 1e9)
        self._qpos.append(self._row)
        self._lost.append([name in untracked for name in self._names] if untracked else False)

    def _signal(self, document: Document, name: str) -> float:
        value = document.get(name, name)
        if value is not None and not _is_finite(value):
            raise RecordingError("is no finite number", field=name, value=document.get(name), hint=HINT)
        return np.nan if value is None else float(value)

    def _check_room(self, frame: int) -> None:
        if frame >= self._most:
            limit = f"{self._limits.frame_bytes:,} bytes"
            hint = f"cut the recording, or hold more than {limit} (setting limits.frame_bytes)"
            raise RecordingError(f"more than {self._most:,} frames", hint=hint)

    def finished(self) -> tuple[Array, PackedRows, dict[str, Mask], dict[str, Signal]]:
        """Times (N,), positions (N, nq), flags (N,) of what was tracked, by name, and signals."""
        lost, values = self._lost.finished(), self._signals.finished()
        tracked: dict[str, Mask] = {
            name: ~lost[:, column] for column, name in enumerate(self._names) if lost[:, column].any()
        }
        signals = {name: Signal(values[:, column], unit) for column, (name, unit) in enumerate(self._units.items())}
        return self._times_s.finished(), self._qpos, tracked, signals


def _at(message: Document, keys: Keys) -> Any:
    found: Any = message
    for key in keys:
        found = found[key]
    return found


def encode_signals(signals: Mapping[str, Signal], frame: int) -> dict[str, float | None]:
    """The message of one frame: value by name, null where unknown."""
    values = {name: round(float(signal.values[frame]), SIGNAL_DECIMALS) for name, signal in signals.items()}
    return {name: None if np.isnan(value) else value for name, value in values.items()}


def _columns(part: slice) -> Indices:
    return np.arange(part.start, part.stop)


def _other_columns(scene: Scene) -> Indices:
    """Columns of qpos that belong to no object and no agent, such as the hinge of a door."""
    named = np.zeros(scene.nq, dtype=np.bool_)
    for free in free_slices(scene):
        named[free] = True
    for agent in scene.agents:
        named[scene.joint_indices(agent)] = True
    return np.flatnonzero(~named)
