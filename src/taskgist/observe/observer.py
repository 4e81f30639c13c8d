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
from taskgist.observe.frames import KEPT_FRAMES, Confirmed, FrameSequence, Hysteresis, speed_m_s
from taskgist.settings import DEFAULT, Settings, Timing
from taskgist.world.contacts import hand_known, rests_on
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage, posture_of
from taskgist.world.state import Frames, Hold, State

POSTURES = {"standing": v.STANDING, "sitting": v.SITTING}


@dataclass(frozen=True)
class Placement:
    """Where an object is: the symbol (None: unknown), and by what: support, container, or hands."""

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


def hand_key(status: HandStatus) -> tuple[str | None, str | None]:
    """What of a hand's status must last: which object it holds matters, on which support it rests does not."""
    return status.symbol, status.thing if status.symbol == v.HOLDING_OBJECT else None


class Motion:
    """Whether something moves: its speed over a short window, with hysteresis between starting and coming to rest.

    Only frames between which it was always tracked make a speed (5.3.2 leaves all this open).

    Args:
        frames: The frames; more may be appended.
        place: Gives its place in a frame in metres (3,), by the frame's index; None where it was not tracked.
        settings: Window in seconds, and the two speeds in metres per second.
    """

    def __init__(self, frames: FrameSequence, place: Callable[[int], Array | None], settings: Timing) -> None:
        self._frames, self._settings = frames, settings
        self._place, self._speed_m_s = lru_cache(KEPT_FRAMES)(place), lru_cache(KEPT_FRAMES)(self._speed_in)
        self._moving = Hysteresis(self._moves)

    def at(self, index: int) -> str | None:
        """``Moving`` or ``Static`` in a frame; None where it was not tracked, or the frame stands alone."""
        if self._place(index) is None or self._speed_m_s(index) is None:
            return None
        return v.MOVING if self._moving.at(index) else v.STATIC

    def _moves(self, index: int, before: bool) -> bool:
        if self._place(index) is None:
            return False
        speed_m_s, limit = self._speed_m_s(index), self._settings
        return before if speed_m_s is None else speed_m_s > (limit.static_m_s if before else limit.moving_m_s)

    def _speed_in(self, index: int) -> float | None:
        window = self._frames.window(index, self._settings.motion_window_s)
        before = self._tracked(range(index - 1, window.start - 1, -1))
        tracked = [*before[::-1], *self._tracked(range(index, window.stop))]
        return speed_m_s([time_s for time_s, _ in tracked], [place for _, place in tracked])

    def _tracked(self, indices: range) -> list[tuple[float, Array]]:
        """Times and places in these frames, until the first in which it was not tracked."""
        found = []
        for index in indices:
            if (place := self._place(index)) is None:
                break
            found.append((self._frames.times_s[index], place))
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
        self._frames = FrameSequence(max(timing.motion_window_s, self._contact.slip_window_s), frames)
        self._stage = Stage(scene)
        self._carrying = Carrying(self._stage, self._frames, self._contact)
        minimum_s = timing.minimum_s
        self._placements = {
            name: Confirmed(self._frames, partial(self._placement, name), minimum_s, key=lambda placed: placed.symbol)
            for name in scene.objects
        }
        self._motions = {
            name: Confirmed(self._frames, Motion(self._frames, partial(self._place, name), timing).at, minimum_s)
            for name in scene.objects
        }
        hands: list[Confirmed[HandStatus]] = []
        self._hands = {
            (agent, side): Confirmed(self._frames, partial(self._hand, agent, side), minimum_s, hand_key, hands)
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
        self._frames.append(state)

    def finish(self) -> None:
        """Say that no more frames will come: the last ones count, too."""
        self._frames.finish()

    def placement(self, name: str) -> Confirmed[Placement]:
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

    def hand(self, agent: str, side: str) -> Confirmed[HandStatus]:
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

    def with_holding(self, state: State) -> State:
        """A state with who holds what in it, as confirmed at its time: what perspective should start from."""
        return state.with_holding(self.holds(state.time_s))

    # What is so in a single frame, before time confirms it:

    def _placement(self, name: str, index: int) -> Placement:
        """The first that applies (5.3.1): Inside_Container, On_Support, In_Hand, In_Air."""
        holding = self._carrying.holding(index, name)
        if holding is None:
            return Placement(None)
        if holding.container:
            return Placement(v.INSIDE_CONTAINER, (holding.container,))
        if holding.support:
            return Placement(v.ON_SUPPORT, (holding.support,))
        if holding.hands:
            return Placement(v.IN_HAND, tuple(f"{agent}'s {side} hand" for agent, side in holding.hands))
        return Placement(v.IN_AIR if holding.complete else None)

    def _hand(self, name: str, side: str, index: int) -> HandStatus:
        """What one hand does (Eq. 16); holding comes before resting."""
        agent, stage = self.scene.agent(name), self._stage
        arm = agent.arm(side)
        if not hand_known(stage.show(self._frames.state(index)), agent, arm):
            return HandStatus(None)
        if held := self._carrying.held(index, name, side):
            return HandStatus(v.HOLDING_OBJECT, held)
        support = rests_on(stage.show(self._frames.state(index)), arm, self._contact)
        return HandStatus(v.RESTING_ON_SUPPORT, support) if support else HandStatus(v.FREE_OF_OBJECT)

    def _place(self, name: str, index: int) -> Array | None:
        state = self._frames.state(index)
        return np.array(state.qpos[self.scene.object_slice(name)][:3]) if state.known([name]) else None

    def _posture(self, name: str, index: int) -> str | None:
        posture = posture_of(self._stage.show(self._frames.state(index)), self.scene.agent(name), self._contact)
        return POSTURES[posture] if posture else None
