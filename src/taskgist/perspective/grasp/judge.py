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

from taskgist.common.arrays import Array, Indices
from taskgist.common.compiled import compiled
from taskgist.perspective.actions import Stance, stretch
from taskgist.perspective.candidates import Stances
from taskgist.perspective.effort import Among, Hopeless, Miss, Outcome, Why
from taskgist.perspective.grasp.grasps import Grasps, Hands
from taskgist.perspective.grasp.sampling import TOUCH_M, grasps_in_object
from taskgist.perspective.reach import ByHand, Cloud, ReachAmong
from taskgist.perspective.sector import DIGITS, grasps_in_reach
from taskgist.perspective.viewpoint import Standpoint, Target
from taskgist.world.bodies.agent import Agent, ArmIndices
from taskgist.world.bodies.hands import Hand
from taskgist.world.geometry.distances import TURNED, near_ball, next_near, seen_from, surely_overlap
from taskgist.world.geometry.transforms import Pose
from taskgist.world.stage import Stage

# --- Tries: which of many grasps a hand can take without meeting anything (5.1.3).
#
# Boxes around all that stands near the object are held against those of the hand, in the object's frame, for many
# grasps at once. Most grasps surely meet nothing then, or surely something; MuJoCo measures the others.

UNTRIED, DOUBTFUL, CLEAR = -1, -2, -3
"""What a grasp meets, where that is not the index of something."""
SURE_M = 1e-3
"""What surely overlaps deeper than this need not be measured: no two ways of measuring disagree on it (ours)."""


class Tries:
    """Grasps of one object by one agent, tried one after the other; what another shape blocks stays blocked.

    Args:
        stage: The scene; objects and others stay where they are.
        agent: Whose head, torso and base may be in the way as well, wherever it stands.
        object_in_world: Where the object is.
        grasps: Its grasps, in its frame.
        hands: The hand in each of them.
        obstacles: Other solid shapes, (k,), and boxes around them, (k, 18).

    Attributes:
        others: Those of them that a hand may meet.
        met: What is in the way of each grasp: index into ``others``, one more for the object itself; negative where
            nothing is known to be, (n,).
    """

    def __init__(
        self,
        stage: Stage,
        agent: Agent,
        *,
        object_in_world: Pose,
        grasps: Grasps,
        hands: Hands,
        obstacles: tuple[Indices, Array],
    ) -> None:
        self._stage, self._agent, self._hands, self._pose = stage, agent, hands, object_in_world
        (geoms, boxes), own = obstacles, frozenset(grasps.solids.tolist())
        x, y, z = object_in_world.to_world(hands.middle).tolist()
        near = near_ball(boxes, x, y, z, hands.radius_m)
        near = near[[geom not in own for geom in geoms[near].tolist()]]
        self.others: Indices = geoms[near]
        self._boxes = seen_from(boxes[near], object_in_world.position, object_in_world.matrix)
        self.met: Indices = np.where(grasps.in_itself, len(self.others), UNTRIED)

    def first_free(self, order: Indices, arm: ArmIndices) -> int | None:
        """The first of some grasps that meets nothing, the agent being as the stage shows it; None if all do."""
        own = seen_from(self._stage.boxes(self._agent.core_geoms), self._pose.position, self._pose.matrix)
        hands, at = self._hands, 0
        while True:
            at, sure = _next(order, at, self.met, hands.frames, hands.centers, hands.boxes, self._boxes, own)
            if at == len(order):
                return None
            index = int(order[at])
            if sure or self._free(index, arm.ghosts):
                return index
            at += 1

    def _free(self, index: int, ghosts: Indices) -> bool:
        """Whether MuJoCo finds a grasp free."""
        centers, matrix = self._pose.to_world(self._hands.centers[index]), self._hands.frames[index].reshape(3, 3)
        self._stage.place(ghosts, centers, (self._pose.matrix @ matrix).reshape(9))
        if self.met[index] == DOUBTFUL:
            overlaps = self._stage.overlaps(ghosts, self.others, deeper_than_m=TOUCH_M)
            met = next((other for _, other, _ in overlaps), None)
            self.met[index] = CLEAR if met is None else np.flatnonzero(self.others == met)[0]
        own = self._agent.core_geoms
        return bool(self.met[index] == CLEAR) and not any(self._stage.overlaps(ghosts, own, deeper_than_m=TOUCH_M))


@compiled
def _next(
    order: Indices, start: int, met: Indices, frames: Array, centers: Array, boxes: Array, others: Array, own: Array
) -> tuple[int, bool]:
    """Place in the order of the next grasp that may be free, and whether it surely is; notes what others meet."""
    hand = boxes.copy()
    for at in range(start, len(order)):
        index = order[at]
        if met[index] >= 0:
            continue
        for box in range(len(hand)):
            for axis in range(3):
                hand[box, axis] = centers[index, box, axis]
            for k in range(9):
                hand[box, TURNED + k] = frames[index, k]
        if met[index] == UNTRIED:
            met[index] = _met(hand, others)
        if met[index] >= 0:
            continue
        own_met = _met(hand, own)
        if own_met < 0:
            return at, met[index] == CLEAR and own_met == CLEAR
    return len(order), False


@compiled
def _met(hand: Array, things: Array) -> int:
    """The first box, by row, that a hand surely meets; that it is clear of all, or that there is doubt before."""
    pair = next_near(hand, things, 0.0, 0)
    if pair < 0:
        return CLEAR
    box, row = pair // len(things), pair % len(things)
    return row if surely_overlap(hand, box, things, row, SURE_M) else DOUBTFUL


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
