"""Is a profile fit to use? Every problem by name, what is probably wrong, what the body lacks, and the body itself."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from taskgist.common.arrays import Array
from taskgist.common.toml import UNREADABLE
from taskgist.errors import InputError, UnknownNameError
from taskgist.world.assembly import DEFAULT_STATURE_M
from taskgist.world.bodies.agent import Agent, subtree
from taskgist.world.bodies.eyes import OPTICAL_WXYZ
from taskgist.world.bodies.hands import NEEDED
from taskgist.world.bodies.human import HumanSize
from taskgist.world.bodies.model_files import add_body, name_problems, read_file, read_model, size_problems
from taskgist.world.bodies.profile import (
    AS_THE_JOINT,
    AgentProfile,
    builtin_profile_text,
    builtin_profiles,
    examine_profile,
)
from taskgist.world.geometry.transforms import matrix_from_wxyz
from taskgist.world.scene import Scene
from taskgist.world.scene_file import AgentEntry

# --- Does a body look ahead, and do its joints turn it as their names in the profile say? A mistake here compiles.

MOSTLY = 0.7
"""Cosine of 45°: nearer to an axis than across it."""
ROUGHLY = 0.5
"""Cosine of 60°, for heads that rest bent."""
MOST_TOLD = 4
"""Bodies that a doubt names."""
UPRIGHT = {"head.pan": "pan turns to the side", "torso.turn": "turn turns to the side"}
ACROSS = {"head.tilt": "tilt looks up and down", "torso.lean": "lean bends forward"}


def direction_doubts(model: mujoco.MjModel, body: Agent, qpos: Array) -> Iterator[str]:
    """What a body that stands at the origin, heading along x, has probably the wrong way round.

    Args:
        model: The compiled scene.
        body: The agent.
        qpos: A state in which it rests.
    """
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_kinematics(model, data)
    if body.profile.eye.sees:
        yield from _eye_doubts(data.site_xmat[body.eye_site].reshape(3, 3), body)
    for field, axis in body.profile.axes:
        joint = int(model.joint(f"{body.name}/{axis.joint}").id)
        yield from _axis_doubts(field, axis.joint, np.array(data.xaxis[joint]))
        yield from _carrying_doubts(model, body, field, joint)


def _carrying_doubts(model: mujoco.MjModel, body: Agent, field: str, joint: int) -> Iterator[str]:
    """A joint of the head that leaves the eye where it is, or one of the torso that leaves eye and shoulders."""
    name, moved = str(model.joint(joint).name).partition("/")[2], int(model.jnt_bodyid[joint])
    eye = {int(model.site_bodyid[body.eye_site])} if body.profile.eye.sees else set()
    shoulders = {int(model.site_bodyid[arm.shoulder_site]) for arm in body.arms}
    carried = subtree(model, moved)
    if field.startswith("head") and not eye & set(carried):
        yield f"{field}: the joint {name!r} does not move the eye; {_carried(model, carried)}"
    if field.startswith("torso") and not (eye | shoulders) & set(carried):
        yield f"{field}: the joint {name!r} carries neither the eye nor a shoulder; {_carried(model, carried)}"


def _carried(model: mujoco.MjModel, bodies: Sequence[int]) -> str:
    """What a joint carries, by names of the model, not more than a line of them."""
    names = [str(model.body(each).name).partition("/")[2] for each in bodies]
    more = f" and {len(names) - MOST_TOLD} more" if len(names) > MOST_TOLD else ""
    return f"it carries {', '.join(names[:MOST_TOLD])}{more}"


def _eye_doubts(eye: Array, body: Agent) -> Iterator[str]:
    ahead, up = eye[0, 0], eye[2, 2]
    if ahead >= ROUGHLY and up >= ROUGHLY:
        return
    turned = eye @ matrix_from_wxyz(OPTICAL_WXYZ)
    optical = turned[0, 0] >= ROUGHLY and turned[2, 2] >= ROUGHLY
    hint = "it would with optical = true" if optical else "turn it by rpy_deg, or the joints by rest_deg"
    name = body.profile.eye.frame.name
    if ahead < ROUGHLY:
        yield f"eye.frame: {name!r} does not look ahead, but along {_told(eye[:, 0])} (x ahead, z up); {hint}"
    else:
        yield f"eye.frame: {name!r} looks ahead with its z along {_told(eye[:, 2])}, not upwards; {hint}"


def _axis_doubts(field: str, joint: str, axis: Array) -> Iterator[str]:
    """About the vertical, or level and across the body's heading."""
    if field in UPRIGHT and abs(axis[2]) < MOSTLY:
        yield f"{field}: {UPRIGHT[field]}, but the axis of {joint!r} is {_told(axis)}, not upright"
    if field in ACROSS and abs(axis[1]) < MOSTLY:
        yield f"{field}: {ACROSS[field]}, but the axis of {joint!r} is {_told(axis)}, not level and across the body"


def _told(vector: Array) -> str:
    return "(" + ", ".join(f"{value + 0.0:.1f}" for value in np.round(vector, 1) + 0.0) + ")"


BODY = "body"
"""Name of the agent in the scene of a check."""


