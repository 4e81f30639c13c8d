"""A standpoint: one agent in one state, and all that it might do from there (5.1.4).

What does not depend on the object is found once here: which contacts are usual, which torso angles, postures and
places are within reach. Stances come level by level, from the least amount to the greatest; each level moves only its
own joints:

====== =============================== ==========================================================================
level  effort (Fig. 6)                 stances
====== =============================== ==========================================================================
0, 1   none; head, or arm              the current one
2      and torso                       turns and leans of the torso
3      whole body                      the other posture, with turns and leans of the torso
4      displacement                    standing, on every place of the floor that can be got to, the chest turned to
                                       the object, with leans of the torso (a turn would repeat that of the base)
====== =============================== ==========================================================================

What an agent holds stays where it is in all of them: a held object can be reached and grasped without effort anyway,
and arms can keep it in place while the torso moves.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.constraints import Blocking, Collisions
from taskgist.perspective.floor import Floor, Place, moved
from taskgist.perspective.judge import Miss
from taskgist.perspective.seat import seat_height_m
from taskgist.perspective.torso import bent
from taskgist.perspective.virtual_actions import MOVE, SIT, STAND, TURN, Amount, Stance, checked_actions
from taskgist.settings import DEFAULT, Settings
from taskgist.world import Agent, Posture, Stage, State, posture_of, with_posture
from taskgist.world.rotations import wrapped, yaw_of

Array = NDArray[np.float64]
NO_STANCE = {2: "the torso does not move", 3: "no other posture to take", 4: "cannot move about"}
"""Why an effort level has nothing to try."""


class Standpoint:
    """An agent in the state that a stage shows.

    Things and agents that were not tracked stand where their fillers in the state put them.

    Args:
        stage: The scene in a state. It is borrowed for trying other states, and always shows the same one afterwards.
        agent: Name of the agent.
        settings: All settings.
        actions: The virtual actions that the agent may use; all that it has if left out.

    Raises:
        UnknownNameError: There is no such agent, or it has no such action.
    """

    def __init__(
        self, stage: Stage, agent: str, settings: Settings = DEFAULT, *, actions: Iterable[str] | None = None
    ) -> None:
        self.stage, self.settings = stage, settings
        self.agent: Agent = stage.scene.agent(agent)
        self.state: State = stage.state
        self.actions = checked_actions(self.agent, actions)
        self.collisions = Collisions(stage, self.agent, settings)
        self.posture: Posture | None = posture_of(stage, self.agent, settings.contact)

    def blocked(self, state: State) -> Blocking | None:
        """What the agent would push into in a state; None if nothing. The stage shows that state afterwards."""
        self.stage.show(state)
        return self.collisions.find()

    def stances(self, level: int, target: Array) -> Iterator[Stance]:
        """Stances of an effort level, by increasing amount.

        Args:
            level: Effort level, 0 to 4.
            target: Where the object is, metres, (3,): agents that walk turn to it.
        """
        if level <= 1:
            yield self.here
        elif level == 2:
            yield from self._bent(self.here, turns=True)[1:]
        elif level == 3 and self.other_posture is not None:
            yield from self._bent(self.other_posture, turns=True)
        elif level == 4:
            yield from self._displaced(target)

    def no_stance(self, level: int) -> Miss:
        """Why an effort level has no stances."""
        if level == 4 and MOVE in self.actions and self.posture == "sitting" and self.other_posture is not None:
            blocking = self.blocked(self.other_posture.state)
            return Miss(math.inf, f"{STAND} is blocked: {blocking}", blocking.evidence if blocking else None)
        return Miss(math.inf, NO_STANCE[level])

    @cached_property
    def here(self) -> Stance:
        """Where the agent is."""
        return Stance(self.state)

    @cached_property
    def other_posture(self) -> Stance | None:
        """The agent after standing up, or sitting down if there is a seat; None if it cannot. It may collide."""
        if self.posture == "sitting" and STAND in self.actions:
            return Stance(with_posture(self._shown(), self.agent, "standing"), (STAND,))
        if self.posture == "standing" and SIT in self.actions:
            seat = seat_height_m(self._shown(), self.agent, self.settings.efforts)
            if seat is not None:
                return Stance(with_posture(self._shown(), self.agent, "sitting", seat_height_m=seat), (SIT,))
        return None

    @cached_property
    def upright(self) -> Stance | None:
        """The agent standing, free of collisions, ready to walk; None if it cannot be."""
        if self.posture == "standing":
            return self.here
        standing = self.other_posture
        return standing if standing is not None and self.blocked(standing.state) is None else None

    @cached_property
    def _floor(self) -> Iterable[Place]:
        if MOVE not in self.actions or self.upright is None:
            return ()
        return Floor(self.upright.state, self.agent, self.settings.efforts, lambda state: self.blocked(state) is None)

    def _displaced(self, target: Array) -> Iterator[Stance]:
        for _, places in itertools.groupby(self._floor, key=lambda place: round(place.way_m, 6)):
            stances = [bent for place in places for bent in self._bent(self._standing_at(place, target), turns=False)]
            yield from sorted(stances, key=lambda stance: stance.amount.key)

    def _standing_at(self, place: Place, target: Array) -> Stance:
        """At a place, with the chest turned to the target."""
        assert self.upright is not None
        state, actions = self.upright.state, self.upright.actions
        base = state.qpos[self.agent.base]
        ahead = target[:2] - base[:2] - place.offset_m
        turn = 0.0
        if np.hypot(*ahead) > 1e-6:
            turn = wrapped(math.atan2(ahead[1], ahead[0]) - self._torso_turn_rad() - yaw_of(base[3:]))
        amount = Amount(moved_m=place.way_m, turned_rad=abs(turn))
        return Stance(moved(state, self.agent, place.offset_m, turn), (*actions, MOVE), amount)

    def _torso_turn_rad(self) -> float:
        axis = self.agent.profile.turn
        return float(self.state.qpos[self.agent.joints[axis.joint]]) if axis else 0.0

    def _bent(self, stance: Stance, *, turns: bool) -> list[Stance]:
        actions = self.actions if turns else self.actions - {TURN}
        return bent(stance, self.state, self.agent, self.settings.efforts, actions)

    def _shown(self) -> Stage:
        return self.stage.show(self.state)
