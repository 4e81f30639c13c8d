"""A tracked person's body: its size, and its joint angles over time, fitted to landmarks frame after frame."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from taskgist.common.arrays import Array, Mask
from taskgist.importing.mapping import Between
from taskgist.importing.mapping_people import SIDES
from taskgist.importing.sizes import Points
from taskgist.importing.tracks import PersonTrack
from taskgist.settings import DEFAULT
from taskgist.world.bodies.agent import Agent, legs_for
from taskgist.world.bodies.human import HumanSize
from taskgist.world.fit import ARMS, AXES, Axis, Fitter, Marker
from taskgist.world.geometry.transforms import about_z, rotate, wxyz_from_matrix
from taskgist.world.scene import Scene
from taskgist.world.scene_file import AgentEntry
from taskgist.world.state import State

WEIGHTS: Mapping[str, float] = {
    "left_wrist": 2.0,
    "right_wrist": 2.0,
    "head": 0.5,
    "neck": 0.1,
    "chest": 0.1,
    "abdomen": 0.1,
    "left_toe": 0.3,
    "right_toe": 0.3,
    "left_heel": 0.3,
    "right_heel": 0.3,
    "left_fingertip": 0.3,
    "right_fingertip": 0.3,
    "face": 3.0,
}
"""What a fit cares about most: hands, for the facts of hands; the face, for sight. Landmarks along the spine, and on
the feet, lie elsewhere for each tracker and count little; so do fingertips, for fingers bend and the body's do not."""

FIRST_ITERATIONS, ITERATIONS = 200, 20
HEAD_POINTS = ("head_base", "head", "head_top", "nose", "left_eye", "right_eye", "left_ear", "right_ear")
TRUNK_POINTS = ("left_shoulder", "right_shoulder", "chest", "neck")
BENT_RAD = math.radians(45.0)
"""Inclination of the trunk from which the first fit does not start upright (ours)."""
RELAXED = {"shoulder_abduction": 0.12, "elbow": 0.3}
"""Angles in radians of an arm that nobody tracked."""


@dataclass(frozen=True, eq=False)
class BodyTrack:
    """One fitted body.

    Attributes:
        base: Position in metres and wxyz of the pelvis, (N, 7).
        joints_rad: Angles of its joints, (N, joints), in the order of ``Scene.joints``.
        tracked: Frames in which each part was tracked, by part, (N,).
        low: Frames in which the hips are too low for who stands, but no legs were tracked to say more, (N,).
        report: Error of the fit by landmark (centimetres) and direction (degrees): median, 95th percentile, largest.
        notes: What was estimated.
    """

    base: Array
    joints_rad: Array
    tracked: Mapping[str, Mask]
    low: Mask
    report: Mapping[str, Any]
    notes: tuple[str, ...]


def fit_person(name: str, size: HumanSize, person: PersonTrack, progress: Callable[[float], None]) -> BodyTrack:
    """Fit a body to a person's landmarks.

    Args:
        name: Name of the person.
        size: How large the body is.
        person: Landmarks and directions over time.
        progress: Told the share of frames that are done.
    """
    scene = _alone(name, size)
    agent = scene.agent(name)
    tracked = tracked_parts(person)
    count = len(tracked["torso"])
    legs_tracked = bool(tracked["legs"].any())
    trunk = trunk_directions(person)
    markers = {key: _of_stature(marker, size.stature_m) for key, marker in person.markers.items()}
    fitter = Fitter(
        scene,
        name,
        moving="body" if legs_tracked else _without_legs(scene, name),
        weights={**WEIGHTS, **(dict.fromkeys((*trunk, HELD), PELVIS_WEIGHT) if trunk else {})},
        root=True,
        markers=markers,
        axes=_axes_of(scene, name, {**person.lines, **{key: TRUNK_LINES[key] for key in trunk}}, markers),
    )
    features = fitter.features(person.points, (*person.directions, *trunk, *((HELD,) if trunk else ())))
    targets = _targets(person, trunk, count)
    rest = qpos = _start(scene, name, person).qpos
    lost = _lost_arms(agent, tracked)
    states = np.empty((count, scene.nq))
    for frame in range(count):
        if trunk and frame and not np.isfinite(targets[frame, -1 - len(trunk) :]).all(axis=1).any():
            targets[frame, -1] = rotate(qpos[agent.base][3:], (0.0, 0.0, 1.0))  # held as it was fitted last
        leaning = np.where(lost[frame], qpos, rest) if lost[frame].any() else rest
        iterations = FIRST_ITERATIONS if frame == 0 else ITERATIONS
        qpos = fitter.settle(features, qpos, targets[frame], rest=leaning, iterations=iterations)
        states[frame] = qpos
        progress((frame + 1) / count)
    errors = fitter.errors(features, states, targets)[:, : len(person.points) + len(person.directions)]
    notes: tuple[str, ...] = ()
    low = np.zeros(count, dtype=bool)
    if not legs_tracked and tracked["torso"].any():
        low = _estimate_legs(scene, name, states) & tracked["torso"]
        if "legs" not in person.unknown:
            tracked = {**tracked, "legs": tracked["torso"]}
            notes = (f"{name}'s legs are estimated from the height of the hips",)
    base, joints = states[:, scene.base_slice(name)], states[:, scene.joint_indices(name)]
    return BodyTrack(base, joints, tracked, low, _report(person, errors), notes)


