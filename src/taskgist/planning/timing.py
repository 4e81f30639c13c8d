"""Timing: when a way is where, as fast as speeds and accelerations allow, from rest to rest.

A way is checked along straight lines between its way points, and nothing says that anything beside them is free. So
the timed motion must not leave them by more than the checks' own steps do: it follows the quadratic B-spline of the
way points. That runs exactly on straight stretches, turns each corner on a parabola between the middles of the two
steps that meet there, and so leaves the way by at most a quarter of a step in each joint, without having to stop.
(A spline *through* way points swings out between them by as much as it likes.)

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
GRID = 2
"""Intervals of toppra's grid between two way points: even, so that none lies across a kink of the path."""
SHARES = np.linspace(0.0, 1.0, 9)
"""Where, between two points of the grid, limits are held up to the motion that was found."""
TURNS_BACK = -0.99
"""Cosine of the angle from which a corner is a turning back: there a motion comes to rest."""
ROUNDING = 1e-9


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
        those of the way, and none leaves it by more than a quarter of the steps between its way points. Speeds and
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
    moved = np.abs(np.diff(way, axis=0)).max(axis=1, initial=0.0) > ROUNDING
    return way[np.concatenate(([True], moved))], velocity, acceleration


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
    path = _Spline(way)
    grid = np.linspace(0.0, path.end, GRID * (path.pieces - 1) + 1)
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


class _Spline:
    """A uniform quadratic B-spline of way points that begins and ends at the first and the last one.

    Piece i is a parabola from the middle of the steps before and after way point i; half a step comes before the first
    piece and after the last. It is what toppra asks of a path.
    """

    def __init__(self, way: Array) -> None:
        # Ends are reached when the first and the last step are mirrored beyond them.
        self._points = np.concatenate(([2 * way[0] - way[1]], way, [2 * way[-1] - way[-2]]))
        self.pieces = len(way)
        self.end = float(self.pieces - 1)
        self.dof = way.shape[1]
        self.path_interval = np.array([0.0, self.end])
        self.waypoints = None

    def __call__(self, places: ArrayLike, order: int = 0) -> Array:
        """Positions, or their derivatives by the place, at places from 0 to the end, (k,) or (n, k)."""
        places = np.asarray(places, dtype=float)
        piece = np.clip(np.floor(places + 0.5).astype(np.intp), 0, self.pieces - 1)
        return self.on_piece(places, piece, order)

    def pieces_of(self, grid: Array) -> Indices:
        """On which piece each interval of a grid (n,) lies, (n − 1,); none lies on two."""
        return np.floor((grid[1:] + grid[:-1]) / 2 + 0.5).astype(np.intp)

    def on_piece(self, places: Array, piece: Indices, order: int) -> Array:
        """The same on given pieces: at a place between two, either of them."""
        before, at, after = (self._points[piece + shift] for shift in range(3))
        t = (places - piece)[..., None]  # from −1/2 to 1/2
        if order == 0:
            return np.asarray(at + t * (after - before) / 2 + (0.125 + t * t / 2) * (after - 2 * at + before))
        if order == 1:
            return np.asarray((after - before) / 2 + t * (after - 2 * at + before))
        return np.asarray(after - 2 * at + before + 0 * t)


def _sampled(path: _Spline, grid: Array, speeds: Array, velocity: Array, acceleration: Array, rate_hz: float) -> Array:
    """Positions at a rate, of a motion whose speed along the path is known on a grid; its square is linear between."""
    lengths = np.diff(grid)
    durations = 2 * lengths / np.maximum(speeds[1:] + speeds[:-1], ROUNDING)
    gains = (speeds[1:] ** 2 - speeds[:-1] ** 2) / (2 * lengths)
    piece, slow = path.pieces_of(grid), 1.0
    # Slower by a factor divides speeds by it, and accelerations, which are linear in between, by its square.
    for share in SHARES:
        places = grid[:-1] + share * lengths
        speed = np.sqrt(speeds[:-1] ** 2 + 2 * gains * share * lengths)
        first, second = (path.on_piece(places, piece, order) for order in (1, 2))
        changes = first * gains[:, None] + second * speed[:, None] ** 2
        slow = max(slow, float(np.abs(first * speed[:, None] / velocity).max()))
        slow = max(slow, math.sqrt(np.abs(changes / acceleration).max()))
    begins = np.concatenate(([0.0], np.cumsum(durations)))
    count = max(1, math.ceil(begins[-1] * slow * rate_hz - ROUNDING))
    times = np.linspace(0.0, begins[-1], count + 1)
    at = np.clip(np.searchsorted(begins, times, side="right") - 1, 0, len(lengths) - 1)
    since = times - begins[at]
    places = np.clip(grid[at] + since * speeds[at] + since**2 * gains[at] / 2, 0.0, path.end)
    return path(places)
