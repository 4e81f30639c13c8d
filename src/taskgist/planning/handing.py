"""Taking: what somebody does to whom something is handed over; here, what a person does (a robot: ``robot_taking``).

The motion is that of the engine's own moving bodies, which demonstrate handovers as well: the free hand comes up, opens
beside the thing, and closes around it, the torso helping where the arm alone is too short.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from taskgist.common.arrays import Array
from taskgist.errors import SceneError
from taskgist.moving.body import LARGEST_ERROR_M, Body, followed, paced
from taskgist.moving.hand_pose import sampled
from taskgist.moving.steps import CLOSING_S, open_level, taking
from taskgist.planning.plan import RATE_HZ
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist.world.state import State

FULL = "its hands are full"
ITERATIONS = 60
"""Most steps of the fit that brings a hand to a thing."""


@dataclass(frozen=True, eq=False)
class Taking:
    """How somebody takes a thing that another hand holds where it is.

    Attributes:
        side: The hand.
        coming: Frames, (n, nq), in which it comes; the thing is in the giver's hand alone.
        shared: Frames, (m, nq), in which both hold it.
    """

    side: str
    coming: Array
    shared: Array


class Taker(Protocol):
    """Somebody to whom things are handed over."""

    @property
    def name(self) -> str:
        """Who it is."""

    def holding(self, state: State, thing: str) -> State | str:
        """A state in which a hand of it is around a thing, where that is; or why there is none, in words."""

    def takings(self, qpos: Array, thing: str) -> Iterator[Taking | str]:
        """Ways to take a thing out of another hand, the best first; and why others fail, in words.

        Args:
            qpos: Where everything is, (nq,).
            thing: The thing.
        """


class PersonTaker:
    """A person to whom things are handed over.

    Args:
        scene: The scene.
        name: Who it is.
        state: How it is before: a hand that does nothing stays where it is there; one that holds something by that
            state takes nothing else.

    Attributes:
        name: As given.
    """

    def __init__(self, scene: Scene, name: str, state: State) -> None:
        self.name, self._scene, self._before = name, scene, state

    @cached_property
    def _body(self) -> Body:
        """Its body.

        Raises:
            SceneError: It has no torso that turns and leans, or not two arms.
        """
        return Body(self._scene, self.name, self._before)

    def holding(self, state: State, thing: str) -> State | str:
        """As ``Taker`` says."""
        failed = FULL
        for side in self.sides(state.qpos, thing):
            failed = f"its {side} hand does not get around the {thing}"
            try:
                hand, torso_rad = taking(Stage(self._scene, state), self._body, thing, side)
                reached, error_m = self._body.reaching(state, side, hand, torso_rad, iterations=ITERATIONS)
            except SceneError:
                continue
            if error_m <= LARGEST_ERROR_M:
                return reached
        return failed

    def sides(self, qpos: Array, thing: str) -> tuple[str, ...]:
        """Sides of its hands that are free to take a thing, the nearest first."""
        busy = {hold.side for hold in self._before.holding or () if hold.agent == self.name and hold.object != thing}
        nearest = sides_by_distance(self._scene, qpos, thing, self.name)
        return tuple(side for side in nearest if side not in busy)

    def takings(self, qpos: Array, thing: str) -> Iterator[Taking | str]:
        """As ``Taker`` says."""
        sides = self.sides(qpos, thing)
        if not sides:
            yield FULL
        for side in sides:
            try:
                frames = self._motion(qpos, thing, side)
            except SceneError as error:
                yield str(error)
                continue
            closing = len(frames) - round(CLOSING_S * RATE_HZ)
            yield Taking(side, frames[:closing], frames[closing:])

    def _motion(self, qpos: Array, thing: str, side: str) -> Array:
        """Frames, (n, nq), in which a hand comes and closes around a thing that is held where it is.

        Raises:
            SceneError: Its hand does not get there, or its body takes nothing.
        """
        state, body = State(qpos), self._body
        hand, torso_rad = taking(Stage(self._scene, state), body, thing, side)
        way = sampled([body.hand(state, side), *body.raising(side), open_level(hand), hand])[1:]
        states = followed(body, state, side, way, torso_rad=torso_rad, phase="out", role="target")
        motion = paced(body, side, states, start_s=0.0, tempo=1.0, duration_s=None)
        times_s = np.arange(0.0, motion.end_s + CLOSING_S, 1.0 / RATE_HZ)
        frames = np.tile(qpos, (len(times_s), 1))
        frames[:, body.columns] = np.clip(motion.at(times_s), *body.ranges_rad.T)
        return frames


def sides_by_distance(scene: Scene, qpos: Array, thing: str, name: str) -> tuple[str, ...]:
    """Sides of an agent's hands, that whose shoulder is nearest to a thing first."""
    stage = Stage(scene, State(qpos))
    agent, place = scene.agent(name), stage.body_position(scene.object_body(thing))
    away_m = {arm.profile.side: float(np.linalg.norm(stage.shoulder(arm).position - place)) for arm in agent.arms}
    return tuple(sorted(away_m, key=lambda side: (round(away_m[side], 6), side != "right")))