def _targets(person: PersonTrack, trunk: Mapping[str, Array], count: int) -> Array:
    """Where points are to be, and directions to point, in each frame, (N, f, 3); NaN where that is unknown.

    Where trunks have directions, the last one is that in which the pelvis is held where none of them is known.
    """
    directions = [_of_length_1(track) for track in (*person.directions.values(), *trunk.values())]
    held = [np.full((count, 3), np.nan)] if trunk else []
    return np.stack([*person.points.values(), *directions, *held], axis=1)


def _of_length_1(directions: Array) -> Array:
    length = np.linalg.norm(directions, axis=1, keepdims=True)
    return np.asarray(directions / np.where(length > 0.0, length, np.nan))


def _lost_arms(agent: Agent, tracked: Mapping[str, Mask]) -> Mask:
    """Positions of arms that are lost in a frame: they lean to where they were last, (N, nq)."""
    lost = np.zeros((len(tracked["torso"]), agent.base.stop + len(agent.joints)), dtype=bool)
    for joint, column in agent.joints.items():
        for side in SIDES:
            if joint.startswith(f"{side}_") and any(word in joint for word in ARMS):
                lost[:, column] = ~tracked[f"{side}_arm"]
    return lost


# --- Upright pelvis, leaning trunk: what holds the pelvis where no direction of it is tracked.
#
# Shoulders and hips leave the pelvis free to pitch: it and the torso would turn against each other, by 15 to 35°, only
# to bring the points of a face one or two centimetres forward on a neck that does not bend. So the pelvis is drawn to
# between upright and where the trunk points, from the hips to the shoulders. Who bends does so with the back first and
# with the hips then (the lumbar-pelvic rhythm [Esola 1996]), and who lies, lies with the pelvis, too: the more the
# trunk is inclined, the less counts upright. Hips flex as far as they can: in who crouches, the back bends.

HIPS, SHOULDERS = ("left_hip", "right_hip"), ("left_shoulder", "right_shoulder")
TRUNK_LINES: Mapping[str, Between] = {
    f"{'hips' if low is HIPS else 'pelvis'} to {'shoulders' if high is SHOULDERS else 'neck'}": Between(low, high)
    for high in (SHOULDERS, ("neck",))
    for low in (HIPS, ("pelvis",))
}
"""Lines up the trunk, the most trusted first."""
HELD = "pelvis_up"
UPRIGHT_SHARE = 0.7
"""How much upright counts beside a trunk that is upright, too; else times the squared cosine of its inclination (ours).
The pelvis so takes a third of a lean of 20°, half of one of 45° and two thirds of one of 60°."""
PELVIS_WEIGHT = 3.0
"""Weight of that direction in the fit (ours; 1 to 3 make little difference)."""
MOST_FLEXED_RAD = math.radians(125.0)
"""How far hips flex: the range of the body's own [AAOS 1965]."""


def trunk_directions(person: PersonTrack) -> dict[str, Array]:
    """Which way the pelvis is to point up in each frame, (N, 3) by line of ``TRUNK_LINES``.

    Each frame has the direction of one line at most, and NaN in the others. There is none at all where the mapping
    gives a direction of the pelvis.
    """
    if {"pelvis", "pelvis_up"} & person.directions.keys():
        return {}
    thigh = _line(person.points, HIPS, ("left_knee", "right_knee"))
    found: dict[str, Array] = {}
    known: Mask | None = None
    for name, rule in TRUNK_LINES.items():
        line = _line(person.points, rule.start, rule.end)
        if line is None:
            continue
        up = _between_upright_and(line)
        up = up if thigh is None else _flexed(up, thigh)
        found[name] = up if known is None else np.where(known[:, None], np.nan, up)
        finite: Mask = np.asarray(np.isfinite(up).all(axis=1))
        known = finite if known is None else np.asarray(known | finite)
    return found


