"""The observer: what is confirmed of hands, postures, placements and motion at any time (5.2, 5.3).

Of a whole recording it can be asked at once, and looks only at the frames that an answer hangs on. Live it takes one
state after another, and can be asked at any moment; what was confirmed by then stands ever after::

    observer = Observer(recording.scene, recording)
    observer.placement("cup").at(2.5)

    observer = Observer(scene)
    for state in tracker:
        observer.append(state)
        placement = observer.placement("cup").at(state.time_s)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache, partial

import numpy as np

from taskgist.common.arrays import Array
from taskgist.facts import vocabulary as v
from taskgist.observe.carrying import Carrying
from taskgist.observe.eyes import Eyes
from taskgist.observe.frames import KEPT_FRAMES, Confirmed, FrameSequence, Hysteresis, Refined, velocity
from taskgist.settings import DEFAULT, Contact, Settings, Timing
from taskgist.world.contacts import (
    POINT_SPACING_M,
    Holding,
    hand_gap_m,
    hand_known,
    holding_of,
    hook_of,
    object_points,
    possible_holds,
    rests_on,
    wearer_of,
)
from taskgist.world.geometry.transforms import Pose, matrix_from_wxyz
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage, posture_of
from taskgist.world.state import Frames, Hold, State

POSTURES = {"standing": v.STANDING, "sitting": v.SITTING}


@dataclass(frozen=True)
class Placement:
    """Where an object is: the symbol (None: unknown), and by what: support, container, hands, agent or hook."""

    symbol: str | None
    by: tuple[str, ...] = ()


@dataclass(frozen=True)
class HandStatus:
    """What a hand does: the symbol for *some* object (None: unknown), and which object it holds or support it rests on.

    Attributes:
        symbol: ``Holding_Object``, ``Resting_on_Support``, ``Free_of_Object``, or None.
        thing: The object or the support.
    """

    symbol: str | None
    thing: str | None = None


def placement_in(stage: Stage, name: str, holding: Holding | None, settings: Contact) -> Placement:
    """Where an object is in one state, for what is known of who holds it: the first that applies (5.3.1).

    Args:
        stage: The scene in the state.
        name: The object.
        holding: Who holds it, and what it rests on or lies in; None if it was not tracked.
        settings: Distances.
    """
    if holding is None:
        return Placement(None)
    if holding.container:
        return Placement(v.INSIDE_CONTAINER, (holding.container,))
    if holding.support:
        return Placement(v.ON_SUPPORT, (holding.support,))
    if holding.hands:
        return Placement(v.IN_HAND, tuple(f"{agent}'s {side} hand" for agent, side in holding.hands))
    if not holding.complete:
        return Placement(None)
    # The last three are ours: the paper has what is on an agent, or hangs, in the air.
    wearer, sure = wearer_of(stage, name, settings)
    if wearer or not sure:
        return Placement(v.ON_AGENT, (wearer,)) if wearer else Placement(None)
    hook = hook_of(stage, name, settings)
    return Placement(v.HANGING, (hook,)) if hook else Placement(v.IN_AIR)


def hand_status_in(stage: Stage, agent: str, side: str, thing: str | None, settings: Contact) -> HandStatus:
    """What one hand does in one state (Eq. 16); holding comes before resting.

    Args:
        stage: The scene in the state.
        agent: Whose hand.
        side: Which.
        thing: The object that it holds, if any.
        settings: Distances.
    """
    body = stage.scene.agent(agent)
    arm = body.arm(side)
    if not hand_known(stage, body, arm):
        return HandStatus(None)
    if thing:
        return HandStatus(v.HOLDING_OBJECT, thing)
    support = rests_on(stage, arm, settings)
    return HandStatus(v.RESTING_ON_SUPPORT, support) if support else HandStatus(v.FREE_OF_OBJECT)


def held_in(stage: Stage, agent: str, side: str, settings: Contact) -> str | None:
    """The object that a hand holds in a state in which all stands still, so that a hand that is near does not slip."""
    near = {hold.object for hold in possible_holds(stage, settings) if (hold.agent, hold.side) == (agent, side)}
    for name in stage.scene.objects:
        if name in near and (holding := holding_of(stage, name, settings)) and (agent, side) in holding.hands:
            return name
    return None


def held(status: HandStatus) -> tuple[bool | None, str | None]:
    """What of a hand's status must last first: which object it holds, or that it holds none; None if that is unknown.

    Whether it rests or is free then matters less. So nothing is both held and on a support for longer than either
    lasts.
    """
    holds = None if status.symbol is None else status.symbol == v.HOLDING_OBJECT
    return holds, status.thing if holds else None


class Motion:
    """Whether a thing moves: its speed over a short window, with hysteresis between starting and coming to rest.

    It is the speed of that of its points which moves fastest: turning in place is motion (Eq. 22 speaks of position),
    and where the frame of the body lies changes nothing. Only frames between which it was always tracked make a speed
    (5.3.2 leaves all this open).

    Args:
        frames: The frames; more may be appended.
        pose: Gives its pose in a frame, by the frame's index; None where it was not tracked.
        points: Its points in the frame of its pose, metres, (n, 3); of the middle alone, turning is no motion.
        settings: Window in seconds, and the two speeds in metres per second.
    """

    def __init__(
        self, frames: FrameSequence, pose: Callable[[int], Pose | None], points: Array, settings: Timing
    ) -> None:
        self._frames, self._points, self._settings = frames, points, settings
        self._pose, self._speed_m_s = lru_cache(KEPT_FRAMES)(pose), lru_cache(KEPT_FRAMES)(self._speed_in)
        self._moving = Hysteresis(self._moves)

    def at(self, index: int) -> str | None:
        """``Moving`` or ``Static`` in a frame; None where it was not tracked, or the frame stands alone."""
        if self._pose(index) is None or self._speed_m_s(index) is None:
            return None
        return v.MOVING if self._moving.at(index) else v.STATIC

    def _moves(self, index: int, before: bool) -> bool:
        if self._pose(index) is None:
            return False
        speed_m_s, limit = self._speed_m_s(index), self._settings
        return before if speed_m_s is None else speed_m_s > (limit.static_m_s if before else limit.moving_m_s)

    def _speed_in(self, index: int) -> float | None:
        window = self._frames.window(index, self._settings.motion_window_s)
        before = self._tracked(range(index - 1, window.start - 1, -1))
        tracked = [*before[::-1], *self._tracked(range(index, window.stop))]
        times_s = [time_s for time_s, _ in tracked]
        moving = velocity(times_s, [pose.position for _, pose in tracked])
        turning = velocity(times_s, [pose.matrix for _, pose in tracked])
        if moving is None or turning is None:
            return None
        return float(np.linalg.norm(self._points @ turning.T + moving, axis=1).max())

    def _tracked(self, indices: range) -> list[tuple[float, Pose]]:
        """Times and poses in these frames, until the first in which it was not tracked."""
        found = []
        for index in indices:
            if (pose := self._pose(index)) is None:
                break
            found.append((self._frames.times_s[index], pose))
        return found


class Observer:
    """Confirms facts over time.

    Live, it keeps the states of all frames, some 2 kB each, so that any time can be asked: begin with another for the
    next demonstration. What was found in a frame is kept for the latest frames only.

    Args:
        scene: The scene whose states the frames are.
        frames: All frames, such as a recording. Where they are left out, they come one by one: see ``append``.
        settings: Distances and durations.
    """

    def __init__(self, scene: Scene, frames: Frames | None = None, settings: Settings = DEFAULT) -> None:
        self.scene = scene
        timing, self._contact = settings.timing, settings.contact
        self._frames = FrameSequence(timing.motion_window_s, frames)
        # Who carries what is said half a second later: by then it is clear what a hand has come for.
        self._later = FrameSequence(max(timing.motion_window_s, 2 * settings.carrying.delay_s), frames)
        # Where eyes look follows from what hands will hold half a second later still.
        held_s = 2 * timing.minimum_s + max(timing.motion_window_s, 2 * settings.carrying.delay_s)
        self._latest = FrameSequence(held_s + 2 * settings.gaze.before_s, frames)
        self._stage = Stage(scene)
        self._eyes = Eyes(Stage(scene), self._latest, self._handled, settings.gaze)
        self._carrying = Carrying(self._stage, self._later, settings)
        minimum_s = timing.minimum_s
        self._placements = {
            name: Refined(self._later, partial(self._placement, name), minimum_s, kind=lambda placed: placed.symbol)
            for name in scene.objects
        }
        self._motions = {
            name: Confirmed(self._frames, self._motion_of(name, timing), minimum_s) for name in scene.objects
        }
        hands: list[Confirmed[HandStatus]] = []
        self._hands = {
            (agent, side): Refined(self._later, partial(self._hand, agent, side), minimum_s, held, hands)
            for agent in scene.agents
            for side in scene.agent(agent).sides
        }
        self._postures = {
            agent: Confirmed(self._frames, partial(self._posture, agent), minimum_s) for agent in scene.agents
        }

    def append(self, state: State) -> None:
        """Take the next frame. It counts once the frames half a window behind it have come.

        Raises:
            RecordingError: It is not later than the last one, or no more frames were to come.
        """
        for frames in (self._frames, self._later, self._latest):
            frames.append(state)

    def finish(self) -> None:
        """Say that no more frames will come: the last ones count, too."""
        for frames in (self._frames, self._later, self._latest):
            frames.finish()

    def placement(self, name: str) -> Refined[Placement]:
        """Placement of an object over time.

        Raises:
            UnknownNameError: There is no such object.
        """
        self.scene.object_body(name)
        return self._placements[name]

    def motion(self, name: str) -> Confirmed[str | None]:
        """Motion of an object over time; None is unknown.

        Raises:
            UnknownNameError: There is no such object.
        """
        self.scene.object_body(name)
        return self._motions[name]

    def hand(self, agent: str, side: str) -> Refined[HandStatus]:
        """Status of a hand over time.

        Raises:
            UnknownNameError: There is no such agent, or it has no such hand.
        """
        self.scene.agent(agent).arm(side)
        return self._hands[agent, side]

    def posture(self, agent: str) -> Confirmed[str | None]:
        """Posture of an agent over time; None is unknown.

        Raises:
            UnknownNameError: There is no such agent.
        """
        self.scene.agent(agent)
        return self._postures[agent]

    def holds(self, time_s: float) -> tuple[Hold, ...]:
        """Which hands hold what at a time, as confirmed."""
        statuses = ((hand, confirmed.at(time_s)) for hand, confirmed in self._hands.items())
        return tuple(
            Hold(*hand, status.thing)
            for hand, status in statuses
            if status and status.thing and status.symbol == v.HOLDING_OBJECT
        )

    def as_confirmed(self, state: State, gaze_of: str | None = None) -> State:
        """A state with who holds what in it and where eyes look, at its time: what perspective should start from.

        Args:
            state: The state.
            gaze_of: The only agent whose gaze matters; None: those of all are inferred, where they were not recorded.
        """
        agents = self.scene.agents if gaze_of is None else (gaze_of,)
        return state.with_holding(self.holds(state.time_s)).with_eyes(self._eyes.turns(state, agents))

    def _handled(self, hand: tuple[str, str], index: int) -> str | None:
        """What a hand holds in a frame, as confirmed, or else moves by touching it; None: nothing that is known."""
        time_s = self._latest.times_s[index]
        status = self._hands[hand].at(time_s)
        if status is None or status.symbol is None:
            return None
        if status.symbol == v.HOLDING_OBJECT:
            return status.thing
        agent, side = hand
        arm, limit_m, scene = self.scene.agent(agent).arm(side), self._contact.grip_m, self.scene
        stage = self._stage.show(self._latest.state(index))
        near = stage.near_pairs(arm.hand_geoms, scene.objects_geoms, limit_m=limit_m)
        for name in sorted({scene.owners[geom] for _, geom in near}):
            if hand_gap_m(stage, arm, name, limit_m=limit_m) < limit_m and self._motions[name].at(time_s) == v.MOVING:
                return name
        return None

    # What is so in a single frame, before time confirms it:

    def _placement(self, name: str, index: int) -> Placement:
        holding = self._carrying.holding(index, name)
        return placement_in(self._stage.show(self._later.state(index)), name, holding, self._contact)

    def _hand(self, name: str, side: str, index: int) -> HandStatus:
        thing = self._carrying.held(index, name, side)
        return hand_status_in(self._stage.show(self._later.state(index)), name, side, thing, self._contact)

    def _motion_of(self, name: str, timing: Timing) -> Callable[[int], str | None]:
        stage, body = self._stage.show(self.scene.initial), self.scene.object_body(name)
        points = stage.body(body).to_local(object_points(stage, name, POINT_SPACING_M))
        if not timing.turning_moves:
            points = points.mean(axis=0, keepdims=True)
        return Motion(self._frames, partial(self._pose, name), points, timing).at

    def _pose(self, name: str, index: int) -> Pose | None:
        state = self._frames.state(index)
        if not state.known([name]):
            return None
        pose = state.qpos[self.scene.object_slice(name)]
        return Pose(np.array(pose[:3]), matrix_from_wxyz(pose[3:]))

    def _posture(self, name: str, index: int) -> str | None:
        posture = posture_of(self._stage.show(self._frames.state(index)), self.scene.agent(name), self._contact)
        return POSTURES[posture] if posture else None
