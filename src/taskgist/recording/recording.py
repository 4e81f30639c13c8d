"""A recording: what perception delivered of a demonstration, the operator's label, and where it comes from."""

from __future__ import annotations

import copy
import dataclasses
import hashlib
import json
import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
from types import MappingProxyType
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.common.text import clean_name, fault_of_name, one_or_list
from taskgist.errors import LabelError, RecordingError, UnknownNameError
from taskgist.recording.columns import PackedRows
from taskgist.recording.signals import SIGNAL_DECIMALS, RecordedGaze, Signal, checked_signals
from taskgist.world.scene import Scene
from taskgist.world.state import State

# --- The operator's label: which task, by whom, for whom, on what, from when to when (7.2).

_TOLERANCE_S = 1e-6  # times on disk are whole nanoseconds


Pair = tuple[str, str]
"""A target agent and a target object: for whom, with what."""


@dataclass(frozen=True, init=False)
class Label:
    """What a recording demonstrates.

    A task may be performed for several agents at once (hide from both, 9.6) and with several objects (give pen and
    paper, 9.7): each of the objects is then meant for each of the agents. Who is alone performs it for nobody else. In
    files one name stands as it is, none as null, and several as a list, beneath ``target_agent`` and ``target_object``.

    Attributes:
        task: Name of the task, such as "give"; like all names, without spaces at its ends and composed (NFC).
        performing_agent: Who performs it.
        target_agents: For whom, in the order in which they were named; none: for nobody else, and what changes for the
            performing agent itself is looked at. None and the empty tuple mean the same.
        target_objects: With what; one or more, likewise.
        start_s: Start, seconds since the recording's origin.
        end_s: End.
        how: How the label was set: by hand, from which events.

    Raises:
        LabelError: A field is empty, or not a time; a name holds control characters or stands twice; the end is not
            after the start; the performing agent is a target agent, too.
    """

    task: str
    performing_agent: str
    target_agents: tuple[str, ...]
    target_objects: tuple[str, ...]
    start_s: float
    end_s: float
    how: str = ""

    def __init__(
        self,
        task: str,
        performing_agent: str,
        target_agents: str | Sequence[str] | None,
        target_objects: str | Sequence[str],
        start_s: float,
        end_s: float,
        how: str = "",
    ) -> None:
        given = {
            "task": _checked_name("task", task),
            "performing_agent": _checked_name("performing_agent", performing_agent),
            "target_agents": () if target_agents in (None, ()) else _checked_names("target_agent", target_agents),
            "target_objects": _checked_names("target_object", target_objects),
            "start_s": start_s,
            "end_s": end_s,
            "how": how,
        }
        for name, value in given.items():
            object.__setattr__(self, name, value)
        _check_time("start_s", start_s)
        _check_time("end_s", end_s)
        if end_s <= start_s:
            raise LabelError(
                "the label ends before it starts",
                field="end_s",
                value=end_s,
                hint=f"give an end after start_s = {start_s:g}",
            )
        if self.performing_agent in self.target_agents:
            raise LabelError(
                "performing and target agent are the same",
                field="target_agent",
                value=self.performing_agent,
                hint="name the other agent, for whom the task is performed; leave it out if there is none",
            )

    @property
    def watched(self) -> tuple[str, ...]:
        """Whose perspective it is explained from: the target agents, or else the performing agent itself."""
        return self.target_agents or (self.performing_agent,)

    @property
    def alone(self) -> Label:
        """The same, performed for nobody else: what changes for the performing agent itself is looked at."""
        return replace(self, target_agents=())

    @property
    def pairs(self) -> tuple[Pair, ...]:
        """Each of these agents with each target object: what is explained one by one."""
        return tuple(product(self.watched, self.target_objects))

    @property
    def target_agent(self) -> str:
        """The one target agent; the performing agent, if it is performed for nobody else.

        Raises:
            LabelError: There are several.
        """
        return _only("target_agent", self.watched)

    @property
    def target_object(self) -> str:
        """The one target object.

        Raises:
            LabelError: There are several.
        """
        return _only("target_object", self.target_objects)

    def as_dict(self) -> dict[str, Any]:
        """All fields as plain values, as files have them; ``label_of_fields`` makes the label of them again."""
        return {
            "task": self.task,
            "performing_agent": self.performing_agent,
            "target_agent": one_or_list(self.target_agents) if self.target_agents else None,
            "target_object": one_or_list(self.target_objects),
            "start_s": self.start_s,
            "end_s": self.end_s,
            "how": self.how,
        }

    def check(
        self,
        *,
        agents: Collection[str],
        objects: Collection[str],
        first_s: float = -math.inf,
        last_s: float = math.inf,
    ) -> None:
        """Refuse a label that does not fit a recording.

        Args:
            agents: Names of the recording's agents.
            objects: Names of its objects.
            first_s: Time of its first frame.
            last_s: Time of its last frame.

        Raises:
            UnknownNameError: An agent or an object is not in it.
            LabelError: The label reaches outside of it.
        """
        for agent in (self.performing_agent, *self.target_agents):
            if agent not in agents:
                raise UnknownNameError("agent", agent, agents)
        for name in self.target_objects:
            if name not in objects:
                raise UnknownNameError("object", name, objects)
        for name, time_s in (("start_s", self.start_s), ("end_s", self.end_s)):
            if not first_s - _TOLERANCE_S <= time_s <= last_s + _TOLERANCE_S:
                raise LabelError(
                    "the label reaches outside of the recording",
                    field=name,
                    value=time_s,
                    hint=f"give a time between {first_s:g} and {last_s:g} s",
                )


