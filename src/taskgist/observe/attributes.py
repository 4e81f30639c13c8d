"""All attributes of the tree at one instant: the seam between geometry and symbols (level 3).

``snapshot`` gathers what is confirmed over time, what ``perspective`` finds in the state (5.1), and what a user's own
predicates observe. A predicate's function is called as ``observe(stage, agent, object)`` with the stage in that state,
and returns a value of its attribute, a truth value, an ``Observation``, or ``UNKNOWN``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import cast

from taskgist.common.frozen import Json
from taskgist.errors import FactsError
from taskgist.facts import vocabulary as v
from taskgist.facts.predicates import Predicate
from taskgist.facts.values import UNKNOWN, Observation, Raw
from taskgist.observe.observer import (
    POSTURES,
    HandStatus,
    Observer,
    Placement,
    hand_status_in,
    held_in,
    placement_in,
)
from taskgist.perspective.effort import ABILITIES, Effort, Visibility, evidence_document
from taskgist.perspective.image import visibility
from taskgist.perspective.search import effort_from
from taskgist.perspective.viewpoint import Viewpoint
from taskgist.settings import DEFAULT, Settings
from taskgist.world.contacts import holding_of
from taskgist.world.stage import Stage, posture_of
from taskgist.world.state import HEADS_ALONE

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
        observations |= effort_observations(effort_from(here, name, ability, explained=True), settings)
    observations["visibility.score"] = score_observation(here.visibility(name))
    return observations


def score_observation(seen: Visibility | None) -> Observation[Raw]:
    """The attribute *visibility score*; None is unknown."""
    return Observation(UNKNOWN) if seen is None else Observation(seen.score, _plain(evidence_document(seen)))


def effort_observations(effort: Effort, settings: Settings, *, explained: bool = True) -> Snapshot:
    """The attributes effort, state and action of an ability, with the effort's evidence or without it."""
    ability = effort.ability
    names = ("effort", "state", "action")
    evidence = _plain(effort.evidence_document if explained else {})
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
        stage: The scene in a state; afterwards it shows the same one with holding decided, and gazes: that of the
            agent, or those of all, if predicates are to be observed.
        observer: What is confirmed over time: in a whole recording, or in the states up to this one.
        agent: From whose perspective.
        name: The object.
        settings: All settings.
        predicates: A user's own predicates to observe too.
    """
    predicates = tuple(predicates)
    stage.show(observer.as_confirmed(stage.state, gaze_of=None if predicates else agent))
    observations = ability_observations(stage, agent, name, settings)
    observations |= status_observations(observer, agent, name, stage.state.time_s)
    return observations | _predicate_observations(predicates, stage, agent, name)


def status_observations(
    observer: Observer, agent: str, name: str, time_s: float, *, explained: bool = True
) -> Snapshot:
    """The attributes that need time but no perspective: posture, hands, placement, motion.

    Unless it is to be explained, placement is told without whose hands those are, and nobody else's are looked at.
    """
    holds = observer.holds(time_s) if explained else ()
    hands = [f"{hold.agent}'s {hold.side} hand" for hold in holds if hold.object == name]
    placement = observer.placement(name).at(time_s) or Placement(None)
    statuses = {side: observer.hand(agent, side).at(time_s) for side in observer.scene.agent(agent).sides}
    return {
        "posture": Observation(observer.posture(agent).at(time_s) or UNKNOWN),
        "hands": _hands(statuses, name),
        "placement": placement_observation(replace(placement, by=tuple(hands) or placement.by)),
        "motion": Observation(observer.motion(name).at(time_s) or UNKNOWN),
    }


def placement_observation(placement: Placement) -> Observation[Raw]:
    """The attribute *placement*, and by what the object is there."""
    return Observation(placement.symbol or UNKNOWN, {"by": list(placement.by)})


def _hands(statuses: Mapping[str, HandStatus | None], name: str) -> Observation[Raw]:
    """Status of each hand: does it hold this object, or another? What it holds or rests on is evidence."""
    symbols: dict[str, str | None] = {}
    evidence: dict[str, str] = {}
    for side, status in statuses.items():
        status = status or HandStatus(None)
        holds_other = status.symbol == v.HOLDING_OBJECT and status.thing != name
        symbols[side] = v.HOLDING_OTHER if holds_other else status.symbol
        if status.thing:
            evidence[side] = status.thing
    return Observation(symbols or UNKNOWN, evidence)


def _predicate_observations(predicates: Iterable[Predicate], stage: Stage, agent: str, name: str) -> Snapshot:
    """The attributes of those of a user's own predicates that have a function."""
    return {
        predicate.subtree.attribute.name: predicate_observation(predicate, stage, agent, name)
        for predicate in predicates
        if predicate.observe is not None
    }


def predicate_observation(predicate: Predicate, stage: Stage, agent: str, name: str) -> Observation[Raw]:
    """What a user's own predicate, which has a function, observes in the state that the stage shows.

    Raises:
        FactsError: The function gives something else than it should.
    """
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


# --- One state alone, as if all had stood still in it for a while: how a planner judges what it has not brought about.
#
# Nothing slips in the hand that is near to it, nothing moves, and what is so lasts: time confirms all of it.


def resting_snapshot(
    stage: Stage,
    *,
    agent: str,
    name: str,
    settings: Settings = DEFAULT,
    predicates: Iterable[Predicate] = (),
) -> Snapshot:
    """Every attribute in a state in which all stands still: what ``snapshot`` says of it once it has lasted.

    Args:
        stage: The scene in a state; afterwards it shows the same state, with who holds what left to distances.
        agent: From whose perspective.
        name: The object.
        settings: All settings.
        predicates: A user's own predicates to observe too.
    """
    stage.show(stage.state.with_holding(None).with_eyes(HEADS_ALONE))
    observations = ability_observations(stage, agent, name, settings)
    for attribute, observe in RESTING.items():
        observations[attribute] = observe(stage, agent, name, settings)
    return observations | _predicate_observations(predicates, stage, agent, name)


def _resting_posture(stage: Stage, agent: str, _name: str, settings: Settings) -> Observation[Raw]:
    posture = posture_of(stage, stage.scene.agent(agent), settings.contact)
    return Observation(POSTURES[posture] if posture else UNKNOWN)


def _resting_hands(stage: Stage, agent: str, name: str, settings: Settings) -> Observation[Raw]:
    contact = settings.contact
    things = {side: held_in(stage, agent, side, contact) for side in stage.scene.agent(agent).sides}
    statuses = {side: hand_status_in(stage, agent, side, thing, contact) for side, thing in things.items()}
    return _hands(statuses, name)


def _resting_placement(stage: Stage, _agent: str, name: str, settings: Settings) -> Observation[Raw]:
    holding = holding_of(stage, name, settings.contact)
    return placement_observation(placement_in(stage, name, holding, settings.contact))


def _resting_motion(stage: Stage, _agent: str, name: str, _settings: Settings) -> Observation[Raw]:
    return Observation(v.STATIC if stage.state.known([name]) else UNKNOWN)


def _resting_score(stage: Stage, agent: str, name: str, settings: Settings) -> Observation[Raw]:
    return score_observation(visibility(stage, agent, name, settings))


RESTING: Mapping[str, Callable[[Stage, str, str, Settings], Observation[Raw]]] = {
    "placement": _resting_placement,
    "motion": _resting_motion,
    "posture": _resting_posture,
    "hands": _resting_hands,
    "visibility.score": _resting_score,
}
"""What observes each attribute that needs no search, in a state in which all stands still, the cheapest first."""
