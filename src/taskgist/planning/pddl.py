"""The same problem for other planners, as PDDL: who gets at what where, what is in whose way, what ends will do (9.2).

Places are sampled: where each thing is, where it may go that the goal holds, where a cover goes over it, where
something may be put out of the way or handed on. What geometry says of each is a fact, with effort levels as kinds of
carrying, so that costs are constant, whole numbers (fifths of an action)::

    (:action carry-displacement
      :parameters (?who - agent ?what - thing ?from ?to - place)
      :precondition (and (at ?what ?from) (not (= ?from ?to))
                         (gets-displacement ?who ?what ?from) (gets-displacement ?who ?what ?to)
                         (forall (?other - thing) (imply (blocks ?other ?what ?from) (moved ?other))))
      :effect (and (not (at ?what ?from)) (at ?what ?to) (moved ?what) (increase (total-cost) 9)))

What no hand of a robot closes on as it lies, but would where it sticks out over an edge, the robot does not get at
where it is: it slides it to such a place first, by actions ``slide-...`` with facts ``slides-...`` from place to place.

Motions are not in it: that a robot finds its way must be asked of ``Actions`` for each step of a plan. The same names
with poses stand in ``places``, a value for JSON.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import islice
from typing import Any

from taskgist.learning.task_clauses import BY_RULE
from taskgist.learning.understanding import Clause
from taskgist.perspective.effort import EFFORT_NAMES, NO_KNOWN_LEVEL
from taskgist.planning.actions import Actions
from taskgist.planning.endings import Endings, Judged
from taskgist.planning.placing import Candidate
from taskgist.planning.plan import Action, Plan
from taskgist.planning.requests import Request
from taskgist.world.scene import Scene
from taskgist.world.state import State

KINDS = tuple(name.removesuffix("_Effort").lower().replace("_", "-") for name in EFFORT_NAMES["grasp"][:NO_KNOWN_LEVEL])
"""Kinds of carrying by the effort level that they take: "no-effort-required", "arm", "arm-torso", ..."""
ACTION_COST = NO_KNOWN_LEVEL
"""What an action costs beside its effort level, in fifths of an action."""
ENOUGH, MOST = 4, 200
"""So many places of a thing are enough, of so many that are judged."""
BETWEEN = 2
"""Places where something is put out of the way, handed on, or slid to."""
RESERVED = frozenset(
    {"agent", "thing", "place", "at", "moved", "blocks", "object", "number", "total-cost", "and", "or"}
)


@dataclass(frozen=True, eq=False)
class Pddl:
    """A problem in PDDL.

    Attributes:
        domain: The domain.
        problem: The problem.
        places: What places are, by name: whose, what carries it there, how it gets there, and the pose of its body.
        plans: The plans that were found, as sequences of its actions, a text for each.
    """

    domain: str
    problem: str
    places: dict[str, Any]
    plans: tuple[str, ...]


@dataclass(frozen=True)
class _Place:
    """A place of a thing: where it is at the start (no candidate), or a candidate; whether the goal holds with it."""

    thing: str
    name: str
    candidate: Candidate | None
    will_do: bool


Levels = dict[tuple[str, _Place], int]
"""The level with which an agent gets at a place."""
Slides = dict[tuple[str, _Place, _Place], int]
"""The level with which an agent slides a thing from a place to another."""


@dataclass
class Names:
    """Names as PDDL has them, each once, whatever case or signs the room's names have."""

    given: dict[tuple[str, str], str] = field(default_factory=dict)

    def of(self, kind: str, name: str) -> str:
        """The name of an agent, a thing or a place."""
        if (kind, name) not in self.given:
            plain = re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-") or kind
            plain = plain if plain[0].isalpha() else f"{kind}-{plain}"
            taken, found, number = RESERVED | set(self.given.values()), plain, 1
            while found in taken:
                number += 1
                found = f"{plain}-{number}"
            self.given[kind, name] = found
        return self.given[kind, name]


def exported(
    scene: Scene,
    state: State,
    request: Request,
    endings: Endings,
    actions: Actions,
    agents: Sequence[str],
    plans: Sequence[Plan] = (),
) -> Pddl:
    """A request as a problem in PDDL.

    Args:
        scene: The scene.
        state: Where everything is.
        request: What is to be performed.
        endings: What ends will do.
        actions: What agents get at.
        agents: Who may act, the performer first.
        plans: Plans that were found, whose places are among those of the problem.
    """
    return _Export(scene, state, request, endings, actions, agents).document(plans)


