"""Ways to grasp an object: with one hand as it lies, after tilting or sliding it, or between both hands.

A way has grasps, and tells which of them an agent can take from a candidate, or why it can take none.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from functools import cached_property

import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.perspective.candidates import Candidate, thrust_of
from taskgist.perspective.effort import (
    BlockedApproaches,
    Grasped,
    GraspedByBoth,
    Miss,
    Prepared,
    Reason,
    stretch,
)
from taskgist.perspective.grasp_sampling import SIDES, Grasps
from taskgist.perspective.grasp_trials import GraspTrials
from taskgist.perspective.points_in_reach import DIGITS, PointCloud, grasps_in_reach
from taskgist.perspective.target import Target, vector
from taskgist.perspective.viewpoint import Hit, Viewpoint
from taskgist.world.bodies.agent import ArmIndices
from taskgist.world.bodies.hands import Hand, Palms
from taskgist.world.geometry.transforms import Pose

NAMED = 2
"""Names of what is in the way that a reason tells; the evidence has all of them."""


class _Tried:
    """Grasps of an object that are tried where it is.

    Args:
        here: Whose hands.
        target: The object.
        pose: Where it is.
        grasps: In its frame.
        hand: What closes on it.
    """

    def __init__(self, here: Viewpoint, target: Target, pose: Pose, grasps: Grasps, hand: Hand | Palms) -> None:
        self._here, self._target = here, target
        self.grasps = grasps.placed(pose)
        self._trial = (here.stage, here.agent, pose, grasps, hand, here.collisions)
        self._first_blocked: Miss | None = None

    @cached_property
    def trials(self) -> GraspTrials:
        """What is in the way of them."""
        return GraspTrials(*self._trial)

    def _arm(self, index: int) -> tuple[ArmIndices, dict[int, float]]:
        """An arm, and what thrusts its shoulder forward: after all arms at rest they come again, thrust forward."""
        agent = self._here.agent
        arm = agent.arms[index % len(agent.arms)]
        return arm, thrust_of(agent, arm, self._here.state) if index >= len(agent.arms) else {}

    def first_free(self, candidate: Candidate, order: Indices, ghosts: Indices) -> int | Miss:
        """The first of some grasps, at least one, that is free from a candidate; or why none is."""
        to_try = order[self.trials.met[order] < 0]
        if len(to_try):
            self._here.stage.show(candidate.state)
        index = self.trials.first_free(to_try, ghosts) if len(to_try) else None
        return self._blocked(order) if index is None else index

    def all_blocked(self) -> bool:
        """Whether others are in the way of all grasps, wherever the agent is."""
        return not len(self.grasps) or self.trials.all_blocked(self._ghosts)

    @property
    def _ghosts(self) -> Indices:
        """Shapes of a hand that is put into grasps."""
        return self._here.agent.arms[0].ghosts

    def _blocked(self, tried: Indices) -> Miss:
        """Why none of the grasps is free that an arm reaches: what was in the way when that first was so."""
        if self._first_blocked is None:
            self._first_blocked = self._blocked_approaches(tried)
        return self._first_blocked

    def _blocked_approaches(self, tried: Indices) -> Miss:
        """What is in the way of which grasps."""
        name, agent = self._target.name, self._here.agent.name
        owners = [*map(self._called, self.trials.others.tolist()), name]
        met = Counter(owners[row] if row >= 0 else agent for row in self.trials.met[tried].tolist())
        counts = sorted(met.items(), key=lambda each: (-each[1], each[0]))
        telling = [each for each in counts if each[0] != name] or counts  # it is always in its own way somewhere
        counted = [f"{owner} ({count} of {len(tried)})" if len(telling) > 1 else owner for owner, count in telling]
        text = f"every approach blocked by {' and '.join(counted[:NAMED])}"
        return Miss(Reason.NO_FREE_GRASP, text, hindrance=BlockedApproaches(tuple(counts)))

    def _called(self, geom: int) -> str:
        """Name of an obstacle: another agent's hand is called so."""
        scene = self._here.stage.scene
        owner = scene.owners[geom]
        if owner in scene.agents and any(geom in arm.hand_geoms for arm in scene.agent(owner).arms):
            return f"{owner}'s hand"
        return owner


