"""The words of a fit: which joints may move, which points and directions of a body can be asked for."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping

import mujoco

from taskgist.errors import UnknownNameError
from taskgist.world.body.agent import Agent
from taskgist.world.scene import Scene

ARMS = ("girdle", "shoulder", "elbow", "forearm", "wrist")
MOVING: Mapping[str, tuple[str, ...]] = {
    "arms": ARMS,
    "upper_body": ("torso", *ARMS),
    "trunk_and_arms": ("torso", "head", *ARMS),
}
"""Named sets of joints that a fit may move, by words in the joints' names; ``body`` moves everything, the root too."""

AXES: Mapping[str, tuple[str, tuple[float, float, float]]] = {
    "face": ("eye", (1.0, 0.0, 0.0)),
    "head_up": ("eye", (0.0, 0.0, 1.0)),
    "left_hand": ("left_wrist", (0.0, 0.0, -1.0)),
    "right_hand": ("right_wrist", (0.0, 0.0, -1.0)),
    "left_palm": ("left_wrist", (0.0, -1.0, 0.0)),
    "right_palm": ("right_wrist", (0.0, 1.0, 0.0)),
    "left_thumb": ("left_wrist", (1.0, 0.0, 0.0)),
    "right_thumb": ("right_wrist", (1.0, 0.0, 0.0)),
    "pelvis": ("pelvis", (1.0, 0.0, 0.0)),
    "pelvis_up": ("pelvis", (0.0, 0.0, 1.0)),
    "chest": ("chest", (1.0, 0.0, 0.0)),
}
"""Directions that a fit may ask for: a landmark, and the axis of its frame. Of hands: to the fingers, out of the palm,
to the thumb."""


def landmarks(scene: Scene, agent: str) -> tuple[str, ...]:
    """Names of the landmarks that an agent's model has."""
    return landmarks_in(scene.model, agent)


def landmarks_in(model: mujoco.MjModel, agent: str) -> tuple[str, ...]:
    """Names of an agent's landmarks in a model."""
    prefix = f"{agent}/"
    names = (str(model.site(s).name) for s in range(model.nsite))
    return tuple(name.removeprefix(prefix) for name in names if name.startswith(prefix))


def chosen_joints(agent: Agent, moving: str | Collection[str]) -> Iterable[str]:
    """Names of the joints that may move.

    Args:
        agent: Whose.
        moving: A name of ``MOVING``, ``"body"``, or names of joints.

    Raises:
        UnknownNameError: There is no such set of joints, or no such joint.
    """
    if not isinstance(moving, str):
        for joint in moving:
            if joint not in agent.joints:
                raise UnknownNameError("joint", joint, agent.joints, where=agent.name)
        return moving
    if moving == "body":
        return agent.joints
    if moving not in MOVING:
        raise UnknownNameError("set of joints", moving, ("body", *MOVING))
    return [joint for joint in agent.joints if any(word in joint for word in MOVING[moving])]


def free_dofs(model: mujoco.MjModel, agent: Agent, moving: Iterable[str], *, root: bool) -> set[int]:
    """Degrees of freedom of some of an agent's joints, and of its root if that moves, too."""
    starts = [int(model.joint(f"{agent.name}/{joint}").dofadr[0]) for joint in moving]
    base = int(model.body_dofadr[agent.root_body])
    return {*starts, *(range(base, base + 6) if root else ())}
