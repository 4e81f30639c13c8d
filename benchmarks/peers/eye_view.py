"""A scene as other renderers need it: what is there for an eye, where it is, and through which window it is seen."""

from __future__ import annotations

import math
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from taskgist.world import Agent, Scene, State

Array = NDArray[np.float64]
SEEN = (0, 1, 2)


@dataclass(frozen=True, eq=False)
class EyeView:
    """One agent's eye in a scene in a state; frames come straight from MuJoCo.

    Attributes:
        scene: The scene.
        agent: Whose eye.
        data: The scene's kinematics in the state.
        geoms: Shapes that can be seen: all but those of the body around the eye and those not tracked.
    """

    scene: Scene
    agent: Agent
    data: mujoco.MjData
    geoms: tuple[int, ...]

    @classmethod
    def of(cls, scene: Scene, state: State, agent: str) -> EyeView:
        """The eye of an agent in a state."""
        body, model = scene.agent(agent), scene.model
        data = mujoco.MjData(model)
        data.qpos[:] = state.qpos
        mujoco.mj_forward(model, data)
        hidden = set(scene.untracked_geoms(state.untracked).tolist())
        around = model.geom_bodyid == body.eye_exclude_body
        seen = (g for g in range(model.ngeom) if model.geom_group[g] in SEEN and not around[g] and g not in hidden)
        return cls(scene, body, data, tuple(seen))

    @property
    def size_px(self) -> tuple[int, int]:
        """Width and height of the image."""
        return self.agent.profile.eye.image_px

    @property
    def half_window(self) -> tuple[float, float]:
        """Half width and half height of the image plane at distance one."""
        across, up = (math.tan(angle / 2) for angle in self.agent.profile.eye.fov_rad)
        return across, up

    @property
    def position(self) -> Array:
        """The eye, metres, (3,)."""
        return np.array(self.data.site_xpos[self.agent.eye_site])

    @property
    def axes(self) -> Array:
        """Forward, left and up as the columns of (3, 3)."""
        return np.array(self.data.site_xmat[self.agent.eye_site].reshape(3, 3))

    def rays(self) -> Array:
        """Unit directions through the pixels' centres in the world, row by row from the top left, (n, 3)."""
        (width, height), (across, up) = self.size_px, self.half_window
        rows, columns = np.divmod(np.arange(width * height), width)
        left, above = across * (1 - (2 * columns + 1) / width), up * (1 - (2 * rows + 1) / height)
        local = np.stack((np.ones(len(rows)), left, above), axis=1)
        return np.asarray(local @ self.axes.T / np.linalg.norm(local, axis=1, keepdims=True))
