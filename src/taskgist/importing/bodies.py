"""A tracked person's body: its size, and its joint angles over time, fitted to landmarks frame after frame."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from taskgist.common.arrays import Array, Mask
from taskgist.errors import SceneError
from taskgist.importing.mapping_people import SIDES
from taskgist.importing.tracks import PersonTrack
from taskgist.world.bodies.agent import Agent, legs_for
from taskgist.world.bodies.human import SHARES, HumanSize
from taskgist.world.fit import ARMS, Fitter
from taskgist.world.geometry.transforms import about_z
from taskgist.world.scene import Scene
from taskgist.world.scene_file import AgentEntry
from taskgist.world.state import State

# --- How large a tracked person is: stature and segment lengths, from the distances between landmarks.

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


def estimate_size(points: Points, stature_m: float | None) -> HumanSize:
    """Size of a person's body.

    Args:
        points: Landmarks over time, metres, (N, 3) each, NaN where unknown.
        stature_m: The stature, where somebody measured it; else it is estimated from the height of the head.

    Raises:
        SceneError: A length is not one of a human body: units or landmarks are wrong.
    """
    measured = {name: length for name, pairs in SEGMENTS.items() if (length := _length(points, pairs)) is not None}
    trunk = _between(_hips(points), _shoulders(points), STRETCHED_PERCENTILE)
    if trunk is not None:
        measured["trunk_m"] = trunk
    neck = _neck(points)
    if neck is not None:
        measured["neck_m"] = neck
    stature = stature_m if stature_m is not None else _stature(points, measured)
    return HumanSize.from_stature(stature, **measured)


def stands(points: Points) -> Mask:
    """Whether the person stands in each frame, by the height of the hips, (N,); False where unknown."""
    hips, shoulders, head = _hips(points), _shoulders(points), _head(points)
    trunk = _between(hips, shoulders, STRETCHED_PERCENTILE)
    if hips is None or (trunk is None and head is None):
        return np.zeros(_count(points), dtype=bool)
    if trunk is not None:
        return np.asarray(hips[:, 2] > STANDING_TRUNKS * trunk)
    assert head is not None
    return np.asarray(hips[:, 2] / head[0][:, 2] * head[1] / HEAD_HEIGHTS["head_base"] > STANDING_HEADS)


def _stature(points: Points, measured: Mapping[str, float]) -> float:
    """From heights while the person is upright, else from the lengths of the segments."""
    head, hips = _head(points), _hips(points)
    if head is not None and hips is not None:
        upright = _upright(hips, head[0])
        standing = upright & stands(points)
        if standing.any():
            return float(np.median(head[0][standing, 2])) / head[1]
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


def _head(points: Points) -> tuple[Array, float] | None:
    return next(((points[name], share) for name, share in HEAD_HEIGHTS.items() if name in points), None)


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
RELAXED = {"shoulder_abduction": 0.12, "elbow": 0.3}
"""Angles in radians of an arm that nobody tracked."""


@dataclass(frozen=True, eq=False)
class BodyTrack:
    """One fitted body.

    Attributes:
        base: Position in metres and wxyz of the pelvis, (N, 7).
        joints_rad: Angles of its joints, (N, joints), in the order of ``Scene.joints``.
        tracked: Frames in which each part was tracked, by part, (N,).
        report: Error of the fit by landmark (centimetres) and direction (degrees): median, 95th percentile, largest.
        notes: What was estimated.
    """

    base: Array
    joints_rad: Array
    tracked: Mapping[str, Mask]
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
    tracked = tracked_parts(person)
    count = len(tracked["torso"])
    legs_tracked = bool(tracked["legs"].any())
    fitter = Fitter(
        scene, name, moving="body" if legs_tracked else _without_legs(scene, name), weights=WEIGHTS, root=True
    )
    rest = state = _start(scene, name, person)
    states = np.empty((count, scene.nq))
    errors_m: dict[str, list[float]] = {}
    errors_rad: dict[str, list[float]] = {}
    for frame in range(count):
        points = {key: track[frame] for key, track in person.points.items()}
        directions = {key: track[frame] for key, track in person.directions.items()}
        fit = fitter.fit(
            state,
            points=points,
            directions=directions,
            rest=_leaning(scene.agent(name), rest, state, lost=_lost_sides(tracked, frame)),
            iterations=FIRST_ITERATIONS if frame == 0 else ITERATIONS,
        )
        state = fit.state
        _collect(errors_m, fit.errors_m)
        _collect(errors_rad, fit.errors_rad)
        states[frame] = state.qpos
        progress((frame + 1) / count)
    notes: tuple[str, ...] = ()
    if not legs_tracked and tracked["torso"].any():
        _estimate_legs(scene, name, states)
        if "legs" not in person.unknown:
            tracked = {**tracked, "legs": tracked["torso"]}
            notes = (f"{name}'s legs are estimated from the height of the hips",)
    base, joints = states[:, scene.base_slice(name)], states[:, scene.joint_indices(name)]
    return BodyTrack(base, joints, tracked, _report(errors_m, errors_rad), notes)


def _lost_sides(tracked: Mapping[str, Mask], frame: int) -> list[str]:
    return [side for side in SIDES if not tracked[f"{side}_arm"][frame]]


def _leaning(agent: Agent, rest: State, last: State, *, lost: Collection[str]) -> State:
    """The posture of rest, but for arms that are lost: they stay as they were seen last."""
    arms = [joint for joint in agent.joints if any(word in joint for word in ARMS)]
    columns = [agent.joints[joint] for joint in arms for side in lost if joint.startswith(f"{side}_")]
    return rest.replace({column: float(last.qpos[column]) for column in columns})


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
    """Upright at the first known pelvis (or trunk), facing where the line of the shoulders says, arms relaxed."""
    agent = scene.agent(name)
    place = _first(person, ("pelvis", "left_hip", "right_hip", "abdomen", "chest", "neck", "head", "head_base"))
    height = place[2] if "pelvis" in person.points else scene.initial.qpos[agent.base][2]
    state = scene.initial.replace(at=agent.base, to=(place[0], place[1], height, *about_z(_heading(person))))
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


def _estimate_legs(scene: Scene, name: str, states: Array) -> None:
    """Bend the legs so that the soles stand on the floor beneath hips of the tracked height."""
    agent = scene.agent(name)
    for row in states:
        angles, _ = legs_for(scene.model, agent, hip_height_m=float(row[agent.base][2]))
        for joint, angle in angles.items():
            row[agent.joints[joint]] = angle


def _collect(collected: dict[str, list[float]], errors: Mapping[str, float]) -> None:
    for name, error in errors.items():
        collected.setdefault(name, []).append(error)


def _report(errors_m: Mapping[str, list[float]], errors_rad: Mapping[str, list[float]]) -> dict[str, Any]:
    return {
        "points_cm": {name: _summary(100 * np.array(errors)) for name, errors in errors_m.items()},
        "directions_deg": {name: _summary(np.degrees(errors)) for name, errors in errors_rad.items()},
    }


def _summary(errors: Array) -> dict[str, float]:
    return {
        "median": round(float(np.median(errors)), 2),
        "p95": round(float(np.percentile(errors, 95)), 2),
        "max": round(float(errors.max()), 2),
    }
