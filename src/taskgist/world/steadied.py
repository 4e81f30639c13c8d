"""What a tracker reports, without its noise: bodies that stand still stay exactly where they are.

A tracker's poses tremble, by half a millimetre and some tenths of a degree, also where nothing moves. Who follows it
and keeps answers while nothing moves needs states in which what stands still is equal, number by number::

    steadied = Steadied(stage, first)
    for state in tracker:
        state = steadied.follow(state)

Each body that moves by itself (an agent, an object, a piece of furniture) is taken as a whole: joints that tremble a
little each move a hand or a head by much more. Its positions are averaged while they stay near to their average, and
the average begins anew where they leave it: that is motion. The body is held where it was until its average has moved
by more than a tolerance, measured at all its shapes, frames and turns; then it is put to its average. Where moving some
joints of the arms is enough for that, the rest of the body stays: who handles something stands still. So what stands
still is as quiet as an average of several frames, and what moves is followed without lag beyond
``Following.motion`` tolerances.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import mujoco
import numpy as np

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.settings import DEFAULT, Following
from taskgist.world.stage import Stage
from taskgist.world.state import State

JOINT_SHARE = 0.5
"""Share of the tolerance by which a joint of an arm has moved that is moved alone (ours: more than averaged noise)."""


class Steadied:
    """States of a scene, one after the other, each body held where it is until it moves by more than a tolerance.

    Args:
        stage: The scene. It is borrowed: it shows the same state after each call.
        first: The first state, taken as it is.
        settings: Tolerances.

    Attributes:
        state: What the last state was taken for.
    """

    def __init__(self, stage: Stage, first: State, settings: Following = DEFAULT.following) -> None:
        self._stage, self._settings = stage, settings
        model = stage.scene.model
        self._roots: Indices = np.asarray(model.body_rootid, dtype=np.intp)
        self._shape_roots = np.concatenate((self._roots, self._roots[model.geom_bodyid]))
        self._hinges, self._quaternions, self._position_roots = _positions(model, self._roots)
        self._in_arms, self._arms = _arms(stage, self._roots)
        self.state = first
        self._average, self._counts = np.array(first.qpos), np.ones(model.nq)
        self._averaged = self._held = self._places(first)

    def follow(self, state: State) -> State:
        """What the next state is taken for.

        Time, who is tracked, who holds what and where eyes look are those of the state; a body of which other parts are
        tracked now is taken as it is.
        """
        if self._settings.exact:
            self.state = state
            return state
        known = self._changed(state)
        self._take_in(state, known)
        moved = known | self._beyond(self._averaged, self._held, 1.0)
        if moved.any():
            self._held, qpos = self._moved(moved, known)
        else:
            qpos = self.state.qpos
        self.state = State(qpos, state.time_s, state.untracked, state.holding, state.eyes)
        return self.state

    def _moved(self, moved: Mask, known: Mask) -> tuple[Places, Array]:
        """Where all is held when some bodies have moved, by the body at their root; some of them are taken as known."""
        by = np.abs(self._average - self.state.qpos)
        arms = moved[self._position_roots] & self._in_arms & (by > JOINT_SHARE * self._settings.turn_rad)
        if arms.any():
            qpos = np.where(arms, self._average, self.state.qpos)
            held = self._places(self.state.replace(at=slice(None), to=qpos))
            moved = known | self._beyond(self._averaged, held, 1.0)
        else:
            qpos, held = self.state.qpos, self._held
        qpos = np.where(moved[self._position_roots], self._average, qpos)
        return held.replaced(self._averaged, moved[self._roots], moved[self._shape_roots]), qpos

    def _take_in(self, state: State, anew: Mask) -> None:
        """Average the positions of each body, from here on where it moves."""
        off = state.qpos - self._average
        off[self._hinges] -= 2 * math.pi * np.rint(off[self._hinges] / (2 * math.pi))
        for at in self._quaternions:
            if state.qpos[at] @ self._average[at] < 0:
                off[at] = -state.qpos[at] - self._average[at]
        apart, turned = self._off(self._places(state), self._averaged, self._settings.motion)
        begins = anew | self._by_root(apart & ~self._arms, turned & ~self._arms[: len(turned)])
        handling = self._by_root(apart, turned) & ~begins  # of these some joints of the arms begin, the others tremble
        joints = handling[self._position_roots] & self._in_arms & (np.abs(off) > self._settings.turn_rad)
        some = np.zeros(len(self._roots), dtype=np.bool_)
        some[self._position_roots[joints]] = True
        begins |= handling & ~some
        afresh = begins[self._position_roots] | joints
        self._counts = np.where(afresh, 1.0, np.minimum(self._counts + 1, self._settings.frames))
        average = self._average + off / self._counts
        for at in self._quaternions:
            average[at] /= np.linalg.norm(average[at])
        self._average = np.where(afresh, state.qpos, average)
        self._averaged = self._places(state.replace(at=slice(None), to=self._average))

    def _changed(self, state: State) -> Mask:
        """The bodies of which other parts are tracked now, by the body at their root."""
        scene, found = self._stage.scene, np.zeros(len(self._roots), dtype=np.bool_)
        for name in state.untracked ^ self.state.untracked:
            owner = name.partition("/")[0]
            known = scene.agent(owner).root_body if owner in scene.agents else None
            if known is None and name in scene.objects:
                known = scene.object_body(name)
            if known is not None:
                found[self._roots[known]] = True
        return found

    def _places(self, state: State) -> Places:
        with self._stage.showing(state) as stage:
            bodies = stage.bodies()
            shapes = stage.geom_centers(np.arange(stage.scene.model.ngeom))
        return Places(np.concatenate((bodies[:, :3], shapes)), bodies[:, 3:])

    def _beyond(self, one: Places, other: Places, times: float) -> Mask:
        """Whether anything of each body is farther from where it was than so many tolerances, by root, (bodies,)."""
        return self._by_root(*self._off(one, other, times))

    def _off(self, one: Places, other: Places, times: float) -> tuple[Mask, Mask]:
        """Which points, and which bodies' turns, are farther from where they were than so many tolerances."""
        far_m, cosine = times * self._settings.place_m, math.cos(min(times * self._settings.turn_rad, math.pi) / 2)
        apart = ((one.points - other.points) ** 2).sum(axis=1) > far_m * far_m
        return apart, np.abs((one.wxyz * other.wxyz).sum(axis=1)) < cosine

    def _by_root(self, points: Mask, bodies: Mask) -> Mask:
        """Of which bodies these are, by the body at their root, (bodies,)."""
        found = np.zeros(len(self._roots), dtype=np.bool_)
        found[self._shape_roots[points]] = True
        found[self._roots[bodies]] = True
        return found


