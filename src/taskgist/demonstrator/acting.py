"""Acting: steps of a script become motions over time.

``Acting`` is the notebook of a performance: it knows the state at the present time of the script, and collects what
happens (motions of bodies, things carried, looks). The recorder then films it (``filming``). The performer acts; where
a task takes two, the target agent acts, too.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from taskgist.demonstrator.body import Body
from taskgist.demonstrator.carry import Carry
from taskgist.demonstrator.gaze import Fixation
from taskgist.demonstrator.hand import HandPose
from taskgist.demonstrator.motion import Motion
from taskgist.demonstrator.moving import Moving
from taskgist.errors import SceneError
from taskgist.world import Scene, State

Array = NDArray[np.float64]

MEAN_SPEED_M_S = 0.45
"""Mean speed of a hand; the peak is nearly twice as much (unhurried reaching [Flash & Hogan 1985])."""
LEVER_M = 0.20
"""Lever with which the largest turn of a joint counts like a way of the hand: it bounds the joints' speeds."""
SHORTEST_S = 0.6
WAY_ITERATIONS, GOAL_ITERATIONS = 10, 60
"""Most steps of a fit on the way, where the next knot goes on from there, and at the goal, which must be met."""
LARGEST_ERROR_M = 0.003
"""How far a hand may end from its goal."""
SHORTEST_STEP_M = 1e-4
"""Keeps postures apart whose hands are at the same place."""
TEMPO_SPREAD = 0.1
"""Natural variation of durations, as a share."""
Phase = Literal["out", "over", "back"]
LEANING: Mapping[Phase, Callable[[Array], Array]] = {
    "out": lambda way: way**2,
    "over": lambda way: way,
    "back": lambda way: 1.0 - (1.0 - way) ** 2,
}
"""Share of the torso's movement after a share of the hand's way: near the body a hand needs no lean."""


