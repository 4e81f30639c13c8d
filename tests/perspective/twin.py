"""The slow, obvious twin of the search for the least effort.

It tries every sampled state of every effort level, looks at the whole image, measures every pair of shapes, walks the
floor by relaxing all steps until nothing changes, and only then takes the minimum. It asks MuJoCo itself. With the
fast one it shares what defines the samples (which grasps a surface has, what a posture is, who holds what), nothing
of how they are searched.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from taskgist.perspective import Ability, Effort
from taskgist.settings import Settings
from taskgist.world import Arm, Holding, Stage, holding_of, object_points
from tests.perspective.twin_grasp import TwinGrasps
from tests.perspective.twin_states import Array, Candidate, Key, States

Joints = tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class Answer:
    """The least level (None: unknown), its least amount, and actions and joints of all states that share it."""

    level: int | None
    amount: Key | None = None
    attained: frozenset[tuple[tuple[str, ...], Joints]] = frozenset()


class Twin:
    """One agent in the state that a stage shows.

    Args:
        stage: The scene in a state; shows it again after each answer.
        agent: Whose efforts.
        settings: All settings.
    """

    def __init__(self, stage: Stage, agent: str, settings: Settings) -> None:
        self.stage, self.settings, self.state = stage, settings, stage.state
        self.agent = stage.scene.agent(agent)
        held = {name for name in stage.scene.objects if agent in _holders(self._holding(name))}
        self.states = States(stage, self.agent, settings, frozenset(held))
        self.world = self.states.world
        self._gaze_px: dict[tuple[bytes, str], float] = {}
        self._grasps: dict[str, TwinGrasps] = {}

    def answer(self, name: str, ability: Ability) -> Answer:
        """The least effort of an ability towards an object."""
        try:
            return self._answer(name, ability)
        finally:
            self.stage.show(self.state)

    def _answer(self, name: str, ability: Ability) -> Answer:
        if not self.state.known([name]):
            return Answer(None)
        for level in range(5):
            if self._unknown(name, ability, level):
                return Answer(None)
            if level > 2 and name in self.states.on_body:
                continue
            able = [each for each in self._able(name, ability, level) if self.states.allowed(each.qpos, each.aside)]
            if able:
                best = min((each.key, each.merit) for each in able)
                least = [each for each in able if (each.key, each.merit) == best]
                return Answer(level, best[0], frozenset(self._attained(each) for each in least))
        return Answer(5, None, frozenset({(("No_Possible_Known_Action",), self._joints(self.state.qpos))}))

    def _attained(self, found: Candidate) -> tuple[tuple[str, ...], Joints]:
        return found.actions or ("No_Action_Required",), self._joints(found.qpos)

    def _joints(self, qpos: Array) -> Joints:
        p = self.agent.profile
        names = [axis.joint for axis in (p.pan, p.tilt, p.turn, p.lean) if axis]
        return tuple((name, round(float(qpos[self.agent.joints[name]]), 6)) for name in sorted(names))

    # what is known -------------------------------------------------------------------------------------------

    def _unknown(self, name: str, ability: Ability, level: int) -> bool:
        me = self.agent.name
        parts = (*(["head"] if ability == "see" else []), *(["torso"] if level > 1 else []))
        parts = (*parts, *(["legs"] if level > 2 else []))
        if ability != "see" and level == 0:
            return self._may_hold(name)
        if ability != "see" and level == 1:
            parts = ("torso",)
        return not self.state.known([f"{me}/{part}" for part in parts])

    def _may_hold(self, name: str) -> bool:
        """Whether an untracked hand of the agent, near enough, might hold what rests on nothing."""
        holding = self._holding(name)
        assert holding is not None
        if self.agent.name in _holders(holding) or holding.support or holding.container:
            return False
        points = object_points(self.stage, name, self.settings.reach.cell_m)
        return any(
            not self.state.known([f"{self.agent.name}/{arm.profile.side}_arm", self.agent.name])
            and np.linalg.norm(points - self.stage.shoulder(arm).position, axis=1).min() <= 1.25 * arm.profile.length_m
            for arm in self.agent.arms
        )

    def _holding(self, name: str) -> Holding | None:
        return holding_of(self.stage.show(self.state), name, self.settings.contact)

    # abilities -----------------------------------------------------------------------------------------------

    def _able(self, name: str, ability: Ability, level: int) -> Iterator[Candidate]:
        """All states of a level in which the ability holds, collisions left aside."""
        if ability == "see":
            return self._seen(name, level)
        if level == 0:
            return iter([Candidate(self.state.qpos)] if self.agent.name in _holders(self._holding(name)) else [])
        return self._reached(name, level) if ability == "reach" else self._grasped(name, level)

    def _seen(self, name: str, level: int) -> Iterator[Candidate]:
        target = self._middle(name)
        for stance in self.states.stances(level, target):
            for each in self._heads(name, stance, target) if level else [stance]:
                pixels = self.gaze_px(name, each.qpos)
                if pixels:
                    yield replace(each, merit=-pixels)

    def _heads(self, name: str, stance: Candidate, target: Array) -> Iterator[Candidate]:
        """The head at equal steps from where it is to where it aims; nothing where aiming does not help."""
        aim = self.aimed(stance.qpos, target)
        if not self.gaze_px(name, aim):
            return
        p, steps = self.agent.profile, self.settings.efforts.head_steps
        for step in range(steps + 1):
            qpos = stance.qpos + (aim - stance.qpos) * (step / steps)
            actions, amount = list(stance.actions), 0.0
            for axis, action in ((p.pan, "Pan_Head"), (p.tilt, "Tilt_Head")):
                if axis is not None:
                    by = abs(
                        float(qpos[self.agent.joints[axis.joint]] - self.state.qpos[self.agent.joints[axis.joint]])
                    )
                    amount += by
                    actions += [action] if by > 1e-9 else []
            yield replace(stance, qpos=qpos, actions=tuple(actions), head_rad=amount)

    def aimed(self, qpos: Array, target: Array) -> Array:
        """Pan and tilt turn in turn, twice, to where the eye looks at the target, as far as their ranges allow."""
        p, data = self.agent.profile, self.world.data
        qpos = np.array(qpos)
        for axis in (p.pan, p.tilt, p.pan, p.tilt):
            if axis is None:
                continue
            self.world.show(qpos)
            joint = self.world.model.joint(f"{self.agent.name}/{axis.joint}").id
            index = self.agent.joints[axis.joint]
            about = data.xaxis[joint]
            ahead = data.site_xmat[self.agent.eye_site].reshape(3, 3)[:, 0]
            there = target - data.site_xpos[self.agent.eye_site]
            flat = ahead - about * (about @ ahead), there - about * (about @ there)
            by = math.atan2(about @ np.cross(*flat), flat[0] @ flat[1])
            now = float(self.state.qpos[index])
            low, high = min(axis.range_rad[0], now), max(axis.range_rad[1], now)
            qpos[index] = np.clip(qpos[index] + by, low, high)
        return qpos

    def gaze_px(self, name: str, qpos: Array) -> float:
        """Pixels of the object inside the gaze cone; none if it is too small to be made out."""
        key = (qpos.tobytes(), name)
        if key not in self._gaze_px:
            self.world.show(qpos)
            found, cone_rad = (
                self.world.look(self.agent, name, self.settings.vision),
                self.agent.profile.eye.gaze_cone_rad,
            )
            mine = np.isin(found.geoms, self.world.seen_geoms(name)) & (found.rays[:, 0] >= math.cos(cone_rad))
            self._gaze_px[key] = found.count(mine, self.settings.vision)
        return self._gaze_px[key]

    def _reached(self, name: str, level: int) -> Iterator[Candidate]:
        self.stage.show(self.state)
        points = object_points(self.stage, name, self.settings.reach.cell_m)
        for stance in self.states.stances(level, self._middle(name)):
            self.world.show(stance.qpos)
            for arm in self.agent.arms:
                distances = self.within(arm.shoulder_site, arm.carrier_body, arm.profile, points)
                if np.isfinite(distances).any():
                    yield _stretched(stance, (arm.profile.side,), float(distances.min()))

    def _grasped(self, name: str, level: int) -> Iterator[Candidate]:
        if self.agent.profile.hand is None:
            return
        if name not in self._grasps:
            self._grasps[name] = TwinGrasps(self, name)
        grasps = self._grasps[name]
        for stance in self.states.stances(level, self._middle(name)):
            self.world.show(stance.qpos)
            for sides, distance in grasps.found():
                yield _stretched(stance, sides, distance)

    def within(self, shoulder_site: int, carrier: int, arm: Arm, points: Array) -> Array:
        """Distance from the shoulder of each point in the arm's sector, infinite outside, (n,)."""
        data = self.world.data
        x, y, z = ((points - data.site_xpos[shoulder_site]) @ data.xmat[carrier].reshape(3, 3)).T
        azimuth = np.arctan2(-y if arm.side == "right" else y, x)
        elevation = np.arctan2(z, np.hypot(x, y))
        distances = np.linalg.norm((x, y, z), axis=0)
        inside = distances <= arm.length_m + 1e-9
        for angle, (low, high) in ((azimuth, arm.azimuth_rad), (elevation, arm.elevation_rad)):
            inside &= (angle >= low - 1e-9) & (angle <= high + 1e-9)
        return np.where(inside, distances, np.inf)

    def _middle(self, name: str) -> Array:
        self.world.show(self.state.qpos)
        return self.world.middle(name)


def _stretched(stance: Candidate, sides: tuple[str, ...], distance: float) -> Candidate:
    actions = (*stance.actions, *(f"Stretch_Out_Arm({side})" for side in sides))
    return replace(stance, actions=actions, merit=round(distance, 6))


def _holders(holding: Holding | None) -> tuple[str, ...]:
    return tuple(agent for agent, _ in holding.hands) if holding else ()


def disagreement(fast: Effort, slow: Answer) -> str | None:
    """Where two answers differ, for people; None where they agree."""
    amount = fast.amount and fast.amount.key
    if fast.level != slow.level or amount != slow.amount:
        return f"fast says level {fast.level}, amount {amount}; slow says level {slow.level}, amount {slow.amount}"
    joints = tuple((name, round(angle, 6)) for name, angle in sorted(fast.joints_rad.items()))
    if fast.level is None or (fast.actions, joints) in slow.attained:
        return None
    return f"fast does {fast.actions} to {joints}; slow finds best {sorted(slow.attained)}"