class _Export:
    def __init__(
        self,
        scene: Scene,
        state: State,
        request: Request,
        endings: Endings,
        actions: Actions,
        agents: Sequence[str],
    ) -> None:
        self._scene, self._state, self._request, self._endings, self._actions = scene, state, request, endings, actions
        self._agents = tuple(agents)
        self._things = tuple(name for name in scene.objects if state.known([name]))
        self._names = Names()
        for agent in self._agents:
            self._names.of("agent", agent)
        for thing in self._things:
            self._names.of("thing", thing)

    def document(self, plans: Sequence[Plan]) -> Pddl:
        """All of it."""
        places = [place for thing in self._things for place in self._places(thing, plans)]
        levels = dict(self._levels(places))
        slides = dict(self._slides(places, plans))
        used = sorted(set(levels.values()))
        return Pddl(
            _domain(used, sorted(set(slides.values()))),
            self._problem(places, levels, slides, used, plans),
            {place.name: self._told(place) for place in places},
            tuple(self._plan(plan, places, levels, slides) for plan in plans),
        )

    # --- Places.

    def _places(self, thing: str, plans: Sequence[Plan]) -> Iterator[_Place]:
        """Where a thing is, and where it may go."""
        yield _Place(thing, self._names.of("place", f"{thing}-here"), None, will_do=False)
        found: dict[bytes, tuple[Candidate, bool]] = {}
        slid = ((candidate, False) for there in self._slid[thing].values() for candidate in there)
        for candidate, will_do in (*self._planned(thing, plans), *self._enough(thing), *slid):
            found.setdefault(candidate.pose.tobytes(), (candidate, will_do))
        for number, (candidate, will_do) in enumerate(found.values()):
            yield _Place(thing, self._names.of("place", f"{thing}-{number + 1}"), candidate, will_do)

    def _planned(self, thing: str, plans: Sequence[Plan]) -> Iterator[tuple[Candidate, bool]]:
        for plan in plans:
            for action in plan.actions:
                if action.thing == thing:
                    yield action.candidate, len(plan.actions) == 1

    def _enough(self, thing: str) -> Iterator[tuple[Candidate, bool]]:
        """Places where the goal holds, and a few others that somebody gets at."""
        request, who = self._request, self._request.performer
        ends = list[Iterable[Judged]]()
        if thing == request.thing:
            ends += [self._endings.moved(self._state, who)] if {"move", "relay"} & set(request.means) else []
        else:
            ends += [self._endings.covered(self._state, who, thing)] if "cover" in request.means else []
            ends += [self._endings.cleared(self._state, who, thing)] if "clear" in request.means else []
        for end in ends:
            good = (
                each for each, verdict in islice(end, MOST) if not isinstance(verdict, str) and verdict.holds is True
            )
            for candidate in islice(good, ENOUGH):
                yield candidate, True
        between = {"relay"} if thing == request.thing else {"clear"}
        if between & set(request.means):
            nearby = islice(self._endings.put(self._state, who, thing), MOST)
            reached = (each for each in nearby if all(self._gets(agent, thing, each.state) for agent in self._agents))
            for candidate in islice(reached, BETWEEN):
                yield candidate, False

    def _gets(self, agent: str, thing: str, state: State) -> bool:
        return self._actions.level(state, agent, thing) < NO_KNOWN_LEVEL

    # --- Facts.

    def _levels(self, places: Sequence[_Place]) -> Iterator[tuple[tuple[str, _Place], int]]:
        """The level with which each agent gets at each place, if it does, and need not slide it from there first."""
        for place in places:
            state = self._begin(place.thing) if place.candidate is None else place.candidate.state
            for agent in self._agents:
                level = self._actions.level(state, agent, place.thing)
                flat = place.candidate is None and agent in self._flat[place.thing]
                if level < NO_KNOWN_LEVEL and not flat:
                    yield (agent, place), level

    def _slides(
        self, places: Sequence[_Place], plans: Sequence[Plan]
    ) -> Iterator[tuple[tuple[str, _Place, _Place], int]]:
        """The level with which each agent slides a thing from where it lies, and in plans from anywhere."""
        for thing in self._things:
            here = _here(places, thing)
            for agent, found in self._slid[thing].items():
                for candidate in found:
                    states = (self._begin(thing), candidate.state)
                    level = max(self._actions.level(state, agent, thing) for state in states)
                    if level < NO_KNOWN_LEVEL:
                        yield (agent, here, _place_of(places, candidate)), level
        for plan in plans:
            for action, before, to in _carried(places, plan):
                if action.purpose == "slide":
                    yield (action.performer, before, to), min(action.level, len(KINDS) - 1)

    def _begin(self, thing: str) -> State:
        """The start, in which what must be moved before a thing is thought away."""
        state = self._state
        for name in self._blocking[thing]:
            state = self._endings.without(state, name)
        return state

    @cached_property
    def _flat(self) -> dict[str, tuple[str, ...]]:
        """Of each thing the robots whose hand does not close on it as it lies, but perhaps once it sticks out."""
        return {
            thing: tuple(
                agent
                for agent in self._agents
                if self._gets(agent, thing, self._begin(thing))
                and self._actions.may_slide(self._begin(thing), agent, thing)
            )
            for thing in self._things
        }

    @cached_property
    def _slid(self) -> dict[str, dict[str, tuple[Candidate, ...]]]:
        """Of each thing where each of these may slide it."""
        if "slide" not in self._request.means:
            return {thing: {} for thing in self._things}
        return {
            thing: {
                agent: tuple(islice(self._actions.slid_out(self._begin(thing), agent, thing), BETWEEN))
                for agent in agents
            }
            for thing, agents in self._flat.items()
        }

    @cached_property
    def _blocking(self) -> dict[str, tuple[str, ...]]:
        return {thing: self._blocking_of(thing) for thing in self._things}

    def _blocking_of(self, thing: str) -> tuple[str, ...]:
        """What must be moved before a thing is taken from where it is: what lies on it, what keeps hands off."""
        upon = tuple(name for name in self._endings.upon(self._state, thing) if name != self._request.thing)
        if any(self._gets(agent, thing, self._state) for agent in self._agents):
            return upon
        who = self._request.performer
        kept = self._endings.blockers(self._state, lambda state: self._gets(who, thing, state))
        return tuple(dict.fromkeys((*upon, *(name for name in kept if name != thing))))

    def _problem(
        self,
        places: Sequence[_Place],
        levels: Levels,
        slides: Slides,
        used: Sequence[int],
        plans: Sequence[Plan],
    ) -> str:
        names, here = self._names.of, {place.thing: place for place in places if place.candidate is None}
        init = ["(= (total-cost) 0)"]
        init += [f"(at {names('thing', thing)} {here[thing].name})" for thing in self._things]
        for thing in self._things:
            blocking = [names("thing", name) for name in self._blocking[thing]]
            init += [f"(blocks {name} {names('thing', thing)} {here[thing].name})" for name in blocking]
        for (agent, place), level in levels.items():
            what = f"{names('agent', agent)} {names('thing', place.thing)} {place.name}"
            init += [f"(gets-{KINDS[more]} {what})" for more in used if more >= level]
        for (agent, before, to), level in slides.items():
            what = f"{names('agent', agent)} {names('thing', before.thing)} {before.name} {to.name}"
            init.append(f"(slides-{KINDS[level]} {what})")
        thing = self._request.thing
        ends = []
        for place in places:
            if place.will_do:
                at = f"(at {names('thing', place.thing)} {place.name})"
                stays = f"(at {names('thing', thing)} {here[thing].name})"
                ends.append(at if place.thing == thing else f"(and {at} {stays})")
        for plan in plans:
            if len(plan.actions) > 1:  # it will do where all that was moved is in the end
                last = {action.thing: to for action, _, to in _carried(places, plan)}
                where = " ".join(f"(at {names('thing', each)} {place.name})" for each, place in last.items())
                ends.append(f"(and {where})")
        goal = ["  (:goal (or", *(f"    {end}" for end in ends), "  ))"]
        if not ends:  # none of the places will do
            never = names("thing", thing)
            goal = [f"  (:goal (and (moved {never}) (not (moved {never}))))"]
        task = re.sub(r"[^a-z0-9]+", "-", self._request.clause.task.lower()).strip("-") or "task"
        lines = [
            *_about(self._request.clause),
            f"(define (problem {task}-for-{names('agent', self._request.target)})",
            "  (:domain bringing)",
            "  (:objects",
            *(f"    {names('agent', agent)} - agent" for agent in self._agents),
            *(f"    {names('thing', each)} - thing" for each in self._things),
            *(f"    {place.name} - place" for place in places),
            "  )",
            "  (:init",
            *(f"    {fact}" for fact in init),
            "  )",
            *goal,
            "  (:metric minimize (total-cost))",
            ")",
        ]
        return "\n".join(lines) + "\n"

    def _told(self, place: _Place) -> dict[str, Any]:
        """What a place is, for JSON."""
        column = self._scene.object_slice(place.thing)
        candidate = place.candidate
        pose = (self._state.qpos[column] if candidate is None else candidate.pose).tolist()
        return {
            "object": place.thing,
            "means": None if candidate is None else candidate.means,
            "carrier": None if candidate is None else candidate.carrier,
            "position_m": [round(float(value), 6) for value in pose[:3]],
            "wxyz": [round(float(value), 6) for value in pose[3:]],
        }

    def _plan(self, plan: Plan, places: Sequence[_Place], levels: Levels, slides: Slides) -> str:
        """A plan as a sequence of actions."""
        lines = []
        for action, before, to in _carried(places, plan):
            who, what = self._names.of("agent", action.performer), self._names.of("thing", action.thing)
            if action.purpose == "slide":
                level, how = slides[action.performer, before, to], "slide"
            else:
                known = (levels.get((action.performer, place), action.level) for place in (before, to))
                level, how = min(max(known), len(KINDS) - 1), "carry"
            lines.append(f"({how}-{KINDS[level]} {who} {what} {before.name} {to.name})")
        return "\n".join(lines) + "\n"


