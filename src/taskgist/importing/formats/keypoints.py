"""JSON of body trackers on cameras: ZED (Stereolabs) and MediaPipe (Google); a frame holds people, a person points.

ZED: the bodies of the SDK as its samples write them, frames in a list or by name, each with ``timestamp`` and
``body_list``; a body has ``id``, ``keypoint`` and ``keypoint_confidence`` (https://www.stereolabs.com/docs/body-tracking).
MediaPipe has no file of its own: read are frames in a list, or below ``frames``, each with world landmarks under one of
their names in its interfaces, of one person or of a list of people, and a time, or ``fps`` beside the frames.

Units and axes are settings of the ZED that no file holds; MediaPipe's are metres, y down, from the middle of the hips.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from taskgist.common.arrays import Array
from taskgist.common.files import read_whole
from taskgist.errors import MappingError
from taskgist.importing.skeletons import MEDIAPIPE_POSE, ZED_BODY_34, ZED_BODY_38
from taskgist.importing.takes import OWNER, Take, TakeTrack

ZED_NAMES = {34: ZED_BODY_34.names, 38: ZED_BODY_38.names}
WORLD = ("pose_world_landmarks", "poseWorldLandmarks", "world_landmarks", "worldLandmarks")
IMAGE = ("pose_landmarks", "poseLandmarks", "landmarks")
TIMES = ("timestamp_ms", "timestampMs", "timestamp", "time", "time_s", "t")
SECONDS = (1e9, 4e9)
"""Unix time between 2001 and 2096, in seconds; a thousand, a million, ... times that tell finer units."""
STEP_S = (1e-3, 1.0)
"""Between frames of a camera (ours): tells seconds from milliseconds where times begin at 0."""

Frame = Mapping[str, tuple[Array, Array]]
"""People of a frame: places of their points (k, 3) and confidence (k,), NaN where unknown."""


def is_zed(head: bytes) -> bool:
    """Whether a file that begins so is JSON of ZED."""
    return head.lstrip()[:1] in (b"{", b"[") and b'"body_list"' in head


def is_mediapipe(head: bytes) -> bool:
    """Whether a file that begins so is JSON of MediaPipe."""
    return head.lstrip()[:1] in (b"{", b"[") and any(f'"{name}"'.encode() in head for name in (*WORLD, *IMAGE))


def read_zed(path: Path, where: str, most_bytes: int) -> Take:
    """The bodies of a JSON of ZED, by their numbers.

    Raises:
        MappingError: It cannot be read, is too large, or no JSON; frames have no time; bodies differ in their points.
    """
    frames = [frame for frame in _frames(_document(path, where, most_bytes)) if isinstance(frame, Mapping)]
    times_s = _times(frames, None, where)
    people = [dict(_bodies(frame, f"{where}, frame {k}")) for k, frame in enumerate(frames)]
    return _take("zed", times_s, people, ZED_NAMES, where)


def read_mediapipe(path: Path, where: str, most_bytes: int) -> Take:
    """The world landmarks of a JSON of MediaPipe.

    Raises:
        MappingError: It cannot be read, is too large, or no JSON; it holds places in the image only; frames have no
            time.
    """
    document = _document(path, where, most_bytes)
    frames = [frame for frame in _frames(document) if isinstance(frame, Mapping)]
    if not any(name in frame for frame in frames for name in WORLD):
        hint = f"save the world landmarks ({WORLD[0]}), or points in metres from several cameras"
        raise MappingError("holds places in the image only", where=where, hint=hint)
    times_s = _times(frames, document.get("fps") if isinstance(document, Mapping) else None, where)
    people = [dict(_landmarks(frame, f"{where}, frame {k}")) for k, frame in enumerate(frames)]
    notes = ("world landmarks begin at the hips: who sits down, stands up or walks cannot be told",)
    return _take("mediapipe", times_s, people, {33: MEDIAPIPE_POSE.names}, where, unit="m", up="-y", notes=notes)


def _document(path: Path, where: str, most_bytes: int) -> Any:
    content = read_whole(path, most_bytes=most_bytes // 8, setting="table_bytes", error=MappingError)
    try:
        return json.loads(content)
    except (ValueError, RecursionError) as problem:
        raise MappingError(f"is no JSON: {problem}", where=where, hint="the file may be cut off") from problem


def _frames(document: Any) -> Sequence[Any]:
    """Frames in a list, below "frames", or by name in their order."""
    if isinstance(document, Mapping):
        inside = document.get("frames", document)
        return list(inside.values()) if isinstance(inside, Mapping) else inside if isinstance(inside, list) else []
    return document if isinstance(document, list) else []


def _times(frames: Sequence[Mapping[str, Any]], fps: object, where: str) -> Array:
    """Times in seconds, whatever their unit, which Unix times tell by their size, others by their step."""
    key = next((key for key in TIMES if frames and key in frames[0]), None)
    if key is None and isinstance(fps, int | float) and not isinstance(fps, bool) and 0 < fps < 1e5:
        return np.asarray(np.arange(len(frames)) / float(fps))
    if key is None:
        hint = f"save the time of each frame as one of {', '.join(TIMES)}, or fps beside the frames"
        raise MappingError("frames have no time", where=where, hint=hint)
    times = np.array([_number(frame.get(key)) for frame in frames])
    if not np.isfinite(times).all():
        at = int(np.argmin(np.isfinite(times)))
        raise MappingError("is no time", where=f"{where}, frame {at}", field=key, value=frames[at].get(key))
    if key.endswith(("_ms", "Ms")):
        return np.asarray(times / 1e3)
    for per_second in (1.0, 1e3, 1e6, 1e9):
        if SECONDS[0] <= times[0] / per_second < SECONDS[1]:
            return np.asarray((times - times[0]) / per_second)
    step = float(np.median(np.diff(times))) if len(times) > 1 else 0.0
    for per_second in (1.0, 1e3, 1e6, 1e9):
        if STEP_S[0] < step / per_second < STEP_S[1]:
            return np.asarray(times / per_second)
    raise MappingError("the unit of times is not known", where=where, field=key, value=step, hint="save seconds")


def _bodies(frame: Mapping[str, Any], where: str) -> Iterator[tuple[str, tuple[Array, Array]]]:
    bodies = frame.get("body_list")
    for body in bodies if isinstance(bodies, list) else ():
        if not isinstance(body, Mapping) or not isinstance(body.get("keypoint"), list):
            raise MappingError("is no body with keypoints", where=where, field="body_list", hint="export it again")
        places = np.array([_triple(point, where) for point in body["keypoint"]]).reshape(-1, 3)
        given = body.get("keypoint_confidence")
        confidence = [_number(value) for value in given] if isinstance(given, list) else []
        if len(confidence) != len(places):
            confidence = [math.nan] * len(places)
        yield str(body.get("id", 0)), (places, np.array(confidence))


def _landmarks(frame: Mapping[str, Any], where: str) -> Iterator[tuple[str, tuple[Array, Array]]]:
    found: Any = next((frame[name] for name in WORLD if frame.get(name)), [])
    found = found.get("landmark", []) if isinstance(found, Mapping) else found
    if not isinstance(found, list):
        raise MappingError("is no list of landmarks", where=where, hint="save x, y, z and visibility of each")
    people = found if found and isinstance(found[0], list) else [found] if found else []
    for number, points in enumerate(people):
        if not all(isinstance(point, Mapping) for point in points):
            raise MappingError("is no landmark", where=where, hint="save x, y, z and visibility of each")
        places = [[_number(point.get(axis)) for axis in "xyz"] for point in points]
        seen = [_number(point.get("visibility")) for point in points]
        yield str(number), (np.array(places).reshape(-1, 3), np.array(seen))


def _triple(point: object, where: str) -> list[float]:
    if point is None:
        return [math.nan] * 3
    if not isinstance(point, list) or len(point) != 3:
        hint = "export keypoint, which has x, y and z, not keypoint_2d"
        raise MappingError("is no place", where=where, field="keypoint", value=point, hint=hint)
    return [_number(value) for value in point]


def _number(value: object) -> float:
    return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else math.nan


def _take(
    kind: str,
    times_s: Array,
    frames: Sequence[Frame],
    names: Mapping[int, Sequence[str]],
    where: str,
    *,
    unit: str | None = None,
    up: str | None = None,
    notes: tuple[str, ...] = (),
) -> Take:
    """Each person's points over time, NaN in frames without that person."""
    tracks: dict[str, TakeTrack] = {}
    for person in dict.fromkeys(person for frame in frames for person in frame):
        counts = {len(frame[person][0]) for frame in frames if person in frame}
        if len(counts) > 1:
            hint = "export all frames with one model of the body"
            raise MappingError("a person's number of points changes", where=where, value=sorted(counts), hint=hint)
        count = counts.pop()
        lost = (np.full((count, 3), np.nan), np.full(count, np.nan))
        places = np.stack([frame.get(person, lost)[0] for frame in frames])
        confidence = np.stack([frame.get(person, lost)[1] for frame in frames])
        known = bool(np.isfinite(confidence).any())
        for k, name in enumerate(names.get(count, [f"point {k}" for k in range(count)])):
            tracks[f"{person}{OWNER}{name}"] = TakeTrack(
                times_s, places[:, k], confidence=confidence[:, k] if known else None
            )
    if not tracks:
        raise MappingError("nobody is in it", where=where, hint="check the file")
    return Take(kind, tracks, unit=unit, up=up, notes=notes)
