"""What a profile names, held against what its model has: every name that is missing, with the one that was meant."""

from __future__ import annotations

from collections.abc import Collection, Iterator

import mujoco

from taskgist.errors import InputError, SceneError, UnknownNameError
from taskgist.world.body.attempts import UNREADABLE
from taskgist.world.body.profile import AgentProfile, Arm

FREE, HINGE, SLIDE = mujoco.mjtJoint.mjJNT_FREE, mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE


def name_problems(spec: mujoco.MjSpec, profile: AgentProfile, where: str) -> Iterator[InputError]:
    """Every name of the profile that its model does not have, and every one of the wrong kind.

    Args:
        spec: The model.
        profile: The profile.
        where: Profile's file for the messages.
    """
    yield from _root_problems(spec, profile, where)
    bodies = {str(body.name) for body in spec.bodies if body.name != "world"}
    for field, name in _bodies(profile):
        if name not in (*bodies, UNREADABLE):
            yield UnknownNameError("body", name, bodies, where=f"{where}: {field}")
    yield from _frame_problems(spec, profile, where, bodies)
    yield from _joint_problems(spec, profile, where)
    for arm in profile.arms:
        yield from _arm_problems(spec, arm, where)


def _root_problems(spec: mujoco.MjSpec, profile: AgentProfile, where: str) -> Iterator[InputError]:
    roots = [str(body.name) or "(no name)" for body in spec.worldbody.bodies]
    if len(roots) != 1:
        names = ", ".join(roots) or "none"
        hint = "keep the robot, and leave floor and furniture to the scene"
        problem = f"a model of an agent has one top-level body, {profile.model!r} has {len(roots)}: {names}"
        yield SceneError(problem, where=where, field="model", hint=hint)
        return
    joints = spec.worldbody.first_body().joints
    if joints and [joint.type for joint in joints] != [FREE]:
        hint = "without any it is made free to stand anywhere"
        problem = "the root body of an agent's model has a free joint, or none"
        yield SceneError(problem, where=where, field="model", value=str(joints[0].name), hint=hint)


def _bodies(profile: AgentProfile) -> Iterator[tuple[str, str]]:
    yield from (("eye.exclude", name) for name in (profile.eye.exclude, *profile.eye.housing))
    yield from ((f"posture.{key}", name) for key in ("thighs", "feet") for name in getattr(profile.legs, key))
    for arm in profile.arms:
        yield f"arms.{arm.side}.root", arm.root
        yield f"arms.{arm.side}.hand", arm.hand
        if arm.carrier:
            yield f"arms.{arm.side}.carrier", arm.carrier
    yield from ((f"parts.{part}", name) for part, names in profile.parts for name in names)


def _frame_problems(
    spec: mujoco.MjSpec, profile: AgentProfile, where: str, bodies: Collection[str]
) -> Iterator[InputError]:
    sites = {str(site.name) for site in spec.sites if site.name}
    for _, field, frame in (each for each in profile.frames if each[2].name != UNREADABLE):
        if frame.name not in sites and frame.name not in bodies:
            yield UnknownNameError("site or body", frame.name, {*sites, *bodies}, where=f"{where}: {field}")
        elif frame.name in sites and not frame.is_plain:
            hint = "move and turn the site in the model, or name the body that it sits in"
            yield SceneError("a site is taken as it stands", where=where, field=field, value=frame.name, hint=hint)


def _joint_problems(spec: mujoco.MjSpec, profile: AgentProfile, where: str) -> Iterator[InputError]:
    kinds = {str(joint.name): joint.type for joint in spec.joints if joint.type in (HINGE, SLIDE)}
    for field, name in _joints(profile):
        if name not in (*kinds, UNREADABLE):
            yield UnknownNameError("joint", name, kinds, where=f"{where}: {field}")
        elif kinds.get(name, HINGE) != HINGE and field != "rest_m":
            hint = "give its rest under [rest_m]" if field == "rest_deg" else "name a joint that turns"
            yield SceneError("a joint that slides", where=where, field=field, value=name, hint=hint)


def _joints(profile: AgentProfile) -> Iterator[tuple[str, str]]:
    yield from ((field, axis.joint) for field, axis in profile.axes)
    for key in ("hips", "knees", "ankles"):
        yield from ((f"posture.{key}", name) for name in getattr(profile.legs, key))
    yield from (("rest_deg", name) for name, _ in profile.rest_rad)
    yield from (("rest_m", name) for name, _ in profile.rest_m)


def _arm_problems(spec: mujoco.MjSpec, arm: Arm, where: str) -> Iterator[InputError]:
    """A hand that its arm does not carry, or a palm: how far it reaches would be told of something else."""
    root = spec.body(arm.root) if arm.root else None
    site = spec.site(arm.palm.name) if arm.palm.name else None
    palm = str(site.parent.name) if site is not None else arm.palm.name
    for key, name in (("hand", arm.hand), ("palm", palm)):
        body = spec.body(name) if name else None
        if root is not None and body is not None and arm.root not in _carriers(body):
            hint = f"name what hangs on {arm.root!r}, or another root"
            problem = f"the {key} is no part of the arm, which begins with {arm.root!r}"
            yield SceneError(problem, where=where, field=f"arms.{arm.side}.{key}", value=name, hint=hint)


def _carriers(body: mujoco.MjsBody) -> set[str]:
    """Names of a body and all that carry it."""
    names: set[str] = set()
    while body is not None and body.name != "world":
        names.add(str(body.name))
        body = body.parent
    return names
