"""Jido carries plans out in the shipped room, once for all tests of a process; neither audited nor judged."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

from taskgist.facts import vocabulary as v
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.values import NEGLIGIBLE
from taskgist.learning.understanding import Clause, Literal
from taskgist.performing.execution import Execution, carried_out
from taskgist.pipeline import shipped_room
from taskgist.planning.plan import Plan
from taskgist.planning.planner import Planner
from taskgist.planning.requests import Request
from taskgist.world import Scene

MEANS = {
    "hide": {"visibility.score.2": NEGLIGIBLE, "see.class": v.BECOMES_DIFFICULT, "placement.status.2": v.ON_SUPPORT},
    "give": {"hands.class": v.MANIP_GAINED, "placement.status.2": v.IN_HAND},
}


class CarriedOut(NamedTuple):
    plan: Plan
    execution: Execution


@cache
def carried(task: str) -> CarriedOut:
    """The first plan by which Jido performs a task for P2 with the cup."""
    wanted = [(STANDARD_TREE.node(name), value) for name, value in MEANS[task].items()]
    literals = tuple(Literal(node.name, node.title, value, node.instant) for node, value in wanted)
    scene = Scene.load(shipped_room())
    request = Request(Clause(task, literals), "Jido", "P2", "cup")
    plan = next(iter(Planner(scene, scene.initial, request).plans()))
    return CarriedOut(plan, carried_out(scene, plan, attention=request.attention))
