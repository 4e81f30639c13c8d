"""An agent alone: the same body in an empty room, for what takes long where much could move.

Inverse kinematics solves for everything that a model has joints for. In a room with others and with things, most of
that stays where it is; without them each step takes less than half the time.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import mujoco
import numpy as np
from numpy.typing import NDArray

from taskgist.world.assembly import assemble
from taskgist.world.body.agent import Agent
from taskgist.world.scene import SCENE_FILE, Scene
from taskgist.world.scene_file import AgentEntry, SceneFile, parse_scene_file

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

EMPTY_ROOM: Mapping[str, bytes] = {"empty.xml": b"<mujoco/>"}
SOME_SEAT_M = 0.45
"""Where nothing is to sit on, the height of a seat must be said; the fitted state has that of the scene."""


@dataclass(frozen=True, eq=False)
class Alone:
    """A model of one agent of a scene and nothing else.

    Attributes:
        model: The model; names are those of the scene.
        agent: The agent in it.
        columns: Index into the scene's qpos of each of the model's, (nq,).
    """

    model: mujoco.MjModel
    agent: Agent
    columns: Indices

    def qpos(self, everywhere: Array) -> Array:
        """The agent's own positions (nq,) among those of the scene, (scene's nq,)."""
        return np.array(everywhere[self.columns])

    def within(self, everywhere: Array, qpos: Array) -> Array:
        """Positions of the scene with the agent's own replaced, (scene's nq,)."""
        changed = np.array(everywhere)
        changed[self.columns] = qpos
        return changed


def alone(scene: Scene, name: str) -> Alone:
    """An agent of a scene, alone.

    Raises:
        UnknownNameError: There is no such agent.
    """
    there = scene.agent(name)
    model, agent = _apart(scene, name) if scene.nq > _count(there) else (scene.model, there)
    columns = np.empty(model.nq, dtype=np.intp)
    columns[agent.base] = np.arange(there.base.start, there.base.stop)
    for joint, column in agent.joints.items():
        columns[column] = there.joints[joint]
    return Alone(model, agent, columns)


def _count(agent: Agent) -> int:
    """How many positions an agent has."""
    return int(agent.base.stop - agent.base.start) + len(agent.joints)


def _apart(scene: Scene, name: str) -> tuple[mujoco.MjModel, Agent]:
    """The agent compiled anew, without the scene."""
    file = parse_scene_file(scene.bundle[SCENE_FILE], where=scene.name)
    (entry,) = (entry for entry in file.agents if entry.name == name)
    (model,) = EMPTY_ROOM
    empty = SceneFile(file.name, model, None, (), (_seated(entry),), file.where)
    assembled = assemble(empty, {**scene.bundle, **EMPTY_ROOM})
    return assembled.model, assembled.agents[name]


def _seated(entry: AgentEntry) -> AgentEntry:
    return replace(entry, seat_height_m=entry.seat_height_m or SOME_SEAT_M)
