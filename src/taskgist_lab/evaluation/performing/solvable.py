"""Whether a task can be performed in a room at all, by a fixed, dense sampling that no planner has a say in.

Final places of the thing: a grid of 5 cm over everything level that carries, floors of containers and tops of things
among it, and of 25 cm over the floor; each with the side down that is down now, and the other two for boxes, at four
headings. Then the air: before the target agent's face, held by the performer; and where the target agent reaches it
with its torso at most, in its own hand, which the engine's moving bodies bring there. A place counts if the thing
touches nothing there but what carries it, the facts say that what is wanted holds (the functions that explain
demonstrations, as in ``planning.judging``), and the performer's own effort to grasp the thing is below 5 (none known),
both there and where it is now::

    found = solvable(scene, clause, "R", "P2", "it")
    found.possible, found.why

It is an upper bound: that one grasp does for both ends, that there is a way between them, and that the robot's arm does
not spoil the end is not asked. Levels are found by MuJoCo's rays, downwards, again from beneath what they hit.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain, product

import mujoco
import numpy as np

from taskgist.common.arrays import Array
from taskgist.facts.standard import STANDARD_TREE
from taskgist.learning.understanding import Clause
from taskgist.observe.attributes import resting_snapshot
from taskgist.perspective.effort import NO_KNOWN_LEVEL
from taskgist.perspective.scene_efforts import SceneEfforts
from taskgist.planning.goal import Goal
from taskgist.planning.judging import Attention, Judge
from taskgist.planning.robot_taking import taker_of
from taskgist.settings import DEFAULT
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist.world.state import Hold, State

STEP_M, FLOOR_STEP_M, AROUND_M = 0.05, 0.25, 3.0
"""Grids over what stands on the floor, and over the floor; and how far from the middle of both agents they go."""
HEADINGS = tuple(math.pi / 4 * k for k in (0, 2, 1, 3))
HIGHEST_M, BENEATH_M, LOWEST_M = 2.3, 0.003, 0.05
"""Rays start so high; each goes on so far beneath what it hit; what is lower than the last is the floor."""
TOUCH_M, FIRM_M, FIRM_SHARE = 0.001, 0.004, 0.5
"""The thing is put so far above a level; what carries it is beneath four points of its base by no more than that; they
are so far from its middle, as a share of its half size."""
VIEWS = tuple(product((0.4, 0.55, 0.7, 0.9), (-30.0, 0.0, 30.0), (0.0, -15.0, -30.0)))
"""Before a face: metres from the eye, degrees aside and below."""
TAKING = tuple(product((0.45, 0.6, 0.75), (-40.0, 0.0, 40.0), (0.0, -25.0, -50.0)))
"""Before a shoulder: shares of the arm's length, degrees aside and below."""
TORSO_LEVEL = 2
MOVED_M = 0.03
"""A place that is no farther from where the thing is now is none."""


@dataclass(frozen=True)
class Solvable:
    """What was found.

    Attributes:
        possible: Whether a place was found.
        why: Where, or why there is none, in a few words.
        places: How many places were judged until then.
        wanted: How many of these satisfy what is wanted.
    """

    possible: bool
    why: str
    places: int = 0
    wanted: int = 0


def solvable(
    scene: Scene, clause: Clause, performer: str, target: str, thing: str, *, attention: Attention = "thing"
) -> Solvable:
    """Whether a task can be performed.

    Args:
        scene: The room.
        clause: What the task means.
        performer: Who is to perform it.
        target: For whom.
        thing: With what.
        attention: What the target agent is assumed to look at in the end.
    """
    state = scene.initial
    goal = goal_of(scene, clause, target, thing)
    if goal.impossible:
        return Solvable(False, f"from the start: {goal.impossible[0].why}")
    efforts = SceneEfforts(Stage(scene, state))
    now = efforts.effort(performer, thing, "grasp")
    if now.level == NO_KNOWN_LEVEL:
        return Solvable(False, "the performer cannot grasp the thing where it is")
    first = f", once it is {now.evidence.prepared}" if now.evidence.prepared else ""
    judge = Judge(scene, state, target, thing, goal, attention=attention, performer=performer)
    sampler = _Sampler(scene, performer, target, thing)
    places, wanted = 0, 0
    for what, there in sampler.places():
        places += 1
        if judge.verdict(there).holds is not True:
            continue
        wanted += 1
        efforts.update(there.with_holding(()))
        if efforts.effort(performer, thing, "grasp").level != NO_KNOWN_LEVEL:
            return Solvable(True, what + first, places, wanted)
    why = "nowhere does it hold" if not wanted else f"the performer does not get at any of {wanted} places"
    return Solvable(False, why, places, wanted)


