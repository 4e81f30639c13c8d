"""Grasp: the object is reachable, and at least one collision-free grasp of that hand exists (5.1.3).

A grasp is tried with the shapes of a hand before it closes, and all that they sweep on the last finger's length of its
approach. They must be free of everything solid: the support, other agents' hands, the agent's own head, torso and
legs, and the object itself; only what the fingers close on is touched by design. The agent's own arms do not count,
they are where the virtual action brings them.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.acting.stances import Stances
from taskgist.perspective.acting.standpoint import Standpoint
from taskgist.perspective.acting.virtual_actions import Stance, stretch
from taskgist.perspective.grasping.grasps import Grasps
from taskgist.perspective.grasping.hand import hand_centers, hand_frames
from taskgist.perspective.grasping.samples import sample_grasps
from taskgist.perspective.grasping.touch import TOUCH_M
from taskgist.perspective.judge import Among, Hopeless, Miss, Outcome
from taskgist.perspective.reaching.by_hand import ByHand
from taskgist.perspective.reaching.reach import ReachAmong
from taskgist.perspective.reaching.sector import DIGITS, Cloud, grasps_in_reach
from taskgist.perspective.target import Target
from taskgist.world import ArmIndices, Hand

Array = NDArray[np.float64]
NEVER = -20.0
"""Shortfall of what no stance can change: nothing is more worth telling."""
NAMED = 2
"""Names of what is in the way that a reason tells; the evidence has all of them."""


class Grasp(ByHand):
    """Judges the ability to grasp one object.

    Args:
        here: Whose, and from where.
        target: The object.
    """

    def __init__(self, here: Standpoint, target: Target) -> None:
        super().__init__(here, target)
        self._blocked_by: dict[int, str] = {}
        self._told: Miss | None = None

    def among(self, stances: Stances) -> Among:
        """What the arms can grasp from some stances."""
        if self._agent.profile.hand is not None:
            surface = ReachAmong(self, stances, self.surface)
            if surface.beyond(self._hand.opening_m / 2 + self._here.settings.reach.cell_m):
                return surface  # no grasp is farther from the surface than this: spares sampling them
        if self._impossible is not None:
            return Hopeless(self._impossible, len(stances))
        return GraspAmong(self, stances)

    @cached_property
    def _impossible(self) -> Miss | None:
        """Why no hand of the agent closes on the object at all."""
        hand = self._agent.profile.hand
        if hand is None:
            return Miss(NEVER, "no hand that grasps")
        narrowest_m = self._grasps.narrowest_m
        if narrowest_m is None:
            return Miss(NEVER, "no two opposite faces to close on")
        if narrowest_m > hand.opening_m and not len(self._grasps):
            return Miss(NEVER, f"too wide ({narrowest_m:.2f} m > {hand.opening_m:.2f} m)")
        return None if len(self._grasps) else Miss(NEVER, "too narrow for both fingers to meet it")

    @cached_property
    def _grasps(self) -> Grasps:
        return sample_grasps(self._stage, self.target.name, self._hand, self._here.settings.grasp)

    @property
    def _hand(self) -> Hand:
        assert self._agent.profile.hand is not None
        return self._agent.profile.hand

    def grasped(self, stance: Stance, arm: int, shoulder: Array, carrier: Array) -> Outcome | Miss:
        """The nearest free grasp of an arm from a stance."""
        grasps, facing = self._grasps, self._here.settings.grasp.facing
        order = grasps_in_reach(shoulder, carrier, self.arm(arm), grasps.centers, grasps.approaches, facing)
        to_try = order[self._open[order]].tolist()
        if to_try:
            self._stage.show(stance.state)
        index = next((index for index in to_try if self._free(self.arm(arm), index)), None)
        return self._miss(order.tolist()) if index is None else self._outcome(self.arm(arm), index, shoulder)

    def consult(self) -> None:
        """Note that hands were tried around the object."""
        hand_m = self._hand.opening_m + 2 * self._hand.finger_length_m + sum(self._hand.palm_m)
        self._here.consulted.add_balls(self.target.centers, self.target.radii_m + hand_m)

    @cached_property
    def _open(self) -> NDArray[np.bool_]:
        """Grasps of which nothing but the agent itself is known to be in the way, (n,)."""
        return ~self._grasps.in_itself

    @cached_property
    def cloud(self) -> Cloud:
        """Where grasps are."""
        return Cloud.of(self._grasps.centers)

    def _free(self, arm: ArmIndices, index: int) -> bool:
        """Whether the hand meets nothing; what others block stays blocked from every stance."""
        self._put_hand(arm, index)
        overlaps = self._stage.overlaps(arm.ghosts, self._others)
        met = next((other for _, other, depth_m in overlaps if depth_m > TOUCH_M), None)
        if met is not None:
            self._blocked_by[index], self._open[index] = self._called(met), False
            return False
        return all(depth_m <= TOUCH_M for *_, depth_m in self._stage.overlaps(arm.ghosts, self._agent.core_geoms))

    @cached_property
    def _others(self) -> NDArray[np.intp]:
        """What is in the hand's way besides the object and the agent itself."""
        return np.setdiff1d(self._here.collisions.obstacles, self._grasps.solids)

    def _put_hand(self, arm: ArmIndices, index: int) -> None:
        """Put the shapes of the arm's virtual hand where they are in a grasp."""
        frames, centers = self._hand_places
        self._stage.place(arm.ghosts, centers[index], frames[index])

    @cached_property
    def _hand_places(self) -> tuple[Array, Array]:
        """Axes of the hand, (n, 9), and middles of its boxes, (n, k, 3), in each grasp."""
        return hand_frames(self._grasps).reshape(-1, 9), hand_centers(self._grasps, self._hand)

    def _called(self, geom: int) -> str:
        """Name of an obstacle: another agent's hand is called so."""
        scene = self._stage.scene
        owner = scene.owners[geom]
        if owner in scene.agents and any(geom in arm.hand_geoms for arm in scene.agent(owner).arms):
            return f"{owner}'s hand"
        return owner

    def _outcome(self, arm: ArmIndices, index: int, shoulder: Array) -> Outcome:
        grasps, side = self._grasps, arm.profile.side
        distance_m = float(np.linalg.norm(grasps.centers[index] - shoulder))
        return Outcome(
            actions=(stretch(side),),
            merit=round(distance_m, DIGITS),
            evidence=lambda: {
                "arm": side,
                "hand": self._hand.kind,
                "point_m": grasps.centers[index].tolist(),
                "distance_m": distance_m,
                "width_m": float(grasps.widths_m[index]),
                "closing": grasps.closings[index].tolist(),
                "approach": grasps.approaches[index].tolist(),
            },
        )

    def _miss(self, tried: list[int]) -> Miss:
        """Why none of the grasps that an arm reaches is free."""
        if not tried:
            return Miss(-1.0, "could only be grasped from behind")
        if self._told is None:
            self._told = self._blocked_miss(tried)
        return self._told

    def _blocked_miss(self, tried: list[int]) -> Miss:
        """What is in the way of which grasps."""
        itself = dict.fromkeys(np.flatnonzero(self._grasps.in_itself).tolist(), self.target.name)
        met = Counter((itself | self._blocked_by).get(index, self._agent.name) for index in tried)
        names = sorted(met, key=lambda name: (-met[name], name))
        telling = [name for name in names if name != self.target.name] or names  # it is always in its own way somewhere
        counted = [f"{name} ({met[name]} of {len(tried)})" for name in telling] if len(telling) > 1 else telling
        why = f"every approach blocked by {' and '.join(counted[:NAMED])}"
        return Miss(-2.0, why, lambda: {"approaches": {name: met[name] for name in names}})


class GraspAmong:
    """Where an arm reaches some grasp of the object, from n stances."""

    def __init__(self, grasp: Grasp, stances: Stances) -> None:
        self._grasp, self._stances = grasp, stances
        grasp.consult()
        self._reach = ReachAmong(grasp, stances, grasp.cloud)
        self.hopeful: NDArray[np.bool_] = self._reach.hopeful

    def outcomes(self, index: int) -> Iterator[Outcome | Miss]:
        """The arms that can grasp the object, the nearer grasp first; or the nearest miss."""
        stance, placed = self._stances[index], self._stances.placed
        results = [
            self._grasp.grasped(stance, arm, placed.shoulders[index, arm], placed.carriers[index, arm])
            for arm in self._reach.able(index)
        ]
        outcomes = [result for result in results if isinstance(result, Outcome)]
        yield from sorted(outcomes, key=lambda outcome: outcome.merit)
        if not outcomes:
            yield min(result for result in results if isinstance(result, Miss))

    def miss(self) -> Miss:
        """Why no grasp is reached from the hopeless stances."""
        return self._reach.miss()
