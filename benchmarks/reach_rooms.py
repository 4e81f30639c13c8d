"""How good levels of reach are in rooms: beside inverse kinematics with collisions, from the same stances.

    python -m benchmarks.reach_rooms [--rooms 12] [--stances 10] [--starts 8]

In each room people and things at random are paired. The witness asks level by level: from some stances of the level,
evenly among those whose torso is free and whose shoulders are near enough, whether inverse kinematics on the arm's real
joints, from several starts, brings the palm to within half a cell of a point of the thing, and to within ``touch_m`` of
it while no shape of the arm is deeper than a centimetre in anything and no ray from hand to palm and from there to the
point meets anything, all by MuJoCo.
It may miss what it did not try, so where it finds nothing at the level that we say, it is asked once more there, from
ten times as many stances; what it finds is there.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterator
from functools import partial

import numpy as np
from numpy.typing import NDArray

from benchmarks.ik import ArmIK
from benchmarks.rooms import furnished
from taskgist.perspective import Viewpoint, effort_from
from taskgist.perspective.candidates import thrust_of
from taskgist.settings import DEFAULT
from taskgist.world import ArmIndices, Stage, State

Array = NDArray[np.float64]
NEAR_M, TOUCH_M = DEFAULT.reach.cell_m / 2, DEFAULT.reach.touch_m
FAR_M = 0.75
"""No shoulder of a person up to 1.9 m reaches farther."""
POINTS = 3
"""Points of a thing that are tried: its nearest, and others spread by their distance."""
PEOPLE, THINGS = 3, 24
AGAIN = 10
"""How many times as many stances are tried where the witness finds nothing at our level."""


class Witness:
    """Asks inverse kinematics for one agent and one thing.

    Args:
        here: The agent's viewpoint.
        name: The thing.
        stances: How many stances of a level are tried.
        starts: Of the inverse kinematics.
    """

    def __init__(self, here: Viewpoint, name: str, *, stances: int, starts: int) -> None:
        self._here, self._name, self._stances, self._starts = here, name, stances, starts
        own = here.stage.scene.geoms_of(name)
        self._others = here.collisions.obstacles[~np.isin(here.collisions.obstacles, own)]
        self._points = here.target(name).points

    def finds(self, level: int) -> bool:
        """Whether an arm reaches the thing from one of the stances of a level."""
        return any(self._reached(state, level) for state in self._of(level))

    def level(self) -> int:
        """The least level from whose stances an arm reaches the thing; 0 if it is held."""
        if self._name in self._here.held:
            return 0
        return next((level for level in range(1, 5) if self.finds(level)), 5)

    def _of(self, level: int) -> Iterator[State]:
        here, found = self._here, []
        for candidates in here.candidates.of_level(level, here.target(self._name).middle):
            for index in range(len(candidates)):
                shoulders = candidates.frames(index)[candidates.torso.frames.first_shoulder :, :3]
                if np.linalg.norm(self._points[:, None] - shoulders, axis=2).min() <= FAR_M:
                    found.append((candidates, index))
        for chosen in np.unique(np.linspace(0, len(found) - 1, self._stances).round().astype(int)) if found else ():
            candidates, index = found[int(chosen)]
            state = candidates[index].state
            if level <= 1 or here.collisions.blocking(state) is None:
                yield state

    def _reached(self, state: State, level: int) -> bool:
        arms = self._here.agent.arms
        return any(self._brought(state, arm) for arm in arms) or (
            level > 1 and any(self._brought(state, arm, thrust=True) for arm in arms if arm.profile.thrust)
        )

    def _brought(self, state: State, arm: ArmIndices, *, thrust: bool = False) -> bool:
        """Whether an arm gets to the thing, its shoulder at rest or thrust forward."""
        here, scene, agent = self._here, self._here.stage.scene, self._here.agent
        if thrust:
            state = state.replace(thrust_of(agent, arm, state))
        shoulder = here.stage.show(state).shoulder(arm).position
        away = np.linalg.norm(self._points - shoulder, axis=1)
        order = np.argsort(away)
        order = order[away[order] <= FAR_M]
        if not len(order):
            return False
        ik = ArmIK(scene, state, agent, arm, starts=self._starts)
        for point in self._points[order[np.unique(np.linspace(0, len(order) - 1, POINTS).astype(int))]]:
            free = partial(self._free, state, arm, point)
            if ik.gap_m(point, enough_m=NEAR_M) <= NEAR_M and ik.brings(point, enough_m=TOUCH_M, free=free):
                return True
        return False

    def _free(self, state: State, arm: ArmIndices, point: Array, qpos: Array) -> bool:
        stage = self._here.stage.show(state.replace(dict(enumerate(qpos.tolist()))))
        palm, hand = stage.site(arm.palm_site).position, stage.geom_centers(arm.hand_geoms).mean(axis=0)
        if any(True for _ in stage.overlaps(arm.geoms, self._others, deeper_than_m=DEFAULT.efforts.collision_m)):
            return False
        for start, end in ((hand, palm), (palm, point)):
            way = end - start
            length_m = float(np.linalg.norm(way))
            geoms, distances = stage.cast(start, way[None] / max(length_m, 1e-9), only=self._others)
            if geoms[0] >= 0 and distances[0] < length_m:
                return False
        return True


def main() -> None:
    """Print how often levels are the same, and which differ."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rooms", type=int, default=12)
    parser.add_argument("--pairs", type=int, default=8, help="of each room")
    parser.add_argument("--stances", type=int, default=10)
    parser.add_argument("--starts", type=int, default=8)
    chosen = parser.parse_args()
    counts: Counter[tuple[int | None, int]] = Counter()
    for seed in range(chosen.rooms):
        stage, rng = Stage(furnished(PEOPLE, THINGS, seed=seed)), np.random.default_rng(seed)
        for _ in range(chosen.pairs):
            here = Viewpoint(stage.show(stage.scene.initial), str(rng.choice(stage.scene.agents)), DEFAULT)
            name = str(rng.choice(stage.scene.objects))
            ours = effort_from(here, name, "reach").level
            theirs = Witness(here, name, stances=chosen.stances, starts=chosen.starts).level()
            if ours is not None and 0 < ours < theirs:
                again = Witness(here, name, stances=AGAIN * chosen.stances, starts=chosen.starts)
                theirs = ours if again.finds(ours) else theirs
            counts[ours, theirs] += 1
            if ours != theirs:
                print(f"room {seed}: {here.agent.name}, {name}: {ours}, by inverse kinematics {theirs}")
    same = sum(count for (ours, theirs), count in counts.items() if ours == theirs)
    print(f"{same} of {counts.total()} levels are the same ({100 * same / counts.total():.0f} %): {dict(counts)}")


if __name__ == "__main__":
    main()
