"""Looking inside a file of motion capture: who and what is there, and the mapping that would bring it in.

Nothing is settled that the file leaves open. What it says itself is taken (its unit, its axis that points up), what
follows from the bodies in it is taken and told (heads lie over feet, a forearm is as long as forearms are), and the
rest is *open*: a line of the mapping that its user fills in. A mapping without open lines can be imported at once.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from taskgist.common.arrays import Array, Mask
from taskgist.common.text import MOST_SHOWN, clean_name
from taskgist.errors import TaskgistError
from taskgist.importing.mapping_fields import UNITS_M
from taskgist.importing.mapping_people import HEAD_POINTS, LEG_POINTS, folded
from taskgist.importing.mapping_things import LEAST_MARKERS
from taskgist.importing.readers import READERS, kind_of, read_take
from taskgist.importing.robots import joint_names
from taskgist.importing.sizes import height_of_soles_m
from taskgist.importing.skeletons import SKELETONS
from taskgist.importing.takes import OWNER, Take, TakeTrack
from taskgist.settings import DEFAULT
from taskgist.world.bodies.profile import builtin_profiles

LEAST_SHARE = 0.4
"""Of a skeleton's landmarks, that a person's points must have for the skeleton to be recognised (ours)."""
FOREARM_M = (0.19, 0.33)
"""Between elbow and wrist of an adult (ours, about [Winter 2009]): so narrow that only one unit fits."""
UPRIGHT = 0.8
"""Cosine between an axis and the line from feet to head that makes the axis the one that points up (ours)."""
AXES = {
    "z": "{}",
    "y": '{ x = "-z", y = "-x", z = "y" }',
    "x": '{ x = "y", y = "z", z = "x" }',
    "-z": '{ x = "x", y = "-y", z = "-z" }',
    "-y": '{ x = "z", y = "-x", z = "-y" }',
    "-x": '{ x = "z", y = "y", z = "-x" }',
}
"""Our axes in those of a right-handed source, by its axis that points up."""


@dataclass(frozen=True)
class Subject:
    """Points that belong to one person.

    Attributes:
        name: What the mapping calls the person.
        owner: What the file calls it; may be empty.
        points: Names of the points in the file, without their owner's.
        skeleton: The skeleton whose names these are; empty if none is recognised.
        lacking: Landmarks of that skeleton that are not there.
    """

    name: str
    owner: str
    points: tuple[str, ...]
    skeleton: str
    lacking: tuple[str, ...]


@dataclass(frozen=True)
class Choice:
    """A value and why it is that; no value where it is open.

    Attributes:
        value: "mm", or "y".
        why: The reason, or the question.
    """

    value: str | None
    why: str


@dataclass(frozen=True, eq=False)
class Proposal:
    """What a file holds, and what it leaves open.

    Attributes:
        take: Its points and bodies.
        file: The file.
        people: Who is in it.
        things: Names of its rigid bodies, as the file has them.
        loose: Names of points that belong to nobody.
        unit: Its unit.
        up: Its axis that points up.
        raised_m: What is added to heights so that people stand on the floor; 0 where they do, or no feet are known.
        robots: Names of built-in profiles whose joints the file has, and the frame of the base of each.
        open: Questions that the mapping's user has to answer, each with its field.
    """

    take: Take
    file: Path
    people: tuple[Subject, ...]
    things: tuple[str, ...]
    loose: tuple[str, ...]
    unit: Choice
    up: Choice
    raised_m: float
    robots: Mapping[str, str | None]
    open: tuple[str, ...]


def look(file: Path, kind: str | None = None) -> Proposal:
    """Look inside a file of motion capture.

    Args:
        file: The file.
        kind: Its format, a key of ``READERS``; by default found out.

    Raises:
        MappingError: It cannot be read, or is of a kind that is not read.
    """
    take = read_take(file, kind or kind_of(file))
    groups: dict[str, list[str]] = {}
    for name in take.tracks:
        owner, _, point = name.rpartition(OWNER)
        if name not in take.things and owner not in take.things:
            groups.setdefault(owner, []).append(point)
    subjects = [_subject(owner, points) for owner, points in groups.items()]
    people = _named([subject for subject in subjects if subject.skeleton])
    robots = _robots(take)
    loose = [_joined(s.owner, point) for s in subjects if not s.skeleton for point in s.points]
    loose = [name for name in loose if name not in robots.values()]
    things = [name for name in take.tracks if name in take.things]
    bodies = [_landmarks(take, subject) for subject in people]
    unit, up = _unit(take, bodies), _up(take, bodies)
    return Proposal(
        take,
        file,
        people,
        tuple(things),
        tuple(loose),
        unit,
        up,
        _raised_m([_without_markers(s, body) for s, body in zip(people, bodies, strict=True)], unit, up),
        robots,
        _open(people, things, loose, robots, unit, up),
    )


JOINTS_SHARE = 0.6
"""Of a profile's joints, that a file must have for it to be that robot (ours): grippers are often not published."""
BASES = ("base_footprint", "base_link", "base")
"""Frames of tf at a robot's base, the best first [REP-105]."""


