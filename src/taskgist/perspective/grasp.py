"""Grasp: the object is reachable, and at least one collision-free grasp of that hand exists (5.1.3).

A grasp is tried with the shapes of a hand before it closes. They must be free of everything solid: the support, other
agents' hands, the agent's own head, torso and legs, and the object's other shapes; the two that the fingers close on
are touched by design. The agent's own arms do not count, they are where the virtual action brings them.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from functools import cached_property

import numpy as np

from taskgist.perspective.by_hand import ByHand
from taskgist.perspective.grasp_samples import Grasps, hand_poses, sample_grasps
from taskgist.perspective.judge import Miss, Outcome, best_first
from taskgist.perspective.sector import ROUNDING, within_reach
from taskgist.perspective.standpoint import Standpoint
from taskgist.perspective.virtual_actions import Stance, stretch
from taskgist.world import ArmIndices, Hand

NEVER = -20.0
"""Shortfall of what no stance can change: nothing is more worth telling."""
TOUCH_M = 1e-4
"""Overlaps below this are touches: they do not depend on how the scene is turned."""


class Grasp(ByHand):
    """Judges the ability to grasp one object.

    Args:
        here: Whose, and from where.
        name: The object.
    """

    def __init__(self, here: Standpoint, name: str) -> None:
        super().__init__(here, name)
        self._blocked_by: dict[int, str] = {}

    def from_stance(self, stance: Stance) -> Iterator[Outcome | Miss]:
        """The arms that can grasp the object, the nearer shoulder's first."""
        impossible = self._impossible
        if impossible is not None:
            yield impossible
            return
        self._stage.show(stance.state)
        yield from best_first(self._grasped(arm, stance) for arm in self._arms)

    @cached_property
    def _impossible(self) -> Miss | None:
        """Why no hand of the agent closes on the object at all."""
        hand = self._agent.profile.hand
        if hand is None:
            return Miss(NEVER, "no hand that grasps")
        if self._grasps.narrowest_m is None:
            return Miss(NEVER, "no two opposite faces to close on")
        if not self._grasps.pairs:
            return Miss(NEVER, f"too wide ({self._grasps.narrowest_m:.2f} m > {hand.opening_m:.2f} m)")
        return None

    @cached_property
    def _grasps(self) -> Grasps:
        return sample_grasps(self._stage, self._name, self._hand, self._here.settings.grasp)

    @property
    def _hand(self) -> Hand:
        assert self._agent.profile.hand is not None
        return self._agent.profile.hand

    def _grasped(self, arm: ArmIndices, stance: Stance) -> Outcome | Miss:
        shoulder = self._stage.shoulder(arm)
        reached = within_reach(shoulder, arm.profile, self._grasps.centers)
        if not reached.inside.any():
            return reached.miss(arm.profile)
        facing = np.einsum("ij,ij->i", self._grasps.approaches, self._grasps.centers - shoulder.position)
        in_front = facing >= self._here.settings.grasp.facing * reached.distances_m - ROUNDING
        order = [int(index) for index in reached.nearest_first() if in_front[index]]
        for index in order:
            if self._free(arm, index):
                return self._outcome(arm, stance, index, float(reached.distances_m[index]))
        return self._miss(order)

    def _outcome(self, arm: ArmIndices, stance: Stance, index: int, distance_m: float) -> Outcome:
        pair, approach, side = self._grasps.pairs[index], self._grasps.approaches[index], arm.profile.side
        return Outcome(
            stance.state,
            (stretch(side),),
            merit=round(distance_m, 6),
            evidence=lambda: {
                "arm": side,
                "point_m": pair.center.tolist(),
                "distance_m": distance_m,
                "width_m": pair.width_m,
                "closing": pair.closing.tolist(),
                "approach": approach.tolist(),
            },
        )

    def _free(self, arm: ArmIndices, index: int) -> bool:
        """Whether the hand meets nothing; what others block stays blocked from every stance."""
        if index in self._blocked_by:
            return False
        poses = hand_poses(self._grasps, index, self._hand, self._here.settings.grasp.clearance_m)
        self._stage.place_ghosts(arm, poses)
        met = self._meets(arm, index)
        if met is not None:
            self._blocked_by[index] = met
            return False
        return all(depth <= TOUCH_M for *_, depth in self._stage.overlaps(arm.ghosts, self._agent.core_geoms))

    def _meets(self, arm: ArmIndices, index: int) -> str | None:
        """What the hand meets besides the agent itself and the two shapes that the fingers close on."""
        palm = int(arm.ghosts[0])
        touched = self._grasps.pairs[index].shapes
        for ghost, other, depth_m in self._stage.overlaps(arm.ghosts, self._here.collisions.obstacles):
            if depth_m > TOUCH_M and (ghost == palm or other not in touched):
                return self._called(other)
        return None

    def _called(self, geom: int) -> str:
        """Name of an obstacle: another agent's hand is called so."""
        scene = self._stage.scene
        owner = scene.owners[geom]
        if owner in scene.agents and any(geom in arm.hand_geoms for arm in scene.agent(owner).arms):
            return f"{owner}'s hand"
        return owner

    def _miss(self, tried: list[int]) -> Miss:
        if not tried:
            return Miss(-1.0, "could only be grasped from behind")
        met = Counter(self._blocked_by.get(index, self._agent.name) for index in tried)
        by = " and ".join(sorted(met, key=lambda name: (-met[name], name))[:2])
        return Miss(-2.0, f"every approach blocked by {by}")
