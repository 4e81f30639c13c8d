"""From a mapping and its tables to tracks at the frames of a recording."""

from __future__ import annotations

from collections.abc import Mapping
from collections.abc import Mapping as AnyMapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from taskgist.common.arrays import Array, Mask
from taskgist.errors import InputError, MappingError
from taskgist.importing.checks import (
    check_clocks,
    check_duplicates,
    check_not_mirrored,
    check_objects,
    check_person,
    is_low,
)
from taskgist.importing.mapping import (
    Between,
    FixedPose,
    ImportMapping,
    LocalAxis,
    Markers,
    Person,
    Point,
    PointRef,
    Shape,
    SignalColumn,
    Support,
    Thing,
)
from taskgist.importing.mapping_people import HEAD_POINTS, PARTS
from taskgist.importing.resampling import Frames, percent, resample, stayed
from taskgist.importing.rigid import body_of_markers, completed
from taskgist.importing.robots import RobotTrack, robot_notes, robot_samples, tracked_robot
from taskgist.importing.skeletons import SKELETONS
from taskgist.importing.table_values import Track
from taskgist.importing.tables import Samples, Tables
from taskgist.recording.signals import Signal
from taskgist.settings import DEFAULT
from taskgist.world.fit import Marker
from taskgist.world.geometry.transforms import IDENTITY_WXYZ, about_z, changed_frame, matrix_from_wxyz

# --- Tracked motion: what a mapping makes of someone's tables, in our axes, units and frames.
#
# Nothing is invented here. Where a tracker knew nothing there is NaN, and a part that the mapping calls unknown is
# not read at all; how a body fits these points is decided later, and reported.


@dataclass(frozen=True, eq=False)
class PersonTrack:
    """One person over time.

    Attributes:
        points: Positions by landmark, (N, 3) each; NaN where unknown.
        directions: Unit vectors in the world by name ("face", "left_hand", ...), (N, 3) each; NaN where unknown.
        unknown: Parts of the body that are not to be believed, and why. None of their landmarks is in ``points``.
        stature_m: Height of the person, if the mapping gives it.
        markers: Those of the points that are no landmarks of ours but lie beside one; offsets in statures.
        lines: Directions that lead from points to points of the mapping's skeleton: the names of both.
    """

    points: Mapping[str, Array]
    directions: Mapping[str, Array]
    unknown: Mapping[str, str]
    stature_m: float | None
    markers: Mapping[str, Marker] = field(default_factory=lambda: MappingProxyType({}))
    lines: Mapping[str, Between] = field(default_factory=lambda: MappingProxyType({}))


@dataclass(frozen=True, eq=False)
class ObjectTrack:
    """One object over time.

    Attributes:
        position_m: Origin of its frame, (N, 3); NaN where unknown.
        wxyz: Orientation of its frame, (N, 4); NaN where unknown; the identity where the source has no orientations.
        known: Frames in which position and orientation are known, (N,).
        shapes: What it consists of, in its frame.
        estimated: Whether shape or place are an estimate.
        note: How they were estimated.
        stayed: Frames in which it is taken to stay where it was last seen, (N,).
    """

    position_m: Array
    wxyz: Array
    known: Mask
    shapes: tuple[Shape, ...]
    estimated: bool
    note: str
    stayed: Mask


@dataclass(frozen=True, eq=False)
class Tracks:
    """Everything that a mapping brings in.

    Attributes:
        times_s: Frames, (N,), from 0 at a fixed rate.
        start_s: Time of the first frame in the time of the sources.
        people: By name.
        robots: By name.
        objects: By name.
        supports: Furniture that nobody tracked.
        signals: Numbers over time that are no motion, by name.
        notes: What a user should know: parts that are unknown, shapes that are estimated.
    """

    times_s: Array
    start_s: float
    people: Mapping[str, PersonTrack]
    robots: Mapping[str, RobotTrack]
    objects: Mapping[str, ObjectTrack]
    supports: tuple[Support, ...]
    signals: Mapping[str, Signal]
    notes: tuple[str, ...]


