"""One person's landmarks and directions at the frames of a recording."""

from __future__ import annotations

from collections.abc import Mapping as AnyMapping
from types import MappingProxyType

import numpy as np

from taskgist.errors import MappingError
from taskgist.recording.landmarks import HEAD_POINTS
from taskgist.recording.mapping.model import Between, LocalAxis, Mapping, Person, PointRef
from taskgist.recording.rotations import Array
from taskgist.recording.tables import Track
from taskgist.recording.tracks.model import PersonTrack
from taskgist.recording.tracks.resample import Frames, resample
from taskgist.recording.tracks.rigid import completed
from taskgist.world.geometry.rotations import matrix_from_wxyz

Samples = AnyMapping[str, tuple[tuple[PointRef, Track], ...]]
"""The source points of each landmark of one person, and their samples."""


def tracked_person(person: Person, samples: Samples, frames_s: Array, mapping: Mapping) -> PersonTrack:
    """A person at the frames of a recording.

    Args:
        person: What the mapping says.
        samples: The person's tracks.
        frames_s: Times of the frames, (N,), in the time of the sources.
        mapping: The whole mapping.

    Raises:
        MappingError: A local axis is asked of a bare point.
    """
    max_gap_s = mapping.timeline.max_gap_s
    frames = {
        landmark: tuple(resample(track, frames_s, max_gap_s=max_gap_s) for _, track in pairs)
        for landmark, pairs in samples.items()
    }
    seen = {name: np.mean([part.position_m for part in parts], axis=0) for name, parts in frames.items()}
    points = completed(seen, HEAD_POINTS)
    directions = {
        name: _between(rule, points) if isinstance(rule, Between) else _local(name, rule, frames, mapping, person)
        for name, rule in person.directions
        if set(_landmarks_of(rule)) <= points.keys()
    }
    for values in (*points.values(), *directions.values()):
        values.flags.writeable = False
    return PersonTrack(
        points=MappingProxyType(points),
        directions=MappingProxyType(directions),
        unknown=MappingProxyType(dict(person.unknown)),
        stature_m=person.stature_m,
    )


def _landmarks_of(rule: LocalAxis | Between) -> tuple[str, ...]:
    return (rule.landmark,) if isinstance(rule, LocalAxis) else (*rule.start, *rule.end)


def _between(rule: Between, points: AnyMapping[str, Array]) -> Array:
    start = np.mean([points[landmark] for landmark in rule.start], axis=0)
    end = np.mean([points[landmark] for landmark in rule.end], axis=0)
    return _raised(_unit(end - start), rule.raise_rad)


def _local(
    name: str, rule: LocalAxis, frames: AnyMapping[str, tuple[Frames, ...]], mapping: Mapping, person: Person
) -> Array:
    body = frames[rule.landmark][0]
    if body.wxyz is None:
        raise MappingError(
            "a bare point has no local axes",
            where=mapping.file,
            field=f"people.{person.name}.directions ({name})",
            value=rule.landmark,
            hint="add the rotation to its source, or give from = [...], to = [...] (landmarks)",
        )
    return np.asarray(matrix_from_wxyz(body.wxyz) @ (body.signs * np.array(rule.axis)))


def _raised(direction: Array, angle_rad: float) -> Array:
    """Directions turned upwards by an angle, about the horizontal axis at right angles to them."""
    level = _unit(direction * (1.0, 1.0, 0.0))
    elevation_rad = np.arcsin(np.clip(direction[:, 2], -1.0, 1.0)) + angle_rad
    raised = np.cos(elevation_rad)[:, None] * level
    raised[:, 2] = np.sin(elevation_rad)
    return raised if angle_rad else direction


def _unit(vectors: Array) -> Array:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors / np.where(length > 0.0, length, np.nan))
