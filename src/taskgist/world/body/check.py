"""Is a profile fit to use? Every problem by name, what the body lacks, and the body itself on an empty floor."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from taskgist.errors import InputError, UnknownNameError
from taskgist.world.body.anthropometry import HumanSize
from taskgist.world.body.attempts import UNREADABLE
from taskgist.world.body.directions import direction_doubts, sliding_before
from taskgist.world.body.model_files import body_files, read_file, read_model
from taskgist.world.body.named import name_problems
from taskgist.world.body.profile import AS_THE_JOINT, AgentProfile, builtin_profile_text, builtin_profiles
from taskgist.world.body.profile_file import examine_profile
from taskgist.world.body.sizes import size_problems
from taskgist.world.scene import Scene
from taskgist.world.scene_file import DEFAULT_STATURE_M

BODY = "body"
"""Name of the agent in the scene of a check."""
SCENE = f'[scene]\nname = "an empty floor"\nmodel = "floor.xml"\n[agents.{BODY}]\nprofile = "{BODY}.profile.toml"\n'
FLOOR = '<mujoco><worldbody><geom name="floor" type="plane" size="5 5 0.1"/></worldbody></mujoco>'


@dataclass(frozen=True, eq=False)
class BodyCheck:
    """What was found of a profile.

    Attributes:
        name: As it was given.
        given: The profile as its document has it; None if that cannot be read.
        problems: Why it cannot be used; empty if it can.
        doubts: What can be used and is probably wrong: an eye that looks aside, a joint about the wrong axis.
        lacks: What the body does not have, or has otherwise than the profile says, and what follows.
        scene: The body alone on an empty floor; None beside problems.
    """

    name: str
    given: AgentProfile | None
    problems: tuple[InputError, ...]
    doubts: tuple[str, ...] = ()
    lacks: tuple[str, ...] = ()
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
    bundle = {"scene.toml": SCENE.encode(), "floor.xml": FLOOR.encode(), f"{BODY}.profile.toml": text, **files}
    try:
        scene = Scene.from_bundle(bundle, where=where)
    except InputError as error:
        return BodyCheck(profile, given, (error,))
    doubts = direction_doubts(scene.model, scene.agent(BODY), scene.initial.qpos)
    return BodyCheck(profile, given, (), tuple(doubts), tuple(_lacks(given, scene)), scene)


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
    try:
        size = HumanSize.from_stature(DEFAULT_STATURE_M)
        files = body_files(given, key, prefix=f"{BODY}_", folder=folder, where=where, size=size)
        spec = read_model(files, key, where=where, room=False)
    except InputError as error:
        return {}, (error,)
    return files, (*size_problems(spec, where), *name_problems(spec, given, where))


def _lacks(given: AgentProfile, scene: Scene) -> Iterator[str]:
    agent = scene.agent(BODY)
    has = {
        "arms": (given.arms, "it reaches and grasps nothing"),
        "hand": (given.hand, "it reaches, and grasps nothing"),
        "head.pan": (given.pan, "to look aside it turns its torso, or itself"),
        "head.tilt": (given.tilt, "it looks neither up nor down"),
        "torso.turn": (given.turn, "it turns only as a whole"),
        "torso.lean": (given.lean, "it does not lean over to reach or see"),
        "base.moves": (given.moves, "it stays where it stands"),
        "posture": ("sitting" in given.legs.can, "it neither sits down nor stands up"),
        "solid shapes": (len(agent.core_geoms), "head, torso and base push into nothing: every way is free"),
    }
    yield from (f"no {field}: {meaning}" for field, (there, meaning) in has.items() if not there)
    for joint in sliding_before(scene.model, agent):
        yield f"{joint!r} slides between base and shoulders, and no virtual action moves it: a scene may, by joints_m"
    for (field, asked), (_, found) in zip(given.axes, agent.profile.axes, strict=True):
        if asked.range_rad not in (AS_THE_JOINT, found.range_rad):
            low, high = (math.degrees(limit) for limit in found.range_rad)
            yield f"{field}.range_deg is wider than the joint {found.joint!r}: it turns from {low:.0f} to {high:.0f}"
