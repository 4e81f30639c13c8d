"""How an eye moves with its head, whatever the rest of the body does.

All is told in the frame that the eye has when the head's joints are in the middle of their ranges: the same from each
stance. Aiming is that of the search: joint by joint from where they are, each by the angle about its own axis between
gaze and target, twice. No angle is ever computed; cosines and sines are added, and compared with those of the limits,
which lie within half a circle of the middle.

Compiled functions get all of it as one row of numbers, which they pass on for nothing. The inner joint is the one
nearer to the eye; the outer one carries it.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.acting.standpoint import Standpoint
from taskgist.perspective.acting.virtual_actions import PAN, TILT
from taskgist.world.body.profile import Axis
from taskgist.world.geometry.compiled import compiled

Array = NDArray[np.float64]
ROUNDS = 2
SAMPLES = 9
BEYOND = 3.0
SLACK, SLACK_RAD = 0.02, math.radians(5.0)
"""Between two of the sampled angles the eye goes no farther than this share of its way, the gaze than this angle."""
INNER, MOVES, AXES, ANCHORS, ENDS, PARTS, SWING, START = 0, 1, 3, 9, 15, 27, 54, 55
"""Places in the row: which joint is the inner one, 0 for pan; whether each moves; unit vectors of the axes; points on
them, metres; cosine, sine and ``_around`` of each limit; how the inner joint moves the eye and its directions ahead and
aside, in nines: what stays, and what goes with cosine and sine of its turn; how far the eye moves at most; and cosine
and sine of where the inner and the outer joint are now."""
EYE, AHEAD, ASIDE = PARTS, PARTS + 9, PARTS + 18
ORIGIN = np.zeros(3)


@dataclass(frozen=True, eq=False)
class Head:
    """A head, or one that does not move.

    Attributes:
        numbers: The row for compiled functions.
        middle: Angles in the middle of the ranges by index into qpos, radians.
        low_m: With ``high_m`` the box in which the eye stays, metres, (3,).
        high_m: See ``low_m``.
        off_rad: How far the gaze turns at most.
    """

    numbers: Array
    middle: Mapping[int, float]
    low_m: Array
    high_m: Array
    off_rad: float

    @property
    def stiff(self) -> Head:
        """The same head, that stays as it is now."""
        numbers = np.array(self.numbers)
        numbers[MOVES : MOVES + 2] = 0.0
        return replace(self, numbers=numbers)


def head_of(here: Standpoint) -> Head:
    """The head of an agent; the stage shows its state afterwards."""
    joints = (here.agent.profile.pan, here.agent.profile.tilt)
    ranges = [_range_rad(here, action, joint) for action, joint in zip((PAN, TILT), joints, strict=True)]
    middle = {
        here.agent.joints[joint.joint]: sum(ends) / 2 for joint, ends in zip(joints, ranges, strict=True) if joint
    }
    stage = here.stage.show(here.state.replace(middle))
    eye = stage.eye(here.agent)
    axes, anchors = np.zeros((2, 3)), np.zeros((2, 3))
    for row, joint in enumerate(joints):
        if joint is not None:
            anchor, axis = stage.screw(_joint_id(here, joint))
            axes[row], anchors[row] = axis @ eye.matrix, eye.to_local(anchor)
    here.stage.show(here.state)
    pan, tilt = (_joint_id(here, joint) for joint in joints)
    inner = 0 if pan > tilt else 1  # bodies, and the joints of one body, are numbered from the root outwards
    now = [
        float(here.state.qpos[here.agent.joints[joint.joint]]) - sum(ends) / 2 if joint else 0.0
        for joint, ends in zip(joints, ranges, strict=True)
    ]
    limits = np.array([((low - high) / 2, (high - low) / 2) for low, high in ranges])
    return _measured(_numbers(inner, axes, anchors, limits, now), inner, limits, middle)


def _range_rad(here: Standpoint, action: str, joint: Axis | None) -> tuple[float, float]:
    """The angles that a joint may take: its present one is always allowed, and the only one if it may not move."""
    if joint is None:
        return 0.0, 0.0
    now = float(here.state.qpos[here.agent.joints[joint.joint]])
    return (min(joint.range_rad[0], now), max(joint.range_rad[1], now)) if action in here.actions else (now, now)


def shapes_of_head(here: Standpoint) -> NDArray[np.intp]:
    """Shapes that the head's joints carry, and those of the body that the eye looks through, (n,)."""
    model, agent = here.stage.scene.model, here.agent
    joints = [_joint_id(here, axis) for axis in (agent.profile.pan, agent.profile.tilt) if axis]
    carried = {agent.eye_exclude_body, *(int(model.jnt_bodyid[joint]) for joint in joints)}
    for body in agent.bodies:  # a parent's index is always below its children's
        if int(model.body_parentid[body]) in carried:
            carried.add(int(body))
    return np.array([geom for geom in agent.geoms if int(model.geom_bodyid[geom]) in carried], dtype=np.intp)


