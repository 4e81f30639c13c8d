"""Whole recordings moved, turned about the vertical, or seen in a mirror: room, furniture, people and all frames."""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ET
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from taskgist.recording import Recording
from taskgist.world import Scene
from taskgist.world.geometry.transforms import about_z, multiply

Array = NDArray[np.float64]
Change = Callable[[Array], Array]
"""Takes and gives poses, (n, 7): position in metres and wxyz."""

MIRRORED_JOINTS = {"torso_turn", "torso_side", "head_pan", "head_roll"}
"""Joints of the middle of the body that a mirror reverses; those of the sides change places."""


def moved(recording: Recording, yaw_rad: float, x_m: float, y_m: float) -> Recording:
    """The same, standing elsewhere and facing another way."""
    cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
    turn = np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])

    def change(poses: Array) -> Array:
        return np.hstack([poses[:, :3] @ turn.T + (x_m, y_m, 0), multiply(about_z(yaw_rad), poses[:, 3:])])

    scene = _scene(recording.scene, change, lambda yaw_deg: yaw_deg + math.degrees(yaw_rad))
    return replace(recording, scene=scene, qpos=_frames(recording, change))


def mirrored(recording: Recording) -> Recording:
    """The same as a mirror along the x axis shows it: left becomes right."""
    scene = _scene(recording.scene, _mirror, lambda yaw_deg: -yaw_deg, everything=True)
    qpos = _frames(recording, _mirror)
    for agent in scene.agents:
        columns = dict(zip(scene.joints(agent), scene.joint_indices(agent), strict=True))
        for joint, column in columns.items():
            sign = -1 if joint in MIRRORED_JOINTS else 1
            qpos[:, column] = sign * recording.qpos[:, columns[swapped(joint)]]
    tracked = {swapped(name): flags for name, flags in recording.tracked.items()}
    return replace(recording, scene=scene, qpos=qpos, tracked=tracked)


def swapped(text: str) -> str:
    """Left for right, and right for left."""
    return re.sub("left|right", lambda side: {"left": "right", "right": "left"}[side.group()], text)


def _mirror(poses: Array) -> Array:
    return np.asarray(poses * (1, -1, 1, 1, -1, 1, -1))


def _frames(recording: Recording, change: Change) -> Array:
    scene, qpos = recording.scene, np.array(recording.qpos)
    for columns in (*map(scene.base_slice, scene.agents), *map(scene.object_slice, scene.objects)):
        qpos[:, columns] = change(qpos[:, columns])
    return qpos


def _scene(scene: Scene, change: Change, turn: Callable[[float], float], *, everything: bool = False) -> Scene:
    bundle = dict(scene.bundle)
    bundle["room.xml"] = _room(bundle["room.xml"], change, everything=everything)
    bundle["scene.toml"] = _scene_file(bundle["scene.toml"].decode(), change, turn).encode()
    return Scene.from_bundle(bundle)


def _room(xml: bytes, change: Change, *, everything: bool) -> bytes:
    """The room with the bodies and shapes that stand in it changed; with everything, shapes inside bodies too."""
    root = ET.fromstring(xml)
    world = root.find("worldbody")
    assert world is not None
    placed = [element for element in (world.iter() if everything else world) if element.tag in ("body", "geom")]
    for element in placed:
        assert not {"euler", "axisangle", "fromto", "xyaxes"} & set(element.attrib)
        pose = np.array([*_numbers(element.get("pos", "0 0 0")), *_numbers(element.get("quat", "1 0 0 0"))])
        new = change(pose[None])[0]
        element.set("pos", " ".join(map(repr, new[:3].tolist())))
        element.set("quat", " ".join(map(repr, new[3:].tolist())))
    return ET.tostring(root)


def _scene_file(text: str, change: Change, turn: Callable[[float], float]) -> str:
    def place(found: re.Match[str]) -> str:
        x, y, *_ = change(np.array([[*_numbers(found[1].replace(",", " ")), 0, 1, 0, 0, 0]]))[0].tolist()
        return f"position_m = [{x!r}, {y!r}]"

    text, count = re.subn(r"position_m = \[([^]]*)\]", place, text)
    assert count == text.count("position_m")
    return re.sub(r"yaw_deg = (\S+)", lambda found: f"yaw_deg = {turn(float(found[1]))!r}", text)


def _numbers(text: str) -> list[float]:
    return [float(word) for word in text.split()]
