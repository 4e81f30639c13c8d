"""From a mapping and its tables to tracks at the frames of a recording."""

from __future__ import annotations

from collections.abc import Mapping as AnyMapping
from types import MappingProxyType

import numpy as np

from taskgist.errors import InputError, MappingError
from taskgist.recording.landmarks import PARTS
from taskgist.recording.mapping.model import FixedPose, Mapping, Person, Point, PointRef, SignalColumn, Thing
from taskgist.recording.rotations import Array
from taskgist.recording.signals import Signal
from taskgist.recording.tables import Tables, Track
from taskgist.recording.tracks.checks import check_clocks, check_duplicates, check_objects, check_person
from taskgist.recording.tracks.mirrored import check_not_mirrored
from taskgist.recording.tracks.model import ObjectTrack, PersonTrack, Tracks
from taskgist.recording.tracks.people import Samples, tracked_person
from taskgist.recording.tracks.things import fixed_object, tracked_object


def read_tracks(mapping: Mapping) -> Tracks:
    """Read all tables of a mapping.

    Raises:
        MappingError: A table is missing or broken; units, axes or times cannot be right; two points are copies;
            a person or object is never seen.
        UnknownNameError: A column, array or point that does not exist.
        LabelError: The mapping's label reaches outside of the frames.
    """
    tables = Tables(mapping)
    samples = {person.name: _samples(person, tables) for person in mapping.people}
    moving = {t.name: tables.track(t.pose, t.name) for t in mapping.objects if isinstance(t.pose, PointRef)}
    check_duplicates(mapping.file, samples)
    check_clocks(mapping.file, [*_all_tracks(samples), *moving.values()])
    frames_s = _frames(mapping, [*_all_tracks(samples), *moving.values()])
    people = {p.name: tracked_person(p, samples[p.name], frames_s, mapping) for p in mapping.people}
    objects = {t.name: _object(t, moving, frames_s, mapping) for t in mapping.objects}
    _check_plausible(mapping, people, objects)
    times_s = frames_s - frames_s[0]
    _check_label(mapping, float(times_s[-1]))
    times_s.flags.writeable = False
    return Tracks(
        times_s=times_s,
        start_s=float(frames_s[0]),
        people=MappingProxyType(people),
        objects=MappingProxyType(objects),
        supports=mapping.supports,
        signals=MappingProxyType({column.name: _signal(column, tables, frames_s) for column in mapping.signals}),
        notes=_notes(mapping, people),
    )


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


def _frames(mapping: Mapping, tracks: list[Track]) -> Array:
    """Times of the frames: from the first sample of anything to the last, unless the mapping cuts them."""
    line = mapping.timeline
    if not tracks:
        raise MappingError("nothing is tracked", where=mapping.file, hint="add points or objects with a source")
    first_s = min(float(track.times_s[0]) for track in tracks) if line.start_s is None else line.start_s
    last_s = max(float(track.times_s[-1]) for track in tracks) if line.end_s is None else line.end_s
    count = int(np.floor((last_s - first_s) * line.rate_hz + 1e-6)) + 1
    if count < 2:
        problem = f"fewer than two frames lie between {first_s:g} and {last_s:g} s"
        hint = "check start_s, end_s and the times of the sources"
        raise MappingError(problem, where=mapping.file, field="time", hint=hint)
    return np.asarray(first_s + np.arange(count) / line.rate_hz)


def _object(thing: Thing, moving: AnyMapping[str, Track], frames_s: Array, mapping: Mapping) -> ObjectTrack:
    if isinstance(thing.pose, FixedPose):
        return fixed_object(thing, thing.pose, len(frames_s))
    return tracked_object(thing, moving[thing.name], frames_s, mapping)


def _signal(column: SignalColumn, tables: Tables, frames_s: Array) -> Signal:
    """At the frames, along straight lines; unknown beyond the first and the last sample."""
    times_s, values = tables.signal(column)
    at_frames = np.interp(frames_s, times_s, values, left=np.nan, right=np.nan)
    return Signal(at_frames * column.scale, column.unit)


def _check_plausible(
    mapping: Mapping, people: AnyMapping[str, PersonTrack], objects: AnyMapping[str, ObjectTrack]
) -> None:
    for person in mapping.people:
        units_m = {mapping.source(ref.source).frame.scale_m for point in person.points for ref in point.refs}
        check_person(mapping.file, person.name, people[person.name].points, units_m)
        face = people[person.name].directions.get("face")
        check_not_mirrored(mapping.file, person.name, people[person.name].points, face)
    positions = {name: track.position_m for name, track in objects.items()}
    bodies = [np.concatenate(list(person.points.values())) for person in people.values()]
    check_objects(mapping.file, positions, bodies)


def _check_label(mapping: Mapping, last_s: float) -> None:
    if mapping.label is None:
        return
    people, objects = [p.name for p in mapping.people], [t.name for t in mapping.objects]
    try:
        mapping.label.check(agents=people, objects=objects, first_s=0.0, last_s=last_s)
    except InputError as problem:
        problem.where = f"{mapping.file}: label"
        raise


def _unseen(person: PersonTrack) -> list[str]:
    return [landmark for landmark, values in person.points.items() if np.isnan(values).all()]


def _notes(mapping: Mapping, people: AnyMapping[str, PersonTrack]) -> tuple[str, ...]:
    unknown = [f"{p.name}: {part} is unknown: {reason}" for p in mapping.people for part, reason in p.unknown]
    unseen = [f"{name}: never seen: {', '.join(lost)}" for name, person in people.items() if (lost := _unseen(person))]
    estimated = [
        f"{item.name} is estimated" + (f": {item.note}" if item.note else "")
        for items in (mapping.objects, mapping.supports)
        for item in items
        if item.estimated
    ]
    return (*mapping.about.notes, *unknown, *unseen, *estimated)
