"""Taking by a robot: its arm comes to the thing where the giver holds it, grasps it, and both hold it for a moment.

The robot stays where it stands, as a person does. The thing in the giver's hand is a thing to be grasped like any
other, the giver with its hand and arm an obstacle like any other; only that nothing is lifted: the giver lets go, and
goes. So these are the grasps, the inverse kinematics and the motions with which robots pick things up.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from itertools import count, islice

from taskgist.common.arrays import Array
from taskgist.errors import SceneError
from taskgist.planning.grasping import Grasping
from taskgist.planning.hand_ways import PickPose
from taskgist.planning.handing import FULL, PersonTaker, Taker, Taking
from taskgist.planning.motions import Motions, NoMotionError
from taskgist.planning.performer import Performer
from taskgist.planning.persons import moves_itself
from taskgist.planning.transfer import Picks
from taskgist.settings import Settings
from taskgist.world.scene import Scene
from taskgist.world.state import State

MOST_GRASPS = 12
"""Grasps that are tried at a place, before it is told that the thing cannot be taken there."""
MOST_WAYS = 4
"""Grasps to which a way of the arm is looked for (ours)."""


class RobotTaker:
    """A robot to which things are handed over.

    Args:
        scene: The scene.
        name: Who it is.
        state: How it is before; a hand that holds something by that state takes nothing else.
        settings: All settings.
        seed: Of the searches.

    Attributes:
        name: As given.
    """

    def __init__(self, scene: Scene, name: str, state: State, settings: Settings, *, seed: int = 0) -> None:
        self.name, self._scene, self._before, self._settings, self._seed = name, scene, state, settings, seed

    @cached_property
    def _robot(self) -> Performer:
        return Performer(self._scene, self.name, self._settings, start=self._before)

    def holding(self, state: State, thing: str) -> State | str:
        """As ``Taker`` says; who hands it over is not there yet."""
        try:
            grasping = self._grasping(state.qpos, thing)
            pick = next(self._picks(grasping, state.qpos), None)
        except SceneError as error:  # it has no hand, say
            return str(error)
        if pick is None:
            return self._why_not(grasping, thing)
        return state.replace(at=slice(None), to=pick.closed(pick.line[-1]))

    def takings(self, qpos: Array, thing: str) -> Iterator[Taking | str]:
        """As ``Taker`` says."""
        try:
            grasping = self._grasping(qpos, thing)
        except SceneError as error:
            yield str(error)
            return
        motions, found = Motions(self._robot, self._settings.planning, seed=self._seed), False
        for pick in islice(self._picks(grasping, qpos), MOST_WAYS):
            found = True
            try:
                yield motions.taking(pick, qpos)
            except NoMotionError as error:
                yield str(error)
        if not found:
            yield self._why_not(grasping, thing)

    def _grasping(self, qpos: Array, thing: str) -> Grasping:
        return Grasping(self._robot, State(qpos, untracked=self._before.untracked), thing, rises=False)

    def _picks(self, grasping: Grasping, qpos: Array) -> Iterator[PickPose]:
        busy, asked = self._busy(grasping.thing), count()

        def left_aside(side: str, _grasp: int) -> bool:
            return side in busy or next(asked) >= MOST_GRASPS

        return Picks(grasping, qpos).by(hopeless=left_aside)

    def _busy(self, thing: str) -> set[str]:
        return {hold.side for hold in self._before.holding or () if hold.agent == self.name and hold.object != thing}

    def _why_not(self, grasping: Grasping, thing: str) -> str:
        if self._busy(thing) >= set(self._robot.sides):
            return FULL
        return grasping.miss.text if grasping.miss is not None else grasping.tally.text(thing)


def taker_of(scene: Scene, name: str, state: State, settings: Settings, *, seed: int = 0) -> Taker:
    """Somebody to whom things are handed over: a person, or a robot.

    Args:
        scene: The scene.
        name: Who it is.
        state: How it is before: a hand that holds something by that state takes nothing else.
        settings: All settings.
        seed: Of a robot's searches.

    Raises:
        UnknownNameError: There is no such agent.
    """
    if moves_itself(scene.agent(name)):
        return PersonTaker(scene, name, state)
    return RobotTaker(scene, name, state, settings, seed=seed)
