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
from taskgist.perspective.grasping.hand import Hands
from taskgist.perspective.grasping.samples import grasps_in_object
from taskgist.perspective.grasping.tries import Tries
from taskgist.perspective.judge import Among, Hopeless, Miss, Outcome, Why
from taskgist.perspective.reaching.by_hand import ByHand
from taskgist.perspective.reaching.reach import ReachAmong
from taskgist.perspective.reaching.sector import DIGITS, Cloud, grasps_in_reach
from taskgist.perspective.target import Target
from taskgist.world import ArmIndices, Hand, Pose

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
        self._told: Miss | None = None

    def among(self, stances: Stances) -> Among:
        """What the arms can grasp from some stances."""
        if self._agent.profile.hand is not None:
            surface = ReachAmong(self, stances, self.surface)
            if surface.beyond(self._hand.opening_m / 2 + self._here.settings.reach.cell_m):
                return surface  # no grasp is farther from the surface than this: spares sampling them
        if self._impossible is not None:
            return Hopeless(self._impossible)
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
    def _in_object(self) -> Grasps:
        """Grasps in the object's frame."""
        return grasps_in_object(self._stage, self.target.name, self._hand, self._here.settings.grasp)

    @cached_property
    def _grasps(self) -> Grasps:
        """The same where the object is."""
        return self._in_object.placed(self._object_in_world)

    @property
    def _object_in_world(self) -> Pose:
        return self._stage.body(self._stage.scene.object_body(self.target.name))

    @property
    def _hand(self) -> Hand:
        assert self._agent.profile.hand is not None
        return self._agent.profile.hand

    def grasped(self, stance: Stance, arm: int, shoulder: Array) -> Outcome | Miss:
        """The nearest free grasp of an arm from a stance, whose shoulder is at a pose, (12,)."""
        grasps, facing = self._grasps, self._here.settings.grasp.facing
        order = grasps_in_reach(shoulder, self.arm(arm), grasps.centers, grasps.approaches, facing)
        to_try = order[self._tries.met[order] < 0]
        if len(to_try):
            self._stage.show(stance.state)
        index = self._tries.first_free(to_try, self.arm(arm)) if len(to_try) else None
        return self._miss(order.tolist()) if index is None else self._outcome(self.arm(arm), index, shoulder[:3])

    def consult(self) -> None:
        """Note that hands were tried around the object."""
        hand_m = self._hand.opening_m + 2 * self._hand.finger_length_m + sum(self._hand.palm_m)
        self._here.consulted.target.add_balls(self.target.centers, self.target.radii_m + hand_m)

    @cached_property
    def cloud(self) -> Cloud:
        """Where grasps are."""
        return Cloud.of(self._grasps.centers)

    @cached_property
    def _tries(self) -> Tries:
        """What is in the way of them."""
        return Tries(
            self._stage,
            self._agent,
            object_in_world=self._object_in_world,
            grasps=self._in_object,
            hands=Hands.of(self._in_object, self._hand),
            obstacles=(self._here.collisions.obstacles, self._here.collisions.boxes),
        )

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
        owners = [*map(self._called, self._tries.others.tolist()), self.target.name]
        met = Counter(owners[row] if row >= 0 else self._agent.name for row in self._tries.met[tried].tolist())
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

    def next(self, start: int, stop: int) -> int:
        """The first stance from which an arm reaches a grasp."""
        return self._reach.next(start, stop)

    def outcomes(self, index: int) -> Iterator[Outcome | Why]:
        """The arms that can grasp the object, the nearer grasp first; or the nearest miss."""
        stance, frames = self._stances[index], self._stances.frames(index)
        shoulders = frames[self._stances.bent.frames.first_shoulder :]
        arms = [self._grasp.arms[column] for column in self._reach.able(index)]
        results = [self._grasp.grasped(stance, arm, shoulders[arm]) for arm in arms]
        outcomes = [result for result in results if isinstance(result, Outcome)]
        yield from sorted(outcomes, key=lambda outcome: outcome.merit)
        if not outcomes:
            miss = min(result for result in results if isinstance(result, Miss))
            yield lambda: miss

    def miss(self) -> Miss | None:
        """Why no grasp is reached from the other stances."""
        return self._reach.miss()
