"""A robot, or a person, of a scene as a planner needs it: joints by what they do, collisions, inverse kinematics.

Everything comes from the body's profile and its model; nothing here knows a robot's name::

    performer = Performer(scene, "PR2")
    qpos = performer.at(scene.initial.qpos, (1.0, 0.4, 3.1))             # base on the floor
    for found in performer.ik("right", palm, qpos):                      # whole configurations, nearest first
        if performer.blocking(found) is None: ...

Configurations are positions of the whole scene in MuJoCo's order, (nq,), so that what is found can be shown, recorded
and judged as it is.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.errors import SceneError
from taskgist.perspective.effort import LEAN, MOVE, TURN, Blocking, stretch
from taskgist.perspective.effort import LIFT as LIFT_TORSO
from taskgist.perspective.grasp_sampling import Grasps, on_outside
from taskgist.perspective.scene_efforts import SceneEfforts
from taskgist.planning.gripper import Gripper
from taskgist.planning.inverse_kinematics import ArmKinematics, Chain, Pointing, ahead_in_palm, chain_of_arm
from taskgist.planning.sweeps import BaseMoves, JointMoves, Sweep
from taskgist.planning.whole_body import TOLERANCE_M, Grip, WholeBody
from taskgist.settings import DEFAULT, Settings
from taskgist.world.bodies.agent import Agent
from taskgist.world.contacts import holding_of
from taskgist.world.geometry.transforms import Pose, turned_about_z, wrapped, yaw_of
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist.world.state import State

Base = tuple[float, float, float]
"""Where a body stands: x and y in metres, yaw in radians."""

ALONG = 0.999
"""Cosine of what counts as parallel."""

__all__ = ["TOLERANCE_M", "Base", "Chain", "Grip", "Gripper", "Performer", "refuse_held"]


class Performer:
    """A body of a scene that is to perform something.

    Args:
        scene: The scene.
        agent_name: Whose body.
        settings: All settings.
        start: The state from which it starts; by default the scene's own.

    Attributes:
        scene: As given.
        agent: The agent.
        settings: As given.
        start: As given.
        body: Its collisions.

    Raises:
        UnknownNameError: There is no such agent.
        SceneError: It has no arm, or no hand that grasps; or it begins in something.
    """

    def __init__(
        self, scene: Scene, agent_name: str, settings: Settings = DEFAULT, *, start: State | None = None
    ) -> None:
        self.scene, self.settings = scene, settings
        self.agent: Agent = scene.agent(agent_name)
        self.start = scene.initial if start is None else start
        if not self.agent.arms or self.agent.profile.hand is None:
            lacks = "no arm" if not self.agent.arms else "no hand that grasps"
            raise SceneError(f"{agent_name} has {lacks}", where=scene.name, hint="its profile says [[arms]] and [hand]")
        self.body = WholeBody(scene, self.agent, self.start)
        self._stage = Stage(scene, self.start)
        self._chains: dict[str, Chain] = {}
        self._arms: dict[tuple[str, bytes], ArmKinematics] = {}
        self._pointings: dict[str, Pointing] = {}
        self._grippers: dict[str, Gripper] = {}
        self._outside: dict[str, tuple[Grasps, Grasps]] = {}

    # --- Joints by what they do.

    @property
    def sides(self) -> tuple[str, ...]:
        """Sides on which it has an arm."""
        return self.agent.sides

    def chain(self, side: str) -> Chain:
        """The joints that move the palm of a side: lifts, then the arm, with their positions in qpos and limits."""
        if side not in self._chains:
            self._chains[side] = chain_of_arm(self._stage.show(self.start), self.agent, self.agent.arm(side))
        return self._chains[side]

    def gripper(self, side: str) -> Gripper:
        """The hand of a side."""
        if side not in self._grippers:
            hand = self.agent.profile.hand
            assert hand is not None
            self._grippers[side] = Gripper(self._stage.show(self.start), self.agent, self.agent.arm(side), hand)
        return self._grippers[side]

    def opened(self, qpos: Array, side: str, opening_m: float) -> Array:
        """A configuration with the hand of a side so wide open, as near as it gets."""
        gripper = self.gripper(side)
        return with_values(qpos, gripper.positions, gripper.opened(opening_m))

    @cached_property
    def folded(self) -> Array:
        """Positions of the arms at rest, as the profile gives them, in the order of ``agent.arm_positions``, (n,).

        Fingers are as the start has them.
        """
        rest = {**dict(self.agent.profile.rest_rad), **dict(self.agent.profile.rest_m)}
        model = self.scene.model
        positions = self.agent.arm_positions
        names = {position: name for name, position in self.agent.joints.items()}
        values = [rest.get(names[int(position)], float(model.qpos0[position])) for position in positions]
        moved = np.concatenate([self.chain(side).positions for side in self.sides])
        return np.where(np.isin(positions, moved), values, self.start.qpos[positions])

    def at_rest(self, qpos: Array) -> Array:
        """A configuration with the arms folded, and what lifts them where it is at the start."""
        lifts = np.concatenate([self.chain(side).positions[self.chain(side).lifts] for side in self.sides])
        folded = with_values(qpos, lifts, self.start.qpos[lifts])
        return with_values(folded, self.agent.arm_positions, self.folded)

    def outside(self, stage: Stage, thing: str, sampled: Grasps) -> Grasps:
        """Those of a thing's grasps whose points are on its outside; found once for each thing."""
        if thing not in self._outside or self._outside[thing][0] is not sampled:
            self._outside[thing] = (sampled, sampled.only(on_outside(stage, thing, sampled)))
        return self._outside[thing][1]

    @property
    def unused(self) -> tuple[str, ...]:
        """Joints of its torso that would bring an arm farther, and that nothing here moves."""
        axes = (self.agent.profile.turn, self.agent.profile.lean)
        return tuple(axis.joint for axis in axes if axis is not None)

    @property
    def drives(self) -> bool:
        """Whether its base goes over the floor as it is; what stands on legs would have to walk, which is not done."""
        return self.agent.profile.moves and not self.agent.profile.legs.hips

    @property
    def actions(self) -> tuple[str, ...]:
        """The virtual actions (Eq. 1-6) that it can carry out: arms stretched out, torso lifted, base moved."""
        arms = tuple(stretch(side) for side in self.sides)
        lifted = (LIFT_TORSO,) if self.agent.lifts else ()
        return (*arms, *lifted, *((MOVE,) if self.drives else ()))

    @cached_property
    def heights_m(self) -> tuple[float, float]:
        """Between which heights its palms get to anything, wherever it drives and however high it is lifted, metres."""
        if self.settings.reach.model == "sector" or any(arm.profile.thrust for arm in self.agent.arms):
            return -math.inf, math.inf
        found = []
        for side in self.sides:
            chain, reach, shoulder = self.chain(side), self.agent.arm(side).reach, self.shoulder(self.start.qpos, side)
            up = shoulder[-3:] * ((1.0, -1.0, 1.0) if reach.mirrored else 1.0)
            low_m, high_m = (reach.scale * far_m for far_m in reach.map.along(up))
            values = self.start.qpos[chain.positions]
            lowered_m, lifted_m = (float((end - values)[chain.lifts].sum()) for end in (chain.low, chain.high))
            found += [shoulder[2] + low_m + lowered_m, shoulder[2] + high_m + lifted_m]
        return float(min(found)), float(max(found))

    @property
    def not_planned(self) -> tuple[tuple[tuple[str, ...], str], ...]:
        """Virtual actions that its body has and that nothing here carries out, and what they are in words."""
        axes = ((TURN, self.agent.profile.turn), (LEAN, self.agent.profile.lean))
        torso = tuple(name for name, axis in axes if axis is not None)
        walking = (MOVE,) if self.agent.profile.moves and not self.drives else ()
        ways = [(torso, f"move its torso ({' and '.join(self.unused)})"), (walking, "walk")]
        found = [(actions, what) for actions, what in ways if actions]
        return (
            (*found, ((*torso, *walking), " and ".join(what for _, what in found))) if len(found) > 1 else tuple(found)
        )

    def would_have_to(self, efforts: SceneEfforts, thing: str) -> str | None:
        """What it would have to do to grasp a thing, and nothing here carries out; None if that would not do either."""
        for actions, what in self.not_planned:
            if efforts.effort(self.agent.name, thing, "grasp", (*self.actions, *actions)).is_known_to_do:
                return what
        return None

    # --- Where it stands.

    def base(self, qpos: Array) -> Base:
        """Where it stands in a configuration."""
        x, y = (float(value) for value in qpos[self.agent.base][:2])
        return x, y, yaw_of(qpos[self.agent.base][3:])

    def at(self, qpos: Array, base: Base) -> Array:
        """A configuration with the body moved over the floor and turned about the vertical."""
        moved = np.array(qpos)
        whole = moved[self.agent.base]
        whole[:2] = base[:2]
        whole[3:] = turned_about_z(whole[3:], base[2] - yaw_of(whole[3:]))
        return moved

    # --- Collisions.

    def blocking(self, qpos: Array, grip: Grip | None = None, *, taken_by: Indices | None = None) -> Blocking | None:
        """The first pair that collides in a configuration: a part of the robot or its load, and what it is in.

        Args:
            qpos: Positions of the whole scene, (nq,).
            grip: What it holds; that goes with the palm.
            taken_by: Shapes of another hand, which comes to what it holds.

        Returns:
            None if the whole robot and its load are free.
        """
        return self.body.blocking(qpos, grip, taken_by=taken_by)

    def grip(self, qpos: Array, thing: str, side: str) -> Grip:
        """A thing, where it is, in a hand, where that is."""
        return self.body.grip(qpos, thing, side)

    def carried(self, qpos: Array, grip: Grip) -> Array:
        """A configuration with the held thing where the hand has it."""
        return self.body.carried(self._stage.show(self._state(qpos)), grip)

    def arm_sweep(self, qpos: Array, side: str, grip: Grip | None = None, *, ends: Sequence[Array] = ()) -> Sweep:
        """What an arm and its lift, and what the robot holds, may meet along a way of its joints.

        Args:
            qpos: Where everything else is, (nq,).
            side: The arm.
            grip: What the robot holds.
            ends: Joint values of the chain where the way begins and ends, (k,) each.
        """
        return Sweep(self.body, qpos, JointMoves(self.chain(side).positions), grip, ends=ends)

    def base_sweep(self, qpos: Array, grip: Grip | None = None, *, ends: Sequence[Array] = ()) -> Sweep:
        """What the robot, and what it holds, may meet as its base moves; ``ends`` are x, y and yaw, (3,) each."""
        return Sweep(self.body, qpos, BaseMoves(self.agent.base), grip, ends=ends)

    # --- The palm, and what brings it somewhere.

    def palm(self, qpos: Array, side: str) -> Pose:
        """The palm in the world."""
        return self._stage.show(self._state(qpos)).site(self.agent.arm(side).palm_site)

    def ik(
        self,
        side: str,
        palm: Pose,
        qpos: Array,
        *,
        lift: bool = True,
        starts: int = 2,
        most: int = 3,
        seed: int = 0,
    ) -> list[Array]:
        """Configurations, (nq,) each, that bring a palm to a pose within 2 mm and 1°; the nearest one first.

        Only the joints of that arm, and lifts, differ from the configuration given. Collisions are not looked at.

        Args:
            side: Whose palm.
            palm: Where to, in the world.
            qpos: The present configuration; its base stays.
            lift: Whether lifts may move.
            starts: From how many configurations of the arm's capability map to start, and half as many at random.
            most: Enough of them.
            seed: Of what is drawn.

        Returns:
            None of them: it is out of reach, as far as is known.
        """
        arm, chain = self._arm(side, qpos), self.chain(side)
        target, now = self._in_root(palm, qpos), qpos[chain.positions]
        found = arm.solve(target, now, lift=lift, starts=starts, most=most, seed=seed)
        return [with_values(qpos, chain.positions, values) for values in found]

    def comes(self, side: str, palm: Pose, qpos: Array) -> Iterator[Array]:
        """The same as they are found, in no order: for who asks whether one will do; arguments as above."""
        chain = self.chain(side)
        for values in self._arm(side, qpos).solutions(self._in_root(palm, qpos), qpos[chain.positions]):
            yield with_values(qpos, chain.positions, values)

    def follow(self, side: str, palms: Sequence[Pose], qpos: Array, *, lift: bool = False) -> Array | None:
        """Joints of a chain, (n, k), that bring a palm to one pose after the other without a jump; None if none do.

        Args:
            side: Whose palm.
            palms: Where to, in the world; a few millimetres apart.
            qpos: The configuration before the first.
            lift: Whether lifts may move.
        """
        chain = self.chain(side)
        targets = [self._in_root(palm, qpos) for palm in palms]
        return self._arm(side, qpos).follow(targets, qpos[chain.positions], lift=lift)

    def arm_steps(self, side: str, qpos: Array, step_m: float) -> Array:
        """Changes of each joint of a chain, (n,), that move no point of the hand by more than ``step_m``."""
        return np.asarray(step_m / self._arm(side, qpos).levers_m)

    def pointing(self, side: str) -> Pointing:
        """Which way the hand of a side may point, at each place from its shoulder, by its capability map."""
        if side not in self._pointings:
            self._pointings[side] = Pointing(self.agent.arm(side))
        return self._pointings[side]

    def ahead_in_palm(self, side: str) -> Array:
        """Which way the hand points, in the palm's frame, a unit vector (3,)."""
        return ahead_in_palm(self._stage.show(self.start), self.agent.arm(side))

    def rolls_about(self, side: str, axis_in_palm: Array) -> bool:
        """Whether the last joint of an arm turns the palm about an axis of its own, by any angle."""
        chain = self.chain(side)
        stage = self._stage.show(self.start)
        joint = self.scene.model.joint(f"{self.agent.name}/{chain.names[-1]}").id
        axis = stage.site(self.agent.arm(side).palm_site).matrix @ axis_in_palm
        return chain.rolls_freely and abs(float(stage.screw(int(joint))[1] @ axis)) > ALONG

    def shoulder(self, qpos: Array, side: str) -> Array:
        """The shoulder and the frame that carries it, a row of 12 for compiled functions."""
        pose = self._stage.show(self._state(qpos)).shoulder(self.agent.arm(side))
        return np.concatenate((pose.position, pose.matrix.reshape(9)))

    def _state(self, qpos: Array) -> State:
        return State(qpos, untracked=self.start.untracked)

    def _in_root(self, pose: Pose, qpos: Array) -> Pose:
        root = self._root(qpos)
        return Pose(root.to_local(pose.position), root.matrix.T @ pose.matrix)

    def _root(self, qpos: Array) -> Pose:
        return self._stage.show(self._state(qpos)).body(self.agent.root_body)

    def _arm(self, side: str, qpos: Array) -> ArmKinematics:
        """The kinematics of an arm whose links are as the other joints of a configuration have them."""
        chain = self.chain(side)
        key = (side, np.round(qpos[self._own_joints], 6).tobytes())
        if key not in self._arms:
            stage = self._stage.show(self._state(qpos))
            self._arms[key] = ArmKinematics(stage, self.agent, self.agent.arm(side), chain)
        return self._arms[key]

    @cached_property
    def _own_joints(self) -> Indices:
        """Positions of the joints that carry its arms, but those of the arms, and its arms' girdles."""
        model = self.scene.model
        found: set[int] = set()
        for arm in self.agent.arms:
            body = int(model.site_bodyid[arm.palm_site])
            while body not in (self.agent.root_body, 0):
                joints = range(model.body_jntadr[body], model.body_jntadr[body] + model.body_jntnum[body])
                found |= {int(model.jnt_qposadr[joint]) for joint in joints}
                body = int(model.body_parentid[body])
        own = {position for side in self.sides for position in self.chain(side).positions.tolist()}
        return np.array(sorted(found - own), dtype=np.intp)


