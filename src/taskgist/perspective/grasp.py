"""Grasp: the object is reachable, and at least one collision-free grasp of that hand exists (5.1.3).

A grasp is tried with the shapes of a hand before it closes, and all that they sweep on the last finger's length of its
approach. They must be free of everything solid: the support, other agents' hands, the agent's own head, torso and
legs, and the object itself; only what the fingers close on is touched by design. The agent's own arms do not count,
they are where the virtual action brings them.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.common.compiled import compiled, compiled_part
from taskgist.perspective.candidates import Candidate, Candidates
from taskgist.perspective.constraints import Collisions
from taskgist.perspective.effort import BlockedApproaches, Grasped, Miss, Reason, nearest_miss, stretch
from taskgist.perspective.grasp_sampling import TOUCH_M, Grasps, grasps_in_object, hand_centers, hand_frames
from taskgist.perspective.reach import DIGITS, ArmJudge, PointCloud, ReachScreening, grasps_in_reach
from taskgist.perspective.target import Target, vector
from taskgist.perspective.viewpoint import FindMiss, Hit, Screening, Viewpoint
from taskgist.world.bodies.agent import Agent, ArmIndices
from taskgist.world.bodies.hands import Hand, hand_boxes
from taskgist.world.geometry.distances import (
    COLUMNS,
    EXACT,
    HALF,
    RADIUS,
    TURNED,
    next_near,
    seen_from,
    surely_overlap,
)
from taskgist.world.geometry.transforms import Pose
from taskgist.world.stage import Stage

# --- The hand in each of many grasps.


@dataclass(frozen=True, eq=False)
class Hands:
    """The boxes of a hand in each of n grasps, before it closes.

    Attributes:
        frames: How the hand is turned, (n, 9).
        centers: Middles of its boxes, metres, (n, k, 3).
        boxes: The boxes as rows of a table, to be put there, (k, 18); see ``geometry.boxes``.
        middle: Middle of a ball that holds the hand in all of the grasps, metres, (3,).
        radius_m: Its radius.
    """

    frames: Array
    centers: Array
    boxes: Array
    middle: Array
    radius_m: float

    @classmethod
    def of(cls, grasps: Grasps, hand: Hand) -> Hands:
        """The hand in some grasps; found once for each set of grasps."""
        known = _KNOWN.setdefault(grasps, {})
        if hand not in known:
            half = np.array([box.half_m for box in hand_boxes(hand)])
            boxes = np.zeros((len(half), COLUMNS))
            boxes[:, HALF : HALF + 3], boxes[:, RADIUS], boxes[:, EXACT] = half, np.linalg.norm(half, axis=1), 1.0
            centers = hand_centers(grasps, hand)
            middle = centers.mean(axis=(0, 1))
            radius_m = float((np.linalg.norm(centers - middle, axis=2) + boxes[:, RADIUS]).max())
            known[hand] = cls(hand_frames(grasps).reshape(-1, 9), centers, boxes, middle, radius_m)
        return known[hand]


_KNOWN: WeakKeyDictionary[Grasps, dict[Hand, Hands]] = WeakKeyDictionary()


# --- Trials: which of many grasps a hand can take without meeting anything (5.1.3).
#
# Boxes around all that stands near the object are held against those of the hand, in the object's frame, for many
# grasps at once. Most grasps surely meet nothing then, or surely something; MuJoCo measures the others.

UNTRIED, DOUBTFUL, FREE = -1, -2, -3
"""What a grasp meets, where that is not the index of something."""
SURE_M = 1e-3
"""What surely overlaps deeper than this need not be measured: no two ways of measuring disagree on it (ours)."""


class GraspTrials:
    """Grasps of one object by one agent, tried one after the other; what another shape blocks stays blocked.

    Args:
        stage: The scene; objects and others stay where they are.
        agent: Whose head, torso and base may be in the way as well, wherever it stands.
        object_in_world: Where the object is.
        grasps: Its grasps, in its frame.
        hand: What closes on it.
        collisions: What else is in the way of the agent.

    Attributes:
        others: Those of the solid shapes that the hand may meet.
        met: What is in the way of each grasp: index into ``others``, one more for the object itself; negative where
            nothing is known to be, (n,).
    """

    def __init__(
        self, stage: Stage, agent: Agent, object_in_world: Pose, grasps: Grasps, hand: Hand, collisions: Collisions
    ) -> None:
        self._stage, self._agent, self._pose = stage, agent, object_in_world
        self._hands = Hands.of(grasps, hand)
        geoms, boxes = collisions.around(object_in_world.to_world(self._hands.middle), self._hands.radius_m)
        foreign = ~np.isin(geoms, grasps.solids)
        self.others: Indices = geoms[foreign]
        self._boxes = seen_from(boxes[foreign], object_in_world.position, object_in_world.matrix)
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
            self.met[index] = FREE if met is None else np.flatnonzero(self.others == met)[0]
        own = self._agent.core_geoms
        return bool(self.met[index] == FREE) and not any(self._stage.overlaps(ghosts, own, deeper_than_m=TOUCH_M))


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
            return at, met[index] == FREE and own_met == FREE
    return len(order), False


@compiled_part
def _met(hand: Array, things: Array) -> int:
    """The first box, by row, that a hand surely meets; that it is clear of all, or that there is doubt before."""
    pair = next_near(hand, things, 0.0, 0)
    if pair < 0:
        return FREE
    box, row = pair // len(things), pair % len(things)
    return row if surely_overlap(hand, box, things, row, SURE_M) else DOUBTFUL


# --- The judge of grasping.

NAMED = 2
"""Names of what is in the way that a reason tells; the evidence has all of them."""


class Impossible:
    """An ability that no candidate can give, for one and the same reason."""

    def __init__(self, why: Miss) -> None:
        self._why = why

    def next(self, start: int, stop: int) -> int:  # noqa: ARG002 - as all screenings
        """None."""
        return stop

    def results(self, index: int) -> Iterator[Hit | FindMiss]:  # noqa: ARG002 - as all screenings
        """Never."""
        yield self.miss

    def miss(self) -> Miss:
        """The reason."""
        return self._why


class Grasp(ArmJudge):
    """Judges the ability to grasp one object.

    Args:
        here: Whose, and from where.
        target: The object.
    """

    def __init__(self, here: Viewpoint, target: Target) -> None:
        super().__init__(here, target)
        self._first_blocked: Miss | None = None

    def screen(self, candidates: Candidates) -> Screening:
        """What the arms can grasp from some candidates."""
        if self._here.agent.profile.hand is not None:
            surface = ReachScreening(self, candidates, self.surface)
            if surface.beyond(self._hand.opening_m / 2 + self._here.settings.reach.cell_m):
                return surface  # no grasp is farther from the surface than this: spares sampling them
        if self._impossible is not None:
            return Impossible(self._impossible)
        return GraspScreening(self, candidates)

    @cached_property
    def _impossible(self) -> Miss | None:
        """Why no hand of the agent closes on the object at all."""
        hand = self._here.agent.profile.hand
        if hand is None:
            return Miss(Reason.NO_HAND, "no hand that grasps")
        narrowest_m = self._grasps.narrowest_m
        if narrowest_m is None:
            return Miss(Reason.NO_OPPOSITE_FACES, "no two opposite faces to close on")
        if narrowest_m > hand.opening_m and not len(self._grasps):
            return Miss(Reason.TOO_WIDE, f"too wide ({narrowest_m:.2f} m > {hand.opening_m:.2f} m)")
        return None if len(self._grasps) else Miss(Reason.TOO_NARROW, "too narrow for both fingers to meet it")

    @cached_property
    def _in_object(self) -> Grasps:
        """Grasps in the object's frame."""
        return grasps_in_object(self._here.stage, self.target.name, self._hand, self._here.settings.grasp)

    @cached_property
    def _grasps(self) -> Grasps:
        """The same where the object is."""
        return self._in_object.placed(self._object_in_world)

    @property
    def _object_in_world(self) -> Pose:
        stage = self._here.stage
        return stage.body(stage.scene.object_body(self.target.name))

    @property
    def _hand(self) -> Hand:
        assert self._here.agent.profile.hand is not None
        return self._here.agent.profile.hand

    @cached_property
    def cloud(self) -> PointCloud:
        """Where grasps are."""
        return PointCloud.of(self._grasps.centers)

    @cached_property
    def _trials(self) -> GraspTrials:
        """What is in the way of them."""
        here = self._here
        return GraspTrials(here.stage, here.agent, self._object_in_world, self._in_object, self._hand, here.collisions)

    def grasped(self, candidate: Candidate, arm: int, shoulder: Array) -> Hit | Miss:
        """The nearest free grasp of an arm from a candidate, whose shoulder is at a pose, (12,)."""
        grasps, facing = self._grasps, self._here.settings.grasp.facing
        order = grasps_in_reach(shoulder, self.arm(arm), grasps.centers, grasps.approaches, facing, model=self.model)
        if not len(order):
            return Miss(Reason.FROM_BEHIND, "could only be grasped from behind")
        to_try = order[self._trials.met[order] < 0]
        if len(to_try):
            self._here.stage.show(candidate.state)
        index = self._trials.first_free(to_try, self.arm(arm)) if len(to_try) else None
        return self._blocked(order) if index is None else self._hit(self.arm(arm), index, shoulder[:3])

    def _hit(self, arm: ArmIndices, index: int, shoulder: Array) -> Hit:
        grasps, side, kind = self._grasps, arm.profile.side, self._hand.kind
        distance_m = float(np.linalg.norm(grasps.centers[index] - shoulder))

        def grasped() -> Grasped:
            return Grasped(
                side,
                kind,
                vector(grasps.centers[index]),
                distance_m,
                float(grasps.widths_m[index]),
                vector(grasps.closings[index]),
                vector(grasps.approaches[index]),
            )

        return Hit(grasped, actions=(stretch(side),), cost=round(distance_m, DIGITS))

    def _blocked(self, tried: Indices) -> Miss:
        """Why none of the grasps is free that an arm reaches: what was in the way when that first was so."""
        if self._first_blocked is None:
            self._first_blocked = self._blocked_approaches(tried)
        return self._first_blocked

    def _blocked_approaches(self, tried: Indices) -> Miss:
        """What is in the way of which grasps."""
        name, agent = self.target.name, self._here.agent.name
        owners = [*map(self._called, self._trials.others.tolist()), name]
        met = Counter(owners[row] if row >= 0 else agent for row in self._trials.met[tried].tolist())
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


class GraspScreening:
    """Where an arm reaches some grasp of the object, from n candidates."""

    def __init__(self, grasp: Grasp, candidates: Candidates) -> None:
        self._grasp, self._candidates = grasp, candidates
        self._reach = ReachScreening(grasp, candidates, grasp.cloud)

    def next(self, start: int, stop: int) -> int:
        """The first candidate from which an arm reaches a grasp."""
        return self._reach.next(start, stop)

    def results(self, index: int) -> Iterator[Hit | FindMiss]:
        """The arms that can grasp the object, the nearer grasp first; or the nearest miss."""
        candidate, frames = self._candidates[index], self._candidates.frames(index)
        shoulders = frames[self._candidates.torso.frames.first_shoulder :]
        arms = [self._grasp.arms[column] for column in self._reach.able(index)]
        results = [self._grasp.grasped(candidate, arm, shoulders[arm]) for arm in arms]
        hits = [result for result in results if isinstance(result, Hit)]
        yield from sorted(hits, key=lambda hit: hit.cost)
        if not hits:
            miss = nearest_miss([result for result in results if isinstance(result, Miss)])
            yield lambda: miss

    def miss(self) -> Miss | None:
        """Why no grasp is reached from the other candidates."""
        return self._reach.miss()