# --- One person's landmarks and directions at the frames of a recording.


def tracked_person(person: Person, samples: Samples, frames_s: Array, mapping: ImportMapping) -> PersonTrack:
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
    markers = SKELETONS[person.skeleton].markers() if person.skeleton else {}
    lines = {
        name: rule
        for name, rule in person.directions
        if isinstance(rule, Between) and not rule.raise_rad and {*rule.start, *rule.end} <= {*person.preset}
    }
    return PersonTrack(
        points=MappingProxyType(points),
        directions=MappingProxyType(directions),
        unknown=MappingProxyType(dict(person.unknown)),
        stature_m=person.stature_m,
        markers=MappingProxyType({name: markers[name] for name in person.preset if name in markers}),
        lines=MappingProxyType({name: rule for name, rule in lines.items() if name in directions}),
    )


def _landmarks_of(rule: LocalAxis | Between) -> tuple[str, ...]:
    return (rule.landmark,) if isinstance(rule, LocalAxis) else (*rule.start, *rule.end)


def _between(rule: Between, points: AnyMapping[str, Array]) -> Array:
    start = np.mean([points[landmark] for landmark in rule.start], axis=0)
    end = np.mean([points[landmark] for landmark in rule.end], axis=0)
    return _raised(_unit(end - start), rule.raise_rad)