def _robots(take: Take) -> dict[str, str | None]:
    """The built-in robot whose joints a file has most of, with the frame of its base."""
    if not take.series:
        return {}
    shares = {}
    for profile in builtin_profiles():
        with suppress(TaskgistError):  # a robot whose model is not installed
            joints = {*joint_names(profile)}
            shares[profile] = len(joints & take.series.keys()) / len(joints)
    best = max(shares, key=lambda profile: shares[profile])
    if shares[best] < JOINTS_SHARE:
        return {}
    return {best: next((frame for frame in BASES if frame in take.tracks), None)}


def _subject(owner: str, points: Sequence[str]) -> Subject:
    """The person whose points these are: the skeleton of which most is there, best in its own spelling."""
    there, spelled = {folded(point) for point in points}, {*points}
    best: tuple[float, str, tuple[str, ...]] = (0.0, "", ())
    for name, skeleton in SKELETONS.items():
        landmarks = skeleton.points()
        lacking = tuple(key for key, at in landmarks.items() if not {folded(p) for p in at.points} <= there)
        share = 1.0 - len(lacking) / len(landmarks)
        exact = sum({*at.points} <= spelled for at in landmarks.values()) / len(landmarks)
        if share >= LEAST_SHARE and share + exact > best[0]:
            best = (share + exact, name, lacking)
    return Subject(owner, owner, tuple(points), best[1], best[2])


def _named(subjects: Sequence[Subject]) -> tuple[Subject, ...]:
    """The same with names that a mapping allows, each once."""
    named: list[Subject] = []
    for number, subject in enumerate(subjects, start=1):
        name = _allowed(subject.owner)
        name = f"P{name}" if name.isdecimal() else name  # trackers number people
        if not name or name in [other.name for other in named]:
            name = f"P{number}"
        named.append(Subject(name, subject.owner, subject.points, subject.skeleton, subject.lacking))
    return tuple(named)


def _allowed(text: str) -> str:
    """A name of letters, digits, - and _, or nothing."""
    return "".join(c if c.isalnum() or c in "-_" else "_" for c in clean_name(text)).strip("_")


def _joined(owner: str, point: str) -> str:
    return f"{owner}{OWNER}{point}" if owner else point


# --- What bodies tell of their file: its unit, and which way is up.


def _landmarks(take: Take, subject: Subject) -> dict[str, Array]:
    """Positions of a person's landmarks in the file's unit and axes, (n, 3) each, of those that were ever seen."""
    spelled = {folded(point): take.tracks[_joined(subject.owner, point)] for point in subject.points}
    found = {}
    for landmark, at in SKELETONS[subject.skeleton].points().items():
        if landmark not in subject.lacking:
            position = np.mean([spelled[folded(point)].position for point in at.points], axis=0)
            if np.isfinite(position).all(axis=1).any():
                found[landmark] = position
    return found


