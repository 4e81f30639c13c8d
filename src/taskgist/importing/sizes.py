"""How large a tracked person is: stature and segment lengths, from the distances between landmarks."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from taskgist.common.arrays import Array, Mask
from taskgist.errors import SceneError
from taskgist.settings import DEFAULT
from taskgist.world.bodies.human import SHARES, HumanSize
from taskgist.world.fit import Marker

Points = Mapping[str, Array]

SEGMENTS: Mapping[str, tuple[tuple[str, str], ...]] = {
    "upper_arm_m": (("left_shoulder", "left_elbow"), ("right_shoulder", "right_elbow")),
    "forearm_m": (("left_elbow", "left_wrist"), ("right_elbow", "right_wrist")),
    "hand_m": (("left_wrist", "left_fingertip"), ("right_wrist", "right_fingertip")),
    "thigh_m": (("left_hip", "left_knee"), ("right_hip", "right_knee")),
    "shank_m": (("left_knee", "left_ankle"), ("right_knee", "right_ankle")),
    "shoulder_breadth_m": (("left_shoulder", "right_shoulder"),),
    "hip_breadth_m": (("left_hip", "right_hip"),),
}
"""Pairs of landmarks between which each segment is measured."""

HEAD_HEIGHTS = {
    "head_base": 1 - SHARES["head"],
    "head": 1 - 0.5 * SHARES["head"],
    "head_top": 1.0,
    "nose": 1 - 0.60 * SHARES["head"],
    "left_eye": 1 - 0.492 * SHARES["head"],
    "right_eye": 1 - 0.492 * SHARES["head"],
}
"""Height of landmarks of the head on a standing body, as shares of the stature, most trusted first."""

HIP_SHARE = SHARES["foot_height"] + SHARES["shank"] + SHARES["thigh"]
STANDING_TRUNKS = 1.45
"""Height of the hips in lengths of the trunk: 1.84 standing, 1.08 on a chair; between them lies the border (ours)."""
STANDING_HEADS = 0.56
"""The same in heights of the head's base, for who has no tracked shoulders: 0.61 standing, 0.48 on a chair (ours)."""
STRETCHED_PERCENTILE = 90.0
"""A trunk bends and then looks shorter; this percentile of its lengths is taken for the stretched one (ours)."""
UPRIGHT_RAD = math.radians(15.0)
"""Inclination of the trunk up to which heights tell the stature."""

SOLES_M: Mapping[tuple[str, ...], float] = {
    ("left_heel", "left_toe", "right_heel", "right_toe"): 0.03,
    ("left_ankle", "right_ankle"): 0.09,
}
"""How high points of the feet are over what they stand on: heels and toes, else ankles (ours)."""


def estimate_size(
    points: Points, stature_m: float | None, markers: Mapping[str, Marker] = MappingProxyType({})
) -> HumanSize:
    """Size of a person's body.

    Args:
        points: Landmarks over time, metres, (N, 3) each, NaN where unknown.
        stature_m: The stature, where somebody measured it; else it is estimated from the height of the head.
        markers: Those of the points that only lie beside a landmark, offsets in statures: no segment begins there.

    Raises:
        SceneError: A length is not one of a human body: units or landmarks are wrong.
    """
    everything, points = points, {name: track for name, track in points.items() if name not in markers}
    measured = {name: length for name, pairs in SEGMENTS.items() if (length := _length(points, pairs)) is not None}
    trunk = _between(_hips(points), _shoulders(points), STRETCHED_PERCENTILE)
    if trunk is not None:
        measured["trunk_m"] = trunk
    neck = _neck(points)
    if neck is not None:
        measured["neck_m"] = neck
    stature = stature_m if stature_m is not None else _stature(everything, measured, markers)
    return HumanSize.from_stature(stature, **measured)


