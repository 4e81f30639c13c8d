"""Single actions: how one agent brings one thing to one place, from any state (9.2).

Whatever an action is for, it is planned alike: a robot needs a grasp that does for both ends, two places to stand, and
free ways between (``transfer``, ``motions``); a person moves as the engine's own bodies do (``persons``). The next
action begins where this one ends: with everybody where they are then, and what was let go where physics has it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from itertools import islice, pairwise

from taskgist.errors import SceneError
from taskgist.perspective.effort import NO_KNOWN_LEVEL
from taskgist.perspective.scene_efforts import SceneEfforts
from taskgist.planning.grasping import Grasping
from taskgist.planning.hand_ways import Gate
from taskgist.planning.handing import PersonTaker, Taker, sides_by_distance
from taskgist.planning.judging import EXACT, Reason
from taskgist.planning.motions import Motions, NoEndError, NoMotionError, NoPickError
from taskgist.planning.people_colliding import pushing_into
from taskgist.planning.performer import Performer
from taskgist.planning.persons import drawn_near, gets_to, moves_itself, phases_of, usable
from taskgist.planning.placing import Candidate
from taskgist.planning.plan import Action, Phase, Purpose
from taskgist.planning.robot_taking import taker_of
from taskgist.planning.settling import settled
from taskgist.planning.sliding import slid_out, why_not_slid
from taskgist.planning.transfer import Picking, Transfers, slidings
from taskgist.settings import Settings
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist.world.state import State

Attempt = tuple[str, Callable[[], tuple[Phase, ...]]]
"""A hand, and what makes the phases with it, or raises ``NoMotionError``."""
WhyNot = Callable[[State], Reason | None]
"""Why the end of an action, seen as a state, will not do; None if it will."""
TRANSFERS_A_PLACE = 3
"""Ways to bring the thing to a place, grasps and stands, whose motions are tried."""


class Actions:
    """Plans single actions of the agents of a scene.

    Args:
        scene: The scene.
        start: Where everything is at first; people's hands return to where they are then.
        settings: All settings.
        thing: What the task is about.
        target: For whom people act; they look at it.
        seed: The same question with the same seed has the same plans.
    """

    def __init__(
        self, scene: Scene, start: State, settings: Settings, *, thing: str, target: str, seed: int = 0
    ) -> None:
        self._scene, self._start, self._settings, self._seed = scene, start, settings, seed
        self._thing, self._target = thing, target
        self._robots: dict[tuple[str, bytes], Performer] = {}
        self._pickings: dict[tuple[str, bytes, str], Picking] = {}
        self._motions: dict[Performer, Motions] = {}
        self._followed: dict[str, SceneEfforts] = {}
        self._levels: dict[tuple[bytes, str, str], int] = {}

    def robot(self, name: str, state: State) -> Performer | None:
        """A robot that starts from a state; None for a person.

        Raises:
            UnknownNameError: There is no such agent.
            SceneError: It has no arm, or no hand that grasps.
        """
        if moves_itself(self._scene.agent(name)):
            return None
        key = (name, state.qpos.tobytes())
        if key not in self._robots:
            self._robots[key] = Performer(self._scene, name, self._settings, start=state)
        return self._robots[key]

    def plan(
        self,
        state: State,
        name: str,
        purpose: Purpose,
        candidate: Candidate,
        why_not: WhyNot,
        *,
        leaves: bool = False,
        draws: bool = False,
        blockers: dict[str, None] | None = None,
    ) -> Action | Reason:
        """How an agent brings a thing to a place.

        Args:
            state: Where everything is.
            name: Who does it.
            purpose: What for.
            candidate: What is brought where.
            why_not: What is asked of the end.
            leaves: Whether a robot drives back to where it was, to make room for somebody else, if it can.
            draws: Whether a person who takes it draws it near, to make room for what follows, if it can.
            blockers: Filled with the things that are in the way of its hand.

        Returns:
            The action; or why there is none.
        """
        robot = self.robot(name, state)
        failed: Reason = ""
        picking = None if robot is None else self.picking(robot, state, candidate.thing)
        transfers = None if picking is None else Transfers(picking, candidate.pose)
        for side, attempt in self._attempts(state, name, candidate, robot, transfers):
            try:
                phases = attempt()
                if draws and candidate.means == "hand_over":
                    phases = self._drawn_near(name, phases)
                phases = self._ending_well(robot, state, name, phases, why_not, leaves)
            except NoMotionError as error:
                if robot is not None or not failed:  # of people, that of the nearer hand
                    failed = error.reason if isinstance(error, NoEndError) else str(error)
                if picking is not None and isinstance(error, NoPickError):
                    picking.give_up(error.transfer)
                continue
            effort = self.effort(state, name, candidate)
            return Action(name, side, purpose, candidate, effort, phases, self._thing)
        if picking is not None and blockers is not None:
            blockers |= dict.fromkeys(self._blockers(picking.grasping))
        if candidate.means == "slide_out":
            return failed or f"{name} gets its hand on the {candidate.thing} nowhere from where it could slide it"
        return failed or (transfers and transfers.refusal) or "no way was found"

    def picking(self, robot: Performer, state: State, thing: str) -> Picking:
        """A robot's picking a thing up, in a state in which it begins."""
        key = (robot.agent.name, state.qpos.tobytes(), thing)
        if key not in self._pickings:
            self._pickings[key] = Picking(Grasping(robot, state, thing))
        return self._pickings[key]

    def _motions_of(self, robot: Performer) -> Motions:
        if robot not in self._motions:
            self._motions[robot] = Motions(robot, self._settings.planning, seed=self._seed)
        return self._motions[robot]

    def cannot_pick(self, state: State, name: str, thing: str) -> str | None:
        """Why a robot cannot pick a thing up, wherever it is to go; None if it can, or has not been asked to yet."""
        picking = self._pickings.get((name, state.qpos.tobytes(), thing))
        if picking is None or picking.refusal is None:
            return None
        return f"{name} cannot pick the {thing} up: {picking.refusal}"

    def may_slide(self, state: State, name: str, thing: str) -> bool:
        """Whether a robot's hand does not close on a thing as it lies, but perhaps where it sticks out over an edge."""
        robot = self.robot(name, state)
        return robot is not None and self.picking(robot, state, thing).may_slide

    def slid_out(self, state: State, name: str, thing: str) -> Iterator[Candidate]:
        """Where a robot may slide a thing out over an edge, to pick it up from there."""
        robot = self.robot(name, state)
        return iter(()) if robot is None else slid_out(self._scene, state, robot, thing)

    def why_not_slid(self, state: State, name: str, thing: str) -> str:
        """Why ``slid_out`` has no place, in words."""
        robot = self.robot(name, state)
        return f"{name} slides nothing" if robot is None else why_not_slid(self._scene, state, robot, thing)

    def holds_at_both_ends(self, state: State, name: str, candidate: Candidate) -> bool:
        """Whether some grasp of a robot's hand is free where a thing lies, and where it is to be; a person's is."""
        robot = self.robot(name, state)
        if robot is None:
            return True
        return len(self.picking(robot, state, candidate.thing).grasping.towards(candidate.pose).free) > 0

    def out_of_hold(self, state: State, name: str, thing: str) -> str:
        """Why an agent does not get hold of a thing where it is, by its own effort; nothing if it does."""
        if self.grasps(state, name, thing):
            return ""
        efforts, person = self._efforts(name, state), moves_itself(self._scene.agent(name))
        what = None if person else self._anywhere(name).would_have_to(efforts, thing)
        if what is None:
            reason = efforts.effort(name, thing, "grasp", self._usable(name)).reason
        else:
            reason = f"it would have to {what}, which is not planned"
        return f"{name} cannot grasp the {thing}: {reason}"

    def out_of_reach(self, name: str, candidate: Candidate) -> str | None:
        """Why an agent does not get at a place, by its own effort; None if it does."""
        if not self._as_high(name, candidate):
            return f"{name} does not reach so far"
        effort = self._efforts(name, candidate.state).effort(name, candidate.thing, "reach", self._usable(name))
        person = moves_itself(self._scene.agent(name))
        if effort.is_known_to_do and not (person and not self._gets_to(name, candidate)):
            return None
        return f"from where it is, {name} does not reach so far" if person else f"{name} does not reach so far"

    def _as_high(self, name: str, candidate: Candidate) -> bool:
        """Whether an arm may get as high, or as low, as a place is, wherever a robot stands; asked quickly, first."""
        if moves_itself(self._scene.agent(name)):
            return True
        bounds = Stage(self._scene, candidate.state).bounds(self._scene.seen_geoms(candidate.thing))
        (lowest_m, highest_m), (low_m, high_m) = bounds[:, 2], self._anywhere(name).heights_m
        return bool(lowest_m <= high_m and highest_m >= low_m)

    def _gets_to(self, name: str, candidate: Candidate) -> bool:
        stage = Stage(self._scene, candidate.state)
        place = stage.body_position(self._scene.object_body(candidate.thing))
        return gets_to(self._scene, candidate.state, name, candidate.thing, place)

    def _efforts(self, name: str, state: State) -> SceneEfforts:
        """Efforts in a state; from one state to the next only what changes is asked again."""
        state = state.with_holding(None)
        if name not in self._followed:
            settings = replace(self._settings, following=EXACT)
            self._followed[name] = SceneEfforts(Stage(self._scene, state), settings)
        if self._followed[name].state is not state:
            self._followed[name].update(state)
        return self._followed[name]

    def _usable(self, name: str) -> tuple[str, ...]:
        """The virtual actions that an agent carries out here: people stay where they are."""
        agent = self._scene.agent(name)
        return usable(agent) if moves_itself(agent) else self._anywhere(name).actions

    def effort(self, state: State, name: str, candidate: Candidate) -> int | None:
        """The least effort level with which an agent grasps a thing where it is and reaches it where it is to be."""
        efforts = SceneEfforts(Stage(self._scene, state.with_holding(None)), self._settings)
        before = efforts.effort(name, candidate.thing, "grasp", self._usable(name)).level
        efforts.update(candidate.state.with_holding(None))
        after = efforts.effort(name, candidate.thing, "reach", self._usable(name)).level
        return None if before is None or after is None else max(before, after)

    def level(self, state: State, name: str, thing: str) -> int:
        """The least effort level with which an agent grasps a thing where it is; what is unknown counts as none known.

        Only virtual actions count that it carries out here: people stay where they are.
        """
        key = (state.qpos.tobytes(), name, thing)
        if key not in self._levels:
            try:
                level = self._efforts(name, state).effort(name, thing, "grasp", self._usable(name)).level
            except SceneError:  # it has no hand, or stands in something: it does nothing
                level = None
            self._levels[key] = NO_KNOWN_LEVEL if level is None else level
        return self._levels[key]

    def grasps(self, state: State, name: str, thing: str) -> bool:
        """Whether an agent can grasp a thing where it is, by its own effort."""
        return self.level(state, name, thing) < NO_KNOWN_LEVEL

    def _anywhere(self, name: str) -> Performer:
        """A robot wherever it stands: what it can do is the same everywhere."""
        known = next((robot for (who, _), robot in self._robots.items() if who == name), None)
        return known or Performer(self._scene, name, self._settings, start=self._start)

    def _blockers(self, grasping: Grasping) -> list[str]:
        """Things that are in the way of a hand that would pick a thing up, those that block most first."""
        len(grasping.free)  # by which those are counted that are in the way where the thing lies
        met = Counter[str]()
        for gate in (Gate.HAND_AT_START, Gate.BODY, Gate.APPROACH, Gate.RISE):
            met += Counter({name.removeprefix("the "): n for name, n in grasping.tally.met.get(gate, {}).items()})
        return [name for name, _ in met.most_common() if name in self._scene.objects and name != grasping.thing]

    def _attempts(
        self, state: State, name: str, candidate: Candidate, robot: Performer | None, transfers: Transfers | None
    ) -> Iterator[Attempt]:
        whom = candidate.carrier if candidate.means == "hand_over" else self._target
        taker = taker_of(self._scene, whom, state, self._settings, seed=self._seed)
        if robot is None or transfers is None:  # a person, the nearer hand first
            holding = [
                hold.side for hold in state.holding or () if (hold.agent, hold.object) == (name, candidate.thing)
            ]
            rest, seed = self._start, self._seed
            for side in holding or sides_by_distance(self._scene, state.qpos, candidate.thing, name):
                acts = partial(phases_of, self._scene, state, name, whom, candidate, side, taker, rest=rest, seed=seed)
                for into in _hands(taker, candidate, side):
                    yield side, partial(acts, into=into)
            return
        motions = self._motions_of(robot)
        if candidate.means == "slide_out":
            for stand, slid in islice(slidings(robot, state, candidate), TRANSFERS_A_PLACE):
                yield slid.press.side, partial(motions.slid, stand, slid)
            return
        for transfer in islice(transfers, TRANSFERS_A_PLACE):
            yield transfer.pick.side, partial(motions.of, transfer, candidate.means, taker)

    def _drawn_near(self, name: str, phases: tuple[Phase, ...]) -> tuple[Phase, ...]:
        """The phases of a handover, and a person's drawing near what it has taken, if that meets nothing."""
        last = phases[-1]
        for hold in last.holds:
            if hold.agent != name and moves_itself(self._scene.agent(hold.agent)):
                try:
                    drawn = drawn_near(self._scene, last, hold, self._start, seed=self._seed)
                except NoMotionError:
                    return phases
                if pushing_into(self._scene, last.qpos[-1], [drawn], hold.agent) is None:
                    return (*phases, drawn)
        return phases

    def _ending_well(
        self,
        robot: Performer | None,
        state: State,
        name: str,
        phases: tuple[Phase, ...],
        why_not: WhyNot,
        leaves: bool,
    ) -> tuple[Phase, ...]:
        """The phases, and if the robot would spoil the end where it stands, its way back.

        Raises:
            NoMotionError: A person would push into something, or the end will not do.
        """
        met = pushing_into(self._scene, state.qpos, phases, name)
        if met is not None:
            raise NoMotionError(met)
        wrong, holds = why_not(_seen(state, phases)), phases[-1].holds
        if robot is not None and (leaves or wrong is not None) and all(hold.agent != name for hold in holds):
            motions = self._motions_of(robot)
            try:
                phases += motions.back(phases[-1].qpos[-1], holds, robot.base(state.qpos))
            except NoMotionError:
                if wrong is not None:
                    raise
            wrong = why_not(_seen(state, phases))
        if wrong is not None:
            raise NoEndError(wrong)
        return phases


