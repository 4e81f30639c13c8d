"""Sweeps: whether a robot is free all along a way, and not only at places of it.

Who checks a way step by step knows nothing of what lies between the steps, and looks at a hundred steps amid a room in
which there is nothing. A gap tells more: two shapes that are 20 cm apart stay apart until one has moved by 20 cm
("conservative advancement" [Mirtich 1996]). So each look at a configuration says how far around it all is free::

    sweep = Sweep(body, qpos, JointMoves(positions), ends=(start, goal))
    sweep.look(middle, half)             # -1: something is hit; 0.4: free within 0.4 × half of the middle; 1: all of it
    line_is_free(sweep.look, start, goal)

How far a shape moves is bounded by levers: no point of it moves by more than the sum, over the joints that carry it, of
their turns times how far it is from their axes, and may get from there by what turns beyond them.

**Clearance.** Ways keep clear of everything by ``CLEARANCE_M``, for nothing is as exact as a plan. Where a way begins
or ends nearer to something than that, as a hand at a table, it need not be farther from it than it is there. Between
two looks a gap may shrink by a part of its clearance, and never below what audits of motions let pass.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Protocol

import mujoco
import numpy as np

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.common.compiled import compiled
from taskgist.perspective.effort import Blocking
from taskgist.planning.whole_body import TOLERANCE_M, Grip, WholeBody
from taskgist.world.geometry.distances import RADIUS, least_gap_m, may_be_near
from taskgist.world.geometry.transforms import turned_about_z, yaw_of
from taskgist.world.stage import Stage
from taskgist.world.state import State

CLEARANCE_M = 0.008
"""How far ways keep from everything, where they do not begin or end nearer to it (ours)."""
SHRINKS = 0.6
"""By which share of its clearance a gap may be less between two looks."""
LEAST_M = 0.0018
"""How deep two shapes may be in each other between two looks, beyond what is usual: less than audits let pass."""
NOISE_M = 2e-4
"""What a gap that is measured again may be less."""
FARTHEST_M = 0.25
"""How far a look looks, at most: shapes farther apart than that are many, and cost time."""
NOTICED_M = 0.05
"""By how much what is out of reach is farther than that (ours: ways may begin a little outside of their ranges)."""
NOWHERE = -1.0

Look = Callable[[Array, Array], float]
"""Of a configuration (k,) and how far around it (k,), by each joint: the share of that within which all is free; less
than nothing if the configuration itself is not."""


class Moves(Protocol):
    """What moves along a way: some joints, or the base."""

    def placed(self, qpos: Array, values: Array) -> Array:
        """Positions of the whole scene, (nq,), with values (k,) of what moves."""

    def joints(self, body: WholeBody) -> Indices:
        """The model's joints that move, from the root to the hand, (k,); none if levers are the same everywhere."""

    def levers(self, body: WholeBody, qpos: Array, geoms: Indices, load: Indices, carrier: int) -> tuple[Array, Mask]:
        """How far each shape goes at most for a unit of each value, wherever it is, (n, k), and what moves it, (n, k).

        Args:
            body: The robot.
            qpos: A configuration.
            geoms: The shapes, the load's among them.
            load: Those of what it holds.
            carrier: The body that carries the load.
        """


@dataclass(frozen=True, eq=False)
class BaseMoves:
    """A base over its floor: x and y in metres, yaw in radians.

    Attributes:
        base: Where the base is in qpos.
    """

    base: slice

    def placed(self, qpos: Array, values: Array) -> Array:
        """As ``Moves`` says."""
        moved = np.array(qpos)
        whole = moved[self.base]
        whole[:2] = values[:2]
        whole[3:] = turned_about_z(whole[3:], values[2] - yaw_of(whole[3:]))
        return moved

    def joints(self, body: WholeBody) -> Indices:
        """As ``Moves`` says."""
        del body
        return np.empty(0, dtype=np.intp)

    def levers(self, body: WholeBody, qpos: Array, geoms: Indices, load: Indices, carrier: int) -> tuple[Array, Mask]:
        """As ``Moves`` says."""
        del load, carrier
        table = body.stage.boxes(geoms)
        away_m = np.linalg.norm(table[:, :2] - qpos[self.base][:2], axis=1) + table[:, RADIUS]
        return np.stack((np.ones(len(geoms)), np.ones(len(geoms)), away_m), axis=1), np.ones(
            (len(geoms), 3), dtype=bool
        )


