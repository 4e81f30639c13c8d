"""BVH, Biovision hierarchy: joints with their offsets and channels, then a row of channels for each frame.

Written by MotionBuilder, Motive, Xsens, Rokoko, Mixamo, Blender and others. A joint's turns are about its parent's
axes, one after the other in the order of its channels (Meredith & Maddock 2001, Motion Capture File Formats Explained).
With all channels zero every joint's axes are those of the file: its rest pose. A BVH says neither its unit nor which
way is up; y is the custom.

Read by our own code: pybvh, with which the tests compare it, refuses joints with positions of their own, which Motive,
MotionBuilder and Xsens write.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from taskgist.common.arrays import Array
from taskgist.errors import MappingError
from taskgist.importing.csv import number
from taskgist.importing.formats.text import LARGEST, header_number, number_rows, read_lines
from taskgist.importing.mapping import Vector
from taskgist.importing.takes import Take, TakeTrack
from taskgist.world.geometry.transforms import matrix_from_euler, wxyz_from_matrix

BEGIN = b"HIERARCHY"
CHANNELS = tuple(f"{axis}{kind}" for kind in ("position", "rotation") for axis in "XYZ")
UPRIGHT = 0.9
"""Cosine between the y axis and a spine that stands in the rest pose (ours)."""


@dataclass
class _Joint:
    """A joint of the hierarchy.

    Attributes:
        name: Its name.
        parent: Index of the joint that carries it; -1 for a root.
        offset: From the parent, in the parent's axes.
        channels: Names of its channels, in their order.
        first: Column of the first of them.
    """

    name: str
    parent: int
    offset: Vector = (0.0, 0.0, 0.0)
    channels: tuple[str, ...] = ()
    first: int = 0


@dataclass
class _Hierarchy:
    joints: list[_Joint] = field(default_factory=list)
    open: list[int | None] = field(default_factory=list)
    """Joints whose braces are not closed yet; None for an end, which is no joint."""
    columns: int = 0


def is_bvh(head: bytes) -> bool:
    """Whether a file that begins so is one."""
    return head.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(BEGIN)


def read_bvh(path: Path, where: str, most_bytes: int) -> Take:
    """The joints of a BVH file.

    Orientations are given where the rest pose stands upright and faces z, as its own axes say nothing of a body else.

    Raises:
        MappingError: It cannot be read, is too large, no text, or contradicts itself.
    """
    lines = read_lines(path, where, most_bytes)
    hierarchy, at = _hierarchy(lines, where)
    count = int(header_number(_value_of(lines, at, "Frames:", where), f"{where}, line {at + 1}", "Frames"))
    step_s = header_number(_value_of(lines, at + 1, "Frame Time:", where), f"{where}, line {at + 2}", "Frame Time")
    rows = [(line, " ".join(text.split())) for line, text in enumerate(lines[at + 2 :], start=at + 3) if text.strip()]
    if len(rows) < count:
        hint = "the file may be cut off: export it again"
        raise MappingError(f"holds {len(rows)} of {count} frames", where=where, field="Frames", hint=hint)
    names = [f"{joint.name} {channel}" for joint in hierarchy.joints for channel in joint.channels]
    values = number_rows(rows[:count], names, " ", where)
    times_s = step_s * np.arange(count, dtype=np.float64)
    lost = ~np.isfinite(values).all(axis=1)
    position, turns = _moved(hierarchy.joints, np.nan_to_num(values))
    stands = _stands(hierarchy.joints)
    tracks = {}
    for k, joint in enumerate(hierarchy.joints):
        wxyz = wxyz_from_matrix(turns[k]) if stands else None
        for known in (position[k], *([] if wxyz is None else [wxyz])):
            known[lost] = np.nan
        tracks[joint.name] = TakeTrack(times_s, position[k], wxyz)
    notes = () if stands else ("the rest pose is not upright, so that the joints' own axes say nothing: places only",)
    return Take("bvh", tracks, notes=notes)


def _value_of(lines: Sequence[str], at: int, key: str, where: str) -> str:
    """What follows a key in a line of the motion."""
    text = lines[at].strip() if at < len(lines) else ""
    if not text.lower().startswith(key.lower()):
        hint = "MOTION is followed by Frames: and Frame Time:; the file may be cut off"
        raise MappingError(f"has no {key}", where=f"{where}, line {at + 1}", value=text, hint=hint)
    return text[len(key) :]


def _hierarchy(lines: Sequence[str], where: str) -> tuple[_Hierarchy, int]:
    """The joints, and the index of the line after MOTION."""
    found = _Hierarchy()
    for at, line in enumerate(lines):
        words = line.split()
        if words and words[0].upper() == "MOTION":
            if found.open or not found.joints:
                raise MappingError("a joint has no end", where=f"{where}, line {at + 1}", hint="braces do not match")
            return found, at + 1
        if words:
            _take_line(found, words, f"{where}, line {at + 1}")
    raise MappingError("has no MOTION", where=where, hint="the file may be cut off: export it again")


def _take_line(found: _Hierarchy, words: list[str], where: str) -> None:
    key = words[0].upper()
    if key in ("ROOT", "JOINT"):
        name = " ".join(words[1:])
        if any(joint.name == name for joint in found.joints):
            raise MappingError("two joints have one name", where=where, value=name, hint="rename one of them")
        parent = found.open[-1] if found.open else -1
        if parent is None:
            raise MappingError("an end site has a joint", where=where, value=name, hint="braces do not match")
        found.joints.append(_Joint(name, parent, first=found.columns))
        found.open.append(len(found.joints) - 1)
    elif key == "END":
        found.open.append(None)
    elif key == "}" and found.open:
        found.open.pop()
    elif key in ("OFFSET", "CHANNELS") and found.open:
        joint = found.open[-1]
        if joint is not None:
            _describe(found, found.joints[joint], key, words[1:], where)
    elif key not in ("HIERARCHY", "{"):
        raise MappingError("cannot be understood", where=where, value=" ".join(words), hint="export the file again")


def _describe(found: _Hierarchy, joint: _Joint, key: str, words: list[str], where: str) -> None:
    if key == "OFFSET":
        x, y, z = ([number(word) for word in words] + [np.nan] * 3)[:3]
        if not (np.abs([x, y, z]) <= LARGEST).all():
            raise MappingError("must be three numbers", where=where, field="OFFSET", value=words, hint="mend it")
        joint.offset = (x, y, z)
        return
    known = {channel.lower(): channel for channel in CHANNELS}
    channels = tuple(known.get(word.lower(), "") for word in words[1:])
    if (
        joint.channels
        or not words
        or words[0] != str(len(channels))
        or "" in channels
        or len({*channels}) < len(channels)
    ):
        hint = f"give their number and names: {', '.join(CHANNELS)}"
        raise MappingError("cannot be understood", where=where, field="CHANNELS", value=words, hint=hint)
    joint.channels, joint.first = channels, found.columns
    found.columns += len(channels)


def _moved(joints: Sequence[_Joint], values: Array) -> tuple[list[Array], list[Array]]:
    """Places (n, 3) and rotations (n, 3, 3) of all joints in the file's axes."""
    places: list[Array] = []
    turns: list[Array] = []
    for joint in joints:
        columns = {channel: values[:, joint.first + k] for k, channel in enumerate(joint.channels)}
        shift = np.stack([columns.get(f"{a}position", np.full(len(values), o)) for a, o in _axes(joint)], axis=1)
        turn = _turn(columns, len(values))
        if joint.parent < 0:
            places.append(shift)
            turns.append(turn)
        else:
            places.append(places[joint.parent] + np.einsum("nij,nj->ni", turns[joint.parent], shift))
            turns.append(turns[joint.parent] @ turn)
    return places, turns


