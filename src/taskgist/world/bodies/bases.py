"""What moves a body as a whole: a free joint, or joints that come to the same.

Simulators often spell a free body out: three slides and a ball joint, three slides and three hinges, or, for a robot
that drives, two slides and a hinge, maybe on links without shapes, one for each. In a scene whatever moves as a whole
has a free joint, so that a pose is a pose. These joints are recognised here, and give way to it.
"""

from __future__ import annotations

from collections.abc import Iterable

import mujoco
import numpy as np

from taskgist.common.arrays import Array
from taskgist.world.geometry.transforms import matrix_from_wxyz, normalized

FREE, BALL = mujoco.mjtJoint.mjJNT_FREE, mujoco.mjtJoint.mjJNT_BALL
SLIDE, HINGE = mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_HINGE
CONTROLS = ("sensors", "actuators", "tendons", "skins", "tuples", "keys")
"""Elements that may name joints and bodies, and that nothing here asks for."""
LEVEL = 1e-3
"""Sine of the angle by which an axis may miss level or upright."""


def is_free(body: mujoco.MjsBody) -> bool:
    """Whether a body has a free joint, and no other."""
    return [joint.type for joint in body.joints] == [FREE]


def moves_all_ways(body: mujoco.MjsBody) -> bool:
    """Whether a body has three slides, and a ball joint or three hinges: it gets everywhere, turned in every way."""
    kinds = sorted(int(joint.type) for joint in body.joints)
    return kinds in (sorted(map(int, (SLIDE,) * 3 + (BALL,))), sorted(map(int, (SLIDE,) * 3 + (HINGE,) * 3)))


def free(spec: mujoco.MjSpec, body: mujoco.MjsBody) -> mujoco.MjsJoint:
    """Give a top-level body a free joint in the place of whatever moves it; it stays where it is."""
    drop_joints(spec, list(body.joints))
    body.mocap = False
    return body.add_freejoint()


def drop_joints(spec: mujoco.MjSpec, joints: Iterable[mujoco.MjsJoint]) -> None:
    """Delete joints, and what couples others to them."""
    joints = list(joints)
    names = {str(joint.name) for joint in joints if joint.name}
    for equality in list(spec.equalities):
        if equality.type == mujoco.mjtEq.mjEQ_JOINT and names & {str(equality.name1), str(equality.name2)}:
            spec.delete(equality)
    for joint in joints:
        spec.delete(joint)


def drop_controls(spec: mujoco.MjSpec) -> None:
    """Delete what may speak of joints and bodies that go: actuators, sensors, tendons, keyframes and the like."""
    for equality in list(spec.equalities):
        if equality.type == mujoco.mjtEq.mjEQ_TENDON:
            spec.delete(equality)
    for kind in CONTROLS:
        for each in list(getattr(spec, kind)):
            spec.delete(each)


# --- Bases that drive: slides along the floor and a turn about the upright, at the root or on links of no shape.


def stand_still(spec: mujoco.MjSpec) -> None:
    """Delete the joints by which the one root of a robot's model moves as a whole; others stay as they are."""
    roots = list(spec.worldbody.bodies)
    joints = base_joints(roots[0]) if len(roots) == 1 else []
    if joints:
        drop_controls(spec)
        drop_joints(spec, joints)


def base_joints(root: mujoco.MjsBody) -> list[mujoco.MjsJoint]:
    """Joints by which a robot moves as a whole on the floor; none if it does not by slides.

    These are two level slides and, maybe, an upright hinge, in any order, in the root or in links below it that follow
    each other and have no shapes; an upright slide counts beside a level one. A root that moves all ways is one, too.

    Args:
        root: Top-level body of a flat model, whose orientations are quaternions.
    """
    if moves_all_ways(root):
        return list(root.joints)
    found: list[mujoco.MjsJoint] = []
    level: list[Array] = []
    turns, body, matrix = 0, root, matrix_from_wxyz(normalized(root.quat))
    while True:
        axes = {joint: matrix @ normalized(joint.axis) for joint in body.joints if joint.type in (SLIDE, HINGE)}
        slides = [axes[j] for j in axes if j.type == SLIDE and abs(axes[j][2]) < LEVEL]
        upright = [j for j in axes if np.hypot(*axes[j][:2]) < LEVEL and (j.type == HINGE or slides)]
        hinges = sum(j.type == HINGE for j in upright)
        fits = len(slides) + len(upright) == len(body.joints) and turns + hinges <= 1
        if not fits or _directions(level + slides) < len(level + slides):
            break
        found, level, turns = [*found, *body.joints], level + slides, turns + hinges
        children = list(body.bodies)
        if (len(level) == 2 and turns) or len(children) != 1 or len(body.geoms):
            break
        body = children[0]
        matrix = matrix @ matrix_from_wxyz(normalized(body.quat))
    return found if len(level) == 2 else []


def _directions(axes: list[Array]) -> int:
    """How many independent directions some axes have."""
    return int(np.linalg.matrix_rank(np.array(axes), tol=LEVEL)) if axes else 0