@dataclass(frozen=True, eq=False)
class BodyCheck:
    """What was found of a profile.

    Attributes:
        name: As it was given.
        given: The profile as its document has it; None if that cannot be read.
        problems: Why it cannot be used; empty if it can.
        doubts: What can be used and is probably wrong: an eye that looks aside, a joint about the wrong axis.
        lacks: What the body does not have, or has otherwise than the profile says, and what follows.
        derived: What the profile leaves to the model, with the figures that this gave.
        scene: The body alone on an empty floor; None beside problems.
    """

    name: str
    given: AgentProfile | None
    problems: tuple[InputError, ...]
    doubts: tuple[str, ...] = ()
    lacks: tuple[str, ...] = ()
    derived: tuple[str, ...] = ()
    scene: Scene | None = None


def check_body(profile: str) -> BodyCheck:
    """Check a profile.

    Args:
        profile: Name of a built-in profile, or a TOML file.

    Raises:
        SceneError: The file cannot be read.
        UnknownNameError: There is no such built-in profile.
    """
    text, folder, where = _document(profile)
    given, misread = examine_profile(text, where=where, stature_m=DEFAULT_STATURE_M)
    if given is None:
        return BodyCheck(profile, None, misread)
    files, misnamed = _files(given, folder, where)
    if misread or misnamed:
        return BodyCheck(profile, given, (*misread, *misnamed))
    entry = AgentEntry(BODY, profile=f"{BODY}.profile.toml")
    room = mujoco.MjSpec()
    room.worldbody.add_geom(name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=(5.0, 5.0, 0.1))
    try:
        scene = Scene.from_spec(
            room, [entry], name="an empty floor", files={entry.profile_key: text, **files}, where=where
        )
    except InputError as error:
        return BodyCheck(profile, given, (error,))
    doubts = direction_doubts(scene.model, scene.agent(BODY), scene.initial.qpos)
    lacks, derived = tuple(_lacks(given, scene)), tuple(_derived(given, scene.agent(BODY).profile))
    return BodyCheck(profile, given, (), tuple(doubts), lacks, derived, scene)


def _document(profile: str) -> tuple[bytes, Path | None, str]:
    if profile in builtin_profiles():
        return builtin_profile_text(profile).encode(), None, f"profile {profile}"
    if not profile.endswith(".toml"):
        raise UnknownNameError("profile", profile, builtin_profiles(), where="built-in profiles, and files (.toml)")
    return read_file(Path(profile)), Path(profile).parent, profile


def _files(given: AgentProfile, folder: Path | None, where: str) -> tuple[dict[str, bytes], tuple[InputError, ...]]:
    """The model's files, or everything that is wrong with it."""
    if given.model == UNREADABLE:
        return {}, ()
    key = f"{BODY}.model.xml"
    files: dict[str, bytes] = {}
    try:
        size = HumanSize.from_stature(DEFAULT_STATURE_M)
        add_body(given, key, files, prefix=f"{BODY}_", folder=folder, where=where, size=size)
        spec = read_model(files, key, where=where, room=False)
    except InputError as error:
        return {}, (error,)
    return files, (*size_problems(spec, where), *name_problems(spec, given, where))


def _derived(given: AgentProfile, found: AgentProfile) -> Iterator[str]:
    """What the model gave where the profile says nothing."""
    eye, hand = found.eye, found.hand
    if given.eye.camera is not None:
        fov = " by ".join(f"{math.degrees(angle):.1f}°" for angle in eye.fov_rad)
        pixels = " by ".join(map(str, eye.image_px))
        yield f"eye.camera {eye.camera!r} of the body {eye.frame.name!r}: {fov}, {pixels} pixels"
    if given.open_hand is not None and hand is not None:
        said = dict(given.open_hand.given)
        sizes = {field: getattr(hand, field) for field in (*NEEDED, "finger_width_m") if field not in said}
        sizes |= {"spread_m": hand.spread_m} if hand.kind == "three_finger" and "spread_m" not in said else {}
        names = " and ".join(arm.hand for arm in found.arms)
        told = ", ".join(f"{field} {_size(value)}" for field, value in sizes.items() if value is not None)
        yield f"hand: measured on {names}: {told}"


def _size(value: object) -> str:
    if isinstance(value, tuple):
        return "[" + ", ".join(f"{each:.3f}" for each in value) + "]"
    return f"{value:.3f}" if isinstance(value, float) else str(value)


def _lacks(given: AgentProfile, scene: Scene) -> Iterator[str]:
    agent = scene.agent(BODY)
    has = {
        "eye": (given.eye.sees, "what it sees is unknown"),
        "arms": (given.arms, "it reaches and grasps nothing"),
        "hand": (agent.profile.hand, "it reaches, and grasps nothing"),
        "head.pan": (given.pan or not given.eye.sees, "to look aside it turns its torso, or itself"),
        "head.tilt": (given.tilt or not given.eye.sees, "it looks neither up nor down"),
        "torso.turn": (given.turn, "it turns only as a whole"),
        "torso.lean": (given.lean, "it does not lean over to reach or see"),
        "base.moves": (given.moves, "it stays where it stands"),
        "posture": ("sitting" in given.legs.can, "it neither sits down nor stands up"),
        "solid shapes": (len(agent.core_geoms), "head, torso and base push into nothing: every way is free"),
    }
    yield from (f"no {field}: {meaning}" for field, (there, meaning) in has.items() if not there)
    for (field, asked), (_, found) in zip(given.axes, agent.profile.axes, strict=True):
        if asked.range_rad not in (AS_THE_JOINT, found.range_rad):
            low, high = (math.degrees(limit) for limit in found.range_rad)
            yield f"{field}.range_deg is wider than the joint {found.joint!r}: it turns from {low:.0f} to {high:.0f}"
