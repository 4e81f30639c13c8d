"""All attributes of the tree at one instant: the seam between geometry and symbols (level 3).

``snapshot`` gathers what is confirmed over time, what ``perspective`` finds in the state (5.1), and what a user's own
predicates observe. A predicate's function is called as ``observe(stage, agent, object)`` with the stage in that state,
and returns a value of its attribute, a truth value, an ``Observation``, or ``UNKNOWN``.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import cast

from taskgist.common.frozen import Json
from taskgist.errors import FactsError
from taskgist.facts import vocabulary as v
from taskgist.facts.predicates import Predicate
from taskgist.facts.values import UNKNOWN, Observation, Raw
from taskgist.observe.observer import HandStatus, Observer
from taskgist.perspective.effort import ABILITIES, Effort, evidence_document
from taskgist.perspective.search import effort_from
from taskgist.perspective.viewpoint import Viewpoint
from taskgist.settings import DEFAULT, Settings
from taskgist.world.stage import Stage

Snapshot = dict[str, Observation[Raw]]
"""What was observed at one instant, by attribute."""
LADDERS = {"see": v.SEE_EFFORTS, "reach": v.REACH_EFFORTS, "grasp": v.REACH_EFFORTS}


def ability_observations(stage: Stage, agent: str, name: str, settings: Settings) -> Snapshot:
    """Effort, state and action of each ability, and the visibility score, in the state that the stage shows.

    Args:
        stage: The scene in a state.
        agent: From whose perspective.
        name: The object.
        settings: All settings.

    Returns:
        Observations by attribute: ``reach.effort``, ``reach.state``, ``reach.action``, ..., ``visibility.score``.
    """
    observations: Snapshot = {}
    here = Viewpoint(stage, agent, settings)
    for ability in ABILITIES:
        observations |= _effort_observations(effort_from(here, name, ability, explained=True), settings)
    seen = here.visibility(name)
    observations["visibility.score"] = (
        Observation(UNKNOWN) if seen is None else Observation(seen.score, _plain(evidence_document(seen)))
    )
    return observations


def _effort_observations(effort: Effort, settings: Settings) -> Snapshot:
    ability = effort.ability
    names = ("effort", "state", "action")
    evidence = _plain(effort.evidence_document)
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
    """Symbol of the attained state S: posture and binned joint angles, without the place in the room."""
    bin_rad = settings.efforts.state_bin_rad
    bins = {joint: round(angle / bin_rad) for joint, angle in sorted(effort.joints_rad.items())}
    bent = [f"{joint} {round(math.degrees(count * bin_rad)):+d}°" for joint, count in bins.items() if count]
    return ", ".join([effort.posture or "posture unknown", *bent])


def snapshot(
    stage: Stage,
    observer: Observer,
    *,
    agent: str,
    name: str,
    settings: Settings = DEFAULT,
    predicates: Iterable[Predicate] = (),
) -> Snapshot:
    """Every attribute from one agent's perspective of one object, in the state that the stage shows.

    Args:
        stage: The scene in a state; afterwards it shows the same state with who holds what decided.
        observer: What is confirmed over time: in a whole recording, or in the states up to this one.
        agent: From whose perspective.
        name: The object.
        settings: All settings.
        predicates: A user's own predicates to observe too.
    """
    stage.show(observer.with_holding(stage.state))
    observations = ability_observations(stage, agent, name, settings)
    observations |= status_observations(observer, agent, name, stage.state.time_s)
    for predicate in predicates:
        if predicate.observe is not None:
            observations[predicate.subtree.attribute.name] = _observed(predicate, stage, agent, name)
    return observations


def status_observations(observer: Observer, agent: str, name: str, time_s: float) -> Snapshot:
    """The attributes that need time but no perspective: posture, hands, placement, motion."""
    placement = observer.placement(name).at(time_s)
    hands = [f"{hold.agent}'s {hold.side} hand" for hold in observer.holds(time_s) if hold.object == name]
    return {
        "posture": Observation(observer.posture(agent).at(time_s) or UNKNOWN),
        "hands": _hands(observer, agent, name, time_s),
        "placement": Observation(
            (placement and placement.symbol) or UNKNOWN, {"by": hands or list(placement.by if placement else ())}
        ),
        "motion": Observation(observer.motion(name).at(time_s) or UNKNOWN),
    }


def _hands(observer: Observer, agent: str, name: str, time_s: float) -> Observation[Raw]:
    """Status of each hand: does it hold this object, or another? What it holds or rests on is evidence."""
    symbols: dict[str, str | None] = {}
    evidence: dict[str, str] = {}
    for side in observer.scene.agent(agent).sides:
        status = observer.hand(agent, side).at(time_s) or HandStatus(None)
        holds_other = status.symbol == v.HOLDING_OBJECT and status.thing != name
        symbols[side] = v.HOLDING_OTHER if holds_other else status.symbol
        if status.thing:
            evidence[side] = status.thing
    return Observation(symbols or UNKNOWN, evidence)


def _observed(predicate: Predicate, stage: Stage, agent: str, name: str) -> Observation[Raw]:
    assert predicate.observe is not None
    value = predicate.observe(stage, agent, name)
    if isinstance(value, Observation):
        return value
    if value is UNKNOWN or isinstance(value, str | bool):
        return Observation(value)
    raise FactsError(
        "a predicate's function gives a text, a truth value, an Observation or UNKNOWN",
        field=predicate.subtree.name,
        value=value,
    )
