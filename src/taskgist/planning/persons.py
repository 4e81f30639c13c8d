"""People as performers: the engine's own moving bodies, which demonstrate, do it (``moving``).

A person stays where it sits or stands: it takes the thing, brings it to its place or to another's hand, and takes the
hand back, the torso helping where the arm alone is too short.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from taskgist.common.arrays import Array
from taskgist.errors import SceneError
from taskgist.moving.acting import RATE_HZ, Acting, filmed
from taskgist.moving.body import Body
from taskgist.moving.steps import HandOver, HoldUp, PutDown, Take, Withdraw, carried_to, carry_to
from taskgist.perspective.effort import LEAN, TURN, stretch
from taskgist.planning.handing import FULL, PersonTaker, Taker
from taskgist.planning.motions import NoMotionError
from taskgist.planning.placing import Candidate
from taskgist.planning.plan import Phase, PhaseName
from taskgist.world.bodies.agent import Agent
from taskgist.world.contacts import object_points
from taskgist.world.geometry.transforms import rotate
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist.world.state import Hold, State

HOLDING_S = 0.5
NEAR_M, BELOW_M = 0.30, 0.15
"""Where somebody holds what it has been given: ahead of its shoulder, and below it."""
POINT_SPACING_M = 0.02
FARTHER_M = 0.15
"""How much farther than its arm is long a body gets to a thing's middle: it leans a little more than thought, and
fingers hold a thing by its near side (ours; who does not get there in the end is told so)."""


def moves_itself(agent: Agent) -> bool:
    """Whether an agent is moved as people are: it has a torso that turns and leans, legs, and two arms."""
    profile = agent.profile
    return profile.turn is not None and profile.lean is not None and bool(profile.legs.feet) and len(agent.arms) == 2


def usable(agent: Agent) -> tuple[str, ...]:
    """The virtual actions by which a person brings things about here: of arms and torso."""
    return (*(stretch(side) for side in agent.sides), TURN, LEAN)


def gets_to(scene: Scene, state: State, performer: str, thing: str, place: Array) -> bool:
    """Whether an arm of a person gets to a place as its torso moves here: that which holds a thing, or either.

    Perspective asks what a body could do; arms are stretched less far by those who put something down.
    """
    body = Body(scene, performer, state, turns_far=True)
    holding = [hold.side for hold in state.holding or () if (hold.agent, hold.object) == (performer, thing)]
    return any(
        body.away_m(state, side, place, body.torso_for(state, side, place))
        <= body.agent.arm(side).profile.length_m + FARTHER_M
        for side in holding or body.agent.sides
    )


def phases_of(
    scene: Scene,
    state: State,
    performer: str,
    target: str,
    candidate: Candidate,
    side: str,
    taker: Taker,
    *,
    into: str | None = None,
    rest: State | None = None,
    seed: int = 0,
) -> tuple[Phase, ...]:
    """What a person does to bring a thing to its place.

    Args:
        scene: The scene.
        state: Where everything is; who is said to hold the thing in that hand does so from the beginning.
        performer: The person.
        target: For whom: at whom the person looks.
        candidate: Where the thing goes.
        side: The person's hand.
        taker: To whom it is handed over, if it is.
        into: Into which hand of a person.
        rest: How the person is when it does nothing, to where its hand returns; None: as it is.
        seed: Of natural variation.

    Raises:
        NoMotionError: The hand does not get there.
    """
    acting = Acting(scene, performer, target, np.random.default_rng(seed))
    returning = Body(scene, performer, state if rest is None else rest, turns_far=True)
    acting.begin(state, returning=returning)
    to_robot = candidate.means == "hand_over" and not isinstance(taker, PersonTaker)
    marks: list[tuple[PhaseName, float]] = []
    held = Hold(performer, side, candidate.thing) in (state.holding or ())
    try:
        if held:
            acting.now_s = 1.0 / RATE_HZ  # things are carried from where they are in the frame before
            acting.take(candidate.thing, side, acting.body.hand(state, side))
        else:
            Take(candidate.thing, side).play(acting)
            marks.append(("reach", acting.now_s))
        _bring(acting, candidate, taker, into)
        marks.append(("transfer", acting.now_s))
        if candidate.means != "hold_up" and not to_robot:
            Withdraw().play(acting)
            marks.append(("retreat", acting.now_s))
    except SceneError as error:
        raise NoMotionError(f"{performer} does not get there: {error}") from error
    times_s, frames = filmed(acting, swaying=False)
    ends = [int(np.searchsorted(times_s, end_s)) for _, end_s in marks]
    phases = [
        phase
        for (name, _), first, last in zip(marks, [1 if held else 0, *ends], ends, strict=False)
        for phase in _by_holds(acting, name, times_s[first:last], frames[first:last])
    ]
    if to_robot:
        phases += _taken(scene, phases[-1], Hold(performer, side, candidate.thing), taker, returning, seed)
    return tuple(phases)


def _taken(scene: Scene, held: Phase, hold: Hold, taker: Taker, returning: Body, seed: int) -> Iterator[Phase]:
    """A robot takes what a person holds still, and the person takes the hand back.

    Raises:
        NoMotionError: The robot does not take it.
    """
    failed = FULL
    for found in taker.takings(held.qpos[-1], hold.object):
        if isinstance(found, str):
            failed = found
            continue
        other = Hold(taker.name, found.side, hold.object)
        yield Phase("take", found.coming, held.holds)
        yield Phase("take", found.shared, held.holds | {other})
        acting = Acting(scene, hold.agent, taker.name, np.random.default_rng(seed))
        acting.begin(State(found.shared[-1]), returning=returning)
        Withdraw(hold.side).play(acting)
        yield Phase("retreat", filmed(acting, swaying=False)[1][1:], held.holds - {hold} | {other})
        return
    raise NoMotionError(f"{taker.name} cannot take the {hold.object}: {failed}")


def drawn_near(scene: Scene, last: Phase, hold: Hold, rest: State, *, seed: int = 0) -> Phase:
    """Who has taken something draws it near, out of the way of what is to follow.

    Args:
        scene: The scene.
        last: After what it does.
        hold: Whose hand has what.
        rest: How that person is when it does nothing.
        seed: Of natural variation.

    Raises:
        NoMotionError: The hand does not get there.
    """
    body = Body(scene, hold.agent, rest, turns_far=True)
    acting = Acting(scene, hold.agent, hold.agent, np.random.default_rng(seed))
    acting.begin(State(last.qpos[-1]), returning=body)
    acting.now_s = 1.0 / RATE_HZ
    acting.take(hold.object, hold.side, body.hand(acting.state, hold.side))
    ahead = rotate(rest.qpos[body.agent.base][3:], (NEAR_M, 0.0, -BELOW_M))
    try:
        goal, _ = carried_to(acting, body.shoulder(rest, hold.side) + ahead)
        carry_to(acting, goal, lower=False)
    except SceneError as error:
        raise NoMotionError(f"{hold.agent} does not draw the {hold.object} near: {error}") from error
    return Phase("draw near", filmed(acting, swaying=False)[1][1:], last.holds)


def _bring(acting: Acting, candidate: Candidate, taker: Taker, into: str | None) -> None:
    """Put the thing down, hold it up, or hand it over."""
    stage = Stage(acting.scene, candidate.state)
    x, y, z = (float(value) for value in stage.body_position(acting.scene.object_body(candidate.thing)))
    if candidate.means == "hold_up":
        HoldUp((x, y, z), HOLDING_S).play(acting)
    elif candidate.means == "hand_over":
        goal, _ = carried_to(acting, np.array((x, y, z)))
        carry_to(acting, goal, lower=True)  # down to it from above: there may be a table on the way
        if not isinstance(taker, PersonTaker):
            acting.wait(HOLDING_S)
        elif into is None:
            raise SceneError(FULL, where=taker.name)
        else:
            HandOver(into).play(acting)
    else:
        bottom_m = float(object_points(stage, candidate.thing, POINT_SPACING_M)[:, 2].min())
        PutDown((x, y, bottom_m)).play(acting)


def _by_holds(acting: Acting, name: PhaseName, times_s: Array, frames: Array) -> list[Phase]:
    """A phase for each time that nobody takes, or lets go of, anything."""
    holds = [
        frozenset(
            Hold(carry.agent or acting.performer, carry.side, carry.thing)
            for carry in acting.carries
            if carry.from_s <= time_s < carry.until_s
        )
        for time_s in times_s
    ]
    cuts = [0, *(i for i in range(1, len(holds)) if holds[i] != holds[i - 1]), len(holds)]
    return [Phase(name, frames[first:last], holds[first]) for first, last in pairwise(cuts) if last > first]
