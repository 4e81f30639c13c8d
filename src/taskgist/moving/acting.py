"""Acting: steps of a script become motions over time.

``Acting`` is the notebook of a performance: it knows the state at the present time of the script, and collects what
happens (motions of bodies, things carried, looks). The recorder then films it (``filming``). The performer acts; where
a task takes two, the target agent acts, too.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace

import numpy as np

from taskgist.common.arrays import Array
from taskgist.errors import SceneError
from taskgist.moving.body import Body, Phase, followed, paced
from taskgist.moving.gaze import TURN_S, Fixation
from taskgist.moving.hand_pose import Carry, HandPose
from taskgist.moving.motion import SWAYING, Moving, sway
from taskgist.world.dynamics import FreeMotion
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist.world.state import State

# --- Flights: things that have been let go, and move by physics.


@dataclass(frozen=True, eq=False)
class Flight:
    """A thing that moves on its own.

    Attributes:
        thing: Its name.
        from_s: When it was let go, or pushed.
        motion: How it has moved since then.
    """

    thing: str
    from_s: float
    motion: FreeMotion

    def poses(self, times_s: Array) -> Array:
        """Where it is at some times from then on: positions in metres and wxyz, (n, 7)."""
        return self.motion.at(times_s - self.from_s)


TEMPO_SPREAD = 0.1
"""Natural variation of durations, as a share."""


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
        flights: What moves by physics once it has been let go, in order.
        over_s: When what is demonstrated is over; None: once everything rests.
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
    flights: list[Flight] = field(default_factory=list)
    over_s: float | None = None
    _last_side: str = ""
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

    def begin(self, state: State, *, returning: Body | None = None) -> None:
        """Let everything begin in another state than the scene's, as when hands rest elsewhere.

        Args:
            state: How it begins.
            returning: A body that will not return to how it begins, but to where it rests.

        Raises:
            SceneError: Something has happened already.
        """
        if self.motions:
            raise SceneError("it has begun already", where=self.performer, hint="say first how everybody is at rest")
        self.at_rest = self.state = state
        self._bodies = {} if returning is None else {returning.agent.name: returning}

    def look(self, subject: str, *, ahead_s: float = 0.0, turn_s: float = TURN_S) -> None:
        """Let the performer look at something from now on, or from a little earlier, and turn its head so long."""
        self.looks.append(Fixation(max(0.0, self.now_s - ahead_s), subject, turn_s))

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
        self,
        side: str,
        way: Sequence[HandPose],
        *,
        torso_rad: Array,
        phase: Phase,
        agent: str | None = None,
        duration_s: float | None = None,
    ) -> None:
        """Move a hand through a way, and the body with it.

        Args:
            side: The hand.
            way: Where it passes, the last one being the goal (``sampled`` makes a smooth one).
            torso_rad: Turn and lean of the torso at the goal, (2,).
            phase: Out from rest, over from place to place, or back to rest, which follows after the goal.
            agent: Whose; None: the performer's.
            duration_s: How long it takes; None: as long as unhurried people take.

        Raises:
            SceneError: The hand does not get to its goal.
        """
        body = self.body_of(agent or self.performer)
        role = "target" if agent == self.target else "performing"
        states = followed(body, self.state, side, way, torso_rad=torso_rad, phase=phase, role=role)
        tempo = self._tempo() if duration_s is None else 1.0
        motion = paced(body, side, states, start_s=self.now_s, tempo=tempo, duration_s=duration_s)
        self.motions.append(Moving(body.agent.name, motion))
        self.now_s, self.state = motion.end_s, states[-1]
        if body is self.body:
            self._last_side = side

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

    @property
    def acting_side(self) -> str:
        """The hand that the performer moved last.

        Raises:
            SceneError: It has moved none yet.
        """
        return self._last_side or self.last_carry().side

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

    def _tempo(self) -> float:
        return float(1.0 + self.rng.uniform(-TEMPO_SPREAD, TEMPO_SPREAD))


# --- Filming: what was acted becomes frames, and frames a recording.
#
# Motions move bodies; what somebody carries moves rigidly with the hand, what was let go by physics; everybody sways
# a little and looks somewhere (``gaze``).

RATE_HZ = 30.0


def filmed(acting: Acting, *, swaying: bool = True) -> tuple[Array, Array]:
    """Frames of everything but people's gaze.

    Args:
        acting: The performance.
        swaying: Whether people sway a little. Where one motion is to begin as the one before has ended, they do not.

    Returns:
        Times in seconds, (n,), and positions, (n, nq).
    """
    times = np.arange(0.0, acting.now_s, 1.0 / RATE_HZ)
    frames = np.tile(acting.at_rest.qpos, (len(times), 1))
    for moving in acting.motions:
        since, body = times >= moving.start_s, acting.body_of(moving.agent)
        within = np.clip(moving.motion.at(times[since]), *body.ranges_rad.T)  # curves swing a little beyond their knots
        frames[np.ix_(since, body.columns)] = within
    for name in acting.scene.agents:
        joints = acting.scene.agent(name).joints
        if swaying and set(SWAYING) <= set(joints):  # robots keep still
            for joint, offsets in sway(times, acting.rng).items():
                frames[:, joints[joint]] += offsets
    for carry in acting.carries:
        _carry(acting, carry, times, frames)
    for flight in acting.flights:
        since = times >= flight.from_s
        frames[since, acting.scene.object_slice(flight.thing)] = flight.poses(times[since])
    return times, frames


def _carry(acting: Acting, carry: Carry, times: Array, frames: Array) -> None:
    """Let a thing follow the hand from where it was in the frame before, and rest where it was put."""
    column = acting.scene.object_slice(carry.thing)
    held = np.flatnonzero((times >= carry.from_s) & (times < carry.until_s))
    palms, turns = _hand_frames(acting, carry, frames[held])
    taken = replace(carry, taken=frames[held[0] - 1, column])
    frames[held, column] = taken.poses(times[held], palms, turns)
    if carry.rest is not None:
        frames[times >= carry.until_s, column] = carry.rest


def _hand_frames(acting: Acting, carry: Carry, frames: Array) -> tuple[Array, Array]:
    """Places (n, 3) and rotations (n, 3, 3) of the hand that carries."""
    stage, arm = Stage(acting.scene), acting.scene.agent(carry.agent or acting.performer).arm(carry.side)
    poses = [stage.show(State(frame)).site(arm.palm_site) for frame in frames]
    return np.array([pose.position for pose in poses]), np.array([pose.matrix for pose in poses])
