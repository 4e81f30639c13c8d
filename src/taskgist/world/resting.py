"""Resting, remembered: what objects rest on and lie in is found anew only where something may have changed it.

In most frames of a demonstration people move and things do not. What an object lies in follows from where the things
of the room are; what it rests on, too, unless a part of somebody's body is where its points are dropped.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from taskgist.settings import Contact
from taskgist.world.contacts import Drop, Rest, container_of
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage


@dataclass(frozen=True, eq=False)
class _Found:
    """What was found for an object while the things of the room were somewhere.

    Attributes:
        things: Where they were, and what was not tracked.
        container: What it lay in.
        drop: Its points.
        support: What these met.
        alone: Whether nobody's body was there that they might have met.
    """

    things: tuple[bytes, frozenset[str]]
    container: str | None
    drop: Drop
    support: str | None = None
    alone: bool = False


class RestingMemory:
    """Says what objects of a scene rest on and lie in: the same as ``rest_of``, mostly sooner.

    Args:
        scene: The scene.
        settings: Distances.
    """

    def __init__(self, scene: Scene, settings: Contact) -> None:
        self._settings = settings
        bodies = [np.r_[scene.base_slice(name), scene.joint_indices(name)] for name in scene.agents]
        self._things = np.setdiff1d(np.arange(scene.nq), np.concatenate([*bodies, np.empty(0, dtype=np.intp)]))
        self._of_agents = np.isin(scene.owners, scene.agents)
        self._found: dict[str, _Found] = {}

    def __call__(self, stage: Stage, name: str) -> Rest:
        """What an object rests on and lies in, in the state that a stage shows."""
        things = (stage.state.qpos[self._things].tobytes(), stage.state.untracked)
        found = self._found.get(name)
        if found is None or found.things != things:
            container = container_of(stage, name, self._settings)
            found = _Found(things, container, Drop.of(stage, name, self._settings))
        around = found.drop.around(stage, self._settings)
        alone = not self._of_agents[around].any()
        if not (alone and found.alone):
            found = replace(found, support=found.drop.meets(stage, around, self._settings), alone=alone)
            self._found[name] = found
        return Rest(found.support, found.container)