def _axes(joint: _Joint) -> tuple[tuple[str, float], ...]:
    """Axes and what a joint without a position of its own has along them: its offset."""
    return tuple(zip("XYZ", joint.offset, strict=True))


def _turn(columns: Mapping[str, Array], count: int) -> Array:
    """A joint's own rotation: turns in the order of the channels, each about the axes that those before it moved."""
    given = {channel[0].lower(): column for channel, column in columns.items() if channel.endswith("rotation")}
    angles = given | {axis: np.zeros(count) for axis in "xyz" if axis not in given}
    three = np.radians(np.stack(list(angles.values()), axis=1))
    return matrix_from_euler(three, "".join(angles), intrinsic=True)


def _stands(joints: Sequence[_Joint]) -> bool:
    """Whether the rest pose stands along y and has its left at +x: then it faces z."""
    places: list[Array] = []
    for joint in joints:
        origin = places[joint.parent] if joint.parent >= 0 else np.zeros(3)
        places.append(origin + joint.offset if joint.parent >= 0 else origin)
    named = {joint.name.rpartition(":")[2].lower(): place for joint, place in zip(joints, places, strict=True)}
    head = next((named[name] for name in ("head", "neck") if name in named), None)
    sides = [[p[0] for name, p in named.items() if name.startswith(side)] for side in ("left", "right")]
    if head is None or not np.linalg.norm(head) or not all(sides):
        return False
    return bool(head[1] > UPRIGHT * np.linalg.norm(head) and np.mean(sides[0]) > np.mean(sides[1]))