class Places(NamedTuple):
    """Where everything is.

    Attributes:
        points: Frames of bodies, then centres of shapes, metres, (bodies + shapes, 3).
        wxyz: How the bodies are turned, (bodies, 4).
    """

    points: Array
    wxyz: Array

    def replaced(self, by: Places, bodies: Mask, points: Mask) -> Places:
        """Some of them where others are."""
        return Places(np.where(points[:, None], by.points, self.points), np.where(bodies[:, None], by.wxyz, self.wxyz))


def _arms(stage: Stage, roots: Indices) -> tuple[Mask, Mask]:
    """Which of qpos are of agents' arms, (nq,); and which frames of bodies and shapes are, (bodies + shapes,)."""
    scene, model = stage.scene, stage.scene.model
    positions, bodies = np.zeros(model.nq, dtype=np.bool_), np.zeros(len(roots), dtype=np.bool_)
    for name in scene.agents:
        agent = scene.agent(name)
        positions[agent.arm_positions] = True
        for side in agent.sides:
            bodies[agent.parts.get(f"{side}_arm", np.empty(0, dtype=np.intp))] = True
    return positions, np.concatenate((bodies, bodies[model.geom_bodyid]))


def _positions(model: mujoco.MjModel, roots: Indices) -> tuple[Indices, list[slice], Indices]:
    """Of qpos: the angles, the quaternions, and the root of what each of them moves, (nq,)."""
    hinges, quaternions, owners = list[int](), list[slice](), np.zeros(model.nq, dtype=np.intp)
    for joint in range(model.njnt):
        start, kind = int(model.jnt_qposadr[joint]), int(model.jnt_type[joint])
        end = int(model.jnt_qposadr[joint + 1]) if joint + 1 < model.njnt else int(model.nq)
        owners[start:end] = roots[model.jnt_bodyid[joint]]
        if kind == int(mujoco.mjtJoint.mjJNT_HINGE):
            hinges.append(start)
        elif kind in (int(mujoco.mjtJoint.mjJNT_FREE), int(mujoco.mjtJoint.mjJNT_BALL)):
            quaternions.append(slice(end - 4, end))
    return np.array(hinges, dtype=np.intp), quaternions, owners
