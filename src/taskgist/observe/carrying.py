"""Who holds what over time: the one place that decides it. Placement and the hands' status ask here, frame by frame.

In a single state a hand holds what it is close to and what rests on nothing (``world/contacts.py``). Over time that is
too much: a hand that passes an object, or reaches around it before it closes, is near and yet does not hold. What tells
them apart is *slip*: how fast the palm moves in the object's own frame. A near hand begins to hold when its slip is
low, and lets go when it is high; in between it goes on as before.
"""

from __future__ import annotations

from functools import cache, lru_cache, partial

from taskgist.common.arrays import Array
from taskgist.observe.frames import KEPT_FRAMES, KEPT_STATES, FrameSequence, Hysteresis, speed_m_s
from taskgist.settings import Contact
from taskgist.world.contacts import Holding, RestingMemory, hand_known, holding_of, possible_holds
from taskgist.world.stage import Stage
from taskgist.world.state import Hold, State


class Carrying:
    """Says who holds what in the settled frames of a sequence.

    Args:
        stage: Their scene; it shows other states after each question.
        frames: The frames; more may be appended.
        settings: Distances, speeds and the window of the slip.
    """

    def __init__(self, stage: Stage, frames: FrameSequence, settings: Contact) -> None:
        self._stage, self._frames, self._settings = stage, frames, settings
        self._resting = RestingMemory(stage.scene, settings)
        self._possible = lru_cache(KEPT_FRAMES)(self._possible_in)
        self._slip_m_s = lru_cache(KEPT_FRAMES)(self._slip_of)
        self._moves_along = cache(lambda hold: Hysteresis(partial(self._goes_on, hold)))
        self._decided = lru_cache(KEPT_STATES)(self._decided_in)
        self._holding = lru_cache(KEPT_FRAMES)(self._holding_in)

    def holding(self, index: int, name: str) -> Holding | None:
        """Who holds an object in a frame, and what it rests on or lies in; None if it was not tracked."""
        return self._holding(index, name)

    def held(self, index: int, agent: str, side: str) -> str | None:
        """The object that a hand holds in a frame; None if it holds none."""
        moving_along = self._decided(index).holding or ()
        for name in self._stage.scene.objects:
            if Hold(agent, side, name) in moving_along:
                holding = self._holding(index, name)
                if holding and (agent, side) in holding.hands:
                    return name
        return None

    def _holding_in(self, index: int, name: str) -> Holding | None:
        return holding_of(self._stage.show(self._decided(index)), name, self._settings, self._resting)

    def _decided_in(self, index: int) -> State:
        """The state in a frame, and in it those near hands that move along with what they are near to."""
        moving_along = [hold for hold in self._possible(index) if self._moves_along(hold).at(index)]
        return self._frames.state(index).with_holding(moving_along)

    def _goes_on(self, hold: Hold, index: int, before: bool) -> bool:
        """Whether a hand moves along with an object, if it did so before; of an unknown slip, near is all there is."""
        if hold not in self._possible(index):
            return False
        slip_m_s, limit = self._slip_m_s(hold, index), self._settings
        return slip_m_s is None or slip_m_s < (limit.slip_stop_m_s if before else limit.slip_start_m_s)

    def _possible_in(self, index: int) -> frozenset[Hold]:
        return possible_holds(self._stage.show(self._frames.state(index)), self._settings)

    def _slip_of(self, hold: Hold, index: int) -> float | None:
        """Speed of a palm in an object's frame around one frame, metres per second; None where it is unknown."""
        window = self._frames.window(index, self._settings.slip_window_s)
        places = [
            (self._frames.times_s[each], place) for each in window if (place := self._palm(hold, each)) is not None
        ]
        return speed_m_s([time_s for time_s, _ in places], [place for _, place in places])

    def _palm(self, hold: Hold, index: int) -> Array | None:
        """Place of a palm in an object's frame in metres, (3,); None where either was not tracked."""
        stage = self._stage.show(self._frames.state(index))
        agent = stage.scene.agent(hold.agent)
        arm = agent.arm(hold.side)
        if not hand_known(stage, agent, arm) or not stage.state.known([hold.object]):
            return None
        return stage.body(stage.scene.object_body(hold.object)).to_local(stage.site(arm.palm_site).position)
