"""Paths: how joints, or a base that moves any way, get from one configuration to another without collisions.

RRT-Connect [Kuffner & LaValle 2000], as OMPL has it (extra ``planning``), finds some way; shortcuts make it a short
one; and before a way is given back, all of it is checked once more. OMPL's own idea of resolution is not used: search,
shortcuts and last check ask of a straight line the same thing in the same manner. Robots' ways are asked by looks
(``sweeps``): of a configuration it is told how far around it all is free, and the line is walked by that, so that
nothing between two looks is missed, however small::

    way = joint_path(start, goals, ranges, sweep.is_free, step=0.02, seed=0, look=sweep.look)  # (n, k), or None

Where only single configurations can be asked, lines are walked in steps, in which no joint moves by more than its
``step``; what fits between two of them is missed.

The same question has the same answer, however busy the machine: what is limited is the number of checks, and never
the time. Joints are measured in their own steps, so that metres and radians, shoulders and wrists weigh alike.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from taskgist.common.arrays import Array
from taskgist.common.extras import door
from taskgist.errors import InputError
from taskgist.planning.sweeps import NOWHERE, Look, line_is_free

EXTRA = "planning"
CHECKS = 20_000
"""Configurations that a search may ask about, unless told otherwise: some seconds of a whole robot's collisions."""
SHORTCUTS, IN_VAIN = 40, 10
"""Shortcuts that are tried, and how many in a row may fail before that ends."""
WORTH, STRAIGHT = 0.02, 1.1
"""The least share of a way that a shortcut saves; and how much longer than the straight line a way is short enough."""
RANGE = 30.0
"""Longest line that the search adds at once, in steps."""
FULL_TURN_RAD = 2.0 * math.pi
ROUNDING = 1e-9

Free = Callable[[Array], bool]


def joint_path(
    start: ArrayLike,
    goals: ArrayLike,
    ranges: ArrayLike,
    free: Free,
    *,
    step: ArrayLike,
    seed: int,
    checks: int = CHECKS,
    look: Look | None = None,
) -> Array | None:
    """A free way from one configuration to any of some others.

    Joints without limits (infinite ranges) may turn either way round, by less than two turns from where they start;
    they keep counting, so that nothing jumps from +180° to −180°, and a goal counts wherever it is the same angle.

    Args:
        start: Where it begins, radians or metres, (k,). It may lie a little outside its ranges.
        goals: Where it may end, (g, k); those outside the ranges or not free are left aside.
        ranges: Lowest and highest position of each joint, (k, 2).
        free: Whether a configuration (k,) is free of collisions; asked only of configurations within the ranges, and
            with ``look`` only of ends, of the search's samples and of where shortcuts begin.
        step: Largest change of each joint between two way points, (k,) or one for all; the unit in which joints are
            measured; without ``look`` also between two checks.
        seed: Seed of the search; the same question with the same seed has the same answer.
        checks: Configurations of which the search may ask ``free`` or ``look``; shortcuts may ask as many again.
        look: How far around a configuration all is free, as ``Sweep.look`` says it; None: only ``free`` is known.

    Returns:
        Way points (n, k): the first is the start, the last a goal, consecutive ones differ by at most ``step`` in each
        joint. With ``look`` all between them is free, without it they are. A straight line where one is free. None: no
        way was found within the checks.

    Raises:
        InputError: Arrays that do not fit together, or OMPL is not installed.
    """
    start, goals, ranges, step = _checked(start, goals, ranges, step)
    low, high = _window(start, ranges)
    lines = _Lines(free, step, checks, look)
    if not lines.is_free(start):
        return None
    ends = [goal for goal in _ends(start, goals, ranges, low, high, step) if lines.is_free(goal)]
    for end in ends:
        if lines.are_free(start, end):
            return lines.points(np.stack((start, end)))
    corners = _searched(lines, start, ends, low, high, seed) if ends else None
    if corners is None:
        return None
    lines.left = checks
    corners = _shortened(lines, corners, np.random.default_rng(seed))
    if look is not None:
        sure = all(line_is_free(look, one, other) for one, other in itertools.pairwise(corners))
        return lines.points(corners) if sure else None
    way = lines.points(corners)
    return way if all(free(point) for point in way) else None


def base_path(
    start: ArrayLike,
    goal: ArrayLike,
    ranges: ArrayLike,
    free: Free,
    *,
    step_m: float,
    step_rad: float,
    seed: int,
    checks: int = CHECKS,
    look: Look | None = None,
) -> Array | None:
    """A free way of a base that moves and turns any way it likes (holonomic), on a level floor.

    Args:
        start: x and y in metres and yaw in radians, (3,).
        goal: The same where it ends, (3,).
        ranges: Lowest and highest x, y and yaw, (3, 2); infinite for yaw where it may turn all round.
        free: Whether a place (3,) is free of collisions.
        step_m: Largest change of x, and of y, between two way points; see ``joint_path``.
        step_rad: Largest change of yaw between two way points.
        seed: As in ``joint_path``.
        checks: As in ``joint_path``.
        look: As in ``joint_path``.

    Returns:
        Way points (n, 3), as ``joint_path`` gives them; None: no way was found within the checks.

    Raises:
        InputError: Arrays that do not fit together, places without bounds, or OMPL is not installed.
    """
    if not np.isfinite(np.asarray(ranges, dtype=float)[:2]).all():
        raise InputError("a base is searched for within bounds", field="ranges", hint="give x and y finite ones")
    goals = np.asarray(goal, dtype=float)[None]
    return joint_path(start, goals, ranges, free, step=(step_m, step_m, step_rad), seed=seed, checks=checks, look=look)


