"""Timing: when a way is where, as fast as speeds and accelerations allow, from rest to rest.

A way is checked along straight lines between its way points, and nothing says that anything beside them is free. So
the timed motion must not leave them by more than the checks' own steps do: it follows the quadratic B-spline of the
way points. That runs exactly on straight stretches, turns each corner on a parabola between points of the two steps
that meet there, and so leaves the way by at most a third of a step in each joint (a quarter where steps are equal),
without having to stop. (A spline *through* way points swings out between them by as much as it likes.) Whoever checked
a way with a clearance of less than that, at the hand, has to check it anew.

Its speed is found by reachability analysis [Pham & Pham 2018], as toppra has it (extra ``planning``). toppra holds
the limits at points of a grid; between them acceleration is linear, and what is too much there or at a kink of the
path slows the whole motion by that little, so that limits hold everywhere. Example::

    times_s, positions = timed(way, velocity=(2.0,) * 7, acceleration=(4.0,) * 7, rate_hz=30)
"""

from __future__ import annotations

import itertools
import math

import numpy as np
from numpy.typing import ArrayLike

from taskgist.common.arrays import Array, Indices
from taskgist.common.extras import door
from taskgist.errors import InputError

EXTRA = "planning"
RATIO = 2.0
"""Longer steps than this, against their neighbours, are halved."""
TURNS_BACK = -0.99
"""Cosine of the angle from which a corner is a turning back: there a motion comes to rest."""
ROUNDING = 1e-9
NOTHING = 1e-6
"""Steps below this (radians or metres) are none."""


def timed(way: ArrayLike, velocity: ArrayLike, acceleration: ArrayLike, *, rate_hz: float) -> tuple[Array, Array]:
    """Positions over time along a way, from rest to rest.

    Args:
        way: Way points in order, dense, such as ``joint_path`` gives them: radians or metres, (n, k). Where it turns
            right back, the motion stops and starts anew.
        velocity: Highest speed of each joint, rad/s or m/s, (k,).
        acceleration: Highest acceleration of each joint, rad/s² or m/s², (k,).
        rate_hz: Positions per second.

    Returns:
        Times (m,) in seconds from 0 on, all ``1 / rate_hz`` apart, and positions (m, k): the first and the last are
        those of the way, and none leaves it by more than a third of the steps between its way points. Speeds and
        accelerations between any of them are within the limits.

    Raises:
        InputError: Arrays that do not fit together, limits that are nothing, or toppra is not installed.
    """
    way, velocity, acceleration = _checked(way, velocity, acceleration, rate_hz)
    parts = [_timed(part, velocity, acceleration, rate_hz) for part in _without_turning_back(way)]
    positions = np.concatenate([parts[0], *(part[1:] for part in parts[1:])])
    return np.arange(len(positions)) / rate_hz, positions


def _checked(
    way: ArrayLike, velocity: ArrayLike, acceleration: ArrayLike, rate_hz: float
) -> tuple[Array, Array, Array]:
    way = np.array(way, dtype=float)
    if way.ndim != 2 or not len(way) or not np.isfinite(way).all():
        raise InputError("a way has finite way points (n, k)", field="way", value=way.shape)
    velocity, acceleration = np.asarray(velocity, dtype=float), np.asarray(acceleration, dtype=float)
    for field, limit in (("velocity", velocity), ("acceleration", acceleration)):
        if limit.shape != way.shape[1:] or not (np.isfinite(limit) & (limit > 0)).all():
            raise InputError("a limit is a number above zero for each joint", field=field, value=limit.tolist())
    if not rate_hz > 0:
        raise InputError("a rate is above zero", field="rate_hz", value=rate_hz)
    kept = [0]
    for index in range(1, len(way)):
        if np.abs(way[index] - way[kept[-1]]).max() > NOTHING:
            kept.append(index)
    return np.concatenate((way[kept[:-1]], way[-1:])) if len(kept) > 1 else way[:1], velocity, acceleration