def _carried(places: Sequence[_Place], plan: Plan) -> Iterator[tuple[Action, _Place, _Place]]:
    """The actions of a plan, each with the places from which and to which it brings its thing."""
    at = {place.thing: place for place in places if place.candidate is None}
    for action in plan.actions:
        to = _place_of(places, action.candidate)
        yield action, at[action.thing], to
        at[action.thing] = to


def _here(places: Sequence[_Place], thing: str) -> _Place:
    """Where a thing is at the start."""
    return next(place for place in places if place.thing == thing and place.candidate is None)


def _place_of(places: Sequence[_Place], candidate: Candidate) -> _Place:
    """The place that a candidate is."""
    return next(place for place in places if place.thing == candidate.thing and _at(place, candidate))


def _at(place: _Place, candidate: Candidate) -> bool:
    return place.candidate is not None and bool((place.candidate.pose == candidate.pose).all())


ASCII = {"←": "<-", "≠": "!=", "≤": "<=", "≥": ">=", "≈": "about"}
"""Signs of clauses that not every reader of PDDL takes."""


def _about(clause: Clause) -> Iterator[str]:
    """What the problem is about, as comments: the rule by which it was learned, and each literal."""
    yield f"; {clause.head} <- {BY_RULE.get(clause.rule, '')}".rstrip()
    for literals, what in ((clause.literals, ""), (clause.usual, "usually "), (clause.always, "always shown ")):
        for literal in literals:
            text = "".join(ASCII.get(sign, sign) for sign in str(literal))
            yield f";   {what}{text}"