@dataclass(frozen=True, eq=False)
class JointMoves:
    """Joints of an arm and what carries it.

    Attributes:
        positions: Where they are in qpos, from the root to the hand, (k,).
    """

    positions: Indices

    def placed(self, qpos: Array, values: Array) -> Array:
        """As ``Moves`` says."""
        moved = np.array(qpos)
        moved[self.positions] = values
        return moved

    def joints(self, body: WholeBody) -> Indices:
        """As ``Moves`` says."""
        of_position = body.scene.model.jnt_qposadr
        return np.array([np.flatnonzero(of_position == position)[0] for position in self.positions], dtype=np.intp)

    def levers(self, body: WholeBody, qpos: Array, geoms: Indices, load: Indices, carrier: int) -> tuple[Array, Mask]:
        """As ``Moves`` says."""
        del qpos
        model, table, joints = body.scene.model, body.stage.boxes(geoms), self.joints(body)
        anchors = body.stage.screws(joints)[0]
        slides = model.jnt_type[joints] == int(mujoco.mjtJoint.mjJNT_SLIDE)
        spans_m = np.where(slides, np.ptp(model.jnt_range[joints], axis=1), 0.0)
        levers, moved = np.zeros((len(geoms), len(joints))), np.zeros((len(geoms), len(joints)), dtype=bool)
        for row, geom in enumerate(geoms.tolist()):
            above = _bodies_above(model, carrier if geom in load else int(model.geom_bodyid[geom]))
            own = [column for column, joint in enumerate(joints.tolist()) if int(model.jnt_bodyid[joint]) in above]
            far_m, point = float(table[row, RADIUS]), table[row, :3]
            for column in reversed(own):
                far_m += float(np.linalg.norm(anchors[column] - point))
                levers[row, column], moved[row, column] = (1.0 if slides[column] else far_m), True
                far_m, point = far_m + spans_m[column], anchors[column]
        return levers, moved


def _bodies_above(model: mujoco.MjModel, body: int) -> set[int]:
    """A body, and all that carry it."""
    found = {body}
    while body:
        body = int(model.body_parentid[body])
        found.add(body)
    return found