def _joint_id(here: Standpoint, axis: Axis | None) -> int:
    """A joint's place in the model's order, −1 for none."""
    return int(here.stage.scene.model.joint(f"{here.agent.name}/{axis.joint}").id) if axis else -1


def _numbers(inner: int, axes: Array, anchors: Array, limits: Array, now: Sequence[float]) -> Array:
    axis, anchor = axes[inner], anchors[inner]
    parts = []
    for vector, start in ((-anchor, anchor), (np.array([1.0, 0.0, 0.0]), ORIGIN), (np.array([0.0, 1.0, 0.0]), ORIGIN)):
        along = axis * float(axis @ vector)  # Rodrigues' formula, taken apart
        parts += [start + along, vector - along, np.cross(axis, vector)]
    ends = [f(limit) for row in limits for limit in row for f in (math.cos, math.sin, _around)]
    start = [f(now[joint]) for joint in (inner, 1 - inner) for f in (math.cos, math.sin)]
    moves = limits[:, 0] < limits[:, 1]
    return np.concatenate(([inner], moves, axes.ravel(), anchors.ravel(), ends, *parts, [0.0], start))


def _measured(numbers: Array, inner: int, limits: Array, middle: Mapping[int, float]) -> Head:
    """A head, with how far its eye moves and its gaze turns at most, from sampled angles."""
    eyes, off_rad = [ORIGIN], 0.0
    for angles in itertools.product(*(np.linspace(low, high, SAMPLES) for low, high in limits)):
        inside, outside = angles[inner], angles[1 - inner]
        aim = Aim(math.cos(inside), math.sin(inside), math.cos(outside), math.sin(outside))
        ahead = np.add(within_head(numbers, aim, EYE), within_head(numbers, aim, AHEAD))
        eyes.append(np.array(out_of_head(numbers, aim, *within_head(numbers, aim, EYE))))
        gaze = np.array(out_of_head(numbers, aim, *ahead)) - eyes[-1]
        off_rad = max(off_rad, math.acos(float(np.clip(gaze[0], -1.0, 1.0))))
    slack_m = SLACK * float(np.ptp(eyes, axis=0).max())
    numbers[SWING] = float(np.linalg.norm(eyes, axis=1).max()) + slack_m
    low_m, high_m = np.min(eyes, axis=0) - slack_m, np.max(eyes, axis=0) + slack_m
    return Head(numbers, middle, low_m, high_m, off_rad + SLACK_RAD)


class Aim(NamedTuple):
    """Cosine and sine of the turns of the inner and the outer joint, from the middle of their ranges."""

    inner_cos: float
    inner_sin: float
    outer_cos: float
    outer_sin: float


@compiled
def aimed(head: Array, x: float, y: float, z: float) -> Aim:
    """How the head's joints turn so that the eye looks at a point of its frame as nearly as they can."""
    aim = Aim(head[START], head[START + 1], head[START + 2], head[START + 3])
    for turn in range(2 * ROUNDS):
        joint = turn % 2
        if head[MOVES + joint] == 0.0:
            continue
        px, py, pz = into_head(head, aim, x, y, z)
        ex, ey, ez = within_head(head, aim, EYE)
        fx, fy, fz = within_head(head, aim, AHEAD)
        at = AXES + 3 * joint
        across, along = _angle_about(head[at], head[at + 1], head[at + 2], fx, fy, fz, px - ex, py - ey, pz - ez)
        length = math.sqrt(across * across + along * along)
        if length == 0.0:
            continue
        if joint == head[INNER]:
            cos, sin = _turned(head, joint, aim.inner_cos, aim.inner_sin, along / length, across / length)
            aim = Aim(cos, sin, aim.outer_cos, aim.outer_sin)
        else:
            cos, sin = _turned(head, joint, aim.outer_cos, aim.outer_sin, along / length, across / length)
            aim = Aim(aim.inner_cos, aim.inner_sin, cos, sin)
    return aim


