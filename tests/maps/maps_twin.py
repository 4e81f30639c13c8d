"""The slow, obvious twin of ability maps: every cell by itself, every stance, one ray."""

from __future__ import annotations

import math

import mujoco
import numpy as np
from numpy.typing import NDArray

from taskgist.perspective import Ability
from taskgist.settings import Settings
from taskgist.world import Stage
from taskgist.world.geometry.transforms import about_z, multiply, yaw_of
from tests.perspective.twin import Twin
from tests.perspective.twin_states import Candidate
from tests.perspective.twin_world import SEEN_MASK, UNSEEN

Array = NDArray[np.float64]
UP = np.array([0.3, 0.4, math.sqrt(0.75)])
PARTS = {"see": ("head", "head", "head torso", "head torso legs", "head torso legs")}
PARTS["reach"] = ("", "torso", "torso", "torso legs", "torso legs")


class MapTwin:
    """One agent's levels, cell by cell."""

    def __init__(self, stage: Stage, agent: str, settings: Settings) -> None:
        self.twin, self.settings = Twin(stage, agent, settings), settings
        self.agent, self.world, self.states = self.twin.agent, self.twin.world, self.twin.states

    def level(self, ability: Ability, point: Array) -> int:
        if self.solid(point):
            return 5
        for level in range(5):
            parts = [f"{self.agent.name}/{part}" for part in PARTS[ability][level].split()]
            if not self.twin.state.known(parts):
                return -1
            if any(self.able(ability, level, stance, point) for stance in self.stances(level, point)):
                return level
        return 5

    def stances(self, level: int, point: Array) -> list[Candidate]:
        return self.states.stances(level, point)

    def able(self, ability: Ability, level: int, stance: Candidate, point: Array) -> bool:
        if ability == "reach" and level == 0:
            return False
        found = self.sees(level, stance, point) if ability == "see" else self.reaches(stance, point)
        there = self.stepped(stance, point) if level == 4 else stance.qpos
        return found and (level < 2 or self.states.allowed(there, stance.aside))

    def sees(self, level: int, stance: Candidate, point: Array) -> bool:
        qpos = self.twin.aimed(stance.qpos, point) if level else stance.qpos
        self.world.show(qpos)
        data, eye = self.world.data, self.agent.profile.eye
        origin = data.site_xpos[self.agent.eye_site]
        way = point - origin
        ahead, left, up = way @ data.site_xmat[self.agent.eye_site].reshape(3, 3)
        if ahead <= 0 or math.atan2(math.hypot(left, up), ahead) > eye.gaze_cone_rad:
            return False
        if abs(math.atan2(left, ahead)) > eye.fov_rad[0] / 2 or abs(math.atan2(up, ahead)) > eye.fov_rad[1] / 2:
            return False
        length, hit = float(np.linalg.norm(way)), np.zeros(1, dtype=np.int32)
        exclude = self.agent.eye_exclude_body
        met = mujoco.mj_ray(self.world.model, data, origin, way / length, SEEN_MASK, True, exclude, hit)
        return bool(met < 0 or met > length)

    def reaches(self, stance: Candidate, point: Array) -> bool:
        self.world.show(stance.qpos)
        return any(
            np.isfinite(self.twin.within(arm.shoulder_site, arm.carrier_body, arm.profile, point[None])[0])
            for arm in self.agent.arms
        )

    def stepped(self, stance: Candidate, point: Array) -> Array:
        """The stance with the chest turned to the next step from the agent's heading, not quite to the point."""
        base = stance.qpos[self.agent.base]
        heading = yaw_of(self.states.now[self.agent.base][3:])
        exact = math.atan2(point[1] - base[1], point[0] - base[0])
        step = self.settings.efforts.turn_step_rad
        nearest = heading + step * round(round((exact - heading) / step, 9))
        qpos = np.array(stance.qpos)
        qpos[self.agent.base][3:] = multiply(about_z(nearest - exact), base[3:])
        return qpos

    def solid(self, point: Array) -> bool:
        """Whether a point lies in anything convex: it is met both ways."""
        self.world.show(self.states.now)
        return any(self._inside(geom, point) for geom in self.world.solid_geoms([self.agent.name]))

    def _inside(self, geom: int, point: Array) -> bool:
        model, data = self.world.model, self.world.data
        if model.geom_rbound[geom] == 0 or np.linalg.norm(point - data.geom_xpos[geom]) > model.geom_rbound[geom]:
            return False
        groups = np.array(model.geom_group)
        try:
            model.geom_group[:] = UNSEEN
            model.geom_group[geom] = 0
            hit = np.zeros(1, dtype=np.int32)
            return all(mujoco.mj_ray(model, data, point, way, SEEN_MASK, True, -1, hit) >= 0 for way in (UP, -UP))
        finally:
            model.geom_group[:] = groups