def refuse_held(scene: Scene, state: State, performer: str, thing: str, settings: Settings = DEFAULT) -> None:
    """See that a thing is there to be taken, and that the hands are free of who is to take it.

    Args:
        scene: The scene.
        state: Where everything is.
        performer: Who is to take it.
        thing: The thing.
        settings: All settings.

    Raises:
        UnknownNameError: There is no such agent or thing.
        SceneError: Somebody holds the thing, or the performer something.
    """
    scene.object_body(thing)
    stage, agent = Stage(scene, state), scene.agent(performer)
    for name in scene.objects:
        held = holding_of(stage, name, settings.contact)
        for who, side in () if held is None else held.hands:
            if name == thing:
                problem = f"the {thing} is held by {who}, in the {side} hand"
                hint = "put it somewhere, or name another thing"
                raise SceneError(problem, where=scene.name, field=thing, hint=hint)
            if who == agent.name:
                problem = f"{performer} holds the {name} in its {side} hand, and performs with empty hands"
                raise SceneError(problem, where=scene.name, field=name, hint="put that somewhere first")


def with_values(qpos: Array, positions: Indices | slice, values: Array) -> Array:
    """Positions of the whole scene, (nq,), with some replaced."""
    changed = np.array(qpos)
    changed[positions] = values
    return changed


def near_bases(one: Base, other: Base, within_m: float, within_rad: float) -> bool:
    """Whether two places to stand are nearer to one another than that, and turned alike."""
    away_m = math.hypot(one[0] - other[0], one[1] - other[1])
    return away_m < within_m and abs(wrapped(one[2] - other[2])) < within_rad
