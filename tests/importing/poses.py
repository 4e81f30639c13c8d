"""Poses of a person as a depth camera's 34 keypoints give them: upright, leaning, sitting, crouching, lying."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from taskgist.importing import import_recording, load_mapping
from taskgist.recording import Recording
from tests.importing.skeletons import NAMES, Array, mapping_file

MIDDLE = {
    "PELVIS": (0.0, 0.92),
    "NAVAL_SPINE": (0.0, 1.08),
    "CHEST_SPINE": (0.0, 1.25),
    "NECK": (0.0, 1.42),
    "HEAD": (0.02, 1.53),
    "NOSE": (0.13, 1.58),
}
SIDE = {
    "EYE": (0.10, 0.03, 1.62),
    "EAR": (0.01, 0.075, 1.60),
    "CLAVICLE": (0.0, 0.05, 1.42),
    "SHOULDER": (0.0, 0.18, 1.42),
    "ELBOW": (0.0, 0.20, 1.16),
    "WRIST": (0.02, 0.20, 0.91),
    "HAND": (0.03, 0.20, 0.86),
    "HANDTIP": (0.04, 0.20, 0.76),
    "THUMB": (0.06, 0.18, 0.82),
    "HIP": (0.0, 0.09, 0.92),
    "KNEE": (0.01, 0.09, 0.53),
    "ANKLE": (0.0, 0.09, 0.14),
    "FOOT": (0.16, 0.09, 0.04),
    "HEEL": (-0.04, 0.09, 0.05),
}
"""Of somebody upright at the origin who looks along x: no body of ours has its face where this one has it."""
LOWER = ("PELVIS", "HIP", "KNEE", "ANKLE", "FOOT", "HEEL")
Pose = Mapping[str, Array]

MAPPED = {"pelvis": "PELVIS", "abdomen": "NAVAL_SPINE", "chest": "CHEST_SPINE", "neck": "NECK", "head": "HEAD"} | {
    "nose": "NOSE"
}
SIDED = {"hand": "HAND", "fingertip": "HANDTIP", "thumb": "THUMB", "toe": "FOOT"} | {
    name: name.upper() for name in ("eye", "ear", "shoulder", "elbow", "wrist", "hip", "knee", "ankle", "heel")
}
"""Every point as a landmark, as one would map them without knowing better."""


def upright() -> dict[str, Array]:
    """The person upright."""
    points = {name: np.array((x, 0.0, z)) for name, (x, z) in MIDDLE.items()}
    for side, sign in (("LEFT", 1.0), ("RIGHT", -1.0)):
        points |= {f"{side}_{part}": np.array((x, sign * y, z)) for part, (x, y, z) in SIDE.items()}
    return points


def about_y(degrees: float) -> Array:
    """A turn that leans forward, (3, 3)."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array(((c, 0.0, s), (0.0, 1.0, 0.0), (-s, 0.0, c)))


def about_x(degrees: float) -> Array:
    """A turn that leans to the right, (3, 3)."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array(((1.0, 0.0, 0.0), (0.0, c, -s), (0.0, s, c)))


def leaning(turn: Array) -> dict[str, Array]:
    """All above the hips turned about them."""
    hips = np.array((0.0, 0.0, 0.92))
    return {
        name: at if name.split("_")[-1] in LOWER and name != "NAVAL_SPINE" else turn @ (at - hips) + hips
        for name, at in upright().items()
    }


def lying(turn: Array, height_m: float) -> dict[str, Array]:
    """The whole person turned, hips at a height."""
    return {name: turn @ (at - (0.0, 0.0, 0.92)) + (0.0, 0.0, height_m) for name, at in upright().items()}


def legs_bent(thigh_deg: float, shank_deg: float, trunk_deg: float = 0.0) -> dict[str, Array]:
    """Thighs and shanks swung forward, the trunk leaning; the lowest point 3 cm over the floor."""
    points, straight = leaning(about_y(trunk_deg)), upright()
    for side in ("LEFT", "RIGHT"):
        hip, knee, ankle = (straight[f"{side}_{part}"] for part in ("HIP", "KNEE", "ANKLE"))
        points[f"{side}_KNEE"] = hip + about_y(-thigh_deg) @ (knee - hip)
        points[f"{side}_ANKLE"] = points[f"{side}_KNEE"] + about_y(-shank_deg) @ (ankle - knee)
        for part in ("FOOT", "HEEL"):
            points[f"{side}_{part}"] = points[f"{side}_ANKLE"] + straight[f"{side}_{part}"] - ankle
    lowest_m = min(at[2] for at in points.values())
    return {name: at - (0.0, 0.0, lowest_m - 0.03) for name, at in points.items()}


POSES: Mapping[str, Pose] = {
    "upright": upright(),
    "leaning 20": leaning(about_y(20)),
    "leaning 45": leaning(about_y(45)),
    "leaning back 10": leaning(about_y(-10)),
    "leaning aside 15": leaning(about_x(15)),
    "bending 60": leaning(about_y(60)),
    "bending 75": leaning(about_y(75)),
    "bending 90": leaning(about_y(90)),
    "sitting": legs_bent(90, 0),
    "sitting, leaning 30": legs_bent(90, 0, 30),
    "reclining 35": legs_bent(90, 10, -35),
    "sitting on the floor": legs_bent(90, 90, 10),
    "squatting": legs_bent(80, -40, 50),
    "crouching": legs_bent(120, -20, 40),
    "lying on the back": lying(about_y(-90), 0.12),
    "lying on the belly": lying(about_y(90), 0.12),
    "lying on the side": lying(about_x(90), 0.2),
}


def imported(
    folder: Path, pose: Pose, *, noise_m: float = 0.0, frames: int = 20, person: str = "", without: tuple[str, ...] = ()
) -> Recording:
    """A recording of somebody who keeps still in a pose, with white noise, smoothed as the docs advise.

    Args:
        folder: Where to write tables and mapping.
        pose: The keypoints.
        noise_m: Standard deviation of each coordinate.
        frames: How many.
        person: Fields of [people.P1] instead of every point as a landmark.
        without: Endings of landmarks that are not mapped.
    """
    still = np.array([pose[name] for name in NAMES])
    rng = np.random.default_rng(3)
    np.savez(folder / "points.npz", points=still + rng.normal(0.0, noise_m, (frames, *still.shape)))
    landmarks = MAPPED | {
        f"{side}_{name}": f"{side.upper()}_{theirs}" for side in ("left", "right") for name, theirs in SIDED.items()
    }
    points = "".join(
        f'{ours} = "{theirs}"\n' for ours, theirs in landmarks.items() if not ours.endswith(without or "-")
    )
    names = repr(NAMES).replace("'", '"')
    text = f"""
[sources.body]
file = "points.npz"
rate_hz = 30
units = "m"
names = {names}
smooth_s = {0.2 if noise_m else 0}
[people.P1]
source = "body"
{person or "[people.P1.points]" + chr(10) + points}
"""
    return import_recording(load_mapping(mapping_file(folder, text)))