def label_of_fields(fields: Mapping[str, Any]) -> Label:
    """The label of fields as files have them; what is missing has no default but ``target_agent`` and ``how``.

    Raises:
        LabelError: As ``Label``.
    """
    return Label(
        task=fields["task"],
        performing_agent=fields["performing_agent"],
        target_agents=fields.get("target_agent"),
        target_objects=fields["target_object"],
        start_s=fields["start_s"],
        end_s=fields["end_s"],
        how=fields.get("how", ""),
    )


def _spelled(label: Label, scene: Scene) -> Label:
    """The same label with agents and objects spelled as in a scene, whose models may write an accent apart."""
    spelling = {clean_name(name): name for name in (*scene.agents, *scene.objects)}
    spelled = {
        "performing_agent": spelling.get(label.performing_agent, label.performing_agent),
        "target_agents": tuple(spelling.get(name, name) for name in label.target_agents),
        "target_objects": tuple(spelling.get(name, name) for name in label.target_objects),
    }
    changed = {field: value for field, value in spelled.items() if value != getattr(label, field)}
    if changed:
        label = copy.copy(label)
        vars(label).update(changed)  # the constructor would spell them in the one way again
    return label


def _checked_names(field: str, value: object) -> tuple[str, ...]:
    """One name or several, each in its one spelling."""
    if not isinstance(value, list | tuple):
        return (_checked_name(field, value, kind="a name or a list of names"),)
    noun = field.replace("_", " ")
    if not value:
        raise LabelError(f"no {noun}", field=field, value=value, hint="name at least one")
    names = tuple(_checked_name(field, each) for each in value)
    for name in names:
        if names.count(name) > 1:
            raise LabelError(f"one {noun} stands twice", field=field, value=name, hint="name each once")
    return names


def _checked_name(field: str, value: object, *, kind: str = "a name") -> str:
    """A name in its one spelling."""
    if not isinstance(value, str):
        hint = "give a text" if kind == "a name" else "give a text, or several in a list"
        raise LabelError(f"must be {kind}", field=field, value=value, hint=hint)
    if fault := fault_of_name(value):
        hint = "give a short text of one line, without tabs and marks that turn the direction of writing"
        raise LabelError(fault, field=field, value=value, hint=hint)
    return clean_name(value)


def _only(field: str, names: tuple[str, ...]) -> str:
    if len(names) > 1:
        noun = field.replace("_", " ")
        raise LabelError(
            f"the label has several {noun}s",
            field=field,
            value=names,
            hint="ask for all of them, or take a label with one",
        )
    return names[0]


def _check_time(field: str, value: object) -> None:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise LabelError("must be a time", field=field, value=value, hint="give seconds, such as 1.5")


# --- Where a recording comes from, and what was done to it.


@dataclass(frozen=True)
class Provenance:
    """Origin of a recording.

    Attributes:
        source: Who recorded it, where it was published.
        licence: Licence under which it may be used.
        citation: What to cite.
        simulated: Whether a scripted demonstrator made it, rather than people.
        notes: What a user should know about it: estimates, parts that are unknown and why.
        mapping: Text of the mapping file that brought it in.
        fit: Report on how well the body fits the tracked points, as plain JSON values.
    """

    source: str = ""
    licence: str = ""
    citation: str = ""
    simulated: bool = False
    notes: tuple[str, ...] = ()
    mapping: str = ""
    fit: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "notes", tuple(self.notes))
        object.__setattr__(self, "fit", MappingProxyType(copy.deepcopy(dict(self.fit))))

    def __reduce__(self) -> tuple[object, ...]:
        """Rebuild through the constructor: a read-only mapping cannot be pickled."""
        return (Provenance, tuple(self.as_dict().values()))

    def as_dict(self) -> dict[str, Any]:
        """All fields as plain values, in order."""
        return {
            "source": self.source,
            "licence": self.licence,
            "citation": self.citation,
            "simulated": self.simulated,
            "notes": list(self.notes),
            "mapping": self.mapping,
            "fit": copy.deepcopy(dict(self.fit)),
        }


