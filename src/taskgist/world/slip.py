"""Slip: how fast a near hand moves in an object's own frame. It tells a hold from a hand that passes.

A near hand begins to hold when its slip is low, and lets go when it is high; in between it goes on as before.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskgist.settings import Contact
from taskgist.world.geometry.pose import Pose
from taskgist.world.holding import hand_known, near_holds
from taskgist.world.stage import Stage
from taskgist.world.state import Hold, State
from taskgist.world.window import velocity

Array = NDArray[np.float64]


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