class Sweep:
    """A robot that moves some of itself, and what it holds, along a way; all else stands still.

    Args:
        body: The robot's collisions.
        qpos: Positions of the whole scene, (nq,); what moves counts as well, for how what it holds is carried.
        moves: What moves.
        grip: What it holds.
        ends: Where the way begins and ends, (k,) each.
        clearance_m: How far to keep from everything.

    Attributes:
        blocked: What the last configuration that was not free ran into.
        looks: How many configurations were looked at.
    """

    def __init__(
        self,
        body: WholeBody,
        qpos: Array,
        moves: Moves,
        grip: Grip | None = None,
        *,
        ends: Sequence[Array] = (),
        clearance_m: float = CLEARANCE_M,
    ) -> None:
        self._body, self._qpos, self._moves = body, np.array(qpos), moves
        self.blocked: Blocking | None = None
        self.looks = 0
        self._load = np.empty(0, dtype=np.intp) if grip is None else body.geoms_of(grip.thing)
        stage = body.show(qpos, grip)
        self._held = None if grip is None else _Held.of(stage, body, grip, self._load)
        own = np.concatenate((body.own, self._load))
        carrier = 0 if self._held is None else int(body.scene.model.site_bodyid[self._held.palm])
        levers, moved = moves.levers(body, self._qpos, own, self._load, carrier)
        active = moved.any(axis=1)
        self._geoms, pairs, self._usual_m = body.pairs(own[active], grip)
        rows = {int(geom): row for row, geom in enumerate(self._geoms)}
        self._farthest = np.zeros((len(self._geoms), levers.shape[1]))
        self._moved = np.zeros(self._farthest.shape, dtype=bool)
        for geom, lever, moves_it in zip(own.tolist(), levers, moved, strict=True):
            if geom in rows:
                self._farthest[rows[geom]], self._moved[rows[geom]] = lever, moves_it
        one, other = pairs.T
        # What a joint moves together stays as far apart as it is.
        between = self._farthest[one] * ~self._moved[other] + self._farthest[other] * ~self._moved[one]
        self._joints = moves.joints(body)
        self._slides = body.scene.model.jnt_type[self._joints] == int(mujoco.mjtJoint.mjJNT_SLIDE)
        self._table = stage.boxes(self._geoms)
        counts = between.any(axis=1) & self._within_reach(stage, pairs, clearance_m)
        self._pairs, self._levers, self._usual_m = pairs[counts], between[counts], self._usual_m[counts]
        self._shapes: list[list[int]] = self._geoms[self._pairs].tolist()
        self._moving = np.flatnonzero(self._moved.any(axis=1))
        self._groups = self._grouped(own)
        self._least_m = -self._usual_m - TOLERANCE_M
        self._needs_m, self._floors_m = self._least_m, -self._usual_m - LEAST_M
        # The gap of each pair as it was measured last, and where: it changes by no more than shapes move from there.
        self._known = np.full(len(self._pairs), -np.inf), np.zeros(self._levers.shape)
        self._close_to(ends, clearance_m)

    def look(self, values: Array, half: Array) -> float:
        """How far around a configuration all is free, as ``Look`` says."""
        return self._look(values, half, self._needs_m, self._floors_m)

    def look_closely(self, values: Array, half: Array) -> float:
        """The same without any clearance: for what is near a way that was found, as the timed motion along it."""
        return self._look(values, half, self._least_m, -self._usual_m - LEAST_M)

    def is_free(self, values: Array) -> bool:
        """Whether a configuration is free, clearance and all."""
        return self.look(values, np.zeros(len(values))) >= 0.0

    def _look(self, values: Array, half: Array, needs_m: Array, floors_m: Array) -> float:
        self.looks += 1
        stage = self._show(values)
        self._table[self._moving] = stage.boxes(self._geoms[self._moving])
        travel_m = self._travel(stage, np.abs(half))
        longest_m = float(travel_m.max(initial=0.0))
        share = 1.0 if longest_m <= FARTHEST_M else FARTHEST_M / longest_m
        known_m, known_at = self._known
        rows, shares = _suspects(
            self._table, self._pairs, needs_m, floors_m, travel_m, share, self._levers, values, known_m, known_at
        )
        for row, within in zip(rows.tolist(), shares.tolist(), strict=True):
            if within >= share:
                break  # those that follow are no nearer
            geom, other = self._shapes[row]
            need_m, floor_m, way_m = float(needs_m[row]), float(floors_m[row]), float(travel_m[row])
            limit_m = max(need_m, floor_m + share * way_m)
            gap_m = stage.gap(geom, other, limit_m=limit_m)
            known_m[row], known_at[row] = gap_m, values
            if gap_m < need_m:
                self.blocked = self._body.met(geom, other, -gap_m)
                return NOWHERE
            if gap_m < limit_m and way_m > 0.0:
                share = min(share, (gap_m - floor_m) / way_m)
        return share

    def _within_reach(self, stage: Stage, pairs: Indices, clearance_m: float) -> Mask:
        """Which pairs may meet at all, (k,): what an arm carries stays around the first joint that turns."""
        turning = np.flatnonzero(~self._slides)
        if not len(turning):
            return np.ones(len(pairs), dtype=bool)
        first, (one, other) = int(turning[0]), pairs.T
        anchor = stage.screws(self._joints[[first]])[0][0]
        ranges = self._body.scene.model.jnt_range[self._joints[:first]]
        reach_m = self._farthest[one, first] + float(np.ptp(ranges, axis=1).sum()) + clearance_m + NOTICED_M
        away_m = np.linalg.norm(self._table[other, :3] - anchor, axis=1) - self._table[other, RADIUS]
        return np.asarray(~self._moved[one, first] | self._moved[other].any(axis=1) | (away_m < reach_m))

    def _travel(self, stage: Stage, half: Array) -> Array:
        """How far the shapes of each pair may move against each other, (k,), around the configuration that is shown."""
        if not len(self._joints) or not half.any():
            return np.asarray(self._levers @ half)
        anchors, axes = stage.screws(self._joints)
        return np.asarray(
            _travel(self._table, self._pairs, self._farthest, self._moved, self._slides, anchors, axes, half)
        )

    def _show(self, values: Array) -> Stage:
        body = self._body
        stage = body.stage.show(State(self._moves.placed(self._qpos, values), untracked=body.start.untracked))
        if self._held is not None:
            self._held.place(stage)
        return stage

    def _grouped(self, own: Indices) -> Indices:
        """Numbers of groups of pairs, (k,): all links beside one thing or piece of furniture, or the load beside it.

        Each pair of the robot's own shapes is a group of its own.
        """
        owners = np.unique(np.array(self._body.scene.owners), return_inverse=True)[1]
        one, other = self._geoms[self._pairs].T
        numbers = owners[other] * 2 + np.isin(one, self._load)
        within = np.isin(other, own)
        numbers[within] = 2 * len(owners) + np.flatnonzero(within)
        return np.unique(numbers, return_inverse=True)[1].astype(np.intp)

    def _close_to(self, ends: Iterable[Array], clearance_m: float) -> None:
        """Find what is nearer to an end of the way than ways keep, and need be no farther from it along the way."""
        nearest_m = np.full(int(self._groups.max(initial=-1)) + 1, clearance_m)
        limits_m = np.full(len(self._pairs), clearance_m)
        for values in ends:
            stage = self._show(values)
            self._table[self._moving] = stage.boxes(self._geoms[self._moving])
            for row in _near_rows(self._table, self._pairs, limits_m).tolist():
                one, other = self._pairs[row].tolist()
                gap_m = stage.gap(int(self._geoms[one]), int(self._geoms[other]), limit_m=clearance_m)
                # What usually overlaps is looked at pair by pair: it says nothing of what is beside it.
                nearest_m[self._groups[row]] = min(nearest_m[self._groups[row]], gap_m + self._usual_m[row] - NOISE_M)
        self._needs_m = np.maximum(nearest_m[self._groups] - self._usual_m, self._least_m)
        shrunk_m = self._needs_m - SHRINKS * clearance_m
        self._floors_m = np.maximum(shrunk_m, -self._usual_m - LEAST_M)


