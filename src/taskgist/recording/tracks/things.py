"""One object's pose and shapes at the frames of a recording."""

from __future__ import annotations

import numpy as np

from taskgist.errors import MappingError
from taskgist.recording.mapping.model import FixedPose, Mapping, Shape, Thing
from taskgist.recording.rotations import Array, changed_frame
from taskgist.recording.tables import Track
from taskgist.recording.tracks.model import ObjectTrack
from taskgist.recording.tracks.resample import resample
from taskgist.world.geometry.rotations import IDENTITY_WXYZ, about_z


def fixed_object(thing: Thing, pose: FixedPose, count: int) -> ObjectTrack:
    """An object that stays where the mapping puts it, for a number of frames."""
    position_m, wxyz = np.array(pose.position_m), about_z(pose.yaw_rad)
    return _track(thing, np.tile(position_m, (count, 1)), np.tile(wxyz, (count, 1)), thing.shapes)


def tracked_object(thing: Thing, track: Track, frames_s: Array, mapping: Mapping) -> ObjectTrack:
    """A tracked object at the frames of a recording.

    Args:
        thing: What the mapping says.
        track: Its samples.
        frames_s: Times of the frames, (N,), in the time of the sources.
        mapping: The whole mapping.

    Raises:
        MappingError: It is never seen; or it is a mesh in left-handed axes.
    """
    frames = resample(track, frames_s, max_gap_s=mapping.timeline.max_gap_s)
    wxyz = np.tile(IDENTITY_WXYZ, (len(frames_s), 1)) if frames.wxyz is None else frames.wxyz
    shapes = tuple(_in_right_handed_frame(shape, thing, frames.signs, mapping) for shape in thing.shapes)
    result = _track(thing, frames.position_m, wxyz, shapes)
    if not result.known.any():
        hint = "check missing, confidence, time and rotation of its source"
        field = f"objects.{thing.name}"
        raise MappingError("the object is never seen", where=mapping.file, field=field, hint=hint)
    return result


def _track(thing: Thing, position_m: Array, wxyz: Array, shapes: tuple[Shape, ...]) -> ObjectTrack:
    known = np.asarray(np.isfinite(np.hstack([position_m, wxyz])).all(axis=1))
    for values in (position_m, wxyz, known):
        values.flags.writeable = False
    return ObjectTrack(position_m, wxyz, known, shapes, thing.estimated, thing.note)


def _in_right_handed_frame(shape: Shape, thing: Thing, signs: Array, mapping: Mapping) -> Shape:
    """A shape given in a left-handed frame, in the right-handed one that stands for it."""
    if (signs > 0).all():
        return shape
    if shape.kind == "mesh":
        hint = "mirror the mesh and convert the tracking to right-handed axes, or use box, cylinder, sphere"
        field = f"objects.{thing.name}.shape"
        raise MappingError("a mesh in left-handed axes is not supported", where=mapping.file, field=field, hint=hint)
    mirror = np.diag(signs)
    wxyz = changed_frame(np.array([shape.wxyz]), mirror, mirror)[0]
    x, y, z = (float(value) for value in signs * np.array(shape.position_m))
    w, i, j, k = (float(value) for value in wxyz)
    return Shape(shape.kind, shape.size_m, (x, y, z), (w, i, j, k))
