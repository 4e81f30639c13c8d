"""The observer: watches states as they come and keeps what is confirmed of hands, postures, placements and motion.

Live use feeds it frames from a tracker; offline use feeds it a recording. Both are the same code::

    observer = Observer(scene)
    for state in states:
        observer.update(state)
    observer.placement("cup").at(2.5)
"""

from __future__ import annotations

from collections.abc import Iterable

from taskgist.observe.confirmation import Confirmation
from taskgist.observe.history import History
from taskgist.observe.motion import MotionWatch, object_place
from taskgist.observe.status import HandUse, Placed, hand_key, placement_key, statuses_of
from taskgist.settings import DEFAULT, Settings
from taskgist.world import HoldingWatch, Scene, Stage, State
from taskgist.world.resting import RestingMemory


class Observer(History):
    """Confirms facts over time.

    Args:
        scene: The scene whose states it will be shown.
        settings: Distances and durations.
    """

    def __init__(self, scene: Scene, settings: Settings = DEFAULT) -> None:
        super().__init__(scene)
        minimum = settings.timing.minimum_s
        self._settings = settings
        self._stage = Stage(scene)
        self._holding = HoldingWatch(scene, settings.contact)
        self._resting = RestingMemory(scene, settings.contact)
        self._placements: dict[str, Confirmation[Placed]] = {
            name: Confirmation(minimum, key=placement_key) for name in scene.objects
        }
        self._motions: dict[str, Confirmation[str | None]] = {name: Confirmation(minimum) for name in scene.objects}
        self._watches = {name: MotionWatch(settings.timing) for name in scene.objects}
        self._hands: dict[tuple[str, str], Confirmation[HandUse]] = {
            (agent, side): Confirmation(minimum, key=hand_key)
            for agent in scene.agents
            for side in scene.agent(agent).sides
        }
        self._postures: dict[str, Confirmation[str | None]] = {name: Confirmation(minimum) for name in scene.agents}

    @classmethod
    def of(cls, scene: Scene, states: Iterable[State], settings: Settings = DEFAULT) -> Observer:
        """An observer that has seen all of these states, and knows that no more will come."""
        observer = cls(scene, settings)
        for state in states:
            observer.update(state)
        observer.finish()
        return observer

    def update(self, state: State) -> None:
        """Take the next frame."""
        for decided in self._holding.update(state):
            self._take(decided)

    def finish(self) -> None:
        """Say that no more frames will come."""
        for decided in self._holding.finish():
            self._take(decided)
        for name, watch in self._watches.items():
            for at_s, motion in watch.finish():
                self._motions[name].update(at_s, motion)

    def _take(self, state: State) -> None:
        time = state.time_s
        statuses = statuses_of(self._stage.show(state), self._settings.contact, self._resting)
        for name, placed in statuses.placements.items():
            self._placements[name].update(time, placed)
        for hand, use in statuses.hands.items():
            self._hands[hand].update(time, use)
        for agent, posture in statuses.postures.items():
            self._postures[agent].update(time, posture)
        for name, watch in self._watches.items():
            for at_s, motion in watch.update(time, object_place(self.scene, state, name)):
                self._motions[name].update(at_s, motion)

    def placement(self, name: str) -> Confirmation[Placed]:
        """Placement of an object over time."""
        self.scene.object_body(name)
        return self._placements[name]

    def motion(self, name: str) -> Confirmation[str | None]:
        """Motion of an object over time; None is unknown."""
        self.scene.object_body(name)
        return self._motions[name]

    def hand(self, agent: str, side: str) -> Confirmation[HandUse]:
        """Use of a hand over time."""
        self.scene.agent(agent).arm(side)
        return self._hands[agent, side]

    def posture(self, agent: str) -> Confirmation[str | None]:
        """Posture of an agent over time; None is unknown."""
        self.scene.agent(agent)
        return self._postures[agent]
