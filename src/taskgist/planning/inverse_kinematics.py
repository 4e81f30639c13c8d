"""Inverse kinematics of one arm: configurations of its joints, and of the lift that carries it, for a pose of the palm.

The arm is taken out of the scene: a small model holds the joints between the robot's root and the palm and nothing
else, so that a step of mink's costs a tenth of what it costs in the whole room. Joints that are no variables (a torso
that leans, a shoulder girdle) stay where the state has them; they are part of the links.

Steps of differential inverse kinematics start where the arm is, and from configurations that the arm's capability map
keeps for the cells around the place, which nearly point the hand the right way already. The map also says at once that
a place is out of reach. Nothing is drawn at random but the last starts, by a seed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import islice

import mink
import mujoco
import numpy as np
from numpy.typing import NDArray

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.common.compiled import compiled
from taskgist.world.bodies.agent import Agent, ArmIndices
from taskgist.world.bodies.arm_chain import GIRDLE_M, LOW, SPAN, STEPS, put, put_frames, within_limits
from taskgist.world.bodies.capability import DIRECTIONS, SPREAD, CapabilityMap, pointing
from taskgist.world.geometry.transforms import Pose, normalized, wxyz_from_matrix
from taskgist.world.stage import Stage

NEAR_M, NEAR_RAD = 0.002, math.radians(1.0)
"""How near the palm comes to the pose that is asked for."""
SHARPER = 8
"""Steps end so many times nearer than that: Newton steps are so near one step later, and lines stay straight."""
SOLVER_STEPS, STALLED = 40, 0.6
"""Steps from one start, and the share of the error that must be left after five of them to call it stuck."""
DAMPING, LEVER_M = 1e-4, 0.15
"""Damping of a step; and the lever with which an error of direction (radians) counts like one of place (metres)."""
TURN_RAD = 2 * math.pi
"""A joint without end is put at most one turn off its zero."""
POINTING_COS = math.cos(math.radians(60.0))
"""A configuration from which the hand would have to be turned farther is no start: the map has nearer ones, if any."""
LIFT_STEPS = 4
"""Heights of a lift at which the capability map is asked."""
LIFT_WEIGHT = 5.0
"""How many radians of an arm's joint a metre of a lift counts like: lifts are slow (ours)."""
SAME_RAD = 0.05
"""Configurations that differ by less in every joint are one."""
JUMP_RAD = 0.3
"""Largest change of a joint from one pose of a line to the next; what changes more has gone over to another branch."""
RIGID_KG = 1.0


