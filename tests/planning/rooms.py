"""Rooms for planning: two tables, a thing on one of them, a robot; and a judge of collisions that shares no code."""

from __future__ import annotations

import mujoco
import numpy as np

from taskgist.common.arrays import Array
from taskgist.world import Scene
from tools.rooms import Person, Room, Shape, Thing

TABLE_M = 0.72


def table(name: str, x: float, y: float = 0.0, height: float = TABLE_M) -> Thing:
    return Thing(name, (0.35, 0.5, 0.02), (x, y, height - 0.02), free=False)


def box(x: float, y: float = 0.0, half: tuple[float, float, float] = (0.025, 0.025, 0.025)) -> Thing:
    return Thing("box", half, (x, y, TABLE_M + half[2]))


def mug(x: float, y: float = 0.0) -> Thing:
    """Four walls and a bottom, and a handle."""
    wide, thin, high = 0.035, 0.004, 0.05
    walls = [Shape("box", (thin / 2, wide, high), (sign * (wide - thin / 2), 0, 0)) for sign in (1, -1)]
    walls += [Shape("box", (wide, thin / 2, high), (0, sign * (wide - thin / 2), 0)) for sign in (1, -1)]
    bottom = Shape("box", (wide, wide, thin / 2), (0, 0, thin / 2 - high))
    ears = [Shape("box", (0.015, 0.005, 0.005), (wide + 0.013, 0, sign * 0.025)) for sign in (1, -1)]
    handle = Shape("box", (0.004, 0.005, 0.03), (wide + 0.027, 0, 0))
    return Thing("mug", (0.03, 0.05), (x, y, TABLE_M + high), shapes=(bottom, *walls, *ears, handle))


def tape(x: float, y: float = 0.0) -> Thing:
    """A roll of tape that lies flat, its hole up; round about."""
    outer, thick, half = 0.042, 0.016, 0.012
    sides = [Shape("box", (thick / 2, outer, half), (sign * (outer - thick / 2), 0, 0)) for sign in (1, -1)]
    sides += [Shape("box", (outer, thick / 2, half), (0, sign * (outer - thick / 2), 0)) for sign in (1, -1)]
    return Thing("tape", (0.03, 0.05), (x, y, TABLE_M + half), shapes=tuple(sides))


def cover(x: float, y: float = 0.0) -> Thing:
    """A heavy box without a bottom that stands over something."""
    half, high, thin = 0.11, 0.05, 0.005
    walls = [Shape("box", (thin, half, high), (sign * half, 0, 0)) for sign in (1, -1)]
    walls += [Shape("box", (half, thin, high), (0, sign * half, 0)) for sign in (1, -1)]
    lid = Shape("box", (half, half, thin), (0, 0, high))
    return Thing("cover", (half,) * 3, (x, y, TABLE_M + high), free=False, shapes=(*walls, lid))


def room(profile: str, *things: Thing, at: tuple[float, float] = (0.0, 0.0), yaw: float = 0.0) -> Scene:
    """A scene of a robot ``R`` with things."""
    built = Room(things, (Person("R", at, yaw, profile=profile),))
    spec = mujoco.MjSpec.from_string(built.files()["room.xml"].decode())
    return Scene.from_spec(spec, [person.entry() for person in built.people])


def two_tables(profile: str, thing: Thing, *more: Thing) -> Scene:
    """One table ahead, with the thing, and one behind."""
    return room(profile, table("table", 1.7), table("shelf", -1.2, 1.0), thing, *more)


# --- The judge: MuJoCo alone, all pairs, no boxes, no sampling.


class Judge:
    """How deep a robot, and what it holds, are in anything, by MuJoCo's distances and a filter made by hand.

    Pairs do not count that are of one body, of neighbours, or of one hand; and own pairs that overlap at the start.
    What overlaps with others there counts where it is deeper.
    """

    def __init__(self, scene: Scene, agent: str = "R") -> None:
        self._scene, self._model = scene, scene.model
        self._data = mujoco.MjData(scene.model)
        model = scene.model
        prefix = f"{agent}/"
        touching = [g for g in range(model.ngeom) if model.geom_contype[g] or model.geom_conaffinity[g]]
        self._own = [g for g in touching if model.body(model.geom_bodyid[g]).name.startswith(prefix)]
        self._others = [g for g in touching if g not in self._own]
        self._hands = [
            {g for g in self._own if self._hangs_on(int(model.geom_bodyid[g]), arm.hand_body)}
            for arm in scene.agent(agent).arms
        ]
        at_start = self._pairs(scene.initial.qpos, frozenset())
        own = set(self._own)
        self._usual = {pair: np.inf if {*pair} <= own else self._depth_m(*pair) for pair in at_start}

    def deepest(self, qpos: Array, held: str | None = None) -> tuple[float, str]:
        """The deepest overlap that is not usual, metres, and what it is between.

        Args:
            qpos: All positions, (nq,).
            held: A thing whose contact with hands does not count, and whose others do.
        """
        load = frozenset() if held is None else frozenset(self._scene.solid_geoms_of(held).tolist())
        found = (0.0, "")
        for pair in self._pairs(qpos, load):
            beyond = self._depth_m(*pair) - self._usual.get(pair, 0.0)
            if beyond > found[0]:
                names = [self._model.body(self._model.geom_bodyid[g]).name for g in pair]
                found = (beyond, " and ".join(names))
        return found

    def _pairs(self, qpos: Array, load: frozenset[int]) -> list[tuple[int, int]]:
        self._data.qpos[:] = qpos
        mujoco.mj_kinematics(self._model, self._data)
        hands = set().union(*self._hands)
        pairs = [(a, b) for a in self._own for b in self._others if not (b in load and a in hands)]
        pairs += [(a, b) for i, a in enumerate(self._own) for b in self._own[i + 1 :] if self._counts(a, b)]
        pairs += [(a, b) for a in load for b in self._others if b not in load]
        return [pair for pair in pairs if self._depth_m(*pair) > 0.0]

    def _depth_m(self, a: int, b: int) -> float:
        apart = self._data.geom_xpos[a] - self._data.geom_xpos[b]
        model = self._model
        radii = model.geom_rbound[[a, b]]
        if radii.all() and np.linalg.norm(apart) > radii.sum():
            return 0.0
        return float(-min(0.0, mujoco.mj_geomDistance(model, self._data, a, b, 0.0, None)))

    def _counts(self, a: int, b: int) -> bool:
        model = self._model
        if any(a in hand and b in hand for hand in self._hands):
            return False
        first, second = (int(model.body_weldid[model.geom_bodyid[g]]) for g in (a, b))
        parents = [int(model.body_weldid[model.body_parentid[body]]) for body in (first, second)]
        return first != second and first != parents[1] and second != parents[0]

    def _hangs_on(self, body: int, hand: int) -> bool:
        while body not in (hand, 0):
            body = int(self._model.body_parentid[body])
        return body == hand