def _line(points: Points, start: Sequence[str], end: Sequence[str]) -> Array | None:
    """Unit vectors from the middle of some points to that of others, (N, 3); None if one of them is not there."""
    if not {*start, *end} <= points.keys():
        return None
    line = np.mean([points[name] for name in end], axis=0) - np.mean([points[name] for name in start], axis=0)
    length = np.linalg.norm(line, axis=1, keepdims=True)
    return np.asarray(line / np.where(length > 0.0, length, np.nan))


def _between_upright_and(trunk: Array) -> Array:
    """Unit vectors between upright and directions of the trunk, (N, 3)."""
    upright = UPRIGHT_SHARE * np.maximum(trunk[:, 2:], 0.0) ** 2 * np.array((0.0, 0.0, 1.0))
    drawn = upright + (1.0 - UPRIGHT_SHARE) * trunk
    return np.asarray(drawn / np.linalg.norm(drawn, axis=1, keepdims=True))


def _flexed(trunk: Array, thigh: Array) -> Array:
    """The trunk's directions, those nearer to the thighs than hips flex turned away from them, (N, 3)."""
    nearest = np.pi - MOST_FLEXED_RAD
    along = np.sum(trunk * thigh, axis=1, keepdims=True)
    across = trunk - along * thigh
    width = np.linalg.norm(across, axis=1, keepdims=True)
    turned = np.cos(nearest) * thigh + np.sin(nearest) * across / np.where(width > 0.0, width, np.nan)
    return np.where((along > np.cos(nearest)) & np.isfinite(turned), turned, trunk)


def _of_stature(marker: Marker, stature_m: float) -> Marker:
    x, y, z = (share * stature_m for share in marker.offset_m)
    return Marker(marker.landmark, (x, y, z), marker.axes)


def _axes_of(scene: Scene, name: str, lines: Mapping[str, Between], markers: Mapping[str, Marker]) -> dict[str, Axis]:
    """The axes of the body that correspond to lines between points: where these lead on it in its zero configuration.

    Its parts stand there along the axes of the world, so that a direction in the world is one in each part.
    """
    model, data = scene.model, mujoco.MjData(scene.model)
    mujoco.mj_kinematics(model, data)

    def place(point: str) -> Array:
        marker = markers.get(point, Marker(point, (0.0, 0.0, 0.0)))
        return np.asarray(data.site(f"{name}/{marker.landmark}").xpos + np.array(marker.offset_m))

    axes = {}
    for key, rule in lines.items():
        line = np.mean([place(point) for point in rule.end], axis=0) - np.mean(
            [place(point) for point in rule.start], axis=0
        )
        x, y, z = (float(value) for value in line / np.linalg.norm(line))
        axes[key] = (AXES[HELD if key in TRUNK_LINES else key][0], (x, y, z))
    return axes


def _alone(name: str, size: HumanSize) -> Scene:
    """A scene with nothing but this person: fitting is fast where little can move."""
    return Scene.from_spec(mujoco.MjSpec(), [entry_of(name, size)])


def entry_of(name: str, size: HumanSize) -> AgentEntry:
    """A person of a size, to tenths of a millimetre, as an agent of a scene."""
    return AgentEntry(name, body={key: round(value, 4) for key, value in vars(size).items()})


def tracked_parts(person: PersonTrack) -> dict[str, Mask]:
    """Frames in which each part of the body was tracked, (N,) by part.

    A head needs a place and a direction, a trunk some place, an arm its wrist or hand, legs a knee and an ankle.
    """
    count = len(next(iter([*person.points.values(), *person.directions.values()])))

    def known(names: tuple[str, ...], tracks: Mapping[str, Array] = person.points) -> Mask:
        found = [np.isfinite(tracks[key]).all(axis=1) for key in names if key in tracks]
        return np.asarray(np.any(found, axis=0)) if found else np.zeros(count, dtype=bool)

    parts = {
        "head": known(HEAD_POINTS) & known(("face",), person.directions),
        "torso": known(TRUNK_POINTS) & known(("pelvis", "left_hip", "right_hip", "abdomen")),
        "legs": known(("left_knee", "right_knee")) & known(("left_ankle", "right_ankle")),
    }
    for side in ("left", "right"):
        parts[f"{side}_arm"] = known((f"{side}_wrist", f"{side}_hand", f"{side}_fingertip"))
    return parts