def _without_turning_back(way: Array) -> list[Array]:
    """A way cut where it turns right back."""
    steps = np.diff(way, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    cosines = (steps[1:] * steps[:-1]).sum(axis=1) / (lengths[1:] * lengths[:-1])
    cuts = [0, *(np.flatnonzero(cosines < TURNS_BACK) + 1).tolist(), len(way) - 1]
    return [way[first : last + 1] for first, last in itertools.pairwise(cuts)]


def _timed(way: Array, velocity: Array, acceleration: Array, rate_hz: float) -> Array:
    """Positions (m, k) of one stretch, from rest to rest."""
    if len(way) == 1:
        return way
    path = _Spline(_graded(way))
    grid = path.grid()
    toppra, constraint = door("toppra", EXTRA), door("toppra.constraint", EXTRA)

    class Accelerations(constraint.LinearConstraint):  # type: ignore[misc, name-defined]  # toppra has no types
        """Acceleration within limits at both ends of every interval; toppra's own takes kinks for the next piece's."""

        def __init__(self) -> None:
            super().__init__()
            self.dof, self.identical = path.dof, True
            self._format_string = ""

        def compute_constraint_params(self, _path: object, _grid: Array) -> tuple[Array | None, ...]:
            return _acceleration_rows(path, grid, acceleration)

    limits = [constraint.JointVelocityConstraint(np.stack((-velocity, velocity), axis=1)), Accelerations()]
    algorithm = toppra.algorithm.TOPPRA(limits, path, gridpoints=grid, solver_wrapper="seidel")
    _, speeds, _ = algorithm.compute_parameterization(0.0, 0.0)
    if speeds is None or not np.isfinite(speeds).all():
        raise InputError("toppra finds no timing", field="way", value=way.shape, hint="give it smaller steps")
    return _sampled(path, grid, np.asarray(speeds), velocity, acceleration, rate_hz)


def _acceleration_rows(path: _Spline, grid: Array, acceleration: Array) -> tuple[Array | None, ...]:
    """What toppra calls a canonical linear constraint: a u + b x + c within limits, for each interval of the grid.

    u is the acceleration along the path, x the square of the speed at the interval's begin; at its end, the latter is
    x + 2 u times the interval's length.
    """
    lengths, piece = np.diff(grid), path.pieces_of(grid)
    begin, end = (path.on_piece(places, piece, 1) for places in (grid[:-1], grid[1:]))
    bend = path.on_piece(grid[:-1], piece, 2)
    a = np.concatenate((begin, end + 2 * lengths[:, None] * bend), axis=1)
    b = np.concatenate((bend, bend), axis=1)
    a, b = (np.concatenate((rows, rows[-1:])) for rows in (a, b))  # no interval begins at the last point of the grid
    one = np.eye(a.shape[1])
    within = np.concatenate((acceleration,) * 4)
    return a, b, np.zeros_like(a), np.concatenate((one, -one)), within, None, None


def _graded(way: Array) -> Array:
    """The same way with way points added, so that no step is much longer than the one before or after it.

    Next to a long step a tiny one would be a place where the path all but stands still, and toppra fails.
    """
    while True:
        lengths = np.linalg.norm(np.diff(way, axis=0), axis=1)
        around = np.concatenate(([np.inf], lengths, [np.inf]))
        long = np.flatnonzero(lengths > RATIO * (1 + ROUNDING) * np.minimum(around[2:], around[:-2]))
        if not len(long):
            return way
        way = np.insert(way, long + 1, (way[long] + way[long + 1]) / 2, axis=0)


class _Spline:
    """The quadratic B-spline of way points that begins and ends at the first and the last one, as toppra asks a path.

    Piece i is a parabola about way point i. It takes as long as half the steps before and after it, so that the path
    goes at an even pace; where it meets the next one, the step between them is divided as their lengths are.
    """

    def __init__(self, way: Array) -> None:
        # Ends are reached when what is next to them is mirrored beyond them: half of the first and last piece counts.
        points = np.concatenate(([2 * way[0] - way[1]], way, [2 * way[-1] - way[-2]]))
        steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        lengths = (steps[1:] + steps[:-1]) / 2
        around = np.concatenate((lengths[1:2], lengths, lengths[-2:-1]))
        shares = (around[:-1] / (around[:-1] + around[1:]))[:, None]
        joints = points[:-1] + shares * np.diff(points, axis=0)
        starts, ends = joints[:-1], joints[1:]
        self._starts = starts
        self._slopes = 2 * (way - starts) / lengths[:, None]
        self._bends = 2 * (ends - 2 * way + starts) / lengths[:, None] ** 2
        self._begins = np.concatenate(([0.0], np.cumsum(lengths)[:-1])) - lengths[0] / 2
        self.end = float(self._begins[-1] + lengths[-1] / 2)
        self.dof = way.shape[1]
        self.path_interval = np.array([0.0, self.end])
        self.waypoints = None

    def __call__(self, places: ArrayLike, order: int = 0) -> Array:
        """Positions, or their derivatives by the place, at places from 0 to the end, (k,) or (n, k)."""
        places = np.asarray(places, dtype=float)
        piece = np.clip(np.searchsorted(self._begins, places, side="right") - 1, 0, len(self._begins) - 1)
        return self.on_piece(places, piece, order)

    def grid(self) -> Array:
        """Places where pieces begin and in the middle of each, from 0 to the end: no interval lies on two pieces."""
        knots = np.concatenate(([0.0], self._begins[1:], [self.end]))
        return np.sort(np.concatenate((knots, (knots[1:] + knots[:-1]) / 2)))

    def pieces_of(self, grid: Array) -> Indices:
        """On which piece each interval of the grid (n,) lies, (n − 1,)."""
        return np.asarray(np.searchsorted(self._begins, (grid[1:] + grid[:-1]) / 2) - 1)

    def on_piece(self, places: Array, piece: Indices, order: int) -> Array:
        """Positions or derivatives on given pieces: at a place between two, on either of them."""
        along = (places - self._begins[piece])[..., None]
        slopes, bends = self._slopes[piece], self._bends[piece]
        if order == 0:
            return np.asarray(self._starts[piece] + along * slopes + along**2 * bends / 2)
        return np.asarray(slopes + along * bends if order == 1 else bends + 0 * along)


def _sampled(path: _Spline, grid: Array, speeds: Array, velocity: Array, acceleration: Array, rate_hz: float) -> Array:
    """Positions at a rate, of a motion whose speed along the path is known on a grid; its square is linear between."""
    lengths = np.diff(grid)
    durations = 2 * lengths / np.maximum(speeds[1:] + speeds[:-1], ROUNDING)
    gains = (speeds[1:] ** 2 - speeds[:-1] ** 2) / (2 * lengths)
    slow = _excess(path, grid, speeds**2, gains, velocity, acceleration)
    begins = np.concatenate(([0.0], np.cumsum(durations)))
    count = max(1, math.ceil(begins[-1] * slow * rate_hz - ROUNDING))
    times = np.linspace(0.0, begins[-1], count + 1)
    at = np.clip(np.searchsorted(begins, times, side="right") - 1, 0, len(lengths) - 1)
    since = times - begins[at]
    places = np.clip(grid[at] + since * speeds[at] + since**2 * gains[at] / 2, 0.0, path.end)
    return path(places)


def _excess(path: _Spline, grid: Array, squares: Array, gains: Array, velocity: Array, acceleration: Array) -> float:
    """The factor, at least 1, by which a motion must be slower to keep all limits everywhere.

    In an interval of the grid the square of the speed along the path, and all accelerations, are linear. Joints are
    fastest at its ends or where their acceleration is nothing. Slower by a factor divides speeds by it, and
    accelerations by its square.
    """
    piece = path.pieces_of(grid)
    begin, end = (path.on_piece(places, piece, 1) for places in (grid[:-1], grid[1:]))
    bend, gain = path.on_piece(grid[:-1], piece, 2), gains[:, None]
    first, last = begin * gain + bend * squares[:-1, None], end * gain + bend * squares[1:, None]
    turns = first * last < 0.0
    shares = np.where(turns, first / np.where(turns, first - last, 1.0), 0.0)
    slow = math.sqrt(max(1.0, *(float(np.abs(each / acceleration).max()) for each in (first, last))))
    for share in (0.0, shares, 1.0):
        square = squares[:-1, None] + share * (squares[1:] - squares[:-1])[:, None]
        slow = max(slow, float(np.abs((begin + share * (end - begin)) * np.sqrt(square) / velocity).max()))
    return slow
