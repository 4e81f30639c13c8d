"""The gaze: where eyes are when their head aims at points, and whether these lie in view. Compiled."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from taskgist.common.arrays import Array, Indices
from taskgist.common.compiled import compiled
from taskgist.maps.grid import LANES
from taskgist.perspective.effort import PAN, TILT
from taskgist.perspective.viewpoint import Viewpoint
from taskgist.world.bodies.profile import Axis

# --- Aiming a head at many points at once: the angles by which its joints turn the eye to each. Compiled.
#
# Aiming is that of the search: from where the joints are, each by the angle about its own axis between gaze and
# target, twice. No angle is ever computed; cosines and sines are added, and compared with those of the limits, which
# lie within half a circle of the middle.
#
# A head is one row of numbers. The inner joint is the one nearer to the eye; the outer one carries it. Points are
# given, and found is noted, in a *workspace*: one flat array, a row of ``LANES`` numbers for each quantity. Loops
# over its lanes have no branches and no row but by constants, so that several lanes are computed by each instruction
# of the processor.

ROUNDS = 2
BEYOND = 3.0
INNER, MOVES, AXES, ANCHORS, ENDS, PARTS, SWING, START = 0, 1, 3, 9, 15, 27, 54, 55
"""Places in the row of a head: which joint is the inner one, 0 for pan; whether each moves; unit vectors of the axes;
points on them, metres; cosine, sine and ``around`` of each limit; how the inner joint moves the eye and its directions
ahead and aside, in nines: what stays, and what goes with cosine and sine of its turn; how far the eye moves at most;
and cosine and sine of where the inner and the outer joint are now."""
EYE, AHEAD, ASIDE = PARTS, PARTS + 9, PARTS + 18
ROWS = 16
X, Y, Z, INNER_COS, INNER_SIN, OUTER_COS, OUTER_SIN, NEW_COS, NEW_SIN = (LANES * row for row in range(9))
"""Rows of the workspace: points in the frame of the eye, its head in the middle, metres; cosine and sine of the turns
of the inner and the outer joint, from the middle of their ranges; and of a joint's next turn."""


@compiled
def aim_all(head: Array, work: Array, count: int) -> None:
    """Turn the joints so that the eye looks at each of some points as nearly as they can."""
    for lane in range(count):
        work[INNER_COS + lane], work[INNER_SIN + lane] = head[START], head[START + 1]
        work[OUTER_COS + lane], work[OUTER_SIN + lane] = head[START + 2], head[START + 3]
    for turn in range(2 * ROUNDS):
        joint = turn % 2
        if head[MOVES + joint] != 0.0:
            _turn(head, joint, work, count)
            row = INNER_COS if joint == head[INNER] else OUTER_COS
            work[row : row + count] = work[NEW_COS : NEW_COS + count]
            work[row + LANES : row + LANES + count] = work[NEW_SIN : NEW_SIN + count]


@compiled
def _turn(head: Array, joint: int, work: Array, count: int) -> None:
    """The next turn of one joint: from gaze to target about its axis, as far as its limits let it."""
    at = AXES + 3 * joint
    jx, jy, jz = head[at], head[at + 1], head[at + 2]
    low, high = ENDS + 6 * joint, ENDS + 6 * joint + 3
    low_cos, low_sin, lowest = head[low], head[low + 1], head[low + 2]
    high_cos, high_sin, highest = head[high], head[high + 1], head[high + 2]
    old = INNER_COS if joint == head[INNER] else OUTER_COS
    outer, eye, ahead = outer_axis(head), part_of_head(head, EYE), part_of_head(head, AHEAD)
    for lane in range(count):
        cos, sin = work[INNER_COS + lane], work[INNER_SIN + lane]
        px, py, pz = about(
            outer, work[OUTER_COS + lane], -work[OUTER_SIN + lane], work[X + lane], work[Y + lane], work[Z + lane]
        )
        ex, ey, ez = within_head(eye, cos, sin)
        gx, gy, gz = within_head(ahead, cos, sin)
        tx, ty, tz = px - ex, py - ey, pz - ez
        across = jx * (gy * tz - gz * ty) + jy * (gz * tx - gx * tz) + jz * (gx * ty - gy * tx)
        along = (gx * tx + gy * ty + gz * tz) - (jx * gx + jy * gy + jz * gz) * (jx * tx + jy * ty + jz * tz)
        length = math.sqrt(across * across + along * along)
        turn_cos, turn_sin = along / length, across / length
        old_cos, old_sin = work[old + lane], work[old + LANES + lane]
        cos, sin = old_cos * turn_cos - old_sin * turn_sin, old_sin * turn_cos + old_cos * turn_sin
        end = math.copysign(1.0 - cos, sin)
        end = BEYOND if (old_sin > 0.0) & (turn_sin > 0.0) & (sin < 0.0) else end  # beyond half a circle
        end = -BEYOND if (old_sin < 0.0) & (turn_sin < 0.0) & (sin > 0.0) else end
        cos, sin = (high_cos if end > highest else cos), (high_sin if end > highest else sin)
        cos, sin = (low_cos if end < lowest else cos), (low_sin if end < lowest else sin)
        work[NEW_COS + lane] = cos if length > 0.0 else old_cos
        work[NEW_SIN + lane] = sin if length > 0.0 else old_sin


