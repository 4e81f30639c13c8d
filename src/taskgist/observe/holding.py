"""Holding over time: a held object moves with the hand.

A hand that passes an object, or reaches around it before it closes, is near and yet does not hold. What tells them
apart is slip. A ``HoldingWatch`` takes states as they come and gives them back, half a window later, with
``State.holding`` decided. A ``HoldingLookup`` decides single frames of a whole sequence, as that watch would.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache, partial

import numpy as np

from taskgist.common.arrays import Array
from taskgist.observe.motion import Around, SlidingWindow, followed, velocity, window_at
from taskgist.settings import Contact
from taskgist.world.geometry.transforms import Pose
from taskgist.world.holding import hand_known, near_holds
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist.world.state import Frames, Hold, State

# --- Slip: how fast a near hand moves in an object's own frame. It tells a hold from a hand that passes.
#
# A near hand begins to hold when its slip is low, and lets go when it is high; in between it goes on as before.


@dataclass(frozen=True, eq=False)
class Hands:
    """A state, and where its hands and objects are.

    Attributes:
        near: The hands that are near to objects.
        palms: Place of each tracked palm in metres, (3,), by agent and side.
        objects: Pose of each tracked object.
    """

    state: State
    near: frozenset[Hold]
    palms: dict[tuple[str, str], Array]
    objects: dict[str, Pose]

    @classmethod
    def of(cls, stage: Stage, state: State, settings: Contact) -> Hands:
        """Those of a state, which the stage shows afterwards."""
        scene, known = stage.scene, stage.show(state).state.known
        agents = [scene.agent(name) for name in scene.agents]
        return cls(
            state=state,
            near=near_holds(stage, settings),
            palms={
                (agent.name, arm.profile.side): stage.site(arm.palm_site).position
                for agent in agents
                for arm in agent.arms
                if hand_known(stage, agent, arm)
            },
            objects={name: stage.body(scene.object_body(name)) for name in scene.objects if known([name])},
        )

    def place(self, hold: Hold) -> Array | None:
        """Place of the palm in the object's frame, metres, (3,); None where either was not tracked."""
        palm, thing = self.palms.get((hold.agent, hold.side)), self.objects.get(hold.object)
        return None if palm is None or thing is None else thing.to_local(palm)


def slip_m_s(hold: Hold, window: Iterable[Hands]) -> float | None:
    """Speed of a palm in an object's frame within a window, metres per second; None where it is unknown."""
    places = [(hands.state.time_s, place) for hands in window if (place := hands.place(hold)) is not None]
    slip = velocity([time_s for time_s, _ in places], [place for _, place in places])
    return None if slip is None else float(np.linalg.norm(slip))


def holds_on(slip_m_s: float | None, before: bool, settings: Contact) -> bool:
    """Whether a near hand holds, by its slip and whether it held before; of an unknown slip, near is all there is."""
    limit = settings.slip_stop_m_s if before else settings.slip_start_m_s
    return slip_m_s is None or slip_m_s < limit


class HoldingWatch:
    """Decides who holds what in states that follow each other.

    Args:
        scene: Their scene.
        settings: Distances, speeds and the window.
    """

    def __init__(self, scene: Scene, settings: Contact) -> None:
        self._settings = settings
        self._stage = Stage(scene)
        self._window: SlidingWindow[Hands] = SlidingWindow(settings.slip_window_s)
        self._held: frozenset[Hold] = frozenset()

    def update(self, state: State) -> Iterator[State]:
        """Take the next state; yields those that can be decided now, in order."""
        hands = Hands.of(self._stage, state, self._settings)
        yield from map(self._decided, self._window.push(state.time_s, hands))

    def finish(self) -> Iterator[State]:
        """Decide the states that still wait, by what has been seen of their windows."""
        yield from map(self._decided, self._window.finish())

    def _decided(self, around: Around[Hands]) -> State:
        self._held = frozenset(hold for hold in around.item.near if self._stays(hold, around))
        return around.item.state.with_holding(self._held)

    def _stays(self, hold: Hold, around: Around[Hands]) -> bool:
        return holds_on(slip_m_s(hold, around.items), hold in self._held, self._settings)


class HoldingLookup:
    """Decides who holds what in any frame of a sequence, as a ``HoldingWatch`` that saw all of them does.

    Args:
        stage: Their scene; it shows other states after each question.
        frames: The sequence.
        settings: Distances, speeds and the window.
    """

    def __init__(self, stage: Stage, frames: Frames, settings: Contact) -> None:
        self._stage, self._frames, self._settings = stage, frames, settings
        self._times_s: list[float] = frames.times_s.tolist()
        self._hands, self._slip_m_s = cache(self._look), cache(self._measure)
        self.decided = cache(self._decided)

    def _decided(self, index: int) -> State:
        hands = self._hands(index)
        held = (hold for hold in hands.near if followed(partial(self._holds, hold), index))
        return hands.state.with_holding(held)

    def _holds(self, hold: Hold, index: int, before: bool) -> bool:
        near = hold in self._hands(index).near
        return near and holds_on(self._slip_m_s(hold, index), before, self._settings)

    def _look(self, index: int) -> Hands:
        return Hands.of(self._stage, self._frames.state(index), self._settings)

    def _measure(self, hold: Hold, index: int) -> float | None:
        around = window_at(self._times_s, index, self._settings.slip_window_s)
        return slip_m_s(hold, map(self._hands, around))