# --- The precision of a recording: what is kept on disk, and what its digest sees.
#
# Rounding is idempotent, so that writing, reading and writing again gives the same file, and a recording that was
# just imported has the digest of the file that is written of it. A tenth of a millimetre and a thousandth of a degree
# are finer than any tracker.

POSITION_DECIMALS = 4  # metres
ANGLE_DECIMALS = 5  # radians, and components of quaternions
TIME_DECIMALS = 9  # seconds


def decimals(scene: Scene) -> Indices:
    """Decimals kept of each of a scene's positions, (nq,)."""
    kept = np.full(scene.nq, ANGLE_DECIMALS, dtype=np.intp)
    for free in free_slices(scene):
        kept[free.start : free.start + 3] = POSITION_DECIMALS
    return kept


def free_slices(scene: Scene) -> tuple[slice, ...]:
    """Slices of qpos (7) of everything that moves freely: agents first, then objects."""
    bases = [scene.base_slice(agent) for agent in scene.agents]
    return (*bases, *(scene.object_slice(name) for name in scene.objects))


def rounded(qpos: Array, scene: Scene) -> Array:
    """Positions, (..., nq), at the precision of a recording."""
    scale = 10.0 ** decimals(scene)
    return np.asarray(np.rint(qpos * scale) / scale + 0.0)  # + 0.0 turns -0.0 into 0.0


def whole(qpos: Array, scene: Scene) -> NDArray[np.int64]:
    """The same as whole numbers of their last decimal, (..., nq), for digests."""
    return np.asarray(np.rint(qpos * 10.0 ** decimals(scene)), dtype=np.int64)


def nanoseconds(times_s: Array) -> NDArray[np.int64]:
    """Times in whole nanoseconds, (N,)."""
    return np.asarray(np.rint(times_s * 10.0**TIME_DECIMALS), dtype=np.int64)


# --- What the arrays of a recording must be.

BLOCK = 4096
"""As many frames are worked on at a time, so that no array of all of them is made beside the recording's own."""
FARTHEST = 1e6
"""Metres or radians: no scene is as large, and what is kept is still exact there."""
LATEST_S = 9.2e9
"""Nanoseconds since the recording's origin, or since 1970, are 64-bit numbers."""


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
    if not times_s.max() < LATEST_S:
        hint = "count seconds from the start of the recording"
        raise RecordingError("times are too large", field="times_s", value=float(times_s.max()), hint=hint)
    forwards = np.diff(nanoseconds(times_s)) > 0
    if not forwards.all():
        frame = int(np.argmin(forwards)) + 1
        before, after = float(times_s[frame - 1]), float(times_s[frame])
        problem = "times run backwards" if after < before else "times repeat"
        hint = "sort the frames by time, and drop repeated ones"
        raise RecordingError(f"{problem} at frame {frame}", field="times_s", value=(before, after), hint=hint)


def check_positions(scene: Scene, times_s: Array, qpos: Array) -> None:
    """Refuse positions of the wrong shape, values that are not finite or too large, and quaternions of length zero.

    Raises:
        RecordingError: There are such.
    """
    if qpos.shape != (len(times_s), scene.nq):
        hint = f"{len(times_s)} frames of this scene need the shape {(len(times_s), scene.nq)}"
        raise RecordingError("wrong shape", field="qpos", value=qpos.shape, hint=hint)
    for first in range(0, len(qpos), BLOCK):
        block = qpos[first : first + BLOCK]
        wrong = ~(np.abs(block) <= FARTHEST)
        if wrong.any():
            frame, column = (int(index) for index in np.argwhere(wrong)[0])
            value = float(block[frame, column])
            problem = f"beyond {FARTHEST:,.0f} metres or radians" if np.isfinite(value) else "not finite"
            raise RecordingError(
                f"frame {first + frame}, column {column} is {problem}",
                field="qpos",
                value=value,
                hint="give any finite filler and say in tracked that it is unknown",
            )
        for free in free_slices(scene):
            short = np.linalg.norm(block[:, free][:, 3:], axis=1) < 0.5
            if short.any():
                frame = int(np.argmax(short))
                problem = f"frame {first + frame}, columns {free.start + 3} to {free.stop - 1} hold no unit quaternion"
                value = block[frame, free][3:].tolist()
                raise RecordingError(problem, field="qpos", value=value, hint="give w, x, y, z of length 1")


def trackable(scene: Scene) -> frozenset[str]:
    """Names of all that a tracker may lose: objects, agents and their parts ("P1/left_arm")."""
    parts = (f"{agent}/{part}" for agent in scene.agents for part in scene.parts(agent))
    return frozenset((*scene.agents, *scene.objects, *parts))