@compiled
def outer_axis(head: Array) -> tuple[float, float, float, float, float, float]:
    """Axis of the outer joint, and a point on it."""
    at = 3 * (1 - int(head[INNER]))
    ax, an = AXES + at, ANCHORS + at
    return head[ax], head[ax + 1], head[ax + 2], head[an], head[an + 1], head[an + 2]


@compiled
def about(
    axis: tuple[float, float, float, float, float, float], cos: float, sin: float, x: float, y: float, z: float
) -> tuple[float, float, float]:
    """A point turned about an axis [Rodrigues]."""
    ax, ay, az, cx, cy, cz = axis
    x, y, z = x - cx, y - cy, z - cz
    along = (ax * x + ay * y + az * z) * (1.0 - cos)
    return (
        x * cos + (ay * z - az * y) * sin + ax * along + cx,
        y * cos + (az * x - ax * z) * sin + ay * along + cy,
        z * cos + (ax * y - ay * x) * sin + az * along + cz,
    )


Part = tuple[float, float, float, float, float, float, float, float, float]


@compiled
def part_of_head(head: Array, part: int) -> Part:
    """How the inner joint moves the eye, or its direction ahead or aside."""
    a, b, c = head[part], head[part + 1], head[part + 2]
    d, e, f = head[part + 3], head[part + 4], head[part + 5]
    return a, b, c, d, e, f, head[part + 6], head[part + 7], head[part + 8]


@compiled
def within_head(part: Part, cos: float, sin: float) -> tuple[float, float, float]:
    """The eye (or its direction ahead or aside) after the inner joint's turn, before the outer's."""
    return (
        part[0] + cos * part[3] + sin * part[6],
        part[1] + cos * part[4] + sin * part[7],
        part[2] + cos * part[5] + sin * part[8],
    )


@compiled
def around(angle: float) -> float:
    """A number from −2 to 2 that grows with an angle, from −π to π, as ``_turn`` compares them."""
    if abs(angle) >= math.pi:
        return math.copysign(2.0, angle)
    return math.copysign(1.0 - math.cos(angle), angle)


PLACE, TURNED, EYE_COLUMNS = 12, 14, 15
"""Columns of a table of eyes, one row for each trial: its position with the head in its middle; its axes, the columns
of a matrix, row by row; where the base stands if the agent turns to what it looks at, and 1 if it does: then all else
is given in the frame under the base that looks along the chest."""
EYE_X, EYE_Y, EYE_Z, IN_VIEW, AWAY, TURN_COS, TURN_SIN = (LANES * row for row in range(9, 16))
"""More rows of the workspace: where the eye gets to, in the frame of its eye; 1 for points in view; how far these are
over the floor from the base of an agent that turns, and cosine and sine of the direction."""
CONE_COS, ACROSS_TAN, UP_TAN = range(3)
"""What the eye sees at once: cosine of the gaze cone's half-angle, and tangents of half the view."""
LIMIT_COS, LIMIT_SIN = 3, 4
"""Columns of a table of cones in the eye's frame, its head in the middle: axis, and cosine and sine of half the angle.
All that is ever seen lies in each of them."""


