"""``/taskgist/state``: one JSON message per frame, by names, so that any program can read a recording."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taskgist.errors import RecordingError
from taskgist.recording.recording import Recording
from taskgist.recording.rounding import free_slices
from taskgist.world import Scene

Message = dict[str, Any]
Array = NDArray[np.float64]

_NUMBERS: Message = {"type": "array", "items": {"type": "number"}}
_POSE = _NUMBERS | {
    "minItems": 7,
    "maxItems": 7,
    "description": "x, y, z in metres and the quaternion w, x, y, z, in the world (z up)",
}
STATE_SCHEMA: Message = {
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


def encode(recording: Recording) -> list[Message]:
    """The messages of all frames."""
    others = _other_columns(recording.scene)
    states = (recording.state(frame) for frame in range(len(recording)))
    return [_message(recording.scene, state.qpos, others, state.untracked) for state in states]


def decode(scene: Scene, messages: Sequence[Message]) -> tuple[Array, dict[str, NDArray[np.bool_]]]:
    """Positions (N, nq), and by name the frames in which something was tracked, (N,).

    Raises:
        RecordingError: A message lacks something that the scene has, or holds another number of values.
    """
    qpos = np.empty((len(messages), scene.nq))
    others = _other_columns(scene)
    untracked: dict[str, list[int]] = {}
    for frame, message in enumerate(messages):
        try:
            _read(scene, message, qpos[frame], others)
            names = [str(name) for name in message["untracked"]]
        except (KeyError, TypeError, ValueError, AttributeError) as problem:
            hint = "the file was changed, or not written by taskgist"
            raise RecordingError(
                f"state {frame} does not fit the scene", field="/taskgist/state", value=repr(problem), hint=hint
            ) from None
        for name in names:
            untracked.setdefault(name, []).append(frame)
    tracked = {name: ~np.isin(np.arange(len(messages)), frames) for name, frames in untracked.items()}
    return qpos, tracked


def _message(scene: Scene, row: Array, others: NDArray[np.intp], untracked: frozenset[str]) -> Message:
    message: Message = {
        "objects": {name: row[scene.object_slice(name)].tolist() for name in scene.objects},
        "agents": {
            name: {"base": row[scene.base_slice(name)].tolist(), "joints": row[scene.joint_indices(name)].tolist()}
            for name in scene.agents
        },
        "untracked": sorted(untracked),
    }
    return message | ({"others": row[others].tolist()} if len(others) else {})


def _read(scene: Scene, message: Mapping[str, Any], row: Array, others: NDArray[np.intp]) -> None:
    for name in scene.objects:
        row[scene.object_slice(name)] = _numbers(message["objects"][name], 7)
    for name in scene.agents:
        agent, joints = message["agents"][name], scene.joint_indices(name)
        row[scene.base_slice(name)] = _numbers(agent["base"], 7)
        row[joints] = _numbers(agent["joints"], len(joints))
    row[others] = _numbers(message.get("others", []), len(others))


def _numbers(values: Any, count: int) -> Array:
    array = np.array(values, dtype=np.float64)
    if array.shape != (count,):
        raise ValueError(f"{count} numbers expected, {array.shape} found")
    return array


def _other_columns(scene: Scene) -> NDArray[np.intp]:
    """Columns of qpos that belong to no object and no agent, such as the hinge of a door."""
    named = np.zeros(scene.nq, dtype=np.bool_)
    for free in free_slices(scene):
        named[free] = True
    for agent in scene.agents:
        named[scene.joint_indices(agent)] = True
    return np.flatnonzero(~named)
