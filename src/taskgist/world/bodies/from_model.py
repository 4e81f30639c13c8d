"""What a profile leaves to its model: a camera that is the eye, and what a hand's fingers tell of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import mujoco

from taskgist.errors import SceneError
from taskgist.world.bodies.eyes import Frame, from_camera
from taskgist.world.bodies.fingers import Plain, Unclear, measured_hand
from taskgist.world.bodies.hands import NEEDED, Hand, OpenHand
from taskgist.world.bodies.profile import AgentProfile

SAME_M = 0.005
"""How far two hands of one body may differ and be one kind of hand (ours)."""


def completed_by_model(
    profile: AgentProfile, spec: mujoco.MjSpec, compiled: Callable[[], mujoco.MjModel], where: str
) -> AgentProfile:
    """The profile with its eye and its hand as the model has them, where it leaves them to that.

    Args:
        profile: As its document has it; its names are those of the model.
        spec: The body alone.
        compiled: Compiles it; asked only if something is left to it.
        where: The profile's file, for messages.

    Raises:
        SceneError: The camera is no eye, or a hand's fingers are not plain: the message names the fields to give.
    """
    if not profile.eye.sees:
        frame = profile.arms[0].shoulder if profile.arms else Frame(str(spec.worldbody.first_body().name))
        root = str(spec.worldbody.first_body().name)
        profile = replace(profile, eye=replace(profile.eye, frame=frame, exclude=root))
    if profile.eye.camera is None and profile.open_hand is None:
        return profile
    model = compiled()
    if profile.eye.camera is not None:
        profile = replace(profile, eye=from_camera(profile.eye, model, where))
    if profile.open_hand is not None:
        profile = replace(profile, hand=_hand(profile, profile.open_hand, model, where), open_hand=None)
    return profile


def _hand(profile: AgentProfile, given: OpenHand, model: mujoco.MjModel, where: str) -> Hand:
    found = {arm.side: measured_hand(model, int(model.body(arm.hand).id)) for arm in profile.arms}
    plain = [each for each in found.values() if isinstance(each, Plain)]
    fields: dict[str, Any] = dict(plain[0].fields) if plain and len(plain) == len(found) else {}
    if len(plain) > 1:
        fields = {key: value for key, value in fields.items() if _alike(value, plain[1].fields.get(key))}
    if set(given.missing) == {"kind"} and "kind" not in fields:
        fields["kind"] = Hand.kind
    missing = [field for field in NEEDED if field not in fields and field not in dict(given.given)]
    if missing:
        why = "; ".join(
            f"{arm.hand}: {each.why}" for arm in profile.arms if isinstance(each := found[arm.side], Unclear)
        )
        if not profile.arms:
            why = "no arm names a hand"
        why = why or ("its two hands differ" if len(plain) > 1 else "nothing but fingers is there")
        hint = "give them in the profile, in metres; kind is human, parallel or three_finger"
        problem = f"the model does not tell {', '.join(missing)}: {why}"
        raise SceneError(problem, where=where, field=f"hand.{missing[0]}", hint=hint)
    return given.completed(fields, where)


def _alike(one: Any, other: Any) -> bool:
    if isinstance(one, tuple) and isinstance(other, tuple):
        return all(_alike(a, b) for a, b in zip(one, other, strict=True))
    if isinstance(one, float) and isinstance(other, float):
        return abs(one - other) <= SAME_M
    return bool(one == other)