def _unit(take: Take, bodies: Sequence[Mapping[str, Array]]) -> Choice:
    if take.unit:
        return Choice(take.unit, "the file says so")
    lengths = [
        np.linalg.norm(body[f"{side}_elbow"] - body[f"{side}_wrist"], axis=1)
        for body in bodies
        for side in ("left", "right")
        if {f"{side}_elbow", f"{side}_wrist"} <= body.keys()
    ]
    known = [float(np.median(length[np.isfinite(length)])) for length in lengths if np.isfinite(length).any()]
    forearm = float(np.median(known)) if known else 0.0
    fitting = [unit for unit, scale_m in UNITS_M.items() if FOREARM_M[0] <= forearm * scale_m <= FOREARM_M[1]]
    if len(fitting) == 1:
        return Choice(fitting[0], f"so a forearm is {100 * forearm * UNITS_M[fitting[0]]:.0f} cm long")
    metres = f"; a forearm of 0.26 m would make it {0.26 / forearm:.3g} metres" if forearm > 0 else ""
    return Choice(None, f'the file does not say its unit: "m", "cm", "mm", "inch", or metres per unit{metres}')


def _up(take: Take, bodies: Sequence[Mapping[str, Array]]) -> Choice:
    seen = {axis for body in bodies if (axis := _rise(body))}
    measured = seen.pop() if len(seen) == 1 else None
    custom = READERS[take.kind].up
    if measured and take.up and measured != take.up:
        return Choice(None, f"the file says that {take.up} points up, but heads lie over feet along {measured}")
    if measured:
        return Choice(measured, f"{measured} points up: heads lie over feet")
    if take.up:
        return Choice(take.up, f"{take.up} points up: the file says so")
    if custom:
        return Choice(custom, f"{custom} points up by the custom of this format")
    return Choice(None, "which of the file's axes points up?")


def _rise(body: Mapping[str, Array]) -> str | None:
    """The axis along which a person's head lies over the feet, or what else is up over what else is down."""
    high = _middle(body, HEAD_POINTS) or _middle(body, {"left_shoulder", "right_shoulder", "neck"})
    low = _middle(body, LEG_POINTS) or _middle(body, {"left_hip", "right_hip", "pelvis"})
    if high is None or low is None:
        return None
    rise = np.subtract(high, low)
    axis = int(np.argmax(np.abs(rise)))
    upright = abs(rise[axis]) > UPRIGHT * float(np.linalg.norm(rise))
    return ("-" if rise[axis] < 0.0 else "") + "xyz"[axis] if upright else None


def _middle(body: Mapping[str, Array], names: set[str] | frozenset[str]) -> tuple[float, ...] | None:
    """Mean over some landmarks of where each is most of the time."""
    medians = [
        np.median(values[np.isfinite(values).all(axis=1)], axis=0) for key, values in body.items() if key in names
    ]
    return tuple(float(value) for value in np.mean(medians, axis=0)) if medians else None


def _without_markers(subject: Subject, body: Mapping[str, Array]) -> Mapping[str, Array]:
    """The landmarks without those that are only beside one, where feet are left."""
    markers = SKELETONS[subject.skeleton].markers()
    joints = {key: at for key, at in body.items() if key not in markers}
    return joints if joints.keys() & LEG_POINTS - {"left_knee", "right_knee"} else body


def _raised_m(bodies: Sequence[Mapping[str, Array]], unit: Choice, up: Choice) -> float:
    """How far people stand under the height 0, metres, to the centimetre; trackers count from cameras or from hips."""
    if unit.value is None or up.value is None:
        return 0.0
    axis, sign = "xyz".index(up.value[-1]), -1.0 if up.value.startswith("-") else 1.0
    soles_m = [
        height_of_soles_m({key: sign * UNITS_M[unit.value] * at[:, [axis, axis, axis]] for key, at in body.items()})
        for body in bodies
    ]
    height_m = float(np.median(soles_m)) if soles_m else 0.0
    return -round(height_m, 2) if abs(height_m) > DEFAULT.checks.off_floor_m else 0.0


