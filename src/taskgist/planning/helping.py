"""What would help: the least change of the room with which a task could be performed that cannot be now.

A refusal that only says what failed leaves people to guess what to do about it. So where the robot does not get hold of
the thing, the thing is thought nearer to it, centimetre by centimetre; and where no place satisfies the goal, the other
things are thought nearer to a target agent, or farther away, while the thing is at the place that came nearest. Each
such room is judged by what judges all others, and the first that will do is told::

    the tape could be grasped if it stood 14 cm nearer to PR2
    on the table it would do if the box stood 6 cm nearer to P2

What is thought elsewhere must lie on the same support, and in nothing else.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import product
from typing import Literal as OneOf

import numpy as np

from taskgist.common.arrays import Array
from taskgist.planning.actions import Actions
from taskgist.planning.endings import Endings
from taskgist.planning.requests import Request, Search
from taskgist.settings import Contact
from taskgist.world.contacts import support_of
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist.world.state import State

STEP_M, FARTHEST_M = 0.02, 0.40
"""Steps in which things are thought elsewhere, and how far at most (ours: what somebody would shove aside)."""
DEEP_M = 0.002
"""How deep it may be in others there: what rests is in its support by rounding."""


@dataclass(frozen=True)
class Help:
    """A change of the room with which something would do.

    Attributes:
        what: The thing that would stand elsewhere.
        shift_m: How far from where it is, metres.
        nearer: Whether nearer to ``whom``, or farther from it.
        whom: An agent.
        so: What would do then: the thing could be ``grasped``, or would satisfy the goal at a ``place``.
        place: On or in what that place is; empty for ``grasped``.
    """

    what: str
    shift_m: float
    nearer: bool
    whom: str
    so: OneOf["grasped", "place"]
    place: str = ""


def helps(
    scene: Scene, state: State, request: Request, endings: Endings, actions: Actions, search: Search, contact: Contact
) -> Iterator[Help]:
    """Changes that would help, after a search in vain.

    Args:
        scene: The scene.
        state: Where everything is at the start.
        request: What was to be performed.
        endings: What ends will do.
        actions: What agents can grasp.
        search: What became of the candidates.
        contact: What rests on what.
    """
    thing, who = request.thing, request.performer
    if not actions.grasps(state, who, thing):
        near = _shifted(scene, state, thing, who, True, contact, lambda end: actions.grasps(end, who, thing))
        if near is not None:
            yield Help(thing, near, True, who, "grasped")
    closest = next((search.nearest[each] for each, _ in search.missed.most_common() if each in search.nearest), None)
    if not search.wanted and closest is not None:
        judge, place = endings.judge(state), closest.candidate
        still = [each for each in endings.others(place.state) if not endings.upon(place.state, each)]

        def does(end: State) -> bool:
            return judge.verdict(end).holds is True

        found = list[tuple[float, str, bool, str]]()
        for name, whom, nearer in product(still, request.targets, (True, False)):
            far = _shifted(scene, place.state, name, whom, nearer, contact, does)
            found += [] if far is None else [(far, name, nearer, whom)]
        if found:
            far, name, nearer, whom = min(found)
            yield Help(name, far, nearer, whom, "place", place.carrier)


def _shifted(
    scene: Scene, state: State, name: str, whom: str, nearer: bool, contact: Contact, does: Callable[[State], bool]
) -> float | None:
    """How far a thing would have to stand nearer to an agent, or farther away, at least; None if that does not do."""
    stage = Stage(scene, state)
    column, own = scene.object_slice(name), scene.solid_geoms_of(name)
    others, support = np.setdiff1d(stage.solid_geoms(), own), support_of(stage, name, contact)
    pose = np.array(state.qpos[column])
    way: Array = stage.body_position(scene.agent(whom).root_body)[:2] - pose[:2]
    length_m = float(np.linalg.norm(way))
    if support is None or not length_m:
        return None
    way = (way if nearer else -way) / length_m
    for far in np.arange(1, round(FARTHEST_M / STEP_M) + 1) * STEP_M:
        moved = pose.copy()
        moved[:2] += far * way
        end = state.replace(at=column, to=moved)
        stage.show(end)
        if support_of(stage, name, contact) != support:
            return None
        if max((deep for *_, deep in stage.overlaps(own, others)), default=0.0) > DEEP_M:
            continue
        if does(end):
            return float(far)
    return None