def goal_of(scene: Scene, clause: Clause, target: str, thing: str) -> Goal:
    """What a clause asks for from the state in which a scene is."""
    start = resting_snapshot(Stage(scene), agent=target, name=thing, settings=DEFAULT, predicates=())
    return Goal.of(clause, start, STANDARD_TREE, DEFAULT)


class _Sampler:
    """Final states of a scene, each with the thing somewhere else; MuJoCo alone says where there is room for it."""

    def __init__(self, scene: Scene, performer: str, target: str, thing: str) -> None:
        self._scene, self._performer, self._target, self._thing = scene, performer, target, thing
        self._model: mujoco.MjModel = scene.model
        self._data = mujoco.MjData(self._model)
        self._own = scene.solid_geoms_of(thing)
        self._others = np.setdiff1d(scene.solid_geoms, self._own)
        self._column = scene.object_slice(thing)
        self._start = np.array(scene.initial.qpos)
        self._show(self._start)
        kinds = self._model.geom_type[self._own]
        boxes = (kinds == int(mujoco.mjtGeom.mjGEOM_BOX)).all()
        upright = (kinds == int(mujoco.mjtGeom.mjGEOM_CYLINDER)).all()
        self._headings = HEADINGS[:1] if upright else HEADINGS
        self._turns = (_turn(0, 0.0), _turn(0, math.pi / 2), _turn(1, math.pi / 2))[: 3 if boxes else 1]

    def places(self) -> Iterator[tuple[str, State]]:
        """What kind of place, and the state, in random but fixed order: on supports, in the air, on the floor."""
        raised, floor = self._levels()
        rng = np.random.default_rng(0)
        raised = [raised[k] for k in rng.permutation(len(raised))]
        on_floor = (("on the floor", state) for point in floor for state in self._put(point))
        on_top = (("on something", state) for point in raised for state in self._put(point))
        return chain(self._in_air(), on_top, on_floor)

    def _show(self, qpos: Array) -> None:
        self._data.qpos[:] = qpos
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_comPos(self._model, self._data)

    # --- On something.

    def _levels(self) -> tuple[list[Array], list[Array]]:
        """Points of what is level, with the thing out of the way: on what stands on the floor, and on the floor."""
        scene, away = self._scene, self._start.copy()
        away[self._column][:3] = (0.0, 0.0, -50.0)
        self._show(away)
        agents = [self._start[scene.base_slice(name)][:2] for name in (self._performer, self._target)]
        middle = np.mean(agents, axis=0)
        count = round(AROUND_M / STEP_M)
        raised, floor = list[Array](), list[Array]()
        each = round(FLOOR_STEP_M / STEP_M)
        for i, k in product(range(-count, count + 1), repeat=2):
            x, y = middle + STEP_M * np.array((i, k))
            for height in self._heights(float(x), float(y)):
                if height > LOWEST_M:
                    raised.append(np.array((x, y, height)))
                elif i % each == 0 and k % each == 0:
                    floor.append(np.array((x, y, height)))
        return raised, floor

    def _heights(self, x: float, y: float) -> list[float]:
        """Heights at which a ray downwards meets something that carries, again and again."""
        found, height = list[float](), HIGHEST_M
        geom, groups = np.full(1, -1, dtype=np.int32), np.ones(6, dtype=np.uint8)
        while height > -0.1:
            start, down = np.array((x, y, height)), np.array((0.0, 0.0, -1.0))
            far = mujoco.mj_ray(self._model, self._data, start, down, groups, 1, -1, geom)
            if far < 0:
                break
            height -= far
            if self._scene.owners[int(geom[0])] not in self._scene.agents:
                found.append(height)
            height -= BENEATH_M
        return found

    def _put(self, point: Array) -> Iterator[State]:
        """The states with the thing at a point, however turned, where it is carried and free."""
        for turn, heading in product(self._turns, self._headings):
            qpos = self._posed(point, turn, heading)
            low, half = self._lowest()
            qpos[self._column][2] += float(point[2]) + TOUCH_M - low
            self._show(qpos)
            if np.linalg.norm(qpos[self._column][:3] - self._start[self._column][:3]) > MOVED_M and (
                self._is_carried(qpos[self._column][:2], float(point[2]), half, heading) and self._is_free(0.0)
            ):
                yield State(qpos)

    def _posed(self, point: Array, turn: Array, heading: float) -> Array:
        """Positions with the thing's frame at a point, tipped, then turned about the vertical; they are shown."""
        qpos, yaw, tipped = self._start.copy(), _turn(2, heading), np.zeros(4)
        mujoco.mju_mulQuat(tipped, turn, self._start[self._column][3:])
        whole = np.zeros(4)
        mujoco.mju_mulQuat(whole, yaw, tipped)
        qpos[self._column] = (*point[:2], 0.0, *whole)
        self._show(qpos)
        return qpos

    def _lowest(self) -> tuple[float, float]:
        """The thing's lowest point as it is shown, and the half of its smaller extent seen from above."""
        low, high = np.full(3, math.inf), np.full(3, -math.inf)
        for geom in self._own.tolist():
            matrix = self._data.geom_xmat[geom].reshape(3, 3)
            centre, half = self._model.geom_aabb[geom, :3], self._model.geom_aabb[geom, 3:]
            middle = self._data.geom_xpos[geom] + matrix @ centre
            extent = np.abs(matrix) @ half
            if self._model.geom_type[geom] == int(mujoco.mjtGeom.mjGEOM_CYLINDER) and abs(matrix[2, 2]) > 0.999:
                extent = half
            low, high = np.minimum(low, middle - extent), np.maximum(high, middle + extent)
        return float(low[2]), float((high - low)[:2].min()) / 2

    def _is_carried(self, middle: Array, height: float, half: float, heading: float) -> bool:
        """Whether something level is beneath four points of its base."""
        geom = np.full(1, -1, dtype=np.int32)
        skip = int(self._scene.object_body(self._thing))
        groups = np.ones(6, dtype=np.uint8)
        for k in range(4):
            angle = heading + math.pi / 2 * k
            x, y = middle + FIRM_SHARE * half * np.array((math.cos(angle), math.sin(angle)))
            start, down = np.array((x, y, height + FIRM_M / 2)), np.array((0.0, 0.0, -1.0))
            far = mujoco.mj_ray(self._model, self._data, start, down, groups, 1, skip, geom)
            if not 0.0 <= far <= FIRM_M:
                return False
        return True

    def _is_free(self, gap_m: float) -> bool:
        """Whether the thing, as it is shown, is so far from everything."""
        model, data = self._model, self._data
        for mine in self._own.tolist():
            apart = np.linalg.norm(data.geom_xpos[self._others] - data.geom_xpos[mine], axis=1)
            radii = model.geom_rbound[self._others]
            near = (radii == 0.0) | (apart < radii + model.geom_rbound[mine] + gap_m)
            for other in self._others[near].tolist():
                if mujoco.mj_geomDistance(model, data, mine, other, 0.01 + gap_m, None) < gap_m:
                    return False
        return True

    # --- In the air.

    def _in_air(self) -> Iterator[tuple[str, State]]:
        """Held before the target agent's face, and in its own hand where it reaches it."""
        scene = self._scene
        agent = scene.agent(self._target)
        stage = Stage(scene)
        eye = stage.eye(agent)
        performer_side = scene.agent(self._performer).arms[0].profile.side
        ahead = math.atan2(eye.matrix[1, 0], eye.matrix[0, 0])
        for far, aside, below in VIEWS:
            place = eye.position + far * _direction(ahead + math.radians(aside), math.radians(below))
            for state in self._held(place):
                yield "held up", state.with_holding([Hold(self._performer, performer_side, self._thing)])
        efforts, taker = SceneEfforts(Stage(scene)), taker_of(scene, self._target, scene.initial, DEFAULT)
        for arm in agent.arms:
            shoulder = stage.shoulder(arm)
            ahead = math.atan2(shoulder.matrix[1, 0], shoulder.matrix[0, 0])
            for share, aside, below in TAKING:
                far = share * arm.profile.length_m
                place = shoulder.position + far * _direction(ahead + math.radians(aside), math.radians(below))
                for state in self._held(place):
                    efforts.update(state)
                    level = efforts.level(self._target, self._thing, "reach", up_to=TORSO_LEVEL)
                    if level is None or level > TORSO_LEVEL:
                        continue
                    there = taker.holding(state, self._thing)
                    if isinstance(there, State):
                        yield "handed over", there

    def _held(self, place: Array) -> Iterator[State]:
        """The states with the thing at a place in the air, in nobody's hand, where it is free."""
        for turn, heading in product(self._turns, self._headings):
            qpos = self._posed(place, turn, heading)
            qpos[self._column][2] = place[2]
            self._show(qpos)
            if self._is_free(0.005):
                yield State(qpos).with_holding(())


def _turn(axis: int, angle: float) -> Array:
    """A turn about an axis of the world, as a quaternion."""
    wxyz = np.zeros(4)
    wxyz[0], wxyz[1 + axis] = math.cos(angle / 2), math.sin(angle / 2)
    return wxyz


def _direction(yaw_rad: float, pitch_rad: float) -> Array:
    level = math.cos(pitch_rad)
    return np.array((level * math.cos(yaw_rad), level * math.sin(yaw_rad), math.sin(pitch_rad)))
