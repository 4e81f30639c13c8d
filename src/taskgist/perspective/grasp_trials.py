"""Which of many grasps a hand, or two, can take without meeting anything (5.1.3).

Boxes around all that stands near the object are held against those of the hand, in the object's frame, for many
grasps at once. Most grasps surely meet nothing then, or surely something; MuJoCo measures the others.
"""

from __future__ import annotations

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.common.compiled import compiled, compiled_part
from taskgist.perspective.constraints import Collisions
from taskgist.perspective.grasp_sampling import TOUCH_M, Grasps, hand_centers, hand_frames
from taskgist.world.bodies.agent import Agent
from taskgist.world.bodies.hands import Hand, Palms, hand_boxes
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
    def of(cls, grasps: Grasps, hand: Hand | Palms) -> Hands:
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


_KNOWN: WeakKeyDictionary[Grasps, dict[Hand | Palms, Hands]] = WeakKeyDictionary()


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
        self,
        stage: Stage,
        agent: Agent,
        object_in_world: Pose,
        grasps: Grasps,
        hand: Hand | Palms,
        collisions: Collisions,
    ) -> None:
        self._stage, self._agent, self._pose, self._grasps = stage, agent, object_in_world, grasps
        self._hands = Hands.of(grasps, hand)
        geoms, boxes = collisions.around(object_in_world.to_world(self._hands.middle), self._hands.radius_m)
        foreign = ~np.isin(geoms, grasps.solids)
        self.others: Indices = geoms[foreign]
        self._boxes = seen_from(boxes[foreign], object_in_world.position, object_in_world.matrix)
        self.met: Indices = np.where(grasps.in_itself, len(self.others), UNTRIED)
        self._not_blocked = 0

    def first_free(self, order: Indices, ghosts: Indices) -> int | None:
        """The first of some grasps that meets nothing, the agent being as the stage shows it; None if all do.

        Args:
            order: Indices of the grasps, (k,).
            ghosts: Shapes of the hand, in the order of its boxes.
        """
        own = seen_from(self._stage.boxes(self._agent.core_geoms), self._pose.position, self._pose.matrix)
        hands, at = self._hands, 0
        while True:
            at, sure = _next(order, at, self.met, hands.frames, hands.centers, hands.boxes, self._boxes, own)
            if at == len(order):
                return None
            index = int(order[at])
            if (sure or self._free(index, ghosts)) and self._closes(index):
                return index
            at += 1

    def all_blocked(self, ghosts: Indices) -> bool:
        """Whether others are in the way of all grasps, wherever the agent is; arguments as above."""
        hands, nobody = self._hands, np.empty((0, COLUMNS))
        while self._not_blocked < len(self.met):
            order = np.arange(self._not_blocked, len(self.met))
            at, _ = _next(order, 0, self.met, hands.frames, hands.centers, hands.boxes, self._boxes, nobody)
            self._not_blocked += at
            if at < len(order):
                index = int(order[at])
                if (self.met[index] == FREE or self._free_of_others(index, ghosts)) and self._closes(index):
                    return False
        return True

    def _free(self, index: int, ghosts: Indices) -> bool:
        """Whether MuJoCo finds a grasp free."""
        if not self._free_of_others(index, ghosts):
            return False
        own = self._agent.core_geoms
        return not any(self._stage.overlaps(ghosts, own, deeper_than_m=TOUCH_M))

    def _free_of_others(self, index: int, ghosts: Indices) -> bool:
        """Whether MuJoCo finds it free of others; the hand is put there."""
        centers, matrix = self._pose.to_world(self._hands.centers[index]), self._hands.frames[index].reshape(3, 3)
        self._stage.place(ghosts, centers, (self._pose.matrix @ matrix).reshape(9))
        if self.met[index] == DOUBTFUL:
            overlaps = self._stage.overlaps(ghosts, self.others, deeper_than_m=TOUCH_M)
            met = next((other for _, other, _ in overlaps), None)
            self.met[index] = FREE if met is None else np.flatnonzero(self.others == met)[0]
        return bool(self.met[index] == FREE)

    def _closes(self, index: int) -> bool:
        """Whether nothing lies between the pads and the points that they close on: a sleeve, another's fist."""
        grasps = self._grasps
        closing, gap_m = grasps.closings[index], float(grasps.gaps_m[index])
        off = closing * (float(grasps.widths_m[index]) / 2 + gap_m)
        starts = self._pose.to_world(np.stack((grasps.centers[index] - off, grasps.centers[index] + off)))
        inwards = np.stack((closing, -closing)) @ self._pose.matrix.T
        met, distances_m, _ = self._stage.cast_each(self.others, starts, inwards)
        between = met[(met >= 0) & (distances_m < gap_m - TOUCH_M)]
        if len(between):
            self.met[index] = np.flatnonzero(self.others == between[0])[0]
        return not len(between)


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
