"""A small scene with two people, a cup, a box and a door, and recordings of it."""

from __future__ import annotations

from functools import cache

import numpy as np

from taskgist.recording import Label, Provenance, Recording
from taskgist.world import Scene
from taskgist.world.geometry.transforms import about_z
from tests.scenes import TABLE, agent, box, cylinder, scene

DOOR = """<body name="door" pos="0 2 1"><joint name="hinge" axis="0 0 1"/>
<geom type="capsule" fromto="0 0 -1 0 0 1" size="0.05"/><geom type="ellipsoid" size="0.1 0.2 0.3"/></body>"""
FRAMES = 5
LABEL = Label("give", "P1", "P2", "cup", 0.05, 0.1, "by hand")


@cache
def room() -> Scene:
    agents = agent("P1", -0.8, 0.0) + agent("P2", 0.8, 0.0, yaw_deg=180)
    return scene(
        TABLE, cylinder("cup", 0.1, 0.0, 0.78), box("box", 0.0, 0.3, 0.8, (0.1, 0.05, 0.1)), DOOR, agents=agents
    )


def recording(*, label: Label | None = None, seed: int = 0) -> Recording:
    """Everything moves a little; the box and an arm are lost at times."""
    rng = np.random.default_rng(seed)
    world = room()
    qpos = np.tile(world.initial.qpos, (FRAMES, 1))
    qpos += 0.01 * rng.normal(size=qpos.shape).cumsum(axis=0)
    free = [*(world.base_slice(name) for name in world.agents), *(world.object_slice(name) for name in world.objects)]
    for columns in free:
        poses = qpos[:, columns]
        poses[:, 3:] = [about_z(angle) for angle in rng.normal(size=FRAMES)]
    return Recording(
        scene=world,
        times_s=np.arange(FRAMES) / 30,
        qpos=qpos,
        tracked={"box": np.array([1, 1, 0, 0, 1], bool), "P1/left_arm": np.arange(FRAMES) > 0},
        label=label,
        provenance=Provenance(
            source="a test",
            licence="Apache-2.0",
            notes=("nobody was there",),
            mapping='[about]\nname = "Gruß"',
            fit={"P1": {"head": {"median": 1.5}}},
        ),
        name="handover 1",
    )
