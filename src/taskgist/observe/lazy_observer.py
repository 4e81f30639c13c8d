"""The lazy observer: says of any time what an observer that has seen all frames says, and looks at few of them.

An explanation asks for two times, one object and one agent's hands and posture. What is confirmed there hangs on the
frames around these times: the windows of motion and slip, the frames before them as long as hysteresis leaves them
open, and the runs of equal raw facts until one has lasted. These frames are looked at, and no others.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from functools import cache, partial
from typing import TypeVar

from taskgist.observe.history import History
from taskgist.observe.lookup import Lookup
from taskgist.observe.motion import MotionLookup, Place, object_place
from taskgist.observe.status import HandUse, Placed, hand_key, hand_use, placed, placement_key, posture_symbol
from taskgist.settings import DEFAULT, Settings
from taskgist.world import Holding, Scene, Stage, holding_of
from taskgist.world.frames import Frames
from taskgist.world.holding_watch import HoldingLookup
from taskgist.world.resting import RestingMemory

V = TypeVar("V", bound=Hashable)


class LazyObserver(History):
    """Confirmed facts over a whole sequence of frames, each found when it is asked for.

    Args:
        scene: The scene whose states they are.
        frames: The frames, such as a recording.
        settings: Distances and durations.
    """

    def __init__(self, scene: Scene, frames: Frames, settings: Settings = DEFAULT) -> None:
        super().__init__(scene)
        self._frames, self._settings = frames, settings
        self._times_s: list[float] = frames.times_s.tolist()
        self._stage = Stage(scene)
        self._holding = HoldingLookup(self._stage, frames, settings.contact)
        self._resting = RestingMemory(scene, settings.contact)
        self._held = cache(self._holding_of)
        self._placement, self._motion = cache(self._placement_of), cache(self._motion_of)
        self._hand, self._posture = cache(self._hand_of), cache(self._posture_of)

    def placement(self, name: str) -> Lookup[Placed]:
        """Placement of an object over time."""
        return self._placement(name)

    def motion(self, name: str) -> Lookup[str | None]:
        """Motion of an object over time; None is unknown."""
        return self._motion(name)

    def hand(self, agent: str, side: str) -> Lookup[HandUse]:
        """Use of a hand over time."""
        return self._hand(agent, side)

    def posture(self, agent: str) -> Lookup[str | None]:
        """Posture of an agent over time; None is unknown."""
        return self._posture(agent)

    def _placement_of(self, name: str) -> Lookup[Placed]:
        self.scene.object_body(name)
        return self._lookup(lambda index: placed(self._held(index, name)), placement_key)

    def _motion_of(self, name: str) -> Lookup[str | None]:
        self.scene.object_body(name)
        moving = MotionLookup(self._times_s, partial(self._place, name), self._settings.timing)
        return self._lookup(moving.at)

    def _hand_of(self, agent: str, side: str) -> Lookup[HandUse]:
        who, arm = self.scene.agent(agent), self.scene.agent(agent).arm(side)

        def raw(index: int) -> HandUse:
            stage = self._stage.show(self._holding.decided(index))
            return hand_use(stage, who, arm, partial(self._held, index), self._settings.contact)

        return self._lookup(raw, hand_key)

    def _posture_of(self, agent: str) -> Lookup[str | None]:
        who = self.scene.agent(agent)
        return self._lookup(
            lambda index: posture_symbol(self._stage.show(self._frames.state(index)), who, self._settings.contact)
        )

    def _holding_of(self, index: int, name: str) -> Holding | None:
        stage = self._stage.show(self._holding.decided(index))
        return holding_of(stage, name, self._settings.contact, self._resting)

    def _place(self, name: str, index: int) -> Place | None:
        return object_place(self.scene, self._frames.state(index), name)

    def _lookup(self, raw: Callable[[int], V], key: Callable[[V], Hashable] = lambda value: value) -> Lookup[V]:
        return Lookup(self._times_s, raw, self._settings.timing.minimum_s, key)
