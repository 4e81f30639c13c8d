"""What people push into as they act: their arms, torso and legs, and what they hold; themselves among it.

People's motions are not planned around things: a hand goes where hands go, and the body follows it (``moving``). So
what was worked out is looked at before it counts as a plan: whoever would push into something uses the other hand, or
brings the thing elsewhere.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.perspective.constraints import part_of
from taskgist.planning.persons import moves_itself
from taskgist.planning.plan import Phase
from taskgist.planning.whole_body import TOLERANCE_M, Pair, near_of, own_pairs
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist.world.state import Hold, State

EVERY = 3
"""Of the frames each so-manieth is looked at, and the last of a phase."""
SEATED_M = 0.06
"""How deep people may be in what they touch before they act (ours: thighs give, and so do seats)."""


GIVES_M = 0.03
"""How much deeper two parts of one person may be in each other than at rest (ours: flesh gives, and links of a model do
not; a person who stands at a table and reaches across has an arm 25 mm in the chest)."""


def pushing_into(scene: Scene, before: Array, phases: Sequence[Phase], performer: str) -> str | None:
    """What a person who acts, or takes, would push into, in words; None if nothing.

    Args:
        scene: The scene.
        before: Where everything is at first, (nq,): what touches then may touch.
        phases: What is done.
        performer: Who does it.
    """
    holds = frozenset[Hold]().union(*(phase.holds for phase in phases))
    names = sorted({performer, *(hold.agent for hold in holds)})
    people = [name for name in names if moves_itself(scene.agent(name))]
    stage = Stage(scene, State(before))
    pairs = [(scene.solid_geoms_of(name), _around(stage, name, holds)) for name in people]
    allowed_m = {
        (geom, other): min(depth_m, SEATED_M)
        for own, others in pairs
        for geom, other, depth_m in stage.overlaps(own, others)
    }
    selves = [_Self(stage, name) for name in people]
    for phase in phases:
        loads = [_load(stage, hold, phase.holds) for hold in phase.holds if hold.agent in people]
        for qpos in (*phase.qpos[:-1:EVERY], phase.qpos[-1]):
            stage.show(State(qpos))
            met = next(filter(None, (_deepest(stage, *each, allowed_m) for each in (*pairs, *loads))), None)
            met = met or next(filter(None, (each.met(stage) for each in selves)), None)
            if met is not None:
                return f"{_called(stage, met[0])} would push into {_called(stage, met[1])}"
    return None


class _Self:
    """Pairs of shapes of one person that may come into each other no more than flesh gives, from rest or at first.

    Args:
        stage: How everything is at first.
        name: Whose body.
    """

    def __init__(self, stage: Stage, name: str) -> None:
        self._own = stage.scene.solid_geoms_of(name)
        self._pairs, usual_m = own_pairs(stage.scene, stage.scene.agent(name), self._own)
        self._usual_m = dict(usual_m)
        for pair, depth_m in self._near(stage):
            self._usual_m[pair] = max(depth_m, self._usual_m.get(pair, 0.0))

    def met(self, stage: Stage) -> Pair | None:
        """Two of its shapes that are too deep in each other, as the stage shows them."""
        for pair, depth_m in self._near(stage):
            if depth_m > self._usual_m.get(pair, 0.0) + GIVES_M:
                return int(self._own[pair[0]]), int(self._own[pair[1]])
        return None

    def _near(self, stage: Stage) -> Iterator[tuple[Pair, float]]:
        """Pairs whose boxes overlap, by their places in the body, and how deep they are in each other."""
        for one, other in near_of(stage.boxes(self._own), self._pairs, -TOLERANCE_M / 2).tolist():
            yield (one, other), -stage.distance(int(self._own[one]), int(self._own[other]), limit_m=0.0)


def _around(stage: Stage, name: str, holds: frozenset[Hold]) -> Indices:
    """Shapes that somebody may not push into: all but its own, and those of what it takes."""
    scene = stage.scene
    taken = [scene.solid_geoms_of(hold.object) for hold in holds if hold.agent == name]
    return np.setdiff1d(stage.solid_geoms(), np.concatenate([scene.solid_geoms_of(name), *taken]))


def _load(stage: Stage, hold: Hold, holds: frozenset[Hold]) -> tuple[Indices, Indices]:
    """Shapes of a held thing, and those that it may not come to: all but the hands that hold it."""
    scene, own = stage.scene, stage.scene.solid_geoms_of(hold.object)
    hands = [scene.agent(each.agent).arm(each.side).hand_geoms for each in holds if each.object == hold.object]
    return own, np.setdiff1d(stage.solid_geoms(), np.concatenate([own, *hands]))


def _deepest(stage: Stage, own: Indices, others: Indices, allowed_m: Mapping[Pair, float]) -> Pair | None:
    deep = {
        (geom, other): depth_m - allowed_m.get((geom, other), 0.0)
        for geom, other, depth_m in stage.overlaps(own, others, deeper_than_m=TOLERANCE_M)
    }
    pair = max(deep, key=lambda pair: deep[pair], default=None)
    return pair if pair is not None and deep[pair] > TOLERANCE_M else None


def _called(stage: Stage, geom: int) -> str:
    """What a shape belongs to: "the table", "P2's left hand"."""
    owner = stage.scene.owners[geom]
    if owner not in stage.scene.agents:
        return f"the {owner}"
    return f"{owner}'s {part_of(stage, stage.scene.agent(owner), geom).replace('_', ' ')}"
