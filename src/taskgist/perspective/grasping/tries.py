"""Tries: which of many grasps a hand can take without meeting anything (5.1.3).

Boxes around all that stands near the object are held against those of the hand, in the object's frame, for many
grasps at once. Most grasps surely meet nothing then, or surely something; MuJoCo measures the others.
"""

from __future__ import annotations

import numpy as np

from taskgist.perspective.grasping.grasps import Array, Grasps, Indices
from taskgist.perspective.grasping.hand import Hands
from taskgist.perspective.grasping.touch import TOUCH_M
from taskgist.world import Agent, ArmIndices, Pose, Stage
from taskgist.world.geometry.box_gaps import next_near, surely_overlap
from taskgist.world.geometry.boxes import TURNED, near_ball, seen_from
from taskgist.world.geometry.compiled import compiled

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