@dataclass(frozen=True, eq=False)
class _Held:
    """The shapes of what is held, in the palm's frame.

    Attributes:
        palm: The palm's site.
        geoms: The shapes, (n,).
        positions: Where they are, metres, (n, 3).
        matrices: How they are turned, (n, 3, 3).
    """

    palm: int
    geoms: Indices
    positions: Array
    matrices: Array

    @classmethod
    def of(cls, stage: Stage, body: WholeBody, grip: Grip, geoms: Indices) -> _Held:
        palm = int(body.agent.arm(grip.side).palm_site)
        pose, (positions, matrices) = stage.site(palm), stage.geoms(geoms)
        turned = pose.matrix.T @ matrices.reshape(-1, 3, 3)
        return cls(palm, geoms, pose.to_local(positions), turned)

    def place(self, stage: Stage) -> None:
        """Put them where the hand is."""
        pose = stage.site(self.palm)
        stage.place(self.geoms, pose.to_world(self.positions), (pose.matrix @ self.matrices).reshape(-1, 9))


@compiled
def _near_rows(table: Array, pairs: Indices, limits_m: Array) -> Indices:
    """Which pairs of boxes, by rows of a table (n, 18), may come nearer than their limits, (k,)."""
    found, count = np.empty(len(pairs), dtype=np.intp), 0
    for row in range(len(pairs)):
        if may_be_near(table, pairs[row, 0], table, pairs[row, 1], limits_m[row]):
            found[count] = row
            count += 1
    return found[:count]