def _checked(start: ArrayLike, goals: ArrayLike, ranges: ArrayLike, step: ArrayLike) -> tuple[Array, ...]:
    start, goals = np.array(start, dtype=float), np.array(goals, dtype=float)
    ranges = np.array(ranges, dtype=float)
    fits = start.ndim == 1 and goals.ndim == 2 and goals.shape[1:] == start.shape and ranges.shape == (len(start), 2)
    if not fits:
        shapes = f"{start.shape}, {goals.shape}, {ranges.shape}"
        raise InputError("start, goals and ranges are of one robot", value=shapes, hint="give (k,), (g, k) and (k, 2)")
    if not (np.isfinite(start).all() and np.isfinite(goals).all() and (ranges[:, 0] <= ranges[:, 1]).all()):
        raise InputError("start and goals are finite, and ranges begin below their end", field="ranges")
    step = np.broadcast_to(np.asarray(step, dtype=float), start.shape)
    if not (np.isfinite(step) & (step > 0)).all():
        raise InputError("a step is more than nothing", field="step", value=step.tolist())
    return start, goals, ranges, step


def _window(start: Array, ranges: Array) -> tuple[Array, Array]:
    """Lowest and highest positions that are searched: the ranges, and a turn either way where there are none."""
    low = np.where(np.isfinite(ranges[:, 0]), ranges[:, 0], start - FULL_TURN_RAD)
    high = np.where(np.isfinite(ranges[:, 1]), ranges[:, 1], start + FULL_TURN_RAD)
    return np.minimum(low, start), np.maximum(high, start)


def _ends(start: Array, goals: Array, ranges: Array, low: Array, high: Array, step: Array) -> list[Array]:
    """All configurations that count as a goal, the one with the fewest steps on the straight line to it first.

    What turns without end reaches a goal one way round, and the other.
    """
    endless = np.flatnonzero(~np.isfinite(ranges).any(axis=1))
    ends = goals.copy()
    for joint in endless:
        turns = np.round((ends[:, joint] - start[joint]) / FULL_TURN_RAD)
        ends[:, joint] -= turns * FULL_TURN_RAD
        other = ends.copy()
        other[:, joint] -= np.where(ends[:, joint] >= start[joint], FULL_TURN_RAD, -FULL_TURN_RAD)
        ends = np.concatenate((ends, other))
    ends = ends[((ends >= low - ROUNDING) & (ends <= high + ROUNDING)).all(axis=1)]
    order = np.argsort(np.abs((ends - start) / step).max(axis=1), kind="stable")
    return list(np.clip(ends[order], low, high))


# --- Straight lines: the one way in which anything is checked here.


class _Lines:
    """Checks straight lines, step by step or look by look, as long as there are checks left."""

    def __init__(self, free: Free, step: Array, checks: int, look: Look | None = None) -> None:
        self._free, self.step, self.left, self._looks = free, step, checks, look

    def is_free(self, configuration: Array) -> bool:
        """Whether a configuration is free; what cannot be checked any more is not."""
        if self.left <= 0:
            return False
        self.left -= 1
        return bool(self._free(configuration))

    def are_free(self, start: Array, end: Array) -> bool:
        """Whether a line is free, its end included; its start was checked before."""
        if self._looks is not None:
            return line_is_free(self._look, start, end)
        count = self.count(start, end)
        return all(self.is_free(start + (end - start) * (place / count)) for place in _middles_first(count))

    def _look(self, configuration: Array, half: Array) -> float:
        """As it is asked; what cannot be looked at any more is not free."""
        if self.left <= 0:
            return NOWHERE
        self.left -= 1
        assert self._looks is not None
        return self._looks(configuration, half)

    def count(self, start: Array, end: Array) -> int:
        """Steps of a line."""
        return max(1, math.ceil(float(np.abs((end - start) / self.step).max()) - ROUNDING))

    def points(self, corners: Array) -> Array:
        """All steps of the lines between corners (m, k), (n, k)."""
        parts = [corners[:1]]
        for start, end in itertools.pairwise(corners):
            count = self.count(start, end)
            shares = np.arange(1, count + 1)[:, None] / count
            parts.append(np.where(shares < 1.0, start + (end - start) * shares, end))
        return np.concatenate(parts)


@lru_cache(maxsize=1024)
def _middles_first(count: int) -> tuple[int, ...]:
    """The numbers from 1 to a count, each halving the widest gap: what blocks a line is mostly amid it."""
    found, gaps = [count], [(0, count)]
    for low, high in gaps:  # it grows meanwhile
        middle = (low + high) // 2
        if low < middle < high:
            found.append(middle)
            gaps += [(low, middle), (middle, high)]
    return tuple(found)