@compiled
def look_all(head: Array, view: Array, work: Array, count: int) -> None:
    """Aim the head at each of some points, and find out where the eye is then, and whether they are in view."""
    aim_all(head, work, count)
    outer, eye = outer_axis(head), part_of_head(head, EYE)
    ahead_part, aside_part = part_of_head(head, AHEAD), part_of_head(head, ASIDE)
    cone_cos, across_tan, up_tan = view[CONE_COS], view[ACROSS_TAN], view[UP_TAN]
    for lane in range(count):
        cos, sin = work[INNER_COS + lane], work[INNER_SIN + lane]
        turn_cos, turn_sin = work[OUTER_COS + lane], work[OUTER_SIN + lane]
        ix, iy, iz = within_head(eye, cos, sin)
        fx, fy, fz = within_head(ahead_part, cos, sin)
        sx, sy, sz = within_head(aside_part, cos, sin)
        px, py, pz = about(outer, turn_cos, -turn_sin, work[X + lane], work[Y + lane], work[Z + lane])
        dx, dy, dz = px - ix, py - iy, pz - iz
        ahead, aside = dx * fx + dy * fy + dz * fz, dx * sx + dy * sy + dz * sz
        squared = dx * dx + dy * dy + dz * dz
        up = math.sqrt(max(squared - ahead * ahead - aside * aside, 0.0))
        inside = (ahead > 0.0) & (ahead >= cone_cos * math.sqrt(squared))
        inside = inside & (abs(aside) <= across_tan * ahead) & (up <= up_tan * ahead)
        work[IN_VIEW + lane] = 1.0 if inside else 0.0
        work[EYE_X + lane], work[EYE_Y + lane], work[EYE_Z + lane] = about(outer, turn_cos, turn_sin, ix, iy, iz)


@compiled
def show_points(points: Array, lanes: Indices, which: int, count: int, eyes: Array, trial: int, work: Array) -> None:
    """Bring the points in one row of ``lanes`` into the workspace, as a trial has them."""
    for lane in range(count):
        row = lanes[which, lane]
        x, y, z = points[row, 0], points[row, 1], points[row, 2]
        if eyes[trial, TURNED] != 0.0:
            x, y = x - eyes[trial, PLACE], y - eyes[trial, PLACE + 1]
            away = math.hypot(x, y)
            cos, sin = (x / away, y / away) if away > 1e-9 else (1.0, 0.0)
            work[AWAY + lane], work[TURN_COS + lane], work[TURN_SIN + lane] = away, cos, sin
            x, y = away, 0.0
        work[X + lane], work[Y + lane], work[Z + lane] = in_eye(eyes, trial, x, y, z)


@compiled
def shown_eye(eyes: Array, trial: int, work: Array, lane: int) -> tuple[float, float, float, float, float]:
    """Where the eye is that looks at a point of the workspace: in the trial's own frame, then x and y in the world."""
    x, y, z = in_trial(eyes, trial, work[EYE_X + lane], work[EYE_Y + lane], work[EYE_Z + lane])
    if eyes[trial, TURNED] == 0.0:
        return x, y, z, x, y
    cos, sin = work[TURN_COS + lane], work[TURN_SIN + lane]
    return x, y, z, cos * x - sin * y + eyes[trial, PLACE], sin * x + cos * y + eyes[trial, PLACE + 1]


@compiled
def eye_positions(points: Array, rows: Indices, head: Array, view: Array, eyes: Array, trial: int) -> Array:
    """Where the eye of a trial is when the head aims at each of some points, metres in the world, (n, 3)."""
    found, work = np.empty((len(rows), 3)), np.empty(ROWS * LANES)
    for start in range(0, len(rows), LANES):
        count = min(LANES, len(rows) - start)
        show_points(points, rows[start : start + count].reshape(1, count), 0, count, eyes, trial, work)
        look_all(head, view, work, count)
        for lane in range(count):
            _, _, z, x, y = shown_eye(eyes, trial, work, lane)
            found[start + lane, 0], found[start + lane, 1], found[start + lane, 2] = x, y, z
    return found


