"""Two people of 34 bare keypoints and a cup, moving a little, in the room's axes; and mappings of them as text."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from taskgist.importing import Tracks, load_mapping, read_tracks
from taskgist.world.geometry.transforms import about_z, matrix_from_wxyz, multiply, wxyz_from_rotation_vector

Array = NDArray[np.float64]

_ARM = ("CLAVICLE", "SHOULDER", "ELBOW", "WRIST", "HAND", "HANDTIP", "THUMB")
_LEG = ("HIP", "KNEE", "ANKLE", "FOOT")
NAMES = [
    *("PELVIS", "NAVAL_SPINE", "CHEST_SPINE", "NECK"),
    *(f"{side}_{part}" for parts in (_ARM, _LEG) for side in ("LEFT", "RIGHT") for part in parts),
    *("HEAD", "NOSE", "LEFT_EYE", "LEFT_EAR", "RIGHT_EYE", "RIGHT_EAR", "LEFT_HEEL", "RIGHT_HEEL"),
]
"""Of a widespread skeleton of 34 keypoints, in its order."""

FRAMES, RATE_HZ = 31, 30.0
TIMES_S = np.arange(FRAMES) / RATE_HZ

POINTS = """
pelvis = "PELVIS"
chest = "CHEST_SPINE"
neck = "NECK"
head = "HEAD"
nose = "NOSE"
left_eye = "LEFT_EYE"
right_eye = "RIGHT_EYE"
left_ear = "LEFT_EAR"
right_ear = "RIGHT_EAR"
left_shoulder = "LEFT_SHOULDER"
left_elbow = "LEFT_ELBOW"
left_wrist = "LEFT_WRIST"
left_fingertip = "LEFT_HANDTIP"
right_shoulder = "RIGHT_SHOULDER"
right_elbow = "RIGHT_ELBOW"
right_wrist = "RIGHT_WRIST"
right_fingertip = "RIGHT_HANDTIP"
left_knee = "LEFT_KNEE"
left_ankle = "LEFT_ANKLE"
"""

_MIDDLE = {
    "PELVIS": (0.0, 0.95),
    "NAVAL_SPINE": (0.0, 1.1),
    "CHEST_SPINE": (0.0, 1.25),
    "NECK": (0.0, 1.48),
    "HEAD": (0.02, 1.62),
    "NOSE": (0.12, 1.6),
}
_SIDE = {
    "CLAVICLE": (0.0, 0.05, 1.42),
    "SHOULDER": (0.0, 0.19, 1.42),
    "ELBOW": (0.02, 0.24, 1.13),
    "WRIST": (0.15, 0.22, 0.95),
    "HAND": (0.22, 0.21, 0.93),
    "HANDTIP": (0.30, 0.20, 0.92),
    "THUMB": (0.22, 0.17, 0.95),
    "HIP": (0.0, 0.09, 0.93),
    "KNEE": (0.02, 0.10, 0.5),
    "ANKLE": (0.0, 0.10, 0.08),
    "FOOT": (0.18, 0.11, 0.03),
    "HEEL": (-0.06, 0.10, 0.03),
    "EYE": (0.1, 0.032, 1.64),
    "EAR": (0.0, 0.075, 1.62),
}


def standing() -> Array:
    """A person at the origin who looks along x, (34, 3)."""
    points = []
    for name in NAMES:
        if name in _MIDDLE:
            x, z = _MIDDLE[name]
            points.append((x, 0.0, z))
        else:
            side, _, part = name.partition("_")
            x, y, z = _SIDE[part]
            points.append((x, y if side == "LEFT" else -y, z))
    return np.array(points)


def keypoints() -> Array:
    """Two people who face each other and sway, each point in its own way, (frames, 2, 34, 3)."""
    rng = np.random.default_rng(4)
    body = standing()
    sway = 0.02 * np.sin(2 * np.pi * TIMES_S[:, None, None] + rng.uniform(0, 6, (34, 3)))
    facing = matrix_from_wxyz(about_z(np.pi))
    first = body + sway + (-0.8, 0.0, 0.0)
    second = (body + sway[::-1]) @ facing.T + (0.8, 0.1, 0.0)
    return np.stack([first, second], axis=1)


def cup_position() -> Array:
    """(frames, 3)."""
    return np.column_stack([0.3 * TIMES_S - 0.2, 0.1 * np.sin(TIMES_S), 0.8 + 0.2 * TIMES_S])


def cup_wxyz() -> Array:
    """A turn about a slanted axis, (frames, 4)."""
    tilted = wxyz_from_rotation_vector(np.array([0.3, -0.2, 0.1]))
    turning = wxyz_from_rotation_vector(np.array([0.2, 0.5, -1.0]) * TIMES_S[:, None])
    return multiply(turning, tilted)


def tracks_of(folder: Path, text: str) -> Tracks:
    """Tracks of a mapping that is given as text."""
    return read_tracks(load_mapping(mapping_file(folder, text)))


def mapping_file(folder: Path, text: str) -> Path:
    file = folder / "mapping.toml"
    file.write_text(text, encoding="utf-8")
    return file


def write_csv(file: Path, header: list[str] | None, rows: Array, delimiter: str = ",") -> None:
    lines = [] if header is None else [delimiter.join(header)]
    lines += [delimiter.join(repr(float(value)) for value in row) for row in rows]
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")


def npz_mapping(folder: Path, *, people: str = "", objects: str = "", source: str = "", top: str = "") -> str:
    """The plain layout: everything in one NPZ, metres, seconds, z up; written to ``folder`` as data.npz."""
    if not (folder / "data.npz").exists():
        np.savez(folder / "data.npz", t=TIMES_S, body=keypoints(), cup=np.hstack([cup_position(), cup_wxyz()]))
    return f"""
{top}
[sources.body]
file = "data.npz"
array = "body"
time = {{ column = "t", unit = "s" }}
units = "m"
names = {NAMES}
{source}
[sources.things]
file = "data.npz"
array = "{{point}}"
time = {{ column = "t", unit = "s" }}
units = "m"
rotation = {{ kind = "wxyz", columns = [3, 4, 5, 6] }}
[people.P1]
source = "body"
person = 0
{people}
[people.P1.points]
{POINTS}
[people.P2]
like = "P1"
person = 1
[objects.cup]
source = "things"
shape = {{ type = "cylinder", radius_m = 0.04, length_m = 0.1 }}
{objects}
"""
