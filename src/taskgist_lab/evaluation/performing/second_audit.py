"""A second auditor of performed motions, which shares no code with the first: MuJoCo's own contacts, every 5 ms.

Nothing of ``taskgist.performing`` and of planning is used here, and of the scene only its compiled model and names. A
copy of the model is told which shapes may touch, and MuJoCo's collision detection looks at every 5 ms of the motion,
positions between frames as MuJoCo integrates them; each contact deeper than 2 mm is measured again as a distance, and
only what both call deep is a fault (of two convex meshes, now one and now the other is off by a lot).

What counts: robot and load against everything, and the robot against itself. What does not: a hand that holds against
its load, parts of one hand, bodies with no more than one body between them along the robot, and own bodies whose
shapes overlap at the start. With others, what overlaps at the start counts for what it gets deeper.

Beside that: limits of joints, jumps, loads that are farther than 3 cm from the hand that is said to hold them,
things that move although nobody holds them, and whether the thing rests in the end: still over the last frames, and,
if no hand holds it, still there after a second of MuJoCo's dynamics with all else fixed.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from taskgist.common.arrays import Array
from taskgist.world.scene import Scene
from taskgist.world.state import Hold

STEP_S, DEPTH_M = 0.005, 0.002
LIMIT, FASTEST_RAD_S, FASTEST_M_S = 1e-3, 8.0, 2.0
"""How far beyond its limits a joint may be, and what moves faster jumps: joints, bases and loads."""
HELD_M, STRAY_M, MOVES_M, TURNS_RAD = 0.030, 0.001, 0.010, math.radians(5.0)
"""How far a held thing may be from the hand (Jido's fingers do not move: what is narrow is that far from both of them);
how far one that nobody holds may stray in a frame unless it is the one that was let go; what still counts as resting.
"""
IMMOVABLE_KG = 1e6
"""Inertia that is added to all that stays where it is while a thing is watched."""
STILL_S, STILL_M, WATCHED_S = 0.3, 0.002, 1.0
"""Over the last of these it is still; so long it is watched under gravity."""
FALLS_S = 2.0
"""So long after it was let go a thing may move."""


@dataclass(frozen=True)
class Fault:
    """One thing that is wrong, where it is worst.

    Attributes:
        kind: "penetration", "joint limit", "jump", "grip", "stray", "rest".
        what: A body, a joint, or a thing.
        other: The body that it is in, the hand; empty where there is none.
        time_s: When.
        amount: How much: metres or radians beyond what is right; radians or metres per second for jumps.
    """

    kind: str
    what: str
    other: str
    time_s: float
    amount: float

    @property
    def text(self) -> str:
        """As a few words."""
        with_other = f" and {self.other}" if self.other else ""
        return f"{self.kind} of {self.what}{with_other}: {self.amount:.4f} at {self.time_s:.2f} s"


def second_audit(
    scene: Scene, performer: str, thing: str, times_s: Array, qpos: Array, holds: Sequence[frozenset[Hold]]
) -> tuple[Fault, ...]:
    """What is wrong with a motion.

    Args:
        scene: The scene, for its model and names.
        performer: The robot, or person, that performs.
        thing: The thing that it acts with.
        times_s: Times of the frames, (n,).
        qpos: Positions of everything in each, (n, nq).
        holds: What is said to be in which hand in each.
    """
    auditor = _Auditor(scene, performer, thing)
    return (
        *auditor.penetrations(times_s, qpos, holds),
        *auditor.limits(times_s, qpos),
        *auditor.jumps(times_s, qpos),
        *auditor.grips(times_s, qpos, holds),
        *auditor.strays(times_s, qpos, holds),
        *auditor.rest(times_s, qpos, holds[-1]),
    )


class _Auditor:
    """A model of its own, with what may touch and which body is whose."""

    def __init__(self, scene: Scene, performer: str, thing: str) -> None:
        self._model: mujoco.MjModel = copy.deepcopy(scene.model)
        self._data = mujoco.MjData(self._model)
        self._performer, self._thing = performer, thing
        model = self._model
        names = [model.body(body).name for body in range(model.nbody)]
        self._names = names
        self._of_robot = np.array([name.startswith(f"{performer}/") or name == performer for name in names])
        self._things = {name: model.body(name).id for name in scene.objects}
        self._root = np.array(model.body_rootid)
        self._load = self._under(self._things[thing])
        self._hands = {
            (agent, arm.profile.side): self._under(arm.hand_body)
            for agent in scene.agents
            for arm in scene.agent(agent).arms
        }
        self._may: dict[tuple[tuple[int, int], frozenset[Hold]], bool] = {}
        self._solid = np.flatnonzero((model.geom_contype != 0) | (model.geom_conaffinity != 0))
        self._tell_what_touches(model, self._of_robot | self._load)

    def _under(self, root: int) -> np.ndarray:
        """Whether each body hangs on one, (nbody,)."""
        inside = np.zeros(self._model.nbody, dtype=bool)
        for body in range(self._model.nbody):  # parents come before their children
            inside[body] = body == root or (body > 0 and inside[self._model.body_parentid[body]])
        return inside

    def _tell_what_touches(self, model: mujoco.MjModel, watched: np.ndarray) -> None:
        """Have MuJoCo look at all pairs of solid shapes with one of the watched bodies at least."""
        mine = watched[model.geom_bodyid[self._solid]]
        model.geom_contype[self._solid] = np.where(mine, 1, 2)
        model.geom_conaffinity[self._solid] = np.where(mine, 3, 1)

    # --- Penetrations.

    def penetrations(self, times_s: Array, qpos: Array, holds: Sequence[frozenset[Hold]]) -> list[Fault]:
        """The worst of each pair of bodies."""
        at_start = self._deep(qpos[0], frozenset(), {}, least_m=0.0)
        usual = {pair: math.inf if self._own(pair) else depth for pair, depth in at_start.items()}
        worst: dict[tuple[int, int], tuple[float, float]] = {}
        for time_s, positions, held in self._between(times_s, qpos, holds):
            for pair, beyond in self._deep(positions, held, usual, least_m=DEPTH_M).items():
                if beyond > worst.get(pair, (0.0, 0.0))[0]:
                    worst[pair] = (beyond, time_s)
        return [
            Fault("penetration", self._names[one], self._names[other], time_s, beyond)
            for (one, other), (beyond, time_s) in worst.items()
        ]

    def _between(
        self, times_s: Array, qpos: Array, holds: Sequence[frozenset[Hold]]
    ) -> Iterator[tuple[float, Array, frozenset[Hold]]]:
        """Time, positions and holds every 5 ms; between two frames both frames' holds count."""
        yield float(times_s[0]), qpos[0], holds[0]
        rate = np.zeros(self._model.nv)
        for index in range(len(times_s) - 1):
            span_s = float(times_s[index + 1] - times_s[index])
            mujoco.mj_differentiatePos(self._model, rate, span_s, qpos[index], qpos[index + 1])
            if not rate.any():
                continue  # nothing moves
            steps = max(1, math.ceil(span_s / STEP_S - 1e-9))
            for step in range(1, steps + 1):
                positions = qpos[index].copy()
                mujoco.mj_integratePos(self._model, positions, rate, span_s * step / steps)
                yield float(times_s[index]) + span_s * step / steps, positions, holds[index] | holds[index + 1]

    def _deep(
        self, positions: Array, held: frozenset[Hold], usual: dict[tuple[int, int], float], *, least_m: float
    ) -> dict[tuple[int, int], float]:
        """By pair of bodies, how much deeper than usual they are in each other; only what is by so much."""
        model, data = self._model, self._data
        data.qpos[:] = positions
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_collision(model, data)
        found: dict[tuple[int, int], float] = {}
        for contact in data.contact[: data.ncon]:
            if contact.dist >= -least_m:
                continue
            first, second = (int(model.geom_bodyid[geom]) for geom in contact.geom)
            pair = (min(first, second), max(first, second))
            allowed = usual.get(pair, 0.0)
            if -contact.dist - allowed <= least_m:
                continue
            if (pair, held) not in self._may:
                self._may[pair, held] = self._may_touch(pair, held)
            if self._may[pair, held]:
                continue
            again = -float(mujoco.mj_geomDistance(model, data, *map(int, contact.geom), 0.0, None))
            beyond = min(again, -float(contact.dist)) - allowed
            if beyond > least_m:
                found[pair] = max(found.get(pair, 0.0), beyond)
        return found

    def _own(self, pair: tuple[int, int]) -> bool:
        return bool(self._of_robot[pair[0]] and self._of_robot[pair[1]])

    def _may_touch(self, pair: tuple[int, int], held: frozenset[Hold]) -> bool:
        one, other = pair
        for hold in held:
            hand = self._hands[hold.agent, hold.side]
            load = self._root[[one, other]] == self._things[hold.object]
            if (hand[one] and load[1]) or (hand[other] and load[0]):
                return True
        if not self._own(pair):
            # Between the target agent's parts nothing is looked at; the load in two things at once is.
            return bool(self._load[one] and self._load[other])
        return any(hand[one] and hand[other] for hand in self._hands.values()) or self._near(one, other)

    def _near(self, one: int, other: int) -> bool:
        """Whether no more than one body is between two along the robot; bodies without joints are part of others."""
        weld, parent = self._model.body_weldid, self._model.body_parentid

        def ancestors(body: int) -> list[int]:
            chain = [int(weld[body])]
            while chain[-1] > 0 and len(chain) < 3:
                chain.append(int(weld[parent[chain[-1]]]))
            return chain

        first, second = ancestors(one), ancestors(other)
        away = [i + k for i, a in enumerate(first) for k, b in enumerate(second) if a == b and a > 0]
        return bool(away) and min(away) <= 2

    # --- Joints and jumps.

    def limits(self, times_s: Array, qpos: Array) -> list[Fault]:
        """Joints of the performer that are farther beyond their limits than at the start.

        Joints that the model has follow others are left out: the PR2's published model has fingers turn to negative
        angles, by their coupling, that their own limits exclude.
        """
        found = []
        coupled = self._model.eq_obj1id[self._model.eq_type == int(mujoco.mjtEq.mjEQ_JOINT)]
        for joint in np.setdiff1d(np.flatnonzero(self._model.jnt_limited), coupled):
            if not self._of_robot[self._model.jnt_bodyid[joint]]:
                continue
            values = qpos[:, self._model.jnt_qposadr[joint]]
            low, high = self._model.jnt_range[joint]
            beyond = np.maximum(low - values, values - high)
            beyond -= max(0.0, float(beyond[0]))
            index = int(beyond.argmax())
            if beyond[index] > LIMIT:
                name = self._model.joint(int(joint)).name
                found.append(Fault("joint limit", name, "", float(times_s[index]), float(beyond[index])))
        return found

    def jumps(self, times_s: Array, qpos: Array) -> list[Fault]:
        """What of the performer moves so fast between two frames that it jumps, and the thing."""
        rates = np.zeros((len(times_s) - 1, self._model.nv))
        for index, rate in enumerate(rates):
            span_s = float(times_s[index + 1] - times_s[index])
            mujoco.mj_differentiatePos(self._model, rate, span_s, qpos[index], qpos[index + 1])
        found = []
        for joint in range(self._model.njnt):
            body = int(self._model.jnt_bodyid[joint])
            if not (self._of_robot[body] or self._load[body]):
                continue
            start, kind = int(self._model.jnt_dofadr[joint]), self._model.jnt_type[joint]
            parts = [(1, FASTEST_RAD_S if kind == mujoco.mjtJoint.mjJNT_HINGE else FASTEST_M_S)]
            if kind == mujoco.mjtJoint.mjJNT_FREE:
                parts = [(3, FASTEST_M_S), (3, FASTEST_RAD_S * (4.0 if self._load[body] else 1.0))]
            for width, fastest in parts:
                speeds = np.linalg.norm(rates[:, start : start + width], axis=1)
                start += width
                index = int(speeds.argmax())
                if speeds[index] > fastest:
                    name = self._model.joint(joint).name or self._names[body]
                    found.append(Fault("jump", name, "", float(times_s[index]), float(speeds[index])))
        return found

    # --- Things: held by whom, let go, at rest.

    def grips(self, times_s: Array, qpos: Array, holds: Sequence[frozenset[Hold]]) -> list[Fault]:
        """Loads that are too far from the performer's hand that is said to hold them; from others' hands in the end.

        A taker's hand is said to hold from when it sets out.
        """
        worst: dict[Hold, tuple[float, float]] = {}
        for index, (time_s, positions) in enumerate(zip(times_s, qpos, strict=True)):
            last = index == len(times_s) - 1
            held = [hold for hold in holds[index] if last or hold.agent == self._performer]
            if not held:
                continue
            self._data.qpos[:] = positions
            mujoco.mj_kinematics(self._model, self._data)
            for hold in held:
                gap = self._gap_m(self._hands[hold.agent, hold.side], self._root == self._things[hold.object])
                if gap > worst.get(hold, (HELD_M, 0.0))[0]:
                    worst[hold] = (gap, float(time_s))
        return [
            Fault("grip", hold.object, f"{hold.agent}/{hold.side} hand", time_s, gap)
            for hold, (gap, time_s) in worst.items()
        ]

    def _gap_m(self, hand: np.ndarray, thing: np.ndarray) -> float:
        bodies = self._model.geom_bodyid
        mine, its = (self._solid[which[bodies[self._solid]]].tolist() for which in (hand, thing))
        return min(
            float(mujoco.mj_geomDistance(self._model, self._data, a, b, 10 * HELD_M, None)) for a in mine for b in its
        )

    def strays(self, times_s: Array, qpos: Array, holds: Sequence[frozenset[Hold]]) -> list[Fault]:
        """Things that move although no hand holds them, nor let go of them a moment ago."""
        found = []
        for name, body in self._things.items():
            start = int(self._model.jnt_qposadr[self._model.body_jntadr[body]])
            steps = np.linalg.norm(np.diff(qpos[:, start : start + 3], axis=0), axis=1)
            held = np.array([any(hold.object == name for hold in each) for each in holds])
            last = np.maximum.accumulate(np.where(held, times_s, -np.inf))
            free = times_s[1:] - last[1:] > FALLS_S
            loose = np.where(free, steps, 0.0)
            if len(loose) and loose.max() > STRAY_M:
                index = int(loose.argmax())
                found.append(Fault("stray", name, "", float(times_s[index]), float(loose[index])))
        return found

    def rest(self, times_s: Array, qpos: Array, held: frozenset[Hold]) -> list[Fault]:
        """Whether the thing is still in the end, and stays."""
        body = self._things[self._thing]
        start = int(self._model.jnt_qposadr[self._model.body_jntadr[body]])
        late = qpos[times_s >= times_s[-1] - STILL_S, start : start + 3]
        moved = float(np.linalg.norm(late - late[-1], axis=1).max())
        if moved > STILL_M:
            return [Fault("rest", self._thing, "", float(times_s[-1]), moved)]
        if any(hold.object == self._thing for hold in held):
            return []
        moved, turned = self._fallen(qpos[-1], start)
        if moved > MOVES_M or turned > TURNS_RAD:
            return [Fault("rest", self._thing, "under gravity", float(times_s[-1]), max(moved, turned))]
        return []

    def _fallen(self, positions: Array, start: int) -> tuple[float, float]:
        """How far the thing moves and turns under gravity, with all else fixed where it is."""
        model = copy.deepcopy(self._model)
        self._tell_what_touches(model, self._load)
        model.geom_conaffinity[self._solid] = np.where(self._load[model.geom_bodyid[self._solid]], 2, 1)
        model.opt.timestep, model.opt.gravity[:] = 0.002, (0.0, 0.0, -9.81)
        data = mujoco.MjData(model)
        free = int(model.body_dofadr[self._things[self._thing]])
        of_others = np.setdiff1d(np.arange(model.nv), np.arange(free, free + 6))
        model.dof_armature[of_others] = IMMOVABLE_KG  # else a thing beneath would give way in each step
        mujoco.mj_setConst(model, data)  # contacts are as hard as what meets is heavy: else one sinks into light things
        data.qpos[:] = positions
        for _ in range(round(WATCHED_S / model.opt.timestep)):
            now, speed = data.qpos[start : start + 7].copy(), data.qvel[free : free + 6].copy()
            data.qpos[:], data.qvel[:] = positions, 0.0
            data.qpos[start : start + 7], data.qvel[free : free + 6] = now, speed
            mujoco.mj_step(model, data)
        change = np.zeros(3)
        negated = np.zeros(4)
        mujoco.mju_negQuat(negated, positions[start + 3 : start + 7])
        turn = np.zeros(4)
        mujoco.mju_mulQuat(turn, data.qpos[start + 3 : start + 7], negated)
        mujoco.mju_quat2Vel(change, turn, 1.0)
        moved = float(np.linalg.norm(data.qpos[start : start + 3] - positions[start : start + 3]))
        return moved, float(np.linalg.norm(change))