@compiled
def out_of_cones(cones: Array, swing: float, x: float, y: float, z: float) -> bool:
    """Whether a point of the eye's frame is plainly out of view, however the head turns and wherever the eye goes.

    Args:
        cones: All that is seen lies in each.
        swing: How far eye and point move at most, together.
        x: The point; all in metres.
        y: As above.
        z: As above.
    """
    away = math.sqrt(x * x + y * y + z * z)
    if away <= swing:
        return False
    sin = swing / away
    cos = math.sqrt(1.0 - sin * sin)
    for cone in range(len(cones)):
        limit_cos, limit_sin = cones[cone, LIMIT_COS], cones[cone, LIMIT_SIN]
        narrow = limit_cos * sin + limit_sin * cos > 0.0  # both angles make less than half a circle
        along = x * cones[cone, 0] + y * cones[cone, 1] + z * cones[cone, 2]
        if narrow and along < away * (limit_cos * cos - limit_sin * sin):
            return True
    return False


@compiled
def in_eye(eyes: Array, trial: int, x: float, y: float, z: float) -> tuple[float, float, float]:
    """A point in the frame of a trial's eye, its head in the middle."""
    dx, dy, dz = x - eyes[trial, 0], y - eyes[trial, 1], z - eyes[trial, 2]
    return (
        dx * eyes[trial, 3] + dy * eyes[trial, 6] + dz * eyes[trial, 9],
        dx * eyes[trial, 4] + dy * eyes[trial, 7] + dz * eyes[trial, 10],
        dx * eyes[trial, 5] + dy * eyes[trial, 8] + dz * eyes[trial, 11],
    )


@compiled
def in_trial(eyes: Array, trial: int, x: float, y: float, z: float) -> tuple[float, float, float]:
    """The reverse of ``in_eye``: a point of the eye's frame in the one in which its trial is told."""
    return (
        x * eyes[trial, 3] + y * eyes[trial, 4] + z * eyes[trial, 5] + eyes[trial, 0],
        x * eyes[trial, 6] + y * eyes[trial, 7] + z * eyes[trial, 8] + eyes[trial, 1],
        x * eyes[trial, 9] + y * eyes[trial, 10] + z * eyes[trial, 11] + eyes[trial, 2],
    )


# --- The head of an agent, as one row of numbers: how its eye moves with it, whatever the rest of the body does.
#
# All is told in the frame that the eye has when the head's joints are in the middle of their ranges: the same from
# each stance.

SAMPLES = 9
SLACK, SLACK_RAD = 0.02, math.radians(5.0)
"""Between two of the sampled angles the eye goes no farther than this share of its way, the gaze than this angle."""
ORIGIN = np.zeros(3)
AHEAD_IN_MIDDLE = np.array([1.0, 0.0, 0.0])
ALL_ROUND = np.array([way for way in itertools.product((-1.0, 0.0, 1.0), repeat=3) if any(way)])


@dataclass(frozen=True, eq=False)
class Head:
    """A head, or one that does not move.

    Attributes:
        numbers: The row for compiled functions.
        middle: Angles in the middle of the ranges by index into qpos, radians.
        low_m: With ``high_m`` the box in which the eye stays, metres, (3,).
        high_m: See ``low_m``.
        gazes: Where it may look, unit vectors some degrees apart, (n, 3).
    """

    numbers: Array
    middle: Mapping[int, float]
    low_m: Array
    high_m: Array
    gazes: Array

    @property
    def stiff(self) -> Head:
        """The same head, that stays as it is now."""
        numbers = np.array(self.numbers)
        numbers[MOVES : MOVES + 2] = 0.0
        _, gaze = _eye_and_gaze(numbers, *numbers[START : START + 4].tolist())
        return replace(self, numbers=numbers, gazes=gaze[None])

    def cones(self, view_rad: float) -> Array:
        """Cones in which lies all that is seen, (n, columns) of ``gaze``: one round the gazes, and others aside.

        Args:
            view_rad: Half the angle of the gaze cone.
        """
        middle = self.gazes.mean(axis=0)
        axes = np.vstack((middle / np.linalg.norm(middle), ALL_ROUND / np.linalg.norm(ALL_ROUND, axis=1)[:, None]))
        limits = np.arccos(np.clip(self.gazes @ axes.T, -1.0, 1.0)).max(axis=0) + SLACK_RAD + view_rad
        narrow = limits < math.pi
        narrow[0] = True
        limits = np.minimum(limits, math.pi)
        return np.asarray(np.column_stack((axes, np.cos(limits), np.sin(limits)))[narrow])


