"""Abilities and visibility as attributes: what perspective finds, in the words of the tree (5.1)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import cast

from taskgist.facts import UNKNOWN, Json, Observation, Raw
from taskgist.facts import vocabulary as v
from taskgist.perspective import ABILITIES, Effort, Standpoint, effort_from, visibility_from
from taskgist.settings import Settings
from taskgist.world import Stage

LADDERS = {"see": v.SEE_EFFORTS, "reach": v.REACH_EFFORTS, "grasp": v.REACH_EFFORTS}


def ability_observations(stage: Stage, agent: str, name: str, settings: Settings) -> dict[str, Observation[Raw]]:
    """Effort, state and action of each ability, and the visibility score, in the state that the stage shows.

    Args:
        stage: The scene in a state.
        agent: From whose perspective.
        name: The object.
        settings: All settings.

    Returns:
        Observations by attribute: ``reach.effort``, ``reach.state``, ``reach.action``, ..., ``visibility.score``.
    """
    observations: dict[str, Observation[Raw]] = {}
    here = Standpoint(stage, agent, settings)
    for ability in ABILITIES:
        observations |= _effort_observations(effort_from(here, name, ability, explained=True), settings)
    seen = visibility_from(here, name)
    observations["visibility.score"] = (
        Observation(UNKNOWN) if seen is None else Observation(seen.score, _plain(seen.evidence))
    )
    return observations


def _effort_observations(effort: Effort, settings: Settings) -> dict[str, Observation[Raw]]:
    ability = effort.ability
    names = ("effort", "state", "action")
    evidence = _plain(effort.evidence)
    if effort.level is None:
        unknown: Observation[Raw] = Observation(UNKNOWN, evidence)
        return {f"{ability}.{name}": unknown for name in names}
    level: Observation[Raw] = Observation(LADDERS[ability][effort.level], evidence)
    state, actions = level.and_also(state_symbol(effort, settings)), level.and_also(" + ".join(effort.actions))
    return dict(zip((f"{ability}.{name}" for name in names), (level, state, actions), strict=True))


def _plain(evidence: Mapping[str, object]) -> Mapping[str, Json]:
    """Evidence of perspective as the facts want it; it is JSON by promise, and freezing it checks that."""
    return cast(Mapping[str, Json], evidence)


def state_symbol(effort: Effort, settings: Settings) -> str:
    """Symbol of the attained state S: posture and binned joint angles, without the place in the room (DESIGN 4.6)."""
    bin_rad = settings.efforts.state_bin_rad
    bins = {joint: round(angle / bin_rad) for joint, angle in sorted(effort.joints_rad.items())}
    bent = [f"{joint} {round(math.degrees(count * bin_rad)):+d}°" for joint, count in bins.items() if count]
    return ", ".join([effort.posture or "posture unknown", *bent])