@dataclass(frozen=True, eq=False)
class Chain:
    """The joints that move a palm, lifts first.

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
        root = stage.body(agent.root_body)
        with stage.showing(stage.state.replace(dict(zip(chain.positions.tolist(), _zero(stage, chain), strict=True)))):
            self._model, order = _arm_model(stage, agent, arm, chain)
            carrier, shoulder = stage.body(arm.carrier_body).matrix, stage.site(arm.shoulder_site).position
            self._shoulder = Pose(root.to_local(shoulder), root.matrix.T @ carrier)
            joints = [stage.scene.model.joint(f"{agent.name}/{name}").id for name, on in _lifts(chain) if on]
            self._up = np.array([stage.screw(int(joint))[1] @ root.matrix for joint in joints]).reshape(-1, 3)
            self._ahead = ahead_in_palm(stage, arm)
        self._zero = _zero(stage, chain)
        self._order = order
        self._configuration = mink.Configuration(self._model)
        self._task = mink.FrameTask("palm", "site", position_cost=1.0, orientation_cost=LEVER_M, lm_damping=0.0)
        self._limits = [mink.ConfigurationLimit(self._model)]
        lifting = [int(self._model.jnt_dofadr[joint]) for joint, column in enumerate(order) if chain.lifts[column]]
        self._lift_fixed = [mink.DofFreezingTask(self._model, lifting)] if lifting else []

    def palm(self, values: Array) -> Pose:
        """Where a configuration, (n,), brings the palm, in the frame of the robot's root."""
        data = self._configuration.data
        data.qpos[:] = values[self._order]
        mujoco.mj_kinematics(self._model, data)
        return Pose(data.site_xpos[0].copy(), data.site_xmat[0].reshape(3, 3).copy())

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
        if not from_map:
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
        configuration, task = self._configuration, self._task
        wxyz_xyz = np.concatenate((wxyz_from_matrix(target.matrix), target.position))
        task.set_target(mink.SE3(wxyz_xyz))
        configuration.update(start[self._order])
        fixed = [] if lift else self._lift_fixed
        errors: list[float] = []
        for _ in range(SOLVER_STEPS):
            off = task.compute_error(configuration)
            place_m, turn_rad = float(np.linalg.norm(off[:3])), float(np.linalg.norm(off[3:]))
            if place_m < NEAR_M / SHARPER and turn_rad < NEAR_RAD / SHARPER:
                return self._values()
            errors.append(place_m + LEVER_M * turn_rad)
            if len(errors) > 5 and errors[-1] > STALLED * errors[-6]:
                return None
            velocity = mink.solve_ik(
                configuration, [task], 1.0, "daqp", DAMPING, limits=self._limits, constraints=fixed
            )
            velocity *= min(1.0, 0.6 / max(float(np.abs(velocity).max()), 1e-9))
            configuration.integrate_inplace(velocity, 1.0)
        return None

    def _values(self) -> Array | None:
        """The present configuration in the order of the chain; None where a ball-and-socket joint does not take it."""
        values = np.empty(len(self.chain))
        values[self._order] = self._configuration.q
        values = np.clip(values, self.chain.low, self.chain.high)
        limits = self._arm.chain.limits
        if len(limits):
            joints = self._arm.chain.joints
            share = (values[~self.chain.lifts] - self._zero[~self.chain.lifts] - joints[:, LOW]) / joints[:, SPAN]
            steps = np.round(np.clip(share, 0.0, 1.0) * STEPS).astype(np.uint16)
            if not _taken(joints, steps, limits):
                return None
        return values

    def _starts(self, target: Pose, now: Array, *, lift: bool, count: int) -> list[Array]:
        """Configurations of the capability map that bring the palm nearest to a pose."""
        ranked: list[tuple[float, int, Array]] = []
        for lifts in self._heights(now, lift):
            shoulder = Pose(self._shoulder.position + lifts @ self._up, self._shoulder.matrix)
            for arm_values in self._near(shoulder.to_local(target.position)):
                values = np.concatenate((lifts + self._zero[self.chain.lifts], arm_values))
                palm = self.palm(values)
                if float(palm.matrix @ self._ahead @ (target.matrix @ self._ahead)) < POINTING_COS:
                    continue
                cosine = (np.trace(palm.matrix.T @ target.matrix) - 1) / 2
                off = float(np.linalg.norm(palm.position - target.position))
                off += LEVER_M * math.acos(float(np.clip(cosine, -1.0, 1.0)))
                off += 0.1 * float(np.abs(values - now)[self.chain.lifts].sum())
                ranked.append((off, len(ranked), values))
        return [values for _, _, values in sorted(ranked)[:count]]

    def _heights(self, now: Array, lift: bool) -> Iterator[Array]:
        """Ways of the lifts above their zeros: as they are, and evenly spread."""
        of_lift = self.chain.lifts
        yield (now - self._zero)[of_lift]
        if lift and of_lift.any():
            for share in np.linspace(0.0, 1.0, LIFT_STEPS):
                yield (self.chain.low + share * (self.chain.high - self.chain.low) - self._zero)[of_lift]

    def _near(self, place: Array) -> Array:
        """Configurations kept for the cell of a place from the shoulder, in the carrier's frame, (n, arm's joints)."""
        reach = self._arm.reach
        found = reach.map
        at = place / reach.scale * ((1.0, -1.0, 1.0) if reach.mirrored else (1.0, 1.0, 1.0))
        cell = np.floor((at - found.corner) / found.cell_m).astype(int)
        if (cell < 0).any() or (cell >= found.shape).any():
            return np.empty((0, int((~self.chain.lifts).sum())))
        index = int(np.ravel_multi_index(tuple(cell), found.shape))
        rows = found.configurations[found.starts[index] : found.starts[index + 1]]
        joints = self._arm.chain.joints
        return np.asarray(self._zero[~self.chain.lifts] + joints[:, LOW] + joints[:, SPAN] * rows / STEPS)

    def _random(self, now: Array, lift: bool, count: int, seed: int) -> Iterator[Array]:
        rng = np.random.default_rng(seed)
        for _ in range(count):
            drawn = rng.uniform(self.chain.low, self.chain.high)
            yield drawn if lift else np.where(self.chain.lifts, now, drawn)


