"""A demonstration of the study: a room, and what is done in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from taskgist.demonstrator.demonstration import demonstrate
from taskgist.demonstrator.means import Means
from taskgist.demonstrator.room import Room
from taskgist.recording import Recording


@dataclass(frozen=True)
class Demonstration:
    """One demonstration of the study.

    Attributes:
        room: Where it takes place; named after the task and the letter of the paper's figure.
        means: What is done in the room's scene.
    """

    room: Room
    means: Means

    @property
    def name(self) -> str:
        """Its name."""
        return self.room.name

    def record(self, seed: int, *, distance_m: float = 0.0, angle_rad: float = 0.0) -> Recording:
        """Play and record it.

        Args:
            seed: Seed of all variation.
            distance_m: How far people and things are displaced at most, in x and y.
            angle_rad: How far they are turned at most.

        Raises:
            SceneError: The displaced arrangement leaves no way to do it.
        """
        room = self.room.varied(np.random.default_rng(seed), distance_m=distance_m, angle_rad=angle_rad)
        scene = room.scene()
        return demonstrate(self.means(scene), scene, seed=seed, name=self.name)
