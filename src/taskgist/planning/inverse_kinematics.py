"""Inverse kinematics of one arm: configurations of its joints, and of the lift that carries it, for a pose of the palm.

The arm is taken out of the scene as numbers: the joints between the robot's root and the palm. Joints that are no
variables (a torso that leans, a shoulder girdle) stay where the state has them; they are part of the links.

Steps of damped least squares start where the arm is, and from configurations that the arm's capability map keeps for
the cells around the place, which nearly point the hand the right way already. The map also says at once that a place is
out of reach. Nothing is drawn at random but the last starts, by a seed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import islice

import mujoco
import numpy as np
from numpy.typing import NDArray

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.common.compiled import compiled
from taskgist.planning.damped_least_squares import descend, levers_m, nearest_kept, palm_at
from taskgist.world.bodies.agent import Agent, ArmIndices
from taskgist.world.bodies.arm_chain import ALONG, GIRDLE_M, LOW, SLIDES, SPAN, STEPS, put, put_frames, within_limits
from taskgist.world.bodies.capability import DIRECTIONS, CapabilityMap, pointing
from taskgist.world.geometry.transforms import Pose, normalized
from taskgist.world.stage import Stage

NEAR_M, NEAR_RAD = 0.002, math.radians(1.0)
"""How near the palm comes to the pose that is asked for."""
SHARPER = 8
"""Steps end so many times nearer than that: Newton steps are so near one step later, and lines stay straight."""
TURN_RAD = 2 * math.pi
"""A joint without end is put at most one turn off its zero."""
POINTING_COS = math.cos(math.radians(60.0))
"""A configuration from which the hand would have to be turned farther is no start: the map has nearer ones, if any."""
LIFT_STEPS = 4
"""Heights of a lift at which the capability map is asked."""
LIFT_WEIGHT = 5.0
"""How many radians of an arm's joint a metre of a lift counts like: lifts are slow (ours)."""
LEVER_SAMPLES, HAND_M = 300, 0.1
"""Configurations in which levers are looked at; how far from the palm hands, and most things in them, get (ours)."""
SAME_RAD = 0.05
"""Configurations that differ by less in every joint are one."""
JUMP_RAD = 0.3
"""Largest change of a joint from one pose of a line to the next; what changes more has gone over to another branch."""


@dataclass(frozen=True, eq=False)
class Chain:
    """The joints that move a palm, from the root to the hand: lifts carry arms, and come first.

    Attributes:
        names: Without the agent's prefix.
        positions: Their indices into qpos, (n,).
        low: Least values, radians or metres, (n,); one turn back for joints without end.
        high: Greatest values, (n,).
        lifts: Which are lifts, (n,).
        endless: Which turn without end, (n,).
    """

    names: tuple[str, ...]
    positions: Indices
    low: Array
    high: Array
    lifts: Mask
    endless: Mask

    def __len__(self) -> int:
        return len(self.names)

    @cached_property
    def weights(self) -> Array:
        """How much a change of each counts, (n,)."""
        return np.where(self.lifts, LIFT_WEIGHT, 1.0)

    @property
    def rolls_freely(self) -> bool:
        """Whether the last joint takes any angle."""
        return bool(self.high[-1] - self.low[-1] >= 2 * math.pi)

    def nearest_turn(self, values: Array, now: Array) -> Array:
        """The same configuration with endless joints turned as little as can be from where they are now."""
        turned = np.where(self.endless, now + np.remainder(values - now + math.pi, TURN_RAD) - math.pi, values)
        return np.asarray(np.where((turned < self.low) | (turned > self.high), values, turned))


def chain_of_arm(stage: Stage, agent: Agent, arm: ArmIndices) -> Chain:
    """The joints that move an arm's palm: its own, but those that move its shoulder, and the lifts that carry it."""
    model = stage.scene.model
    shoulder = stage.site(arm.shoulder_site).position
    arms, lifts = [], []
    root = int(model.body(f"{agent.name}/{arm.profile.root}").id)
    for body in _bodies_to(model, int(model.site_bodyid[arm.palm_site]), agent.root_body):
        for joint in range(model.body_jntadr[body], model.body_jntadr[body] + model.body_jntnum[body]):
            if _named(model, joint) in agent.lifts:
                lifts.append(joint)
            elif _carries(model, root, body) and not _moves_shoulder(stage, joint, arm, shoulder):
                arms.append(joint)
    joints = np.array([*lifts, *arms], dtype=np.intp)
    limited = model.jnt_limited[joints].astype(bool)
    return Chain(
        names=tuple(_named(model, int(joint)) for joint in joints),
        positions=model.jnt_qposadr[joints].astype(np.intp),
        low=np.where(limited, model.jnt_range[joints, 0], -TURN_RAD),
        high=np.where(limited, model.jnt_range[joints, 1], TURN_RAD),
        lifts=np.arange(len(joints)) < len(lifts),
        endless=~limited,
    )