def stands(points: Points, markers: Mapping[str, Marker] = MappingProxyType({})) -> Mask:
    """Whether the person stands in each frame, by the height of the hips, (N,); False where unknown."""
    hips, shoulders, head = _hips(points), _shoulders(points), _head(points, markers)
    trunk = _between(hips, shoulders, STRETCHED_PERCENTILE)
    if hips is None or (trunk is None and head is None):
        return np.zeros(_count(points), dtype=bool)
    if trunk is not None:
        return np.asarray(hips[:, 2] > STANDING_TRUNKS * trunk)
    assert head is not None
    return np.asarray(hips[:, 2] / head[0][:, 2] * head[1] / HEAD_HEIGHTS["head_base"] > STANDING_HEADS)


def _stature(points: Points, measured: Mapping[str, float], markers: Mapping[str, Marker]) -> float:
    """From heights while the person is upright, else from the lengths of the segments."""
    head, hips = _head(points, markers), _hips(points)
    if head is not None and hips is not None:
        soles_m = height_of_soles_m(points)
        floor_m = soles_m if abs(soles_m) > DEFAULT.checks.off_floor_m else 0.0
        upright = _upright(hips, head[0])
        standing = upright & stands({name: track - (0.0, 0.0, floor_m) for name, track in points.items()}, markers)
        if standing.any():
            return (float(np.median(head[0][standing, 2])) - floor_m) / head[1]
        if upright.any():
            return float(np.median((head[0] - hips)[upright, 2])) / (head[1] - HIP_SHARE)
    ratios = [length / SHARES[name.removesuffix("_m")] for name, length in measured.items()]
    if not ratios:
        raise SceneError("too few landmarks to tell how large the person is", field="stature_m", hint="give stature_m")
    return float(np.median(ratios))


def _upright(hips: Array, head: Array) -> Mask:
    rise = head - hips
    return np.asarray(rise[:, 2] > np.cos(UPRIGHT_RAD) * np.linalg.norm(rise, axis=1))


def _neck(points: Points) -> float | None:
    """From the line of the shoulders to the base of the head."""
    return _between(_shoulders(points), points.get("head_base"))


def _shoulders(points: Points) -> Array | None:
    return _middle(points, "left_shoulder", "right_shoulder")


def _hips(points: Points) -> Array | None:
    middle = _middle(points, "left_hip", "right_hip")
    return middle if middle is not None else points.get("pelvis")


def _head(points: Points, markers: Mapping[str, Marker]) -> tuple[Array, float] | None:
    """A point of the head and its height on a standing body, as a share of the stature; landmarks before markers."""
    for name, share in HEAD_HEIGHTS.items():
        if name in points and name not in markers:
            return points[name], share
    for name, marker in markers.items():
        if name in points and marker.landmark in HEAD_HEIGHTS:
            return points[name], HEAD_HEIGHTS[marker.landmark] + marker.offset_m[2]
    return None


def _middle(points: Points, a: str, b: str) -> Array | None:
    return (points[a] + points[b]) / 2 if a in points and b in points else None


def _length(points: Points, pairs: tuple[tuple[str, str], ...]) -> float | None:
    lengths = [length for a, b in pairs if (length := _between(points.get(a), points.get(b))) is not None]
    return float(np.mean(lengths)) if lengths else None


def _between(a: Array | None, b: Array | None, percentile: float = 50.0) -> float | None:
    """Distance in metres over the frames in which both are known: the median, or another percentile."""
    if a is None or b is None:
        return None
    distances = np.linalg.norm(a - b, axis=1)
    known = distances[np.isfinite(distances)]
    length = float(np.percentile(known, percentile)) if len(known) else 0.0
    return length if length > 0 else None


def _count(points: Points) -> int:
    return len(next(iter(points.values()))) if points else 0


def height_of_soles_m(points: Points) -> float:
    """Height of the soles of the lower foot, metres, the median over time; 0 where no feet are known."""
    for landmarks, over_m in SOLES_M.items():
        heights = [points[landmark][:, 2] for landmark in landmarks if landmark in points]
        if heights and np.isfinite(heights).any():
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", RuntimeWarning)  # frames in which no foot is known are NaN
                return float(np.nanmedian(np.nanmin(heights, axis=0))) - over_m
    return 0.0