@compiled
def into_head(head: Array, aim: Aim, x: float, y: float, z: float) -> tuple[float, float, float]:
    """A point of the eye's frame as the inner joint's carrier has it, once the outer joint has turned."""
    return _about_outer(head, aim.outer_cos, -aim.outer_sin, x, y, z)


@compiled
def out_of_head(head: Array, aim: Aim, x: float, y: float, z: float) -> tuple[float, float, float]:
    """The reverse of ``into_head``."""
    return _about_outer(head, aim.outer_cos, aim.outer_sin, x, y, z)


@compiled
def _about_outer(head: Array, cos: float, sin: float, x: float, y: float, z: float) -> tuple[float, float, float]:
    """A point turned about the outer joint's axis [Rodrigues]."""
    at = 3 * (1 - int(head[INNER]))
    ax, ay, az = head[AXES + at], head[AXES + at + 1], head[AXES + at + 2]
    cx, cy, cz = head[ANCHORS + at], head[ANCHORS + at + 1], head[ANCHORS + at + 2]
    x, y, z = x - cx, y - cy, z - cz
    along = (ax * x + ay * y + az * z) * (1.0 - cos)
    return (
        x * cos + (ay * z - az * y) * sin + ax * along + cx,
        y * cos + (az * x - ax * z) * sin + ay * along + cy,
        z * cos + (ax * y - ay * x) * sin + az * along + cz,
    )


@compiled
def within_head(head: Array, aim: Aim, part: int) -> tuple[float, float, float]:
    """The eye (or its direction ahead or aside) after the inner joint's turn, before the outer's."""
    cos, sin = aim.inner_cos, aim.inner_sin
    return (
        head[part] + cos * head[part + 3] + sin * head[part + 6],
        head[part + 1] + cos * head[part + 4] + sin * head[part + 7],
        head[part + 2] + cos * head[part + 5] + sin * head[part + 8],
    )


@compiled
def _angle_about(
    ax: float, ay: float, az: float, sx: float, sy: float, sz: float, ex: float, ey: float, ez: float
) -> tuple[float, float]:
    """Sine and cosine, not normalised, of the angle about a unit axis that turns one direction towards another."""
    across = ax * (sy * ez - sz * ey) + ay * (sz * ex - sx * ez) + az * (sx * ey - sy * ex)
    along = (sx * ex + sy * ey + sz * ez) - (ax * sx + ay * sy + az * sz) * (ax * ex + ay * ey + az * ez)
    return across, along


@compiled
def _turned(
    head: Array, joint: int, old_cos: float, old_sin: float, turn_cos: float, turn_sin: float
) -> tuple[float, float]:
    """Cosine and sine of a joint's angle after a further turn of less than half a circle, within its limits."""
    low, high = ENDS + 6 * joint, ENDS + 6 * joint + 3
    cos, sin = old_cos * turn_cos - old_sin * turn_sin, old_sin * turn_cos + old_cos * turn_sin
    around = math.copysign(1.0 - cos, sin)
    if old_sin > 0.0 and turn_sin > 0.0 and sin < 0.0:  # beyond half a circle
        around = BEYOND
    elif old_sin < 0.0 and turn_sin < 0.0 and sin > 0.0:
        around = -BEYOND
    if around > head[high + 2]:
        return head[high], head[high + 1]
    if around < head[low + 2]:
        return head[low], head[low + 1]
    return cos, sin


@compiled
def _around(angle: float) -> float:
    """A number from −2 to 2 that grows with an angle, from −π to π, as ``_turned`` compares them."""
    if abs(angle) >= math.pi:
        return math.copysign(2.0, angle)
    return math.copysign(1.0 - math.cos(angle), angle)