class OneHanded(_Tried):
    """Grasps by one hand; arguments as above.

    Args:
        prepared: What is done to the object first.
    """

    def __init__(
        self, here: Viewpoint, target: Target, pose: Pose, grasps: Grasps, hand: Hand, *, prepared: Prepared = ""
    ) -> None:
        super().__init__(here, target, pose, grasps, hand)
        self._hand, self._prepared = hand, prepared
        self.cloud = PointCloud.of(self.grasps.centers)

    def results(self, candidate: Candidate, shoulders: Array, able: Sequence[int]) -> list[Hit | Miss]:
        """The nearest free grasp of each arm that gets to the object; or why it has none.

        Args:
            candidate: From where.
            shoulders: Of all arms there, at rest and then thrust forward, (2 arms, 12).
            able: Which of these get there.
        """
        return [self._result(candidate, arm, shoulders[arm]) for arm in able]

    def _result(self, candidate: Candidate, index: int, shoulder: Array) -> Hit | Miss:
        grasps, (arm, angles_rad) = self.grasps, self._arm(index)
        settings = self._here.settings
        facing, model = settings.grasp.facing, settings.reach.model
        order = grasps_in_reach(shoulder, arm, grasps.centers, grasps.approaches, facing, model=model)
        if not len(order):
            return Miss(Reason.FROM_BEHIND, "could only be grasped from behind")
        found = self.first_free(candidate, order, arm.ghosts)
        if isinstance(found, Miss):
            return found
        side, kind, prepared = arm.profile.side, self._hand.kind, self._prepared
        distance_m = float(np.linalg.norm(grasps.centers[found] - shoulder[:3]))

        def grasped() -> Grasped:
            return Grasped(
                side,
                kind,
                vector(grasps.centers[found]),
                distance_m,
                float(grasps.widths_m[found]),
                vector(grasps.closings[found]),
                vector(grasps.approaches[found]),
                prepared,
            )

        cost = round(distance_m, DIGITS)
        return Hit(grasped, angles_rad, (stretch(side),), cost=cost, thrusts=index >= len(self._here.agent.arms))


ONLY_ONE = Miss(Reason.ONE_HAND, "it takes both hands, and only one gets there")


class TwoHanded(_Tried):
    """Grasps between both hands; arguments as above.

    Args:
        kind: Of the hands.
    """

    def __init__(self, here: Viewpoint, target: Target, pose: Pose, grasps: Grasps, palms: Palms, *, kind: str) -> None:
        super().__init__(here, target, pose, grasps, palms)
        self._kind = kind
        half = self.grasps.closings * (self.grasps.widths_m / 2)[:, None]
        self._points = (self.grasps.centers - half, self.grasps.centers + half)
        self.cloud = PointCloud.of(self._points[0])  # of each pair there is the one with the hands changed over

    @property
    def _ghosts(self) -> Indices:
        return np.array([self._here.agent.arm(side).flat_ghost for side in SIDES])

    def results(self, candidate: Candidate, shoulders: Array, able: Sequence[int]) -> list[Hit | Miss]:
        """The nearest free grasp that both arms reach; arguments as above."""
        pair = sorted(able, key=lambda index: SIDES.index(self._arm(index)[0].profile.side))
        arms, angles_rad = zip(*map(self._arm, pair), strict=True)
        rows = [shoulders[index] for index in pair]
        grasps, settings = self.grasps, self._here.settings
        facing, model = settings.grasp.facing, settings.reach.model
        left, right = (
            grasps_in_reach(row, arm, points, grasps.approaches, facing, model=model)
            for row, arm, points in zip(rows, arms, self._points, strict=True)
        )
        both = np.intersect1d(left, right)
        if not len(both):
            return [ONLY_ONE]
        distances_m = [
            np.linalg.norm(points[both] - row[:3], axis=1) for row, points in zip(rows, self._points, strict=True)
        ]
        order = both[np.argsort(np.round(sum(distances_m), DIGITS), kind="stable")]
        found = self.first_free(candidate, order, self._ghosts)
        if isinstance(found, Miss):
            return [found]
        (first, second), (first_m, second_m) = (
            [points[found] for points in self._points],
            [float(np.linalg.norm(points[found] - row[:3])) for points, row in zip(self._points, rows, strict=True)],
        )

        def grasped() -> GraspedByBoth:
            return GraspedByBoth(
                SIDES,
                self._kind,
                (vector(first), vector(second)),
                (first_m, second_m),
                float(grasps.widths_m[found]),
                vector(grasps.closings[found]),
                vector(grasps.approaches[found]),
            )

        angles, cost = angles_rad[0] | angles_rad[1], round(first_m + second_m, DIGITS)
        thrusts = max(able) >= len(self._here.agent.arms)
        return [Hit(grasped, angles, tuple(map(stretch, SIDES)), cost=cost, thrusts=thrusts)]
