"""Does a body look ahead, and do its joints turn it as their names in the profile say? A mistake here compiles."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np
from numpy.typing import NDArray

from taskgist.world.body.agent import Agent
from taskgist.world.body.frames import OPTICAL_WXYZ
from taskgist.world.geometry.rotations import matrix_from_wxyz

MOSTLY = 0.7
"""Cosine of 45°: nearer to an axis than across it."""
ROUGHLY = 0.5
"""Cosine of 60°, for heads that rest bent."""
UPRIGHT = {"head.pan": "pan turns to the side", "torso.turn": "turn turns to the side"}
ACROSS = {"head.tilt": "tilt looks up and down", "torso.lean": "lean bends forward"}

Vector = NDArray[np.float64]


def direction_doubts(model: mujoco.MjModel, body: Agent, qpos: Vector) -> Iterator[str]:
    """What a body that stands at the origin, heading along x, has probably the wrong way round.

    Args:
        model: The compiled scene.
        body: The agent.
        qpos: A state in which it rests.
    """
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_kinematics(model, data)
    eye = data.site_xmat[body.eye_site].reshape(3, 3)
    yield from _eye_doubts(eye, body)
    carriers = _carriers(model, int(model.site_bodyid[body.eye_site]))
    for field, axis in body.profile.axes:
        joint = int(model.joint(f"{body.name}/{axis.joint}").id)
        yield from _axis_doubts(field, axis.joint, np.array(data.xaxis[joint]))
        if field.startswith("head") and int(model.jnt_bodyid[joint]) not in carriers:
            yield f"{field}: the joint {axis.joint!r} does not move the eye"


def _eye_doubts(eye: Vector, body: Agent) -> Iterator[str]:
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


def _axis_doubts(field: str, joint: str, axis: Vector) -> Iterator[str]:
    """About the vertical, or level and across the body's heading."""
    if field in UPRIGHT and abs(axis[2]) < MOSTLY:
        yield f"{field}: {UPRIGHT[field]}, but the axis of {joint!r} is {_told(axis)}, not upright"
    if field in ACROSS and abs(axis[1]) < MOSTLY:
        yield f"{field}: {ACROSS[field]}, but the axis of {joint!r} is {_told(axis)}, not level and across the body"


def _carriers(model: mujoco.MjModel, body: int) -> set[int]:
    """A body and all that carry it."""
    found = {body}
    while body := int(model.body_parentid[body]):
        found.add(body)
    return found


def _told(vector: Vector) -> str:
    return "(" + ", ".join(f"{value + 0.0:.1f}" for value in np.round(vector, 1) + 0.0) + ")"


def sliding_before(model: mujoco.MjModel, body: Agent) -> tuple[str, ...]:
    """Joints that slide between base and shoulders, as a torso's lift does: no virtual action moves them."""
    carriers: set[int] = set()
    for arm in body.arms:
        carriers |= _carriers(model, arm.carrier_body)
    return tuple(
        str(model.joint(j).name).partition("/")[2]
        for j in range(model.njnt)
        if int(model.jnt_bodyid[j]) in carriers and int(model.jnt_type[j]) == int(mujoco.mjtJoint.mjJNT_SLIDE)
    )