def checked_tracking(scene: Scene, count: int, tracked: Mapping[str, Mask]) -> Mapping[str, Mask]:
    """The flags, read-only; without what was always tracked.

    Raises:
        RecordingError: Flags of the wrong shape.
        UnknownNameError: The scene has nothing of that name.
    """
    known = trackable(scene)
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


_TIME_TOLERANCE_S = 1e-6


@dataclass(frozen=True, eq=False)
class Recording:
    """States of one scene over time.

    Attributes:
        scene: Room, objects and agents.
        times_s: Times of the frames, (N,), seconds since the recording's origin, not negative, strictly increasing.
        qpos: Positions of each frame, (N, nq), in the scene's order. Those of a file are packed (``PackedRows``), and
            read as an array is.
        tracked: Frames in which something was tracked, (N,), by its name as in ``State.untracked`` ("box", "P1",
            "P1/left_arm"). What is not named was always tracked.
        label: What it demonstrates, if someone said so.
        provenance: Where it comes from.
        name: What it is called.
        signals: Numbers over time that are no motion, by name: witnesses, such as the force of a grip; and where agents
            look (``recording.signals``), the only ones that facts read.

    Raises:
        RecordingError: Arrays of the wrong shape, fewer than two frames, times that run backwards, values that are
            not finite, quaternions of length zero.
        UnknownNameError: ``tracked`` or the label name something that is not in the scene.
        LabelError: The label reaches outside of the recording.
    """

    scene: Scene
    times_s: Array
    qpos: Array
    tracked: Mapping[str, Mask] = field(default_factory=dict)
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
        _ = self._gaze  # what it says is checked
        if self.label is not None:
            object.__setattr__(self, "label", _spelled(self.label, self.scene))
            self.label.check(
                agents=self.scene.agents,
                objects=self.scene.objects,
                first_s=float(self.times_s[0]),
                last_s=float(self.times_s[-1]),
            )

    def __reduce__(self) -> tuple[object, ...]:
        """Rebuild through the constructor: arrays stay read-only, and a read-only mapping cannot be pickled."""
        tracked = {name: np.array(flags) for name, flags in self.tracked.items()}
        fields = (self.scene, self.times_s, self.qpos, tracked, self.label, self.provenance)
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
        time_s = float(self.times_s[index])
        return State(self.qpos[index], time_s, self.untracked(index), eyes=self._gaze.eyes(index))

    @cached_property
    def _gaze(self) -> RecordedGaze:
        return RecordedGaze(self.scene.agents, self.signals, simulated=self.provenance.simulated)

    def untracked(self, index: int) -> frozenset[str]:
        """What was not tracked in a frame."""
        return frozenset(name for name, flags in self.tracked.items() if not flags[index])

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
        later = min(max(int(np.searchsorted(self.times_s, time_s)), 1), len(self) - 1)
        nearer = self.times_s[later] - time_s < time_s - self.times_s[later - 1]
        return later if nearer else later - 1

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
        """Digest of what was recorded, 16 hexadecimal digits; label, name, provenance, other signals left aside."""
        content = hashlib.sha256()
        for name in sorted(self.scene.bundle):
            data = self.scene.bundle[name]
            content.update(f"{name}\0{len(data)}\0".encode())
            content.update(data)
        content.update(nanoseconds(self.times_s).astype("<i8").tobytes())
        for first in range(0, len(self), BLOCK):
            content.update(whole(self.qpos[first : first + BLOCK], self.scene).astype("<i8").tobytes())
        for text in _json_of({name: np.flatnonzero(~self.tracked[name]) for name in sorted(self.tracked)}):
            content.update(text.encode())
        for name in self._gaze.names:
            content.update(f"{name} {self.signals[name].unit}\0".encode())
            content.update(np.round(self.signals[name].values, SIGNAL_DECIMALS).astype("<f8").tobytes())
        return content.hexdigest()[:16]


def _json_of(lists: Mapping[str, Indices]) -> Iterator[str]:
    """What ``json.dumps`` makes of lists of whole numbers by name, one after another."""
    yield "{"
    for number, (name, values) in enumerate(lists.items()):
        yield f"{', ' if number else ''}{json.dumps(name)}: {json.dumps(values.tolist())}"
    yield "}"


def _read_only(values: ArrayLike | PackedRows) -> Array:
    """A read-only array: a copy, unless it is one already, and a view of no other."""
    match values:
        case PackedRows():
            return cast(Array, values)  # it is read as one
        case np.ndarray() if values.dtype == np.float64 and values.flags.owndata and not values.flags.writeable:
            return values
    array = np.array(values, dtype=np.float64)
    array.flags.writeable = False
    return array
