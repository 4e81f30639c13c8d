"""Set questions about places: where A reaches, B sees and C does not."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import reduce

import numpy as np

from taskgist.errors import InputError
from taskgist.perspective.effort import Ability
from taskgist.perspective.maps.ability_map import TRIALS, AbilityMap, ability_map
from taskgist.perspective.maps.grid import Grid
from taskgist.perspective.maps.zone import Zone
from taskgist.perspective.queries.asking import Perspectives
from taskgist.perspective.queries.sets import All, Condition, Not, Question


@dataclass(frozen=True, eq=False)
class Answered:
    """A question's answer for every cell.

    Attributes:
        yes: Where it holds, and nothing solid is.
        unknown: Where that cannot be said for want of tracking.
        maps: The maps from which it was found.
    """

    yes: Zone
    unknown: Zone
    maps: tuple[AbilityMap, ...]


def zone_where(perspectives: Perspectives, question: Question, *, grid: Grid | None = None) -> Answered:
    """Answer a set question for places instead of objects.

    Args:
        perspectives: Of one state.
        question: As for ``objects_where``.
        grid: Where; by default the workspaces of all agents that the question names, along the first one's heading.

    Raises:
        InputError: It asks about grasping, for which there are no maps, or about nobody.
        UnknownNameError: There is no such agent.
    """
    agents = dict.fromkeys(agent for agent, _ in question.abilities)
    if not agents or any(ability not in TRIALS for _, ability in question.abilities):
        raise InputError("maps tell where agents see and reach", field="where", hint="ask about see and reach")
    stage = perspectives.stage
    for agent in agents:
        stage.scene.agent(agent)
    where = grid or Grid.around(stage, *agents, settings=perspectives.settings.maps)
    maps = {
        (agent, ability): ability_map(perspectives.standpoint(agent), ability=ability, grid=where)
        for agent, ability in question.abilities
    }
    solid = reduce(np.logical_or, (each.solid for each in maps.values()))
    free = Zone(where, ~solid)
    yes, no = _split(question, maps)
    return Answered(yes & free, free - yes - no, tuple(maps.values()))


def _split(question: Question, maps: Mapping[tuple[str, Ability], AbilityMap]) -> tuple[Zone, Zone]:
    """Where a question is true, and where it is false."""
    if isinstance(question, Not):
        yes, no = _split(question.part, maps)
        return no, yes
    if isinstance(question, All):
        split = [_split(part, maps) for part in question.parts]
        return reduce(Zone.__and__, (yes for yes, _ in split)), reduce(Zone.__or__, (no for _, no in split))
    assert isinstance(question, Condition), "questions are conditions and what combines them"
    found = maps[question.agent, question.ability]
    yes = found.at_most(question.max_level) - found.at_most(question.min_level - 1)
    return yes, ~(yes | found.unknown)