@compiled
def _travel(
    table: Array,
    pairs: Indices,
    farthest: Array,
    moved: Mask,
    slides: Mask,
    anchors: Array,
    axes: Array,
    half: Array,
) -> Array:
    """How far the shapes of each pair may move against each other while joints move by up to so much, metres, (k,).

    Args:
        table: Boxes of all shapes, (n, 18).
        pairs: Rows of these, (k, 2).
        farthest: The levers of shapes, wherever they are, (n, joints).
        moved: Which joints move them, (n, joints).
        slides: Which joints slide, (joints,).
        anchors: Points on the joints' axes, metres, (joints, 3).
        axes: Unit vectors along them, (joints, 3).
        half: By how much each joint may move either way, (joints,).
    """
    count = len(half)
    ways, total = np.zeros((len(table), count)), np.zeros(len(table))
    for row in range(len(table)):
        beyond_m = 0.0  # how far what is beyond a joint may bring the shape
        for joint in range(count - 1, -1, -1):
            if not moved[row, joint]:
                continue
            lever_m = 1.0
            if not slides[joint]:
                x, y, z = (
                    table[row, 0] - anchors[joint, 0],
                    table[row, 1] - anchors[joint, 1],
                    table[row, 2] - anchors[joint, 2],
                )
                along = x * axes[joint, 0] + y * axes[joint, 1] + z * axes[joint, 2]
                away_m = math.sqrt(max(x * x + y * y + z * z - along * along, 0.0))
                lever_m = min(farthest[row, joint], away_m + table[row, RADIUS] + beyond_m)
            ways[row, joint] = half[joint] * lever_m
            beyond_m += half[joint] * lever_m
        total[row] = beyond_m
    found = np.zeros(len(pairs))
    for index in range(len(pairs)):
        one, other = pairs[index]
        found[index] = total[one] + total[other]
        if total[one] > 0.0 and total[other] > 0.0:
            for joint in range(count):
                # What a joint moves together stays as far apart as it is.
                if moved[one, joint] and moved[other, joint]:
                    found[index] -= ways[one, joint] + ways[other, joint]
    return found


@compiled
def _suspects(
    table: Array,
    pairs: Indices,
    needs_m: Array,
    floors_m: Array,
    travel_m: Array,
    share: float,
    levers: Array,
    values: Array,
    known_m: Array,
    known_at: Array,
) -> tuple[Indices, Array]:
    """Pairs that may not be free within a share of a way, by rows, (n,), and within which share they surely are, (n,).

    What is known of each is how far its boxes are apart, and its gap as it was measured elsewhere. Those that may be
    hit where the robot is come first, with shares below nothing; then those with the least shares.

    Args:
        table: Boxes of all shapes, (s, 18).
        pairs: Rows of these, (k, 2).
        needs_m: What each gap must be, metres, (k,).
        floors_m: What it must be nowhere around, (k,).
        travel_m: By how much it may change around, metres, (k,).
        share: Of that.
        levers: By how much it changes at most for a unit of each value, wherever that is, (k, v).
        values: The configuration, (v,).
        known_m: Gaps as they were measured last, metres, (k,),
        known_at: and at which configurations, (k, v).
    """
    found, shares, count = np.empty(len(pairs), dtype=np.intp), np.empty(len(pairs)), 0
    for row in range(len(pairs)):
        enough_m = max(needs_m[row], floors_m[row] + share * travel_m[row])
        least_m = known_m[row]
        if least_m > -math.inf:
            for column in range(len(values)):
                least_m -= levers[row, column] * abs(values[column] - known_at[row, column])
        if least_m < enough_m:
            least_m = max(least_m, least_gap_m(table, pairs[row, 0], table, pairs[row, 1], enough_m))
        if least_m < enough_m:
            off_m = least_m - needs_m[row]
            found[count], shares[count] = row, off_m if off_m < 0.0 else (least_m - floors_m[row]) / travel_m[row]
            count += 1
    order = np.argsort(shares[:count], kind="mergesort")
    return found[order], shares[order]


# --- Lines, and what follows points.


def line_is_free(look: Look, start: Array, end: Array) -> bool:
    """Whether a straight line is free, both ends included; the middle of what is not known yet comes first."""
    waiting, along = deque([(0.0, 1.0)]), end - start
    while waiting:
        low, high = waiting.popleft()
        middle, half = (low + high) / 2, (high - low) / 2
        share = look(start + along * middle, np.abs(along) * half)
        if share < 0.0:
            return False
        if share < 1.0:
            waiting += [(low, middle - share * half), (middle + share * half, high)]
    return True


def points_are_free(look: Look, points: Array) -> bool:
    """Whether all is free that moves evenly from each point (n, k) to the next."""
    waiting = deque([(0, len(points) - 1)])
    while waiting:
        first, last = waiting.popleft()
        if last - first <= 1:
            if not line_is_free(look, points[first], points[last]):
                return False
            continue
        middle = (first + last) // 2
        half = np.abs(points[first : last + 1] - points[middle]).max(axis=0)
        share = look(points[middle], half)
        if share < 0.0:
            return False
        if share < 1.0:
            waiting += [(first, middle), (middle, last)]
    return True