# --- The mapping.


def _open(
    people: Sequence[Subject],
    things: Sequence[str],
    loose: Sequence[str],
    robots: Mapping[str, str | None],
    unit: Choice,
    up: Choice,
) -> tuple[str, ...]:
    questions = [f"sources.take.units: {unit.why}"] if unit.value is None else []
    questions += [f"sources.take.axes: {up.why}"] if up.value is None else []
    questions += [f"robots.{name}.point: which frame is its base?" for name, base in robots.items() if base is None]
    if not people and loose and not robots:
        questions.append("people: no skeleton is recognised by its names: say which points are which landmarks")
    return (*questions, *(f"objects.{thing_name(name)}.shape: what does it look like?" for name in things))


def thing_name(name: str) -> str:
    """What a mapping calls a rigid body of a file."""
    return _allowed(name) or "thing"


def mapping_text(proposal: Proposal, file: str) -> str:
    """The mapping of a file as text, with a line to fill in for whatever is open.

    Args:
        proposal: What the file holds.
        file: Its path, as seen from the folder of the mapping.
    """
    return "\n".join(_lines(proposal, file)) + "\n"


def _lines(proposal: Proposal, file: str) -> Iterator[str]:
    yield f"# What {_one_line(proposal.file.name)} holds: {summary(proposal.take)}"
    yield from (f"# {_one_line(note)}" for note in proposal.take.notes)
    yield from (f"# open: {_one_line(question)}" for question in proposal.open)
    yield from ("", "[parameters]", f"file = {_quoted(file)}  # another take of the same set-up: --set file=OTHER")
    yield from ("", "[sources.take]", 'file = "{file}"', f"format = {_quoted(proposal.take.kind)}")
    unit, up = proposal.unit, proposal.up
    yield f"units = {_quoted(unit.value)}  # {unit.why}" if unit.value else f"# units =   # open: {unit.why}"
    yield f"axes = {AXES[up.value]}  # {up.why}" if up.value else f"# axes = {AXES['y']}  # open: {up.why}"
    if proposal.raised_m:
        where = "under" if proposal.raised_m > 0.0 else "over"
        why = f"soles lie {abs(proposal.raised_m)} m {where} the height 0"
        yield f"transform = {{ position_m = [0, 0, {proposal.raised_m}] }}  # {why}"
    yield from _confidence(proposal.take)
    names = list(dict.fromkeys(point for subject in proposal.people for point in _used(subject)))
    if names:
        yield f"names = [{', '.join(map(_quoted, names))}]"
    for subject in proposal.people:
        yield from _person(subject, {folded(name) for name in names})
    if proposal.loose and not proposal.people and not proposal.robots:
        yield from ("", "# [people.P1]", '# source = "take"', '# points = { head = "...", left_wrist = "..." }')
    if proposal.loose:
        yield f"# points of nobody: {_one_line(', '.join(proposal.loose))}"
        if len(proposal.loose) >= LEAST_MARKERS:
            markers = _one_line(", ".join(map(_quoted, proposal.loose[:LEAST_MARKERS])))
            yield from ("# If three or more are markers on one thing:", "# [objects.NAME]", '# source = "take"')
            yield from (f"# points = [{markers}]", '# shape = { type = "box", size_m = [0.1, 0.1, 0.1] }')
    yield from _robot(proposal)
    for name in proposal.things:
        yield from ("", f"[objects.{thing_name(name)}]", 'source = "take"', f"point = {_quoted(name)}")
        yield '# shape = { type = "box", size_m = [0.1, 0.1, 0.1] }  # open: box, cylinder, sphere or mesh'


def _confidence(take: Take) -> Iterator[str]:
    given = [track.confidence for track in take.tracks.values() if track.confidence is not None]
    known = [values[np.isfinite(values)] for values in given if np.isfinite(values).any()]
    if known:
        low, high = min(values.min() for values in known), max(values.max() for values in known)
        why = f"leaves out doubtful points; it is {low:.3g} to {high:.3g}"
        yield f"# confidence = {{ least = {0.5 * high:.3g} }}  # {why}"


