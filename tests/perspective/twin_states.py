"""Every sampled state of every effort level, for the twin: enumerated, never searched."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import mujoco
import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.candidates import THINNED_M, actions_of
from taskgist.perspective.candidates import Candidate as Posture
from taskgist.perspective.constraints import wears
from taskgist.perspective.postures import bends, leaving_seat
from taskgist.settings import Settings
from taskgist.world import Agent, Stage, State, posture_of, seat_position, with_posture
from taskgist.world.bodies.profile import Axis
from taskgist.world.geometry.transforms import about_z, multiply, yaw_of
from tests.perspective.twin_world import SEEN_MASK, World

Array = NDArray[np.float64]
Key = tuple[float, ...]
Cell = tuple[float, float]


@dataclass(frozen=True, eq=False)
class Candidate:
    """A state, what leads there, and how much of it."""

    qpos: Array
    actions: tuple[str, ...] = ()
    way_m: float = 0.0
    turned_rad: float = 0.0
    torso_rad: float = 0.0
    head_rad: float = 0.0
    merit: float = 0.0
    lowered_m: float = 0.0
    bent_rad: float = 0.0
    aside: frozenset[str] = frozenset()

    @property
    def key(self) -> Key:
        bent, turned = (self.lowered_m, self.bent_rad), (self.turned_rad, self.torso_rad, self.head_rad)
        return tuple(round(amount, 6) for amount in (*bent, self.way_m, *turned))


class States:
    """All that one agent might do from one state, and what stops it."""

    def __init__(self, stage: Stage, agent: Agent, settings: Settings, held: frozenset[str]) -> None:
        self.stage, self.agent, self.settings, self.state = stage, agent, settings, stage.state
        self.now: Array = stage.state.qpos
        self.world = World(stage.scene, stage.state)
        self.solid = self.world.solid_geoms({agent.name, *held})
        self.core = [int(geom) for geom in agent.core_geoms]
        self.usual = self.world.depths(self.core, self.solid)
        self._free: dict[tuple[bytes, frozenset[str], float], bool] = {}
        contact = settings.contact
        self.on_body = frozenset(name for name in stage.scene.objects if wears(stage, agent, name, contact))
        self.posture = posture_of(stage, agent, settings.contact)

    def allowed(self, qpos: Array, aside: frozenset[str] = frozenset(), *, passing: bool = False) -> bool:
        """Whether head, torso and base are nowhere deeper in anything than now, by more than the tolerance."""
        efforts = self.settings.efforts
        limit = efforts.passing_m if passing else efforts.collision_m
        key = qpos.tobytes(), aside, limit
        if key not in self._free:
            self.world.show(qpos)
            solid = [geom for geom in self.solid if self.stage.scene.owners[geom] not in aside]
            depths = self.world.depths(self.core, solid)
            self._free[key] = all(depth <= self.usual.get(pair, 0.0) + limit for pair, depth in depths.items())
        return self._free[key]

    def stances(self, level: int, target: Array) -> list[Candidate]:
        """All states of base, legs and torso of a level."""
        here, other, upright = Candidate(self.now), self.other_posture, self.upright
        if level <= 1:
            return [here]
        if level == 2:
            return list(self.bent(here, turns=True))
        crouched = self.crouched(upright) if upright else []
        if level == 3:
            raised = [upright] if upright and self.posture == "sitting" else []
            starts = [*([other] if other else []), *raised, *crouched]
            return [each for start in starts for each in self.bent(start, turns=True)]
        if upright is None or not self.agent.profile.moves:
            return []
        start = self.walker
        crouched = crouched if start is upright else self.crouched(start)
        walked = (self.walked(each, target) for each in (start, *crouched))
        return list(itertools.chain.from_iterable(itertools.chain.from_iterable(walked)))

    # posture -------------------------------------------------------------------------------------------------

    @cached_property
    def other_posture(self) -> Candidate | None:
        self.stage.show(self.state)
        can = self.agent.profile.legs.can
        if "sitting" not in can or "standing" not in can or self.posture is None:
            return None
        if self.posture == "sitting":
            return Candidate(
                with_posture(self.stage, self.agent, "standing").qpos, ("Make_Standing",), aside=self.on_body
            )
        seat = self.seat_m()
        if seat is None:
            return None
        state: State = with_posture(self.stage, self.agent, "sitting", seat_height_m=seat)
        hips = self.agent.base.start + 2
        return Candidate(
            state.qpos, ("Make_Sitting",), lowered_m=float(self.now[hips] - state.qpos[hips]), aside=self.on_body
        )

    @cached_property
    def upright(self) -> Candidate | None:
        """Standing, free of collisions, the seat pushed back if need be."""
        if self.posture == "standing":
            return Candidate(self.now, aside=self.on_body)
        if self.other_posture is None or self.allowed(self.other_posture.qpos, self.on_body):
            return self.other_posture
        return next(self.ways_out(), None)

    def ways_out(self) -> Iterator[Candidate]:
        """Standing, free of collisions, after leaving the seat."""
        actions = frozenset(actions_of(self.agent))
        ways_out = leaving_seat(self.stage.show(self.state), self.agent, self.settings.efforts, actions)
        found = (replace(_of(way), aside=way.aside | self.on_body) for way in ways_out)
        return (each for each in found if self.allowed(each.qpos, each.aside))

    @cached_property
    def walker(self) -> Candidate:
        """Standing where a way leads a metre off, along the seat if need be; else just standing."""
        assert self.upright is not None
        starts = [self.upright] if self.posture == "standing" else [self.upright, *self.ways_out()]
        step_m = self.settings.efforts.move_step_m
        for start in starts:
            if self.posture == "standing" or any(math.hypot(*cell) * step_m >= 1.0 for cell in self.ways_from(start)):
                return start
        return self.upright

    def crouched(self, start: Candidate) -> list[Candidate]:
        """What the legs do from there."""
        standing = Posture(self.state.replace(at=slice(0, len(start.qpos)), to=start.qpos), start.actions)
        actions = frozenset(actions_of(self.agent))
        found = bends(self.stage, self.agent, standing, self.settings.efforts, actions)
        return [replace(_of(each), way_m=start.way_m, aside=start.aside) for each in found]

    def seat_m(self) -> float | None:
        """Height of the topmost thing under the place to sit, from a little over the highest seat; agents are air."""
        lowest, highest = self.settings.efforts.seat_height_m
        top = highest + 0.05
        things = World(self.stage.scene, self.state)
        for geom, owner in enumerate(self.stage.scene.owners):
            if owner in self.stage.scene.agents:
                things.model.geom_group[geom] = 3
        for geom in things.hidden:  # what is not tracked may still be sat on, as long as it is somewhere
            if self.stage.scene.owners[geom] not in self.stage.scene.agents:
                things.model.geom_group[geom] = self.stage.scene.model.geom_group[geom]
        start, down = np.array((*seat_position(self.stage, self.agent), top)), np.array((0.0, 0.0, -1.0))
        hit = np.zeros(1, dtype=np.int32)
        drop = mujoco.mj_ray(things.model, things.data, start, down, SEEN_MASK, True, -1, hit)
        return top - drop if hit[0] >= 0 and lowest <= top - drop <= highest else None

    # torso ---------------------------------------------------------------------------------------------------

    def bent(self, start: Candidate, *, turns: bool) -> Iterator[Candidate]:
        """A state with every turn and lean of the torso."""
        profile, efforts = self.agent.profile, self.settings.efforts
        turned = self.angles(profile.turn if turns else None, efforts.turn_step_rad)
        leaned = self.angles(profile.lean, efforts.lean_step_rad)
        for turn, lean in itertools.product(turned, leaned):
            qpos, torso, actions = np.array(start.qpos), 0.0, list(start.actions)
            for axis, angle, name in ((profile.turn, turn, "Turn_Torso"), (profile.lean, lean, "Lean_Torso")):
                index = self.agent.joints[axis.joint] if axis else -1
                if angle is not None and abs(angle - self.now[index]) > 1e-9:
                    qpos[index] = angle
                    torso += abs(angle - float(self.now[index]))
                    actions.append(name)
            yield replace(start, qpos=qpos, actions=tuple(actions), torso_rad=torso)

    def angles(self, axis: Axis | None, step: float) -> list[float | None]:
        """The present angle, and every multiple of the step in the joint's range."""
        if axis is None:
            return [None]
        low, high = axis.range_rad
        return [None, *(n * step for n in range(-200, 201) if low - 1e-9 * step <= n * step <= high + 1e-9 * step)]

    # floor ---------------------------------------------------------------------------------------------------

    def walked(self, start: Candidate, target: Array) -> Iterator[Iterator[Candidate]]:
        """All places that can be got to, the chest towards the target, with every lean of the torso."""
        base, at = start.qpos[self.agent.base], self.agent.base
        axis = self.agent.profile.turn
        torso = float(self.now[self.agent.joints[axis.joint]]) if axis else 0.0
        for cell, way in self.ways.items():
            x, y = self.spot(base, cell)
            dx, dy = target[0] - x, target[1] - y
            lattice = 4 if math.hypot(dx, dy) > THINNED_M[1] else 2 if math.hypot(dx, dy) > THINNED_M[0] else 1
            if cell[0] % lattice or cell[1] % lattice:
                continue
            by = math.atan2(dy, dx) - torso - yaw_of(base[3:]) if math.hypot(dx, dy) > 1e-6 else 0.0
            qpos = np.array(start.qpos)
            qpos[at] = (x, y, base[2], *multiply(about_z(by), base[3:]))
            turned = abs(math.remainder(by, 2 * math.pi))
            actions, way = (*start.actions, "Move_To"), start.way_m + way
            yield self.bent(replace(start, qpos=qpos, actions=actions, way_m=way, turned_rad=turned), turns=False)

    def spot(self, base: Array, cell: Cell) -> tuple[float, float]:
        yaw, step = yaw_of(base[3:]), self.settings.efforts.move_step_m
        ahead, aside = cell[0] * step, cell[1] * step
        x = base[0] + ahead * math.cos(yaw) - aside * math.sin(yaw)
        return x, base[1] + ahead * math.sin(yaw) + aside * math.cos(yaw)

    @cached_property
    def ways(self) -> dict[Cell, float]:
        """Shortest ways to all cells."""
        return self.ways_from(self.walker)

    def ways_from(self, upright: Candidate) -> dict[Cell, float]:
        """Shortest ways to all cells, by relaxing every step until nothing changes."""
        efforts = self.settings.efforts
        reach = math.ceil(efforts.move_radius_m / efforts.move_step_m)
        around = range(-reach, reach + 1)
        cells: list[Cell] = list(itertools.product(around, around))
        inside = {cell for cell in cells if math.hypot(*cell) * efforts.move_step_m <= efforts.move_radius_m + 1e-9}
        steps = [step for step in itertools.product((-1, 0, 1), repeat=2) if step != (0, 0)]
        ways: dict[Cell, float] = {(0, 0): 0.0}
        before: dict[Cell, float] = {}
        while ways != before:
            before = dict(ways)
            for (i, j), (di, dj) in itertools.product(before, steps):
                end, half = (i + di, j + dj), (i + di / 2, j + dj / 2)
                if end in inside and self.stands(upright, end) and self.stands(upright, half):
                    way = ways[i, j] + math.hypot(di, dj) * efforts.move_step_m
                    ways[end] = min(way, ways.get(end, math.inf))
        return ways

    def stands(self, upright: Candidate, cell: Cell) -> bool:
        base = upright.qpos[self.agent.base]
        there = np.array(upright.qpos)
        there[self.agent.base] = (*self.spot(base, cell), *base[2:])
        return self.allowed(there, upright.aside, passing=True)


def _of(found: Posture) -> Candidate:
    amount = found.amount
    return Candidate(
        found.state.qpos,
        found.actions,
        amount.moved_m,
        lowered_m=amount.lowered_m,
        bent_rad=amount.bent_rad,
        aside=found.aside,
    )
