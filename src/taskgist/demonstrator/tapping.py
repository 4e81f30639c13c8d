"""Tapping: a hand pushes a thing that lies still, which then slides or rolls on by itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskgist.demonstrator.acting import Acting
from taskgist.demonstrator.hand import UP, HandPose, around, sampled
from taskgist.demonstrator.releasing import DIFFERENCE_S, hand_at, set_going, state_at, watch
from taskgist.demonstrator.steps import EYES_AHEAD_S
from taskgist.errors import SceneError
from taskgist.world import FreeMotion, Stage, hand_gap_m

Array = NDArray[np.float64]

BEFORE_M, BEYOND_M = 0.12, 0.05
"""How far from the thing a hand begins to push, and how far it goes on."""
TOUCHING_M = 0.002
"""Gap between hand and thing at which it is pushed."""
LOOKED_AT = 120
"""Moments of the push that are looked at."""
MOVES_S = 0.30
"""What was tapped moves for so long, at least: less is a nudge."""
PEAK = 1.875
"""Greatest speed of a minimum-jerk movement over its mean speed."""
MOVING_SHARE, LONGEST_S = 0.65, 0.8
"""The demonstration ends after this share of the time for which it is seen to move on its support, and so much at
most."""
LEVEL_M = 0.005
"""How much its height changes, at most, while it is on its support."""
SEEN_M_S = 0.10
"""Speed from which on people see something move on a table."""
STAYS_S = 0.4


@dataclass(frozen=True)
class Tap:
    """Push a thing with the palm, so that it moves on by itself.

    Attributes:
        thing: The thing.
        side: The hand.
        speed_m_s: Greatest speed of the hand.
    """

    thing: str
    side: str
    speed_m_s: float

    def play(self, acting: Acting) -> None:
        """Bring the open hand beside the thing, push, stop.

        Raises:
            SceneError: The hand does not meet the thing, or hardly moves it.
        """
        hand, torso = self._beside(acting)
        start, end = hand.moved(-BEFORE_M * hand.facing), hand.moved(BEYOND_M * hand.facing)
        body = acting.body
        acting.look(self.thing, ahead_s=EYES_AHEAD_S)
        way = sampled([body.hand(acting.state, self.side), *body.raising(self.side), start.moved(BEFORE_M * UP), start])
        acting.move(self.side, way[1:], torso_rad=torso, phase="out")
        since_s, duration_s = acting.now_s, PEAK * (BEFORE_M + BEYOND_M) / self.speed_m_s
        acting.move(self.side, sampled([start, end])[1:], torso_rad=torso, phase="over", duration_s=duration_s)
        at_s = self._met_s(acting, since_s, duration_s)
        motion = self._push(acting, at_s)
        acting.over_s = at_s + min(MOVING_SHARE * self._moving_s(acting, motion), LONGEST_S)
        acting.wait(STAYS_S)
        watch(acting, acting.over_s + STAYS_S)

    def _beside(self, acting: Acting) -> tuple[HandPose, Array]:
        """The hand against the thing's side, and the torso's turn and lean with which it gets there."""
        body, state = acting.body, acting.state
        stage = Stage(acting.scene, state)
        middle = stage.body_position(acting.scene.object_body(self.thing))
        torso = body.torso_for(state, self.side, middle)
        heading, dip = body.heading_to(state, self.side, middle), body.dip_to(state, self.side, middle, torso)
        return around(stage, self.thing, self.side, heading, dip_rad=dip, tip_m=body.tip_m(self.side)), torso

    def _met_s(self, acting: Acting, since_s: float, duration_s: float) -> float:
        """When the pushing hand meets the thing."""
        stage, arm = Stage(acting.scene), acting.body.agent.arm(self.side)
        for time in np.linspace(since_s, since_s + duration_s, LOOKED_AT):
            stage.show(state_at(acting, float(time)))
            if hand_gap_m(stage, arm, self.thing, limit_m=2 * TOUCHING_M) < TOUCHING_M:
                return float(time)
        raise SceneError("the hand passes it", where=acting.performer, field=self.thing, hint="clear the way to it")

    def _push(self, acting: Acting, at_s: float) -> FreeMotion:
        """Let the thing move on with the hand's velocity over the support."""
        after, before = (hand_at(acting, self.side, at_s + step) for step in (DIFFERENCE_S, -DIFFERENCE_S))
        velocity = (after.palm - before.palm) / (2 * DIFFERENCE_S) * (1.0, 1.0, 0.0)
        pose = np.array(acting.state.qpos[acting.scene.object_slice(self.thing)])
        return set_going(acting, self.thing, at_s, pose, (velocity, np.zeros(3)))

    def _moving_s(self, acting: Acting, motion: FreeMotion) -> float:
        """For how long it is seen to move on its support."""
        places = motion.poses[:, :3]
        speeds = np.linalg.norm(np.diff(places, axis=0), axis=1) / np.diff(motion.times_s)
        seen = (speeds > SEEN_M_S) & (np.abs(places[1:, 2] - places[0, 2]) < LEVEL_M)
        moving_s = float(motion.times_s[1:][~seen].min(initial=motion.duration_s))
        if moving_s < MOVES_S:
            raise SceneError(
                f"it moves on for less than {MOVES_S:g} s",
                where=acting.performer,
                field=self.thing,
                value=round(moving_s, 3),
                hint="tap it faster, or tap something that rolls",
            )
        return moving_s