def ahead_in_palm(stage: Stage, arm: ArmIndices) -> Array:
    """Which way the hand points, from where it begins to the palm, in the palm's frame, a unit vector (3,)."""
    palm = stage.site(arm.palm_site)
    return normalized(-palm.to_local(stage.body_position(arm.hand_body)))


def _lifts(chain: Chain) -> list[tuple[str, bool]]:
    return list(zip(chain.names, chain.lifts.tolist(), strict=True))


def _zero(stage: Stage, chain: Chain) -> Array:
    """The values at which the model's bodies stand as it places them."""
    return np.array(stage.scene.model.qpos0[chain.positions])


# --- Where a hand may be, and which way it may point there, by the capability map.


class Pointing:
    """Which way an arm's hand may point, at each place from its shoulder [Zacharias 2007].

    Args:
        arm: The arm.
    """

    def __init__(self, arm: ArmIndices) -> None:
        self._reach = arm.reach
        self._known = _directions(self._reach.map)

    def able(self, shoulder: Array, places: Array, directions: Array) -> Mask:
        """Whether a palm may be at places while it points in directions, (n,).

        Args:
            shoulder: Its position in metres and the frame that carries it, a row of 12.
            places: Of the palm, metres, (n, 3).
            directions: From where the hand begins to the palm, unit vectors, (n, 3).
        """
        found, side = self._reach.map, (1.0, -1.0 if self._reach.mirrored else 1.0, 1.0)
        turn = shoulder[3:].reshape(3, 3) * side
        at = (places - shoulder[:3]) @ turn / self._reach.scale
        cells = np.floor((at - found.corner) / found.cell_m).astype(np.intp)
        inside = ((cells >= 0) & (cells < found.shape)).all(axis=1)
        ahead = directions @ turn
        signs = np.sign(ahead) * (np.abs(ahead) >= SPREAD)
        bins = ((signs + 1) @ (9, 3, 1)).astype(np.intp)
        able = np.zeros(len(places), dtype=bool)
        index = np.ravel_multi_index(tuple(cells[inside].T), found.shape)
        able[inside] = self._known[index, bins[inside]]
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


# --- The arm as a model of its own.


def _arm_model(stage: Stage, agent: Agent, arm: ArmIndices, chain: Chain) -> tuple[mujoco.MjModel, Indices]:
    """A model of the bodies that the chain moves; and which of the chain's joints each of its positions is, (n,).

    Args:
        stage: The scene with the chain at its zero.
        agent: Whose arm.
        arm: Which.
        chain: Its joints.
    """
    model = stage.scene.model
    columns = {int(position): column for column, position in enumerate(chain.positions)}
    spec, order = mujoco.MjSpec(), []
    spec.compiler.degree = False
    parent, frame = spec.worldbody, stage.body(agent.root_body)
    for body in _bodies_to(model, int(model.site_bodyid[arm.palm_site]), agent.root_body):
        joints = range(model.body_jntadr[body], model.body_jntadr[body] + model.body_jntnum[body])
        own = [joint for joint in joints if int(model.jnt_qposadr[joint]) in columns]
        if not own:
            continue
        pose = stage.body(body)
        parent, frame = parent.add_body(**_placed(frame, pose)), pose
        parent.mass, parent.inertia, parent.explicitinertial = RIGID_KG, [RIGID_KG] * 3, True
        for joint in own:
            column = columns[int(model.jnt_qposadr[joint])]
            added = parent.add_joint(type=model.jnt_type[joint], pos=model.jnt_pos[joint], axis=model.jnt_axis[joint])
            added.range, added.ref = (chain.low[column], chain.high[column]), model.qpos0[chain.positions[column]]
            added.limited = mujoco.mjtLimited.mjLIMITED_TRUE
            order.append(column)
    parent.add_site(name="palm", **_placed(frame, stage.site(arm.palm_site)))
    return spec.compile(), np.array(order, dtype=np.intp)


def _placed(frame: Pose, pose: Pose) -> dict[str, Array]:
    """A pose within a frame, as MuJoCo's specification has it."""
    return {"pos": frame.to_local(pose.position), "quat": wxyz_from_matrix(frame.matrix.T @ pose.matrix)}


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
