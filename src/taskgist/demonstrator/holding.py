"""Holding from the beginning: somebody has a thing in the hand before anything happens."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from taskgist.demonstrator.acting import Acting
from taskgist.demonstrator.following import LARGEST_ERROR_M
from taskgist.demonstrator.hand import around
from taskgist.errors import SceneError
from taskgist.world import Stage

FIT_ITERATIONS = 60
"""Most steps of the fit that brings the hand to where it holds."""


@dataclass(frozen=True)
class Held:
    """The performer holds a thing from the beginning on. It comes before all steps that move.

    Attributes:
        thing: The thing.
        side: The hand.
        place_m: Where the thing's middle is, (3,).
    """

    thing: str
    side: str
    place_m: tuple[float, float, float]

    def play(self, acting: Acting) -> None:
        """Let everything begin so.

        Raises:
            SceneError: The hand does not get there.
        """
        column, body = acting.scene.object_slice(self.thing), acting.body
        pose = np.array(acting.at_rest.qpos[column])
        pose[:3] = self.place_m
        holding = acting.at_rest.replace(at=column, to=pose)
        heading = body.heading_to(holding, self.side, pose[:3])
        tip_m = body.tip_m(self.side)
        hand = around(Stage(acting.scene, holding), self.thing, self.side, heading, dip_rad=0.0, tip_m=tip_m)
        torso = body.posture(holding)[:2]
        state, error = body.reaching(holding, self.side, hand, torso, iterations=FIT_ITERATIONS)
        if error > LARGEST_ERROR_M:
            hint = "hold it nearer to the shoulder"
            raise SceneError("the hand does not get there", where=acting.performer, field=self.thing, hint=hint)
        acting.begin(state, returning=body)
        acting.take(self.thing, self.side, hand)
        acting.carries[-1] = replace(acting.carries[-1], from_s=0.0)