@dataclass(eq=False)
class Acting:
    """A performance while it is worked out.

    Attributes:
        scene: The scene.
        performer: Name of the agent that acts.
        target: Name of the agent for whom.
        rng: Source of natural variation.
        at_rest: The state before anything happens.
        state: The state at ``now_s``.
        now_s: Time of the script.
        motions: Motions of bodies, in the order in which they were worked out.
        carries: Things carried, in order.
        looks: Looks of the performer, in order.
    """

    scene: Scene
    performer: str
    target: str
    rng: np.random.Generator
    at_rest: State = field(init=False)
    state: State = field(init=False)
    now_s: float = 0.0
    motions: list[Moving] = field(default_factory=list)
    carries: list[Carry] = field(default_factory=list)
    looks: list[Fixation] = field(default_factory=list)
    _bodies: dict[str, Body] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.at_rest = self.state = self.scene.initial

    @property
    def body(self) -> Body:
        """The performer's body."""
        return self.body_of(self.performer)

    def body_of(self, agent: str) -> Body:
        """Somebody's body."""
        if agent not in self._bodies:
            self._bodies[agent] = Body(self.scene, agent, self.at_rest)
        return self._bodies[agent]

    def begin(self, state: State) -> None:
        """Let everything begin in another state than the scene's, as when hands rest elsewhere.

        Raises:
            SceneError: Something has happened already.
        """
        if self.motions:
            raise SceneError("it has begun already", where=self.performer, hint="say first how everybody is at rest")
        self.at_rest = self.state = state
        self._bodies.clear()

    def look(self, subject: str, *, ahead_s: float = 0.0) -> None:
        """Let the performer look at something from now on, or from a little earlier."""
        self.looks.append(Fixation(max(0.0, self.now_s - ahead_s), subject))

    def wait(self, seconds: float) -> None:
        """Let time pass."""
        self.now_s += seconds * self._tempo()

    @contextmanager
    def meanwhile(self, since_s: float) -> Iterator[None]:
        """Let what is done within begin at an earlier time, beside what has been done since then."""
        now_s, self.now_s = self.now_s, since_s
        yield
        self.now_s = max(now_s, self.now_s)

    def move(
        self, side: str, way: Sequence[HandPose], *, torso_rad: Array, phase: Phase, agent: str | None = None
    ) -> None:
        """Move a hand through a way, and the body with it.

        Args:
            side: The hand.
            way: Where it passes, the last one being the goal (``sampled`` makes a smooth one).
            torso_rad: Turn and lean of the torso at the goal, (2,).
            phase: Out from rest, over from place to place, or back to rest, which follows after the goal.
            agent: Whose; None: the performer's.

        Raises:
            SceneError: The hand does not get to its goal.
        """
        body = self.body_of(agent or self.performer)
        states, error = self._following(body, side, way, torso_rad, phase)
        if phase == "back":
            states.append(body.with_posture(states[-1], body.posture(self.at_rest)))
        elif error > LARGEST_ERROR_M:
            who = "target" if agent == self.target else "performing"
            raise SceneError(
                f"the {side} hand ends {1000 * error:.0f} mm from where it shall be",
                where=body.agent.name,
                field=f"{side}_palm",
                value=tuple(way[-1].palm.round(3).tolist()),
                hint=f"put the thing or its goal nearer to the {who} agent",
            )
        self._append(body, side, [self.state, *states])
        self.state = states[-1]

    def _following(
        self, body: Body, side: str, way: Sequence[HandPose], torso_rad: Array, phase: Phase
    ) -> tuple[list[State], float]:
        """States in which the hand follows a way, and how many metres the last one is from its goal."""
        state, states, error = self.state, [], 0.0
        begin = body.posture(state)[:2]
        shares = LEANING[phase](np.linspace(0.0, 1.0, len(way) + 1)[1:])
        for hand, share in zip(way, shares, strict=True):
            torso = begin + share * (torso_rad - begin)
            iterations = GOAL_ITERATIONS if hand is way[-1] else WAY_ITERATIONS
            state, error = body.reaching(state, side, hand, torso, iterations=iterations)
            states.append(state)
        return states, error

    def take(self, thing: str, side: str, grip: HandPose) -> None:
        """Close the hand, which is where ``grip`` says, around a thing."""
        taken = np.array(self.state.qpos[self.scene.object_slice(thing)])
        self.carries.append(Carry(thing, side, self.now_s, grip, taken))

    def hand_over(self, agent: str, side: str, grip: HandPose) -> None:
        """Let somebody's hand, which is where ``grip`` says, take over what the performer holds."""
        carry, pose = self.holding(), self.held_pose()
        self.carries[-1] = replace(carry, until_s=self.now_s)
        self.carries.append(Carry(carry.thing, side, self.now_s, grip, pose, agent=agent))
        self.state = self.state.replace(at=self.scene.object_slice(carry.thing), to=pose)

    def held_pose(self) -> Array:
        """Where the thing that the performer holds is now: position and wxyz, (7,)."""
        carry = self.holding()
        return carry.pose(self.body.hand(self.state, carry.side))

    def release(self, rest: Array) -> None:
        """Leave what is held at rest: position and wxyz, (7,)."""
        carry = self.holding()
        self.carries[-1] = replace(carry, until_s=self.now_s, rest=rest)
        self.state = self.state.replace(at=self.scene.object_slice(carry.thing), to=rest)

    def last_carry(self) -> Carry:
        """What the performer holds now, or held last.

        Raises:
            SceneError: It has taken nothing yet.
        """
        for carry in reversed(self.carries):
            if carry.agent is None:
                return carry
        raise SceneError("nothing has been taken", where=self.performer, hint="begin the script with Take")

    def holding(self) -> Carry:
        """What the performer holds now.

        Raises:
            SceneError: Nothing.
        """
        carry = self.last_carry()
        if carry.until_s < np.inf:
            hint = "let a Take come before"
            raise SceneError("nothing is held any more", where=self.performer, field=carry.thing, hint=hint)
        return carry

    def _append(self, body: Body, side: str, states: Sequence[State]) -> None:
        palms = np.array([body.hand(state, side).palm for state in states])
        postures = np.array([body.posture(state) for state in states])
        moved = np.linalg.norm(np.diff(palms, axis=0), axis=1)
        turned = np.abs(np.diff(postures, axis=0)).max(axis=1)
        steps = np.hypot(moved, LEVER_M * turned) + SHORTEST_STEP_M
        ways = np.concatenate(([0.0], np.cumsum(steps)))
        duration = max(SHORTEST_S, ways[-1] / MEAN_SPEED_M_S) * self._tempo()
        self.motions.append(Moving(body.agent.name, Motion(postures, ways / ways[-1], self.now_s, duration)))
        self.now_s += duration

    def _tempo(self) -> float:
        return float(1.0 + self.rng.uniform(-TEMPO_SPREAD, TEMPO_SPREAD))
