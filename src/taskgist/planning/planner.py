"""The search for a plan: goal, means, places, grasps and stands, motions, one gate after the other (9.1, 9.2).

Candidates for the thing's final place are judged by what the goal wants, cheapest literal first; those that satisfy it
go to the robot, which needs a grasp that does for both ends, two places to stand, and free ways between. What fails is
counted at the first gate that it fails, so that a refusal says what stood in the way, of how many.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import islice

from taskgist.common.workers import Progress, silent
from taskgist.facts.predicates import Predicate
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import HypothesisTree
from taskgist.facts.values import Raw
from taskgist.learning.understanding import AnyLiteral
from taskgist.perspective.effort import NO_KNOWN_LEVEL
from taskgist.planning.actions import Actions
from taskgist.planning.aims import Aim, aims_of, goal_of_all
from taskgist.planning.endings import Endings, laden
from taskgist.planning.goal import Goal
from taskgist.planning.helping import Help, helps
from taskgist.planning.pddl import Pddl, exported
from taskgist.planning.performer import Performer, refuse_held
from taskgist.planning.placing import Candidate
from taskgist.planning.plan import Action, Cost, Plan, efforts_of
from taskgist.planning.requests import Missed, Request, Search
from taskgist.planning.sequences import Sequences
from taskgist.settings import DEFAULT, Settings
from taskgist.world.scene import Scene
from taskgist.world.state import State

__all__ = ["Planner"]

MOST_PLACES = 1400
"""Candidates that are judged at most: so many that some on seats and floors are among them."""
SPARED_AMONG = 40
"""Of those that satisfy the goal so many are ordered by effort, if somebody's is to be spared."""
MOST_TRIED, MOST_TRIED_BY_PEOPLE = 8, 40
"""Of those that satisfy the goal, so many are tried with the robot; and with a person, whose motions are not planned
around things, and quickly found (ours)."""