def _used(subject: Subject) -> list[str]:
    """Those of a person's points that its skeleton maps."""
    wanted = {folded(point) for at in SKELETONS[subject.skeleton].points().values() for point in at.points}
    return [point for point in subject.points if folded(point) in wanted]


def _person(subject: Subject, listed: set[str]) -> Iterator[str]:
    yield from ("", f"[people.{subject.name}]", 'source = "take"')
    if subject.owner:
        yield f"person = {_quoted(subject.owner)}"
    yield f"skeleton = {_quoted(subject.skeleton)}"
    landmarks = SKELETONS[subject.skeleton].points()
    others = [key for key in subject.lacking if {folded(point) for point in landmarks[key].points} <= listed]
    if others:  # another person has them
        yield f"points = {{ {', '.join(f'{key} = false' for key in others)} }}"


def _robot(proposal: Proposal) -> Iterator[str]:
    for name, base in proposal.robots.items():
        yield from (
            "",
            f"[robots.{name}]",
            f"profile = {_quoted(name)}  # its joints are in the file",
            'source = "take"',
        )
        yield f"point = {_quoted(base)}" if base else "# point =   # open: which frame is its base?"
        yield "joints = {}  # those of the file that are called as its own"
    if proposal.take.series and not proposal.robots:
        names = _one_line(", ".join(list(proposal.take.series)[:MOST_SHOWN]))
        yield from (
            "",
            "# Joints of a robot that has no built-in profile: write one (docs/howto/bodies.md), and fill in",
        )
        yield from (f"# {names}", "# [robots.R1]", '# profile = "my_robot.toml"', '# source = "take"')
        yield from ('# point = "base_footprint"', "# joints = {}")


def _quoted(text: str | None) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _one_line(text: str) -> str:
    return clean_name(text.replace("\n", " "))


def summary(take: Take) -> str:
    """What a take holds, in a line: format, points, rate, duration and gaps."""
    tracks = list(take.tracks.values())
    first_s = min((float(track.times_s[0]) for track in tracks if len(track.times_s)), default=0.0)
    last_s = max((float(track.times_s[-1]) for track in tracks if len(track.times_s)), default=0.0)
    bodies = sum(track.wxyz is not None for track in tracks)
    parts = [READERS[take.kind].title, f"{len(tracks)} points" + (f" ({bodies} with rotation)" if bodies else "")]
    parts += [f"{rate:.6g} Hz" for rate in [_rate_hz(tracks)] if rate]
    lost, longest_s, name = _gaps(take)
    gaps = f"{100 * lost:.1f} % lost, for {longest_s:.2f} s at most ({name})" if lost else "no gaps"
    joints = [f"{len(take.series)} joints"] if take.series else []
    return ", ".join([*parts, *joints, f"{last_s - first_s:.2f} s", gaps])


def _rate_hz(tracks: Sequence[TakeTrack]) -> float | None:
    steps = [float(np.median(np.diff(track.times_s))) for track in tracks if len(track.times_s) > 1]
    return 1.0 / float(np.median(steps)) if steps and np.median(steps) > 0 else None


def _gaps(take: Take) -> tuple[float, float, str]:
    """Share of samples that are lost, and the longest gap, seconds, with the point that has it."""
    lost, total, longest = 0, 0, (0.0, "")
    for name, track in take.tracks.items():
        known: Mask = np.asarray(np.isfinite(track.position).all(axis=1))
        lost, total = lost + int((~known).sum()), total + len(known)
        edges = np.concatenate([track.times_s[:1], track.times_s[known], track.times_s[-1:]])
        if not known.all() and len(edges) > 1:
            longest = max(longest, (float(np.diff(edges).max()), name))
    return (lost / total if total else 0.0, *longest)
