"""The slow, obvious twin of the search for the least effort.

It tries every sampled state of every effort level, looks at the whole image, measures every pair of shapes, walks the
floor by relaxing all steps until nothing changes, and only then takes the minimum. It shares with the fast one what
defines the samples (how a head aims, which grasps a surface has, what a posture is), nothing of how they are
searched.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from taskgist.perspective import Ability, view_of
from taskgist.perspective.aim import aimed
from taskgist.perspective.grasp_samples import hand_poses, sample_grasps
from taskgist.perspective.image import pixel_rays
from taskgist.settings import Settings
from taskgist.world import (
    ArmIndices,
    Stage,
    State,
    hand_gap_m,
    holding_of,
    object_points,
    posture_of,
    seat_position,
    with_posture,
)
from taskgist.world.rotations import about_z, multiply, yaw_of

Key = tuple[float, float, float, float]
HEAD, TORSO = ("head_pan", "head_tilt"), ("torso_turn", "torso_lean")
RANGES = {"torso_turn": (-90, 90), "torso_lean": (0, 60)}
NAMES = {"head_pan": "Pan_Head", "head_tilt": "Tilt_Head", "torso_turn": "Turn_Torso", "torso_lean": "Lean_Torso"}


@dataclass(frozen=True, eq=False)
class Candidate:
    state: State
    actions: tuple[str, ...]
    way_m: float
    torso_rad: float
    head_rad: float = 0.0
    merit: float = 0.0
    turned_rad: float = 0.0

    @property
    def key(self) -> Key:
        return round(self.way_m, 6), round(self.turned_rad, 6), round(self.torso_rad, 6), round(self.head_rad, 6)


@dataclass(frozen=True)
class Answer:
    """The least level, its least amount, and the actions of all states that share it."""

    level: int
    amount: Key | None
    actions: frozenset[tuple[str, ...]]


class Twin:
    def __init__(self, stage: Stage, agent: str, name: str, settings: Settings) -> None:
        self.stage, self.settings, self.name = stage, settings, name
        self.agent = stage.scene.agent(agent)
        self.state = stage.state
        self.target = stage.geom_centers(stage.scene.object_geoms(name)).mean(axis=0)
        self.usual = self.depths()
        assert self.agent.profile.hand is not None
        self.hand = self.agent.profile.hand
        self.grasps = sample_grasps(stage, name, self.hand, settings.grasp)
        self.walkable: dict[tuple[int, int], float] | None = None
        self.hands = tuple(side for who, side in self.holding() if who == agent)

    def answer(self, ability: Ability) -> Answer:
        for level in range(5):
            able = [each for each in self.able(ability, level) if self.allowed(each.state)]
            if able:
                best = min((each.key, each.merit) for each in able)
                least = [each for each in able if (each.key, each.merit) == best]
                names = frozenset(each.actions or ("No_Action_Required",) for each in least)
                self.stage.show(self.state)
                return Answer(level, best[0], names)
        self.stage.show(self.state)
        return Answer(5, None, frozenset({("No_Possible_Known_Action",)}))

    # who holds what ------------------------------------------------------------------------------------------

    def holding(self) -> tuple[tuple[str, str], ...]:
        holding = holding_of(self.stage, self.name, self.settings.contact)
        assert holding is not None
        return holding.hands

    # constraints ---------------------------------------------------------------------------------------------

    def depths(self) -> dict[tuple[int, int], float]:
        """How deep each of the agent's core shapes is in each solid shape that it does not hold."""
        scene, grip = self.stage.scene, self.settings.contact.grip_m
        mine = {self.agent.name}
        for name in scene.objects:
            holding = holding_of(self.stage, name, self.settings.contact)
            near = any(hand_gap_m(self.stage, arm, name, limit_m=grip) < grip for arm in self.agent.arms)
            if near and holding and any(who == self.agent.name for who, _ in holding.hands):
                mine.add(name)
        self.solid = [g for g in self.stage.solid_geoms() if scene.owners[g] not in mine]
        return self.measured()

    def measured(self) -> dict[tuple[int, int], float]:
        pairs = itertools.product(map(int, self.agent.core_geoms), map(int, self.solid))
        return {pair: max(0.0, -self.stage.distance(*pair, limit_m=0.01)) for pair in pairs}

    def allowed(self, state: State) -> bool:
        self.stage.show(state)
        limit = self.settings.efforts.collision_m
        return all(depth <= self.usual[pair] + limit for pair, depth in self.measured().items())

    # states --------------------------------------------------------------------------------------------------

    def stances(self, level: int) -> Iterator[Candidate]:
        here = Candidate(self.state, (), 0.0, 0.0)
        if level <= 1:
            yield here
        elif level == 2:
            yield from self.bent(here, turns=True)
        else:
            self.stage.show(self.state)
            posture = posture_of(self.stage, self.agent, self.settings.contact)
            other = self.standing() if posture == "sitting" else self.sitting()
            if level == 3 and other:
                yield from self.bent(other, turns=True)
            if level == 4:
                yield from self.walked(here if posture == "standing" else other)

    def standing(self) -> Candidate:
        return Candidate(with_posture(self.stage, self.agent, "standing"), ("Make_Standing",), 0.0, 0.0)

    def sitting(self) -> Candidate | None:
        x, y = seat_position(self.stage, self.agent)
        things = [g for g, owner in enumerate(self.stage.scene.owners) if owner not in self.stage.scene.agents]
        hit, distance = self.stage.cast((x, y, 2.0), [(0, 0, -1)], only=things)
        height = 2.0 - float(distance[0])
        if hit[0] < 0 or not 0.25 <= height <= 0.70:
            return None
        state = with_posture(self.stage, self.agent, "sitting", seat_height_m=height)
        return Candidate(state, ("Make_Sitting",), 0.0, 0.0)

    def bent(self, start: Candidate, *, turns: bool) -> Iterator[Candidate]:
        efforts = self.settings.efforts
        steps = {"torso_turn": efforts.turn_step_rad, "torso_lean": efforts.lean_step_rad}
        grids = [self.angles(joint, steps[joint]) if turns or joint == "torso_lean" else [None] for joint in TORSO]
        for angles in itertools.product(*grids):
            changes, torso = {}, 0.0
            actions = list(start.actions)
            for joint, angle in zip(TORSO, angles, strict=True):
                index = self.agent.joints[joint]
                if angle is not None and abs(angle - self.state.qpos[index]) > 1e-9:
                    changes[index] = angle
                    torso += abs(angle - float(self.state.qpos[index]))
                    actions.append(NAMES[joint])
            yield Candidate(
                start.state.replace(changes), tuple(actions), start.way_m, torso, turned_rad=start.turned_rad
            )

    def angles(self, joint: str, step: float) -> list[float | None]:
        low, high = map(math.radians, RANGES[joint])
        counts = range(-100, 101)
        return [None, *(count * step for count in counts if low - 1e-9 <= count * step <= high + 1e-9)]

    def walked(self, start: Candidate | None) -> Iterator[Candidate]:
        if start is None or not self.allowed(start.state):
            return
        base = start.state.qpos[self.agent.base]
        turned = float(self.state.qpos[self.agent.joints["torso_turn"]])
        self.walkable = self.walkable or self.ways(start.state)
        for (i, j), way in self.walkable.items():
            x, y = self.spot(base, i, j)
            yaw = math.atan2(self.target[1] - y, self.target[0] - x) - turned
            by = yaw - yaw_of(base[3:])
            turn = multiply(about_z(by), base[3:])
            state = start.state.replace(at=self.agent.base, to=(x, y, base[2], *turn))
            turned_rad = abs(math.remainder(by, 2 * math.pi))
            there = Candidate(state, (*start.actions, "Move_To"), way, 0.0, turned_rad=turned_rad)
            yield from self.bent(there, turns=False)

    def spot(self, base: np.ndarray, i: float, j: float) -> tuple[float, float]:
        yaw, step = yaw_of(base[3:]), self.settings.efforts.move_step_m
        return (
            base[0] + step * (i * math.cos(yaw) - j * math.sin(yaw)),
            base[1] + step * (i * math.sin(yaw) + j * math.cos(yaw)),
        )

    def ways(self, state: State) -> dict[tuple[int, int], float]:
        """Shortest ways to all cells, by relaxing every step until nothing changes."""
        efforts = self.settings.efforts
        reach = math.ceil(efforts.move_radius_m / efforts.move_step_m)
        cells = [
            (i, j)
            for i, j in itertools.product(range(-reach, reach + 1), repeat=2)
            if math.hypot(i, j) * efforts.move_step_m <= efforts.move_radius_m + 1e-9
        ]
        base = state.qpos[self.agent.base]
        half = {(i / 2, j / 2) for i, j in itertools.product(range(-2 * reach, 2 * reach + 1), repeat=2)}
        free = {
            at: self.allowed(state.replace(at=self.agent.base, to=(*self.spot(base, *at), *base[2:]))) for at in half
        }
        ways = {(0, 0): 0.0}
        while True:
            before = dict(ways)
            for (i, j), (di, dj) in itertools.product(cells, itertools.product((-1, 0, 1), repeat=2)):
                end = (i + di, j + dj)
                if (
                    (i, j) in ways
                    and end in cells
                    and (di, dj) != (0, 0)
                    and free[end]
                    and free[i + di / 2, j + dj / 2]
                ):
                    way = ways[i, j] + math.hypot(di, dj) * efforts.move_step_m
                    ways[end] = min(way, ways.get(end, math.inf))
            if ways == before:
                return ways

    # abilities -----------------------------------------------------------------------------------------------

    def able(self, ability: Ability, level: int) -> Iterator[Candidate]:
        if ability == "see":
            for stance in self.stances(level):
                yield from self.heads(stance) if level else self.seen(stance, stance.state, 0.0, ())
        elif level == 0:
            if self.hands:
                yield Candidate(self.state, (), 0.0, 0.0)
        else:
            distance = self.reached if ability == "reach" else self.grasped
            for stance, arm in itertools.product(self.stances(level), self.agent.arms):
                self.stage.show(stance.state)
                found = distance(arm)
                if found is not None:
                    action = f"Stretch_Out_Arm({arm.profile.side})"
                    yield replace(stance, actions=(*stance.actions, action), merit=round(found, 6))

    def heads(self, stance: Candidate) -> Iterator[Candidate]:
        actions = frozenset(NAMES[joint] for joint in HEAD)
        aim = aimed(self.stage, self.agent, stance.state, self.target, actions)
        if not self.gaze_px(stance.state.replace(aim)):
            return
        steps = self.settings.efforts.head_steps
        for step in range(steps + 1):
            now = {i: float(self.state.qpos[i]) for i in aim}
            angles = {i: now[i] + (aim[i] - now[i]) * (step / steps) for i in aim}
            moved = [
                joint for joint in HEAD if abs(angles[self.agent.joints[joint]] - now[self.agent.joints[joint]]) > 1e-9
            ]
            amount = sum(abs(angles[i] - now[i]) for i in aim)
            yield from self.seen(stance, stance.state.replace(angles), amount, tuple(NAMES[joint] for joint in moved))

    def seen(self, stance: Candidate, state: State, head: float, actions: tuple[str, ...]) -> Iterator[Candidate]:
        pixels = self.gaze_px(state)
        if pixels:
            both = (*stance.actions, *actions)
            yield replace(stance, state=state, actions=both, head_rad=head, merit=-float(pixels))

    def gaze_px(self, state: State) -> int:
        """Pixels of the object inside the gaze cone, of the whole image."""
        self.stage.show(state)
        eye = self.agent.profile.eye
        view = view_of(self.stage, self.agent.name)
        in_cone = pixel_rays(eye)[..., 0] >= math.cos(eye.gaze_cone_rad)
        return int((np.isin(view.geoms, self.stage.scene.object_geoms(self.name)) & in_cone).sum())

    def reached(self, arm: ArmIndices) -> float | None:
        points = object_points(self.stage, self.name, self.settings.reach.cell_m)
        return min((d for d in (self.inside(arm, point) for point in points) if d is not None), default=None)

    def inside(self, arm: ArmIndices, point: np.ndarray) -> float | None:
        """Distance from the shoulder of a point in the arm's sector; None outside."""
        x, y, z = self.stage.shoulder(arm).to_local(point)
        outward = math.degrees(math.atan2(-y if arm.profile.side == "right" else y, x))
        up = math.degrees(math.atan2(z, math.hypot(x, y)))
        distance = math.hypot(x, y, z)
        within = distance <= arm.profile.length_m and -60 <= outward <= 120 and -90 <= up <= 80
        return distance if within else None

    def grasped(self, arm: ArmIndices) -> float | None:
        stage, settings, grasps = self.stage, self.settings.grasp, self.grasps
        shoulder = stage.shoulder(arm).position
        best: float | None = None
        for index, center in enumerate(grasps.centers):
            distance = self.inside(arm, center)
            if distance is None or (best is not None and round(distance, 6) >= round(best, 6)):
                continue
            if grasps.approaches[index] @ (center - shoulder) < settings.facing * distance:
                continue
            stage.place_ghosts(arm, hand_poses(grasps, index, self.hand, settings.clearance_m))
            palm = int(arm.ghosts[0])
            pairs = itertools.product(map(int, arm.ghosts), [*self.solid, *self.agent.core_geoms])
            touched = grasps.pairs[index].shapes
            if all(
                stage.distance(ghost, int(other), limit_m=0.01) >= -1e-4
                for ghost, other in pairs
                if ghost == palm or other not in touched
            ):
                best = distance
        return best