def _without_legs(scene: Scene, name: str) -> list[str]:
    legs = scene.agent(name).profile.legs
    still = {*legs.hips, *legs.knees, *legs.ankles}
    return [j for j in scene.joints(name) if j not in still and "hip_abduction" not in j]


def _start(scene: Scene, name: str, person: PersonTrack) -> State:
    """At the first known pelvis (or trunk), facing where the line of the shoulders says, arms relaxed.

    Upright, but for who lies or bends far: the first frame has a long way to go else.
    """
    agent = scene.agent(name)
    place = _first(person, ("pelvis", "left_hip", "right_hip", "abdomen", "chest", "neck", "head", "head_base"))
    height = place[2] if "pelvis" in person.points else scene.initial.qpos[agent.base][2]
    state = scene.initial.replace(at=agent.base, to=(place[0], place[1], height, *_turned(person)))
    return state.replace(
        {index: RELAXED[key] for joint, index in agent.joints.items() for key in RELAXED if joint.endswith(key)}
    )


def _first(person: PersonTrack, names: tuple[str, ...]) -> Array:
    for name in names:
        if name in person.points:
            known = np.isfinite(person.points[name]).all(axis=1)
            if known.any():
                return np.asarray(person.points[name][np.argmax(known)])
    return np.zeros(3)


def _turned(person: PersonTrack) -> Array:
    """Orientation wxyz of the pelvis to start from, (4,)."""
    upright = about_z(_heading(person))
    up = next(
        (up[known][0] for up in trunk_directions(person).values() if (known := np.isfinite(up).all(axis=1)).any()), None
    )
    if up is None or up[2] > math.cos(BENT_RAD):
        return upright
    across = _line(person.points, (SHOULDERS[1],), (SHOULDERS[0],))
    if across is None or not (known := np.isfinite(across).all(axis=1)).any():
        return upright
    left = across[known][0] - (across[known][0] @ up) * up
    left /= np.linalg.norm(left)
    return wxyz_from_matrix(np.column_stack([np.cross(left, up), left, up]))


def _heading(person: PersonTrack) -> float:
    """Heading in radians: across shoulders or hips, else where the face looks."""
    for part in ("shoulder", "hip"):
        left, right = (person.points.get(f"{side}_{part}") for side in ("left", "right"))
        if left is not None and right is not None:
            across = left - right
            known = np.isfinite(across).all(axis=1)
            if known.any():
                y, x = -across[np.argmax(known), 0], across[np.argmax(known), 1]
                return float(np.arctan2(y, x))
    face = person.directions.get("face")
    if face is not None and np.isfinite(face).all(axis=1).any():
        forward = face[np.argmax(np.isfinite(face).all(axis=1))]
        return float(np.arctan2(forward[1], forward[0]))
    return 0.0


def _estimate_legs(scene: Scene, name: str, states: Array) -> Mask:
    """Bend the legs so that the soles stand on the floor beneath hips of the tracked height.

    Returns:
        Frames in which the thighs are so inclined that the body would sit, (N,).
    """
    agent = scene.agent(name)
    low = np.zeros(len(states), dtype=bool)
    for frame, row in enumerate(states):
        angles, _ = legs_for(scene.model, agent, hip_height_m=float(row[agent.base][2]))
        low[frame] = angles[agent.profile.legs.hips[0]] > DEFAULT.contact.sitting_thigh_rad
        pitch = math.asin(np.clip(-rotate(row[agent.base][3:], (1.0, 0.0, 0.0))[2], -1.0, 1.0))
        for joint, angle in angles.items():
            index = agent.joints[joint]
            flexed = angle + (pitch if joint in agent.profile.legs.hips else 0.0)  # legs do not tilt as the pelvis does
            row[index] = np.clip(flexed, *scene.model.joint(f"{name}/{joint}").range)
    return low


def _report(person: PersonTrack, errors: Array) -> dict[str, Any]:
    """The errors of landmarks, centimetres, and directions, degrees, from (N, f) in metres and radians."""
    known = [column[np.isfinite(column)] for column in errors.T]
    points = zip(person.points, known[: len(person.points)], strict=True)
    directions = zip(person.directions, known[len(person.points) :], strict=True)
    return {
        "points_cm": {name: _summary(100 * each) for name, each in points if len(each)},
        "directions_deg": {name: _summary(np.degrees(each)) for name, each in directions if len(each)},
    }


def _summary(errors: Array) -> dict[str, float]:
    return {
        "median": round(float(np.median(errors)), 2),
        "p95": round(float(np.percentile(errors, 95)), 2),
        "max": round(float(errors.max()), 2),
    }