def _domain(used: Sequence[int], sliding: Sequence[int]) -> str:
    """The domain, with a kind of carrying, and of sliding, for each effort level that occurs."""
    lines = [
        "(define (domain bringing)",
        "  (:requirements :adl :typing :action-costs)",
        "  (:types agent thing place)",
        "  (:predicates",
        "    (at ?what - thing ?where - place)",
        "    (moved ?what - thing)",
        "    (blocks ?other - thing ?what - thing ?where - place)",
        *(f"    (gets-{KINDS[level]} ?who - agent ?what - thing ?where - place)" for level in used),
        *(f"    (slides-{KINDS[level]} ?who - agent ?what - thing ?from - place ?to - place)" for level in sliding),
        "  )",
        "  (:functions (total-cost) - number)",
    ]
    for level in used:
        lines += [
            f"  (:action carry-{KINDS[level]}",
            "    :parameters (?who - agent ?what - thing ?from - place ?to - place)",
            "    :precondition (and",
            "      (at ?what ?from) (not (= ?from ?to))",
            f"      (gets-{KINDS[level]} ?who ?what ?from)",
            f"      (gets-{KINDS[level]} ?who ?what ?to)",
            "      (forall (?other - thing) (imply (blocks ?other ?what ?from) (moved ?other))))",
            "    :effect (and",
            "      (not (at ?what ?from)) (at ?what ?to) (moved ?what)",
            f"      (increase (total-cost) {ACTION_COST + level})))",
        ]
    for level in sliding:  # what is slid is not out of the way of what it blocks
        lines += [
            f"  (:action slide-{KINDS[level]}",
            "    :parameters (?who - agent ?what - thing ?from - place ?to - place)",
            "    :precondition (and",
            f"      (at ?what ?from) (slides-{KINDS[level]} ?who ?what ?from ?to)",
            "      (forall (?other - thing) (imply (blocks ?other ?what ?from) (moved ?other))))",
            "    :effect (and",
            "      (not (at ?what ?from)) (at ?what ?to)",
            f"      (increase (total-cost) {ACTION_COST + level})))",
        ]
    return "\n".join([*lines, ")"]) + "\n"