class Planner:
    """Finds plans for a request.

    Args:
        scene: The scene.
        state: Where everything is.
        request: What is to be performed, with the first of its things.
        tree: The tree that the clause was learned in.
        settings: All settings.
        predicates: A user's own predicates.
        start: How everything was before anything was done; None: as in ``state``.
        kept: What has been brought about already, and shall stay so.
        lets_go: Whether hands must be empty in the end, because more is to follow.

    Attributes:
        scene: As given.
        request: As given.
        performer: The performing robot; None for a person.
        goal: What is wanted, given, or impossible for any target agent.
        aims: What is wanted of each target agent.
        search: What became of the candidates until now.

    Raises:
        UnknownNameError: There is no such agent, thing or support.
        SceneError: The performer has no arm or no hand that grasps, begins in something, or holds something; or
            somebody holds the thing.
    """

    def __init__(
        self,
        scene: Scene,
        state: State,
        request: Request,
        *,
        tree: HypothesisTree = STANDARD_TREE,
        settings: Settings = DEFAULT,
        predicates: Sequence[Predicate] = (),
        start: State | None = None,
        kept: Sequence[Aim] = (),
        lets_go: bool = False,
    ) -> None:
        self.scene, self._state, self.request, self._settings = scene, state, request, settings
        self._lets_go = lets_go
        refuse_held(scene, state, request.performer, request.thing, settings)
        self._actions = Actions(scene, state, settings, thing=request.thing, target=request.target, seed=request.seed)
        self.performer = self._actions.robot(request.performer, state)
        begin, who, what = state if start is None else start, request.targets, request.thing
        self.aims = aims_of(scene, begin, request.clause, who, what, tree, settings, predicates)
        self.goal = goal_of_all(self.aims)
        self._endings = Endings(scene, state, request, (*self.aims, *kept), settings, predicates, lets_go=lets_go)
        self.search = Search(thing=request.thing)
        self._sequences = Sequences(scene, state, request, self._endings, self._actions, self.search)

    @property
    def may_act(self) -> tuple[str, ...]:
        """The performer, and who may help it."""
        helpers = self._sequences.helpers if "relay" in self.request.means else ()
        return (self.request.performer, *helpers)

    def robot(self, name: str) -> Performer | None:
        """One of those who act, as it starts; None for a person."""
        return self._actions.robot(name, self._state)

    def pddl(self, plans: Sequence[Plan] = ()) -> Pddl:
        """The same problem for other planners, the places of some plans among its places."""
        return exported(self.scene, self._state, self.request, self._endings, self._actions, self.may_act, plans)

    def plans(self, progress: Progress = silent) -> Iterator[Plan]:
        """Plans, the nearest to the candidates' order first, each for another place; then those by other means.

        Args:
            progress: Told how far it is.
        """
        if self.goal.impossible:
            return
        blocked = dict[str, None]()
        if "move" in self.request.means:
            for action in self._moves(progress, blocked):
                yield self._plan((action,))
        for actions in self._sequences.found(progress, tuple(blocked)):
            yield self._plan(actions)

    def helps(self) -> tuple[Help, ...]:
        """After a search in vain: the least changes of the room with which it would not have been."""
        if self.goal.impossible:
            return ()
        contact = self._settings.contact
        return tuple(helps(self.scene, self._state, self.request, self._endings, self._actions, self.search, contact))

    def _moves(self, progress: Progress, blocked: dict[str, None]) -> Iterator[Action]:
        """The thing moved by the performer alone; what is in the way of its hand is noted."""
        who, why_not = self.request.performer, self._endings.why_not(self._state, self.request.performer)
        self.search.out_of_hold = self._actions.out_of_hold(self._state, who, self.request.thing)
        upon = self._endings.upon(self._state, self.request.thing)
        if upon and not self.search.out_of_hold:
            blocked |= dict.fromkeys(upon)
            self.search.out_of_hold = laden(self.request.thing, upon)
        if self.search.out_of_hold:
            return
        for candidate in self._in_order(self._wanted(progress)):
            if self.search.tried == self._most_tried:
                return
            if self._actions.out_of_reach(who, candidate):
                self.search.out_of_reach += 1
                continue
            self.search.tried += 1
            progress(f"how {who} gets the {self.request.thing} there", self._share())
            action = self._actions.plan(
                self._state, who, "move", candidate, why_not, draws=self._lets_go, blockers=blocked
            )
            if isinstance(action, Action):
                yield action
                continue
            self.search.refusals[action] += 1
            if self.performer is None:
                continue
            picking = self._actions.picking(self.performer, self._state, self.request.thing)
            self.search.details = picking.text
            cannot = self._actions.cannot_pick(self._state, who, self.request.thing)
            if cannot is not None:
                self.search.out_of_hold = cannot
                return

    @property
    def _most_tried(self) -> int:
        return MOST_TRIED_BY_PEOPLE if self.performer is None else MOST_TRIED

    def _share(self) -> float:
        return min(1.0, max(self.search.places / MOST_PLACES, self.search.tried / self._most_tried))

    def _wanted(self, progress: Progress) -> Iterator[Candidate]:
        """Candidates that satisfy the goal."""
        search = self.search
        for candidate, verdict in islice(self._endings.moved(self._state, self.request.performer), MOST_PLACES):
            search.places += 1
            if isinstance(verdict, str):
                search.out_of_hand += 1
                search.not_taken[verdict] += 1
                continue
            if verdict.failed is not None:
                search.missed[verdict.failed] += 1
                if verdict.judge < len(self.aims):
                    self._note(self.aims[verdict.judge].goal, verdict.failed, verdict.values, candidate)
            elif verdict.holds is True:
                search.wanted += 1
                yield candidate
            else:
                search.unknown += 1
            if search.places % 20 == 0:
                progress(f"{search.places} places judged", self._share())

    def _in_order(self, wanted: Iterator[Candidate]) -> Iterator[Candidate]:
        """Candidates in the order in which they are tried: by whose effort is to be spared, among the first of them."""
        request = self.request
        if request.spare == "nobody":
            yield from wanted
            return

        def spent(candidate: Candidate) -> tuple[int, int]:
            """What counts first, and then; the two efforts change places, or the greater one counts."""
            mine = self._actions.effort(self._state, request.performer, candidate)
            giver = NO_KNOWN_LEVEL if mine is None else mine
            taker = max(self._endings.target_levels(candidate).values())
            both = (max(giver, taker), giver + taker)
            return {"performer": (giver, taker), "target": (taker, giver)}.get(request.spare, both)

        yield from sorted(islice(wanted, SPARED_AMONG), key=spent)
        yield from wanted

    def _note(self, goal: Goal, literal: AnyLiteral, values: Mapping[str, Raw], candidate: Candidate) -> None:
        """Keep the nearest miss of a literal."""
        for wanted in goal.wanted:
            if literal in wanted.literals and wanted.attribute in values:
                found = values[wanted.attribute]
                off = wanted.missed_by(found)
                nearest = self.search.nearest.get(literal)
                if off is not None and (nearest is None or off < nearest.off):
                    self.search.nearest[literal] = Missed(off, found, candidate)

    def _plan(self, actions: tuple[Action, ...]) -> Plan:
        request, efforts = self.request, efforts_of(actions)
        if self._endings.target_takes or actions[-1].taker in request.targets:
            efforts |= self._endings.target_levels(actions[-1].candidate)
        return Plan(
            clause=request.clause,
            performer=request.performer,
            target=request.target,
            thing=request.thing,
            also_for=request.also_for,
            actions=actions,
            cost=Cost(len(actions), efforts),
        )