def head_of(here: Viewpoint) -> Head:
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


def _range_rad(here: Viewpoint, action: str, joint: Axis | None) -> tuple[float, float]:
    """The angles that a joint may take: its present one is always allowed, and the only one if it may not move."""
    if joint is None:
        return 0.0, 0.0
    now = float(here.state.qpos[here.agent.joints[joint.joint]])
    return (min(joint.range_rad[0], now), max(joint.range_rad[1], now)) if action in here.actions else (now, now)


def shapes_of_head(here: Viewpoint) -> NDArray[np.intp]:
    """Shapes that the head's joints carry, and those of the body that the eye looks through, (n,)."""
    model, agent = here.stage.scene.model, here.agent
    joints = [_joint_id(here, axis) for axis in (agent.profile.pan, agent.profile.tilt) if axis]
    carried = {agent.eye_exclude_body, *(int(model.jnt_bodyid[joint]) for joint in joints)}
    for body in agent.bodies:  # a parent's index is always below its children's
        if int(model.body_parentid[body]) in carried:
            carried.add(int(body))
    return np.array([geom for geom in agent.geoms if int(model.geom_bodyid[geom]) in carried], dtype=np.intp)


def _joint_id(here: Viewpoint, axis: Axis | None) -> int:
    """A joint's place in the model's order, −1 for none."""
    return int(here.stage.scene.model.joint(f"{here.agent.name}/{axis.joint}").id) if axis else -1


def _numbers(inner: int, axes: Array, anchors: Array, limits: Array, now: Sequence[float]) -> Array:
    axis, anchor = axes[inner], anchors[inner]
    parts = []
    for vector, start in ((-anchor, anchor), (AHEAD_IN_MIDDLE, ORIGIN), (np.array([0.0, 1.0, 0.0]), ORIGIN)):
        along = axis * float(axis @ vector)  # Rodrigues' formula, taken apart
        parts += [start + along, vector - along, np.cross(axis, vector)]
    ends = [f(limit) for row in limits for limit in row for f in (math.cos, math.sin, around)]
    start = [f(now[joint]) for joint in (inner, 1 - inner) for f in (math.cos, math.sin)]
    moves = limits[:, 0] < limits[:, 1]
    return np.concatenate(([inner], moves, axes.ravel(), anchors.ravel(), ends, *parts, [0.0], start))


def _measured(numbers: Array, inner: int, limits: Array, middle: Mapping[int, float]) -> Head:
    """A head, with how far its eye moves and its gaze turns at most, from sampled angles."""
    eyes, gazes = [ORIGIN], []
    for angles in itertools.product(*(np.linspace(low, high, SAMPLES) for low, high in limits)):
        inside, outside = angles[inner], angles[1 - inner]
        eye, gaze = _eye_and_gaze(numbers, math.cos(inside), math.sin(inside), math.cos(outside), math.sin(outside))
        eyes.append(eye)
        gazes.append(gaze)
    slack_m = SLACK * float(np.ptp(eyes, axis=0).max())
    numbers[SWING] = float(np.linalg.norm(eyes, axis=1).max()) + slack_m
    low_m, high_m = np.min(eyes, axis=0) - slack_m, np.max(eyes, axis=0) + slack_m
    return Head(numbers, middle, low_m, high_m, np.array(gazes))


def _eye_and_gaze(
    numbers: Array, inner_cos: float, inner_sin: float, outer_cos: float, outer_sin: float
) -> tuple[Array, Array]:
    """Where the eye is, and where it looks, metres and a unit vector, (3,) each."""
    outer = outer_axis(numbers)
    eye, ahead = (within_head(part_of_head(numbers, part), inner_cos, inner_sin) for part in (EYE, AHEAD))
    position = np.array(about(outer, outer_cos, outer_sin, *eye))
    return position, np.array(about(outer, outer_cos, outer_sin, *np.add(eye, ahead))) - position