# --- The search, by OMPL, in units of steps.


def _searched(lines: _Lines, start: Array, ends: list[Array], low: Array, high: Array, seed: int) -> Array | None:
    """Corners (m, k) of a free way from the start to one of its ends; None: there was none within the checks."""
    base, geometric = door("ompl.base", EXTRA), door("ompl.geometric", EXTRA)
    step = lines.step
    with _quiet(seed):
        space = base.RealVectorStateSpace(len(start))
        bounds = base.RealVectorBounds(len(start))
        for joint in range(len(start)):
            bounds.setLow(joint, float(low[joint] / step[joint]))
            bounds.setHigh(joint, float(max(high[joint] / step[joint], low[joint] / step[joint] + ROUNDING)))
        space.setBounds(bounds)
        information = base.SpaceInformation(space)

        def position(state: Any) -> Array:
            return np.array(state[0 : len(step)]) * step

        def state(configuration: Array) -> Any:
            made = space.allocState()
            made[0 : len(step)] = (configuration / step).tolist()
            return made

        class Motions(base.MotionValidator):  # type: ignore[misc, name-defined]  # OMPL has no types
            def checkMotion(self, first: Any, second: Any) -> bool:
                return lines.are_free(position(first), position(second))

        # OMPL holds only what it needs of these; Python must keep them until the search has ended.
        motions, spent = Motions(information), base.PlannerTerminationCondition(lambda: lines.left <= 0)
        information.setStateValidityChecker(lambda checked: lines.is_free(position(checked)))
        information.setMotionValidator(motions)
        information.setup()
        problem, goal = base.ProblemDefinition(information), base.GoalStates(information)
        # Searched backwards: OMPL plants a tree at every start, but at another goal only when those before have grown,
        # which they never do where one of them is shut in.
        for end in ends:
            problem.addStartState(state(end))
        goal.addState(state(start))
        problem.setGoal(goal)
        planner = geometric.RRTConnect(information)
        planner.setRange(RANGE)
        planner.setProblemDefinition(problem)
        planner.setup()
        planner.solve(spent)
        if not problem.hasExactSolution():
            return None
        found = problem.getSolutionPath()
        corners = np.array([position(found.getState(index)) for index in reversed(range(found.getStateCount()))])
    corners[0], corners[-1] = start, min(ends, key=lambda end: float(np.abs((end - corners[-1]) / step).max()))
    return corners


@contextmanager
def _quiet(seed: int) -> Iterator[None]:
    """Seeds OMPL, which then complains of being seeded again, and keeps it from the console for a while."""
    util = door("ompl.util", EXTRA)
    before = util.getLogLevel()
    util.setLogLevel(util.LogLevel.LOG_NONE)
    try:
        util.RNG.setSeed(1 + seed % (2**31 - 1))  # zero would be no seed
        yield
    finally:
        util.setLogLevel(before)


def _shortened(lines: _Lines, corners: Array, random: np.random.Generator) -> Array:
    """The corners after shortcuts, where the lines between are free.

    They lead from each corner to the farthest that it gets to, and then between any two places of the way, at random.
    """
    corners, failed = _skipped(lines, corners), 0
    straight = float(np.linalg.norm((corners[-1] - corners[0]) / lines.step))
    for _ in range(SHORTCUTS):
        lengths = np.linalg.norm(np.diff(corners, axis=0) / lines.step, axis=1)
        ends = np.cumsum(lengths)
        if len(corners) == 2 or failed == IN_VAIN or lines.left <= 0 or ends[-1] <= STRAIGHT * straight:
            break
        one, other = np.sort(random.uniform(0.0, ends[-1], size=2))
        first, last = (min(int(edge), len(lengths) - 1) for edge in np.searchsorted(ends, (one, other)))
        if first == last:
            continue
        start, end = (
            corners[edge + 1] - (corners[edge + 1] - corners[edge]) * ((ends[edge] - place) / lengths[edge])
            for edge, place in ((first, one), (last, other))
        )
        worth = other - one - float(np.linalg.norm((end - start) / lines.step)) >= WORTH * ends[-1]
        # Its start lies on the way, but maybe between two steps of it.
        if worth and lines.is_free(start) and lines.are_free(start, end):
            joined = np.concatenate((corners[: first + 1], [start, end], corners[last + 1 :]))
            # The pieces that are left of the two lines are walked in other steps than the lines were.
            if lines.are_free(joined[first], start) and lines.are_free(end, corners[last + 1]):
                corners, failed = joined, 0
                continue
        failed += 1
    return corners


def _skipped(lines: _Lines, corners: Array) -> Array:
    """The corners but those that a free line from one before to one after passes over."""
    kept = [0]
    while kept[-1] < len(corners) - 1:
        last = kept[-1]
        ahead = range(len(corners) - 1, last + 1, -1)
        kept.append(next((each for each in ahead if lines.are_free(corners[last], corners[each])), last + 1))
    return corners[kept]
