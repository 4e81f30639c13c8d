"""Sequences of actions: how a task is performed where moving the thing alone does not do (9.2).

**The problem.** The mug stands where nobody can hide it elsewhere, but a box would go over it; the picture would be
seen if the screen were not there; the tape lies under a bowl; the performer does not get to where the thing shall be,
and another robot does. All of these are short sequences of one kind of action: somebody brings something somewhere.

**The way.** A *sketch* says who moves what and why, and not where. Sketches wait in a queue, the cheapest first: an
action costs one, an effort level of whoever acts a fifth. For each that comes up the places are looked for, step by
step, by geometric tests as they are needed: the last step must bring about the goal, by the very judge of all others;
a step before it must leave the next one possible. What turns out to be in the way of a hand makes a longer sketch, in
which it is cleared first::

    1.8   R covers the mug with the box           the mug's 6 places under it all do; but the lid lies on the box:
    3.6   R clears the lid, R covers the mug with the box

Nothing is believed that was not tried: each action is planned by what plans any, from the state that the one before
leaves behind, with what was let go where physics has it.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import islice

import numpy as np

from taskgist.common.workers import Progress
from taskgist.errors import SceneError
from taskgist.learning.understanding import AnyLiteral
from taskgist.planning.actions import Actions, WhyNot, after
from taskgist.planning.endings import NOT_KNOWN, Endings, Judged, laden
from taskgist.planning.judging import Reason
from taskgist.planning.persons import moves_itself
from taskgist.planning.placing import Candidate
from taskgist.planning.plan import EFFORT_COST, Action, Purpose
from taskgist.planning.requests import Request, Search, Tried
from taskgist.world.scene import Scene
from taskgist.world.state import State

MOST_ACTIONS = 4
"""Actions of a sequence."""
MOST_PLACES = {"move": 300, "cover": 120, "clear": 300, "relay": 300, "slide": 32}
"""Places that are judged for a step at most, by what it is for."""
MOST_TRIED = {"move": 4, "cover": 6, "clear": 6, "relay": 10, "slide": 4}
"""Of those that will do, so many are tried with the body of whoever acts."""
MOST_IN_ALL = 12
"""Actions of robots that are tried for a sketch, all its steps together, before it is given up, or between two of its
plans: one in vain takes them a second or so (ours)."""
BY_PEOPLE = 3
"""So many times as many are tried with a person, whose motions are quickly found, and not planned around things."""
MOST_HANDED = 30
"""Places before a person who helps where the thing is handed over."""
MOST_PLANS = 3
"""Of one sketch: where an audit throws one away, others come."""
MOST_SKETCHES = 24
"""Sketches that are looked at (ours)."""


@dataclass(frozen=True)
class Step:
    """One action of a sketch: who moves what, and why.

    Attributes:
        agent: Who.
        purpose: Why.
        thing: What is carried.
    """

    agent: str
    purpose: Purpose
    thing: str


Sketch = tuple[Step, ...]


@dataclass
class _Trial:
    """What becomes of a sketch: how many places were judged, why it fails, what was in the way of which step.

    The reason may be a literal that fails. Of actions of robots those are counted that were tried since a plan was
    found. And the step whose thing may be slid over an edge before it is done, if one's lies too flat for the hand.
    """

    places: int = 0
    tried: int = 0
    why: Reason | AnyLiteral = ""
    blocked: tuple[int, tuple[str, ...]] | None = None
    flat: int | None = None


class _Waiting:
    """Sketches that wait, each once, the cheapest first; more may be added while they come.

    Args:
        cost: What one costs.
    """

    def __init__(self, cost: Callable[[Sketch], float]) -> None:
        self._cost, self._queue, self._known = cost, list[tuple[float, int, Sketch]](), set[Sketch]()

    def add(self, sketch: Sketch) -> None:
        """Let one wait, unless it has before, or is too long."""
        if sketch not in self._known and len(sketch) <= MOST_ACTIONS:
            self._known.add(sketch)
            heapq.heappush(self._queue, (self._cost(sketch), len(self._known), sketch))

    def __iter__(self) -> Iterator[Sketch]:
        while self._queue:
            yield heapq.heappop(self._queue)[-1]


class Sequences:
    """Looks for sequences of actions besides moving the thing alone.

    Args:
        scene: The scene.
        state: Where everything is.
        request: What is to be performed.
        endings: What ends will do.
        actions: Plans single actions.
        search: Told what became of sketches.
    """

    def __init__(
        self, scene: Scene, state: State, request: Request, endings: Endings, actions: Actions, search: Search
    ) -> None:
        self._scene, self._state, self._request = scene, state, request
        self._endings, self._actions, self._search = endings, actions, search

    def found(self, progress: Progress, blocked: tuple[str, ...] = ()) -> Iterator[tuple[Action, ...]]:
        """Sequences that bring about the goal, the cheapest sketch first.

        Args:
            progress: Told how far it is.
            blocked: What was in the way when the performer was to move the thing alone.
        """
        waiting = _Waiting(self._cost)
        for sketch in self._sketches(blocked):
            waiting.add(sketch)
        for number, sketch in enumerate(islice(waiting, MOST_SKETCHES)):
            progress(self.told(sketch), min(1.0, number / MOST_SKETCHES))
            trial, plans = _Trial(), 0
            for actions in islice(self._carried_out(self._state, sketch, (), trial), MOST_PLANS):
                plans += 1
                yield actions
            if plans:
                continue
            self._search.others.append(Tried(self.told(sketch), trial.places, trial.why or "there is no place for it"))
            for longer in (*self._cleared_first(sketch, trial), *self._slid_first(sketch, trial)):
                waiting.add(longer)

    def _slid_first(self, sketch: Sketch, trial: _Trial) -> Iterator[Sketch]:
        """The sketch with the thing of a step slid over an edge before it."""
        if trial.flat is not None and "slide" in self._request.means:
            step = sketch[trial.flat]
            yield *sketch[: trial.flat], Step(step.agent, "slide", step.thing), *sketch[trial.flat :]

    def _cleared_first(self, sketch: Sketch, trial: _Trial) -> Iterator[Sketch]:
        """Sketches in which something is cleared before the step that it kept from being done."""
        if trial.blocked is not None and "clear" in self._request.means:
            at, names = trial.blocked
            moved = {self._request.thing, *(step.thing for step in sketch)}
            for name in names:
                if name not in moved:
                    yield *sketch[:at], Step(sketch[at].agent, "clear", name), *sketch[at:]

    def told(self, sketch: Sketch) -> str:
        """A sketch in words."""
        thing, words = self._request.thing, list[str]()
        for step, then in zip(sketch, (*sketch[1:], None), strict=True):
            words.append(
                {
                    "move": f"{step.agent} brings the {thing} there",
                    "cover": f"{step.agent} covers the {thing} with the {step.thing}",
                    "clear": f"{step.agent} clears the {step.thing} out of the way",
                    "slide": f"{step.agent} slides the {step.thing} out over an edge",
                    "relay": f"{step.agent} brings the {thing} to where {then.agent if then else ''} takes it",
                }[step.purpose]
            )
        return ", ".join(words)

    # --- Sketches.

    def _sketches(self, blocked: tuple[str, ...]) -> Iterator[Sketch]:
        """Sketches to begin with."""
        request, state, who = self._request, self._state, self._request.performer
        move = Step(who, "move", request.thing)
        if {"move", "slide"} <= {*request.means} and self._actions.may_slide(state, who, request.thing):
            yield Step(who, "slide", request.thing), move
        if "cover" in request.means:
            for cover in self._endings.others(state):
                yield (Step(who, "cover", cover),)
        if "clear" in request.means:
            yield from self._clearing(state, move, blocked)
        if "relay" in request.means:
            for helper in self.helpers:
                yield Step(who, "relay", request.thing), Step(helper, "move", request.thing)
                yield Step(helper, "relay", request.thing), move

    def _clearing(self, state: State, move: Step, blocked: tuple[str, ...]) -> Iterator[Sketch]:
        """Sketches in which something is cleared: what hides the thing, or is in the way of moving it."""
        who, occluders = move.agent, self._endings.occluders(state)
        for name in occluders:
            yield (Step(who, "clear", name),)
        if len(occluders) > 1:
            yield tuple(Step(who, "clear", name) for name in occluders[:2])
        if "move" in self._request.means:
            for name in dict.fromkeys((*blocked, *self._in_the_way(state, move))):
                yield Step(who, "clear", name), move

    @property
    def helpers(self) -> tuple[str, ...]:
        """Who may take part besides the performer: those that are named, or all robots with a hand."""
        request, scene = self._request, self._scene
        if request.helpers is not None:
            return request.helpers
        out = (request.performer, *request.targets)
        agents = (scene.agent(name) for name in scene.agents if name not in out)
        return tuple(
            agent.name for agent in agents if agent.arms and agent.profile.hand is not None and not moves_itself(agent)
        )

    def _cost(self, sketch: Sketch) -> float:
        """What a sketch costs at least: its actions, and the effort that is known before anything is moved."""
        first = sketch[0]
        return len(sketch) + EFFORT_COST * self._actions.level(self._state, first.agent, first.thing)

    def _in_the_way(self, state: State, step: Step) -> tuple[str, ...]:
        """What must be cleared so that a step's agent grasps its thing at all; nothing if it does already."""
        if self._actions.grasps(state, step.agent, step.thing):
            return ()
        return tuple(
            name
            for name in self._endings.blockers(state, lambda end: self._actions.grasps(end, step.agent, step.thing))
            if name != step.thing
        )

    # --- Places and motions, step by step.

    def _carried_out(
        self, state: State, steps: Sketch, done: tuple[Action, ...], trial: _Trial
    ) -> Iterator[tuple[Action, ...]]:
        """All actions, where the steps that are left begin in a state."""
        step, rest, blockers = steps[0], steps[1:], dict[str, None]()
        if not self._begins(state, step, len(done), trial):
            return
        why_not = self._endings.why_not(state, step.agent)
        if rest:
            then = rest[0]

            def why_not(end: State) -> Reason | None:
                able = self._actions.grasps(end, then.agent, then.thing)
                return None if able else f"{then.agent} does not get hold of the {then.thing} then"

        leaves = bool(rest) and rest[0].agent != step.agent
        person = moves_itself(self._scene.agent(step.agent))
        most = MOST_TRIED[step.purpose] * (BY_PEOPLE if person else 1)
        slid = bool(done) and done[-1].purpose == "slide"
        for candidate in islice(self._reached(state, step, rest, trial, slid=slid), most):
            trial.tried += not person
            action = self._action(state, step, candidate, why_not, leaves=leaves, blockers=blockers)
            if not isinstance(action, Action):
                trial.why = action
                if not self._begins(state, step, len(done), trial):
                    return
                continue
            if not rest:
                trial.tried = 0
                yield (*done, action)
                continue
            end = after(self._scene, state, action)
            if isinstance(end, str):
                trial.why = end
            else:
                yield from self._carried_out(end, rest, (*done, action), trial)
        if blockers:
            trial.blocked = (len(done), tuple(blockers))

    def _action(
        self,
        state: State,
        step: Step,
        candidate: Candidate,
        why_not: WhyNot,
        *,
        leaves: bool,
        blockers: dict[str, None],
    ) -> Action | Reason:
        """A step carried out; or why not: whoever stands in something by then, say, carries out nothing."""
        try:
            return self._actions.plan(
                state, step.agent, step.purpose, candidate, why_not, leaves=leaves, blockers=blockers
            )
        except SceneError as error:
            return str(error)

    def _begins(self, state: State, step: Step, number: int, trial: _Trial) -> bool:
        """Whether a step can be begun in a state, as far as is known; if not, the trial is told why not."""
        upon = self._endings.upon(state, step.thing)
        cannot = self._actions.cannot_pick(state, step.agent, step.thing)
        if upon:
            trial.why = laden(step.thing, upon)
            trial.blocked = (number, upon)
        elif not self._actions.grasps(state, step.agent, step.thing):
            trial.why = f"{step.agent} does not get hold of the {step.thing}"
            trial.blocked = (number, self._in_the_way(state, step))
        elif cannot is not None and step.purpose != "slide":
            trial.why = cannot
            if self._actions.may_slide(state, step.agent, step.thing):
                trial.flat = number
        else:
            return True
        return False

    def _reached(
        self, state: State, step: Step, rest: Sketch, trial: _Trial, *, slid: bool = False
    ) -> Iterator[Candidate]:
        """Of the places to which a step brings its thing those at which its agent gets, until enough were tried."""
        for candidate in self._places(state, step, rest, trial, slid=slid):
            out = self._actions.out_of_reach(step.agent, candidate)
            if out is None:
                yield candidate
                if trial.tried >= MOST_IN_ALL:
                    return
            else:
                trial.why = trial.why or out

    def _places(self, state: State, step: Step, rest: Sketch, trial: _Trial, *, slid: bool) -> Iterator[Candidate]:
        """Places to which a step brings its thing: at the last the goal holds, before it the next one can be done.

        What was slid out is held from beneath, and put down that way, too; so that is asked before all that takes long.
        """

        def held(candidate: Candidate) -> bool:
            if not slid or self._actions.holds_at_both_ends(state, step.agent, candidate):
                return True
            trial.why = trial.why or f"no grasp of the {step.thing} does for both ends"
            return False

        if not rest:
            yield from filter(held, self._wanted(state, step, trial))
            return
        then, later, places = rest[0], {each.thing for each in rest}, trial.places
        for candidate in self._between(state, step, then):
            trial.places += 1
            if candidate.carrier in later:
                continue  # it would be on what is moved next
            if not held(candidate):
                continue
            able = [(then.agent, then.thing)]
            if step.purpose == "relay":  # who brings it there must get at the place, too
                able.append((step.agent, step.thing))
            cannot = [each for each in able if not self._actions.grasps(candidate.state, *each)]
            if cannot:
                trial.why = trial.why or "{} does not get hold of the {} there".format(*cannot[0])
            else:
                yield candidate
        if step.purpose == "slide" and trial.places == places:
            trial.why = trial.why or self._actions.why_not_slid(state, step.agent, step.thing)

    def _between(self, state: State, step: Step, then: Step) -> Iterator[Candidate]:
        """Places to which something is brought before the next step: before a helper's hand, or near and put down."""
        if step.purpose == "slide":
            yield from self._actions.slid_out(state, step.agent, step.thing)
            return
        if step.purpose == "relay" and moves_itself(self._scene.agent(then.agent)):
            yield from islice(self._endings.handed(state, step.agent, then.agent), MOST_HANDED)
        near = islice(self._endings.put(state, step.agent, step.thing), MOST_PLACES[step.purpose])
        yield from sorted(near, key=lambda each: self._detour_m(state, step, then, each))

    def _wanted(self, state: State, step: Step, trial: _Trial) -> Iterator[Candidate]:
        """Final places of what the last step moves with which the goal holds."""
        for found in islice(self._ends(state, step), MOST_PLACES[step.purpose]):
            trial.places += 1
            if isinstance(found.verdict, str):
                trial.why = trial.why or f"{self._request.target} could not take it: {found.verdict}"
            elif found.verdict.holds is True:
                yield found.candidate
            elif found.verdict.failed is not None:
                trial.why = trial.why or found.verdict.failed
            else:
                trial.why = trial.why or NOT_KNOWN

    def _detour_m(self, state: State, step: Step, then: Step, candidate: Candidate) -> float:
        """How far a place in between is from where the thing is, and from whoever acts next, metres."""
        place, before = candidate.pose[:2], state.qpos[self._scene.object_slice(step.thing)][:2]
        away_m = float(np.linalg.norm(place - before))
        if then.agent != step.agent:
            away_m += float(np.linalg.norm(place - state.qpos[self._scene.base_slice(then.agent)][:2]))
        return round(away_m, 6)

    def _ends(self, state: State, step: Step) -> Iterator[Judged]:
        """Final places of what the last step moves, each judged."""
        if step.purpose == "cover":
            return self._endings.covered(state, step.agent, step.thing)
        if step.purpose == "clear":
            return self._endings.cleared(state, step.agent, step.thing)
        return self._endings.moved(state, step.agent)