def _hands(taker: Taker, candidate: Candidate, side: str) -> tuple[str | None, ...]:
    """Into which hands of a person a hand may hand a thing over; None: that is not the question, or all are full.

    Of two who face one another both right hands come from two sides of the thing, a left and a right one from one.
    """
    if candidate.means != "hand_over" or not isinstance(taker, PersonTaker):
        return (None,)
    free = taker.sides(candidate.state.qpos, candidate.thing)
    return tuple(sorted(free, key=lambda hand: hand != side)) or (None,)


def _seen(state: State, phases: tuple[Phase, ...]) -> State:
    return state.replace(at=slice(None), to=phases[-1].qpos[-1])


def after(scene: Scene, state: State, action: Action) -> State | str:
    """The state that an action leaves behind, with what was let go where physics has it; or why it does not stay.

    Args:
        scene: The scene.
        state: In which it began.
        action: The action.
    """
    qpos = action.phases[-1].qpos[-1].copy()
    for one, other in pairwise(action.phases):
        held = {hold.object for hold in other.holds}
        for hold in sorted(one.holds):
            if hold.object not in held:
                end = settled(scene, State(other.qpos[0]), hold.object, passing=[f"{hold.agent}/{hold.side}_arm"])
                if not end.stays:
                    return f"once it is let go, {end.text}"
                for name in end.motions:
                    column = scene.object_slice(name)
                    qpos[column] = end.state.qpos[column]
    others = {hold for hold in state.holding or () if hold.object != action.thing}
    return state.replace(at=slice(None), to=qpos).with_holding((others | action.phases[-1].holds) or None)
