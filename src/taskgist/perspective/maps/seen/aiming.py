"""Aiming a head at many points at once: the angles by which its joints turn the eye to each. Compiled.

Aiming is that of the search: from where the joints are, each by the angle about its own axis between gaze and target,
twice. No angle is ever computed; cosines and sines are added, and compared with those of the limits, which lie within
half a circle of the middle.

A head is one row of numbers. The inner joint is the one nearer to the eye; the outer one carries it. Points are given,
and found is noted, in a *workspace*: one flat array, a row of ``LANES`` numbers for each quantity. Loops over its lanes
have no branches and no row but by constants, so that several lanes are computed by each instruction of the processor.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.maps.cells import LANES
from taskgist.world.geometry.compiled import compiled

Array = NDArray[np.float64]
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