def _local(
    name: str, rule: LocalAxis, frames: AnyMapping[str, tuple[Frames, ...]], mapping: ImportMapping, person: Person
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


# --- One object's pose and shapes at the frames of a recording.


def fixed_object(thing: Thing, pose: FixedPose, count: int) -> ObjectTrack:
    """An object that stays where the mapping puts it, for a number of frames."""
    position_m, wxyz = np.tile(pose.position_m, (count, 1)), np.tile(about_z(pose.yaw_rad), (count, 1))
    return _object_track(thing, position_m, wxyz, thing.shapes, np.zeros(count, dtype=np.bool_))


def tracked_object(thing: Thing, track: Track, frames_s: Array, mapping: ImportMapping) -> ObjectTrack:
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
    staying = np.zeros(len(frames_s), dtype=np.bool_)
    if thing.stays:
        frames, staying = stayed(frames)
    wxyz = np.tile(IDENTITY_WXYZ, (len(frames_s), 1)) if frames.wxyz is None else frames.wxyz
    shapes = tuple(_in_right_handed_frame(shape, thing, frames.signs, mapping) for shape in thing.shapes)
    result = _object_track(thing, frames.position_m, wxyz, shapes, staying)
    if not result.known.any():
        hint = "check missing, confidence, time and rotation of its source"
        field = f"objects.{thing.name}"
        raise MappingError("the object is never seen", where=mapping.file, field=field, hint=hint)
    return result


def _object_track(
    thing: Thing, position_m: Array, wxyz: Array, shapes: tuple[Shape, ...], staying: Mask
) -> ObjectTrack:
    known = np.asarray(np.isfinite(np.hstack([position_m, wxyz])).all(axis=1))
    for values in (position_m, wxyz, known, staying):
        values.flags.writeable = False
    return ObjectTrack(position_m, wxyz, known, shapes, thing.estimated, thing.note, staying)


def _in_right_handed_frame(shape: Shape, thing: Thing, signs: Array, mapping: ImportMapping) -> Shape:
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


def read_tracks(mapping: ImportMapping) -> Tracks:
    """Read all tables of a mapping.

    Raises:
        MappingError: A table is missing or broken; units, axes or times cannot be right; two points are copies;
            a person or object is never seen.
        UnknownNameError: A column, array or point that does not exist.
        LabelError: The mapping's label reaches outside of the frames.
    """
    tables = Tables(mapping)
    samples = {person.name: _samples(person, tables) for person in mapping.people}
    moving = {t.name: _moving(t, tables, mapping) for t in mapping.objects if not isinstance(t.pose, FixedPose)}
    check_duplicates(mapping.file, samples)
    running = [robot_samples(robot, tables, mapping) for robot in mapping.robots]
    tracks = [*_all_tracks(samples), *moving.values(), *(each.base for each in running if each.base is not None)]
    check_clocks(mapping.file, tracks)
    spans_s = [(float(track.times_s[0]), float(track.times_s[-1])) for track in tracks]
    frames_s = _frames(mapping, [*spans_s, *(span for each in running for span in each.spans_s)])
    people = {p.name: tracked_person(p, samples[p.name], frames_s, mapping) for p in mapping.people}
    robots = {each.robot.name: tracked_robot(each, frames_s, mapping) for each in running}
    objects = {t.name: _object(t, moving, frames_s, mapping) for t in mapping.objects}
    _check_plausible(mapping, people, objects)
    times_s = frames_s - frames_s[0]
    _check_label(mapping, float(times_s[-1]))
    times_s.flags.writeable = False
    return Tracks(
        times_s=times_s,
        start_s=float(frames_s[0]),
        people=MappingProxyType(people),
        robots=MappingProxyType(robots),
        objects=MappingProxyType(objects),
        supports=mapping.supports,
        signals=MappingProxyType({column.name: _signal(column, tables, frames_s) for column in mapping.signals}),
        notes=(
            *_notes(mapping, people, objects),
            *(note for name, robot in robots.items() for note in robot_notes(name, robot)),
        ),
    )


def _moving(thing: Thing, tables: Tables, mapping: ImportMapping) -> Track:
    """Samples of a thing, by itself or by its markers."""
    if not isinstance(thing.pose, Markers):
        assert isinstance(thing.pose, PointRef)
        return tables.track(thing.pose, thing.name)
    markers = [tables.track(ref, thing.name) for ref in thing.pose.refs]
    return body_of_markers(markers, str(mapping.file), f"objects.{thing.name}.points")


def _samples(person: Person, tables: Tables) -> Samples:
    dropped: frozenset[str] = frozenset().union(*(PARTS[part] for part, _ in person.unknown))
    return {
        point.landmark: tuple((ref, _track(tables, ref, person, point)) for ref in point.refs)
        for point in person.points
        if point.landmark not in dropped
    }


def _track(tables: Tables, ref: PointRef, person: Person, point: Point) -> Track:
    try:
        return tables.track(ref, person.token)
    except InputError as problem:
        problem.field = problem.field or f"people.{person.name}.points.{point.landmark}"
        raise


def _all_tracks(people: AnyMapping[str, Samples]) -> list[Track]:
    return [track for landmarks in people.values() for pairs in landmarks.values() for _, track in pairs]


def _frames(mapping: ImportMapping, spans_s: list[tuple[float, float]]) -> Array:
    """Times of the frames: from the first sample of anything to the last, unless the mapping cuts them."""
    line = mapping.timeline
    if not spans_s:
        raise MappingError("nothing is tracked", where=mapping.file, hint="add points or objects with a source")
    first_s = min(first for first, _ in spans_s) if line.start_s is None else line.start_s
    last_s = max(last for _, last in spans_s) if line.end_s is None else line.end_s
    count = int(np.floor((last_s - first_s) * line.rate_hz + 1e-6)) + 1
    if count < 2:
        problem = f"fewer than two frames lie between {first_s:g} and {last_s:g} s"
        hint = "check start_s, end_s and the times of the sources"
        raise MappingError(problem, where=mapping.file, field="time", hint=hint)
    _check_count(mapping, count)
    return np.asarray(first_s + np.arange(count) / line.rate_hz)


NUMBERS_OF_A_PERSON = 200
"""Numbers that a frame holds of a person, or a robot: landmarks, directions and joints."""
NUMBERS_OF_A_THING = 14


def _check_count(mapping: ImportMapping, count: int) -> None:
    """Refuse more frames than are held in memory."""
    agents = len(mapping.people) + len(mapping.robots)
    numbers = NUMBERS_OF_A_PERSON * agents + NUMBERS_OF_A_THING * len(mapping.objects)
    most = DEFAULT.limits.frame_bytes // (8 * numbers)
    if count > most:
        hint = f"check times, rate_hz, start_s and end_s: at most {most:,} are held (setting limits.frame_bytes)"
        raise MappingError("too many frames", where=mapping.file, field="time", value=f"{count:,}", hint=hint)


def _object(thing: Thing, moving: AnyMapping[str, Track], frames_s: Array, mapping: ImportMapping) -> ObjectTrack:
    if isinstance(thing.pose, FixedPose):
        return fixed_object(thing, thing.pose, len(frames_s))
    return tracked_object(thing, moving[thing.name], frames_s, mapping)


def _signal(column: SignalColumn, tables: Tables, frames_s: Array) -> Signal:
    """At the frames, along straight lines; unknown beyond the first and the last sample."""
    times_s, values = tables.signal(column)
    at_frames = np.interp(frames_s, times_s, values, left=np.nan, right=np.nan)
    return Signal(at_frames * column.scale, column.unit)


def _check_plausible(
    mapping: ImportMapping, people: AnyMapping[str, PersonTrack], objects: AnyMapping[str, ObjectTrack]
) -> None:
    for person in mapping.people:
        units_m = {mapping.source(ref.source).frame.scale_m for point in person.points for ref in point.refs}
        check_person(mapping.file, person.name, people[person.name].points, units_m)
        face = people[person.name].directions.get("face")
        check_not_mirrored(mapping.file, person.name, people[person.name].points, face)
    positions = {name: track.position_m for name, track in objects.items()}
    bodies = [np.concatenate(list(person.points.values())) for person in people.values()]
    check_objects(mapping.file, positions, bodies)


def _check_label(mapping: ImportMapping, last_s: float) -> None:
    if mapping.label is None:
        return
    agents, objects = [a.name for a in mapping.agents], [t.name for t in mapping.objects]
    try:
        mapping.label.check(agents=agents, objects=objects, first_s=0.0, last_s=last_s)
    except InputError as problem:
        problem.where = f"{mapping.file}: label"
        raise


def _unseen(person: PersonTrack) -> list[str]:
    return [landmark for landmark, values in person.points.items() if np.isnan(values).all()]


def _notes(
    mapping: ImportMapping, people: AnyMapping[str, PersonTrack], objects: AnyMapping[str, ObjectTrack]
) -> tuple[str, ...]:
    unknown = [f"{p.name}: {part} is unknown: {reason}" for p in mapping.people for part, reason in p.unknown]
    unseen = [f"{name}: never seen: {', '.join(lost)}" for name, person in people.items() if (lost := _unseen(person))]
    low = [
        f"{name} lies, or bends far, all the time: if not, check axes" for name in people if is_low(people[name].points)
    ]
    estimated = [
        f"{item.name} is estimated" + (f": {item.note}" if item.note else "")
        for items in (mapping.objects, mapping.supports)
        for item in items
        if item.estimated
    ]
    lost = [_lost(name, track) for name, track in objects.items() if track.stayed.any() or not track.known.all()]
    return (*mapping.about.notes, *unknown, *unseen, *low, *estimated, *lost)


def _lost(name: str, track: ObjectTrack) -> str:
    """What is made of the frames in which a thing was not tracked, and what could be."""
    unknown = f"{name} is unknown in {percent(~track.known)} % of the frames"
    if not track.stayed.any():
        return f"{unknown}, for it was not tracked; if it stays where it was last seen, say {STAYS} in objects.{name}"
    told = f"{name} is taken to stay where it was last seen in {percent(track.stayed)} % of the frames"
    return told if track.known.all() else f"{told}; {unknown}, after which it is seen elsewhere"


STAYS = 'outside = "stays"'
