"""Whole scenes: every ability of every agent towards every object, from nothing and following a tracker."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from benchmarks.figure import Figure
from benchmarks.rooms import furnished
from benchmarks.timing import once, seconds, share
from taskgist.perspective import ABILITIES, Viewpoint, effort_from
from taskgist.perspective.scene_efforts import SceneEfforts
from taskgist.perspective.target import Target
from taskgist.settings import DEFAULT, Following
from taskgist.world import Scene, Stage, State

AGENTS, OBJECTS = 4, 50
FRAMES, FRAMES_S = 32, 30.0


def figures() -> Iterator[Figure]:
    """Four agents and fifty objects."""
    yield from_nothing()
    yield from following()


def from_nothing() -> Figure:
    """Everything about a scene, nothing known but its model and state."""
    scene = furnished(AGENTS, OBJECTS)
    first = once(lambda: everything(scene, scene.initial))
    ours = seconds(lambda: everything(scene, scene.initial), repeats=3)
    return Figure(
        "scenes",
        f"{AGENTS} agents × {OBJECTS} objects, all abilities and levels, from nothing",
        ours,
        goal="0.5 s",
        met=ours <= 0.5,
        counts=everything(scene, scene.initial),
        note=f"first time in a scene: {first:.3g} s; per agent and object {1000 * ours / AGENTS / OBJECTS:.3g} ms",
    )


def following() -> Iterator[Figure]:
    """The same while a tracker reports one agent and one object moved in every frame."""
    scene = furnished(AGENTS, OBJECTS)
    exact = replace(DEFAULT, following=Following(place_m=0.0, turn_rad=0.0))  # every frame taken as it is
    follower = SceneEfforts(Stage(scene), exact)
    follower.all()
    taken, asked = [], []
    for state in frames(scene):
        taken.append(once(lambda state=state: follow(follower, state)))  # type: ignore[misc]
        asked.append(follower.asked_count)
        last = state
    fresh = seconds(lambda: SceneEfforts(Stage(scene, last)).all(), repeats=1)
    assert follower.all() == SceneEfforts(Stage(scene, last)).all()
    for percent, label in ((50, "median"), (95, "95th percentile")):
        ours = share(taken, percent)
        yield Figure(
            "scenes",
            f"the same, one agent and one object moved since the last frame: {label}",
            ours,
            {"from nothing": fresh},
            goal="30 frames a second",
            met=ours <= 1 / FRAMES_S,
            counts={"answers anew": share([float(count) for count in asked], percent)},
            note=f"of {AGENTS * OBJECTS * len(ABILITIES)} answers; {len(taken)} frames",
        )


def follow(follower: SceneEfforts, state: State) -> None:
    """All efforts in the next state."""
    follower.update(state)
    follower.all()


def frames(scene: Scene) -> Iterator[State]:
    """Agents walk and look about in turn, a little in each frame; one thing after another is carried."""
    rng, state = np.random.default_rng(0), scene.initial
    for number in range(FRAMES):
        agent = scene.agent(scene.agents[number // 8 % len(scene.agents)])
        name = scene.objects[7 * (number // 8) % len(scene.objects)]
        pan = agent.joints["head_pan"]
        base, thing = (np.array(state.qpos[at]) for at in (agent.base, scene.object_slice(name)))
        base[:2] += rng.normal(0.0, 0.01, 2)
        thing[:3] += rng.normal(0.0, 0.01, 3)
        state = state.replace({pan: state.qpos[pan] + rng.normal(0.0, 0.03)}, at=agent.base, to=base)
        state = state.replace(at=scene.object_slice(name), to=thing)
        yield state


def everything(scene: Scene, state: State) -> dict[str, int]:
    """All efforts and visibility scores of a scene in a state; gives the work done."""
    stage, targets = Stage(scene, state), dict[str, Target]()
    for agent in scene.agents:
        here = Viewpoint(stage, agent, DEFAULT, targets=targets)
        for name in scene.objects:
            for ability in ABILITIES:
                effort_from(here, name, ability)
            here.visibility(name)
    return stage.counts