class ArmKinematics:
    """Brings the palm of one arm to poses.

    Args:
        stage: The scene in the state whose other joints the arm's links are made of; it is not borrowed later.
        agent: Whose arm.
        arm: Which.
        chain: Its joints.
    """

    def __init__(self, stage: Stage, agent: Agent, arm: ArmIndices, chain: Chain) -> None:
        self._arm, self.chain = arm, chain
        self._zero = np.array(stage.scene.model.qpos0[chain.positions])
        with stage.showing(stage.state.replace(dict(zip(chain.positions.tolist(), self._zero, strict=True)))):
            root, palm = stage.body(agent.root_body), stage.site(arm.palm_site)
            self._joints = _rows(stage, agent, chain, root, self._zero)
            self._as_in_map = self._joints.copy()
            self._as_in_map[~chain.lifts, LOW:] = arm.chain.joints[:, LOW:]  # the spans of which it counts steps
            self._palm = _row(Pose(root.to_local(palm.position), root.matrix.T @ palm.matrix))
            carrier, shoulder = stage.body(arm.carrier_body).matrix, stage.site(arm.shoulder_site).position
            self._shoulder = Pose(root.to_local(shoulder), root.matrix.T @ carrier)
            self._ahead = ahead_in_palm(stage, arm)

    @cached_property
    def levers_m(self) -> Array:
        """How far a unit of each joint moves a point of the hand, at most, metres, (n,): its own, for lifts."""
        drawn = np.random.default_rng(0).random((LEVER_SAMPLES, len(self.chain)))
        at_palm = levers_m(self._joints, self._palm, self._joints[:, LOW] + self._joints[:, SPAN] * drawn)
        return np.asarray(np.where(self._joints[:, SLIDES] == 1.0, at_palm, at_palm + HAND_M))

    def palm(self, values: Array) -> Pose:
        """Where a configuration, (n,), brings the palm, in the frame of the robot's root."""
        found = palm_at(self._joints, self._palm, values - self._zero)
        return Pose(found[:3], found[3:].reshape(3, 3))

    def solve(
        self, target: Pose, now: Array, *, lift: bool = True, starts: int = 2, most: int = 3, seed: int = 0
    ) -> list[Array]:
        """Configurations that bring the palm to a pose within 2 mm and 1°, the nearest to the present one first.

        Args:
            target: The palm, in the frame of the robot's root.
            now: The present configuration, (n,).
            lift: Whether lifts may move.
            starts: From how many configurations of the capability map to start, and half as many at random.
            most: Enough of them.
            seed: Of what is drawn.
        """
        found = islice(self.solutions(target, now, lift=lift, starts=starts, seed=seed), most)
        return sorted(found, key=lambda values: float(np.abs(values - now) @ self.chain.weights))

    def solutions(
        self, target: Pose, now: Array, *, lift: bool = True, starts: int = 2, seed: int = 0
    ) -> Iterator[Array]:
        """The same as they are found, that from the present configuration first; arguments as above."""
        from_map = self._starts(target, now, lift=lift, count=starts)
        if not len(from_map):
            return
        found: list[Array] = []
        for start in (now, *from_map, *self._random(now, lift, starts // 2, seed)):
            values = self._descend(target, start, lift=lift)
            if values is None:
                continue
            values = self.chain.nearest_turn(values, now)
            if all(np.abs(values - known).max() > SAME_RAD for known in found):
                found.append(values)
                yield values

    def follow(self, targets: Sequence[Pose], start: Array, *, lift: bool = False) -> Array | None:
        """Configurations, (n, k), for one pose after the other, from one for a pose near to the first; None if stuck.

        Args:
            targets: Palms, in the frame of the robot's root.
            start: Where to start from, (k,).
            lift: Whether lifts may move.
        """
        found = [start]
        for target in targets:
            values = self._descend(target, found[-1], lift=lift)
            if values is None or np.abs(values - found[-1]).max() > JUMP_RAD:
                return None
            found.append(values)
        return np.array(found[1:])

    def _descend(self, target: Pose, start: Array, *, lift: bool) -> Array | None:
        """The configuration at which steps from a start arrive; None if they do not."""
        values, moving = np.clip(start, self.chain.low, self.chain.high) - self._zero, lift | ~self.chain.lifts
        near_m, near_rad = NEAR_M / SHARPER, NEAR_RAD / SHARPER
        if not descend(self._joints, self._palm, _row(target), values, moving, near_m, near_rad):
            return None
        values = np.clip(values + self._zero, self.chain.low, self.chain.high)
        return values if self._is_taken(values) else None

    def _is_taken(self, values: Array) -> bool:
        """Whether ball-and-socket joints take a configuration."""
        limits = self._arm.chain.limits
        if not len(limits):
            return True
        joints = self._arm.chain.joints
        share = (values[~self.chain.lifts] - self._zero[~self.chain.lifts] - joints[:, LOW]) / joints[:, SPAN]
        return _taken(joints, np.round(np.clip(share, 0.0, 1.0) * STEPS).astype(np.uint16), limits)

    def _starts(self, target: Pose, now: Array, *, lift: bool, count: int) -> Array:
        """Configurations of the capability map that bring the palm nearest to a pose, (n, k), at most so many."""
        lifts = self._heights(now, lift)
        axes = self._joints[self.chain.lifts, ALONG : ALONG + 3]
        places = (target.position - (self._shoulder.position + lifts @ axes)) @ self._shoulder.matrix
        found = self._arm.reach.map
        kept = nearest_kept(
            self._as_in_map,
            self._palm,
            _row(target),
            self._ahead,
            POINTING_COS,
            lifts,
            np.abs(lifts - lifts[0]).sum(axis=1),
            self._cells(places),
            found.starts,
            found.configurations,
            count,
        )
        return np.asarray(self._zero + kept)

    def _heights(self, now: Array, lift: bool) -> Array:
        """Values of the lifts from their zeros, (h, l): as they are, and evenly spread."""
        of_lift = self.chain.lifts
        as_now = np.asarray((now - self._zero)[of_lift])[None]
        if not lift or not of_lift.any():
            return as_now
        low, high = (self.chain.low - self._zero)[of_lift], (self.chain.high - self._zero)[of_lift]
        return np.concatenate((as_now, np.linspace(low, high, LIFT_STEPS)))

    def _cells(self, places: Array) -> Indices:
        """Cells of the capability map, (h,), for places from the shoulder, in the carrier's frame; −1 outside of it."""
        reach = self._arm.reach
        found, side = reach.map, (1.0, -1.0 if reach.mirrored else 1.0, 1.0)
        cells = np.floor((places / reach.scale * side - found.corner) / found.cell_m).astype(np.intp)
        inside = np.all((cells >= 0) & (cells < found.shape), axis=1)
        index = np.ravel_multi_index(tuple(np.where(inside[:, None], cells, 0).T), found.shape)
        return np.asarray(np.where(inside, index, -1))

    def _random(self, now: Array, lift: bool, count: int, seed: int) -> Iterator[Array]:
        rng = np.random.default_rng(seed)
        for _ in range(count):
            drawn = rng.uniform(self.chain.low, self.chain.high)
            yield drawn if lift else np.where(self.chain.lifts, now, drawn)


def ahead_in_palm(stage: Stage, arm: ArmIndices) -> Array:
    """Which way the hand points, from where it begins to the palm, in the palm's frame, a unit vector (3,)."""
    palm = stage.site(arm.palm_site)
    return normalized(-palm.to_local(stage.body_position(arm.hand_body)))


def _rows(stage: Stage, agent: Agent, chain: Chain, root: Pose, zero: Array) -> Array:
    """A chain's joints, (n, 9), as ``damped_least_squares`` has them, of an arm that is shown at its zero."""
    model, rows = stage.scene.model, []
    for name, low, high in zip(chain.names, chain.low - zero, chain.high - zero, strict=True):
        joint = int(model.joint(f"{agent.name}/{name}").id)
        anchor, axis = stage.screw(joint)
        slides = model.jnt_type[joint] == int(mujoco.mjtJoint.mjJNT_SLIDE)
        rows.append((*root.to_local(anchor), *(axis @ root.matrix), float(slides), low, high - low))
    return np.array(rows)


def _row(pose: Pose) -> Array:
    return np.concatenate((pose.position, pose.matrix.reshape(9)))


# --- Where a hand may be, and which way it may point there, by the capability map.


class Pointing:
    """Which way an arm's hand may point, at each place from its shoulder [Zacharias 2007].

    Args:
        arm: The arm.
    """

    def __init__(self, arm: ArmIndices) -> None:
        self._reach = arm.reach
        self._known = _directions(self._reach.map)

    def able(self, shoulder: Array, places: Array, directions: Array, lifts: Sequence[float] = (0.0,)) -> Mask:
        """Whether a palm may be at places while it points in directions, (n,).

        Args:
            shoulder: Its position in metres and the frame that carries it, a row of 12.
            places: Of the palm, metres, (n, 3).
            directions: From where the hand begins to the palm, unit vectors, (n, 3).
            lifts: How far the shoulder may be lifted from there, metres.
        """
        found, side = self._reach.map, (1.0, -1.0 if self._reach.mirrored else 1.0, 1.0)
        turn = shoulder[3:].reshape(3, 3) * side
        up = np.array([(0.0, 0.0, up_m) for up_m in lifts])
        shoulders = (shoulder[:3] + up) @ turn / self._reach.scale
        at, ahead = places @ turn / self._reach.scale, directions @ turn
        return _able(shoulders, at, ahead, self._known, found.corner, found.cell_m, np.array(found.shape))


@compiled
def _able(shoulders: Array, at: Array, ahead: Array, known: Mask, corner: Array, cell_m: float, shape: Indices) -> Mask:
    """Whether places (n, 3) and directions (n, 3) are known from any of some shoulders (l, 3), all in a map's axes."""
    able = np.zeros(len(at), dtype=np.bool_)
    for row in range(len(at)):
        bearing = pointing(ahead[row, 0], ahead[row, 1], ahead[row, 2])
        for lift in range(len(shoulders)):
            index, inside = 0, True
            for axis in range(3):
                cell = math.floor((at[row, axis] - shoulders[lift, axis] - corner[axis]) / cell_m)
                inside = inside and 0 <= cell < shape[axis]
                index = index * shape[axis] + cell
            if inside and known[index, bearing]:
                able[row] = True
                break
    return able


@lru_cache(maxsize=8)
def _directions(found: CapabilityMap) -> Mask:
    """Whether the map has a configuration in a cell with the hand pointing along each of 27 directions, (cells, 27)."""
    chain = found.chain
    return _pointed(chain.joints, chain.palm, chain.wrist, found.configurations, found.starts)


@compiled
def _pointed(joints: Array, palm: Array, wrist: Array, configurations: NDArray[np.uint16], starts: Indices) -> Mask:
    frames = np.empty((len(joints) + 1, 12))
    known = np.zeros((len(starts) - 1, DIRECTIONS), dtype=np.bool_)
    for cell in range(len(starts) - 1):
        for row in range(starts[cell], starts[cell + 1]):
            put_frames(joints, configurations[row], frames)
            x, y, z = put(frames[len(joints)], palm[0], palm[1], palm[2])
            wx, wy, wz = put(frames[len(joints)], wrist[0], wrist[1], wrist[2])
            known[cell, pointing(x - wx, y - wy, z - wz)] = True
    return known


@compiled
def _taken(joints: Array, steps: NDArray[np.uint16], limits: Array) -> bool:
    """Whether ball-and-socket joints take a configuration of an arm."""
    frames = np.empty((len(joints) + 1, 12))
    put_frames(joints, steps, frames)
    return within_limits(frames, limits)


# --- Bodies and joints.


def _bodies_to(model: mujoco.MjModel, body: int, root: int) -> list[int]:
    """Bodies that a root carries on the way to another one, in this order; without the root."""
    found: list[int] = []
    while body not in (root, 0):
        found.append(body)
        body = int(model.body_parentid[body])
    return found[::-1]


def _carries(model: mujoco.MjModel, root: int, body: int) -> bool:
    while body not in (root, 0):
        body = int(model.body_parentid[body])
    return body == root


def _named(model: mujoco.MjModel, joint: int) -> str:
    return str(model.joint(joint).name).partition("/")[2]


def _moves_shoulder(stage: Stage, joint: int, arm: ArmIndices, shoulder: Array) -> bool:
    """Whether a joint carries the shoulder and its axis passes it."""
    model = stage.scene.model
    if not _carries(model, int(model.jnt_bodyid[joint]), int(model.site_bodyid[arm.shoulder_site])):
        return False
    anchor, axis = stage.screw(joint)
    return float(np.linalg.norm(np.cross(shoulder - anchor, axis))) > GIRDLE_M
