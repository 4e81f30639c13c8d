"""Following a real tracker: noise on everything, one person walks, another one carries something.

Times are CPU time on one core. Levels found for what the tracker's states were taken for are compared with those of
the states themselves.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from typing import NamedTuple

import mujoco
import numpy as np

from benchmarks.figure import Figure
from benchmarks.rooms import furnished
from benchmarks.timing import share
from taskgist.common.arrays import Array
from taskgist.perspective.scene_efforts import SceneEfforts
from taskgist.world import Scene, Stage, State

FRAME_S = 1 / 30
NOISE_M, NOISE_RAD = 0.0005, math.radians(0.2)
"""Standard deviations of the noise of each coordinate, and of each joint and turn about each axis."""
WALK_M_S = 0.8
COMPARED_EVERY = 10
"""Every so many frames all levels are compared with those of the frame itself."""


class Size(NamedTuple):
    """How much there is to follow, and how fast that is to go."""

    agents: int
    objects: int
    goal_hz: float
    frames: int


SIZES = (Size(3, 20, 30.0, 60), Size(4, 50, 15.0, 10))


def figures() -> Iterator[Figure]:
    """All questions in every frame, only those of who does not move by himself, and all within a time."""
    for size in SIZES:
        scene = furnished(size.agents, size.objects)
        for standing in (True, False):
            yield following(scene, size, standing=standing)
        yield within_time(scene, size)


def following(scene: Scene, size: Size, *, standing: bool) -> Figure:
    """CPU time of a frame: the next state, and the answers to all questions, or only of those who stand."""
    asked = [name for name in scene.agents if not (standing and name in (WALKER, CARRIER))]
    warm_up(scene)
    states = list(tracked(scene, size.frames + 1))
    efforts = SceneEfforts(Stage(scene, states[0]))
    ask(efforts, scene.agents)
    taken, anew, compared, different = list[float](), list[float](), 0, 0
    for number, state in enumerate(states[1:]):
        taken.append(cpu(lambda state=state: go_on(efforts, state, asked)))  # type: ignore[misc]
        anew.append(float(efforts.asked_count))
        if number % COMPARED_EVERY == COMPARED_EVERY - 1:
            exact = SceneEfforts(Stage(scene, state))
            for question, effort in exact.all().items():
                if question[0] in asked:
                    compared += 1
                    different += efforts.effort(*question).level != effort.level
    goal_s = 1 / size.goal_hz
    who = "of those who stand" if standing else "of everybody"
    return Figure(
        "tracking",
        f"{size.agents} people × {size.objects} things tremble, one walks, one carries; questions {who}: mean",
        float(np.mean(taken)),
        goal=f"{size.goal_hz:.0f} frames a second",
        met=float(np.mean(taken)) <= goal_s,
        counts={
            "answers anew in a frame, median": share(anew, 50),
            "levels compared": compared,
            "different": different,
        },
        note=f"median {1000 * share(taken, 50):.3g} ms, 95th percentile {1000 * share(taken, 95):.3g} ms, CPU time",
    )


def within_time(scene: Scene, size: Size) -> Figure:
    """CPU time of a frame where what changed is found anew within a time, and how old the other answers are."""
    warm_up(scene)
    states = list(tracked(scene, size.frames + 1))
    efforts, budget_s = SceneEfforts(Stage(scene, states[0])), BUDGET_SHARE / size.goal_hz
    efforts.latest(budget_s)
    taken, ages_s, compared, different = list[float](), list[float](), 0, 0
    for number, state in enumerate(states[1:]):
        taken.append(cpu(lambda state=state: go_on_within(efforts, state, budget_s)))  # type: ignore[misc]
        found = efforts.latest(0.0)
        ages_s += [state.time_s - each.time_s for each in found.values()]
        if number % COMPARED_EVERY == COMPARED_EVERY - 1:
            for question, effort in SceneEfforts(Stage(scene, state)).all().items():
                compared += 1
                different += found[question].effort.level != effort.level
    mean_s = float(np.mean(taken))
    return Figure(
        "tracking",
        f"{size.agents} people × {size.objects} things, as above, answers renewed for {1000 * budget_s:.0f} ms a frame",
        mean_s,
        goal=f"{size.goal_hz:.0f} frames a second",
        met=mean_s <= 1 / size.goal_hz,
        counts={"levels compared": compared, "different": different},
        note=f"median {1000 * share(taken, 50):.3g} ms, 95th percentile {1000 * share(taken, 95):.3g} ms, CPU; "
        f"{np.mean(np.array(ages_s) == 0.0):.0%} of the answers are of the frame, the oldest {max(ages_s):.2g} s old",
    )


BUDGET_SHARE = 0.5
"""Share of a frame's time that is spent on answers; going on to the next state takes the rest."""


def cpu(run: Callable[[], object]) -> float:
    """CPU time of one call, seconds."""
    start = time.process_time()
    run()
    return time.process_time() - start


def warm_up(scene: Scene) -> None:
    """Have all compiled, and what belongs to the scene alone made."""
    efforts = SceneEfforts(Stage(scene))
    for state in tracked(scene, 3):
        efforts.update(state)
        efforts.all()


def go_on(efforts: SceneEfforts, state: State, agents: list[str]) -> None:
    """The next state, and all questions of some agents."""
    efforts.update(state)
    ask(efforts, agents)


def go_on_within(efforts: SceneEfforts, state: State, budget_s: float) -> None:
    """The next state, and what is found anew within a time."""
    efforts.update(state)
    efforts.latest(budget_s)


def ask(efforts: SceneEfforts, agents: list[str] | tuple[str, ...]) -> None:
    """All questions of some agents."""
    for agent in agents:
        for name in efforts.stage.scene.objects:
            for ability in ("see", "reach", "grasp"):
                efforts.effort(agent, name, ability)


WALKER, CARRIER = "P1", "P2"


def tracked(scene: Scene, frames: int) -> Iterator[State]:
    """What a tracker tells: one person walks to and fro, another moves a thing about in front of her, all trembles."""
    rng = np.random.default_rng(0)
    for number in range(1, frames + 1):
        state = carried(scene, walked(scene, scene.initial, number * FRAME_S), number * FRAME_S)
        yield State(trembled(scene.model, state.qpos, rng), time_s=number * FRAME_S)


def walked(scene: Scene, state: State, time_s: float) -> State:
    """The walker on her way: away from her table and back, legs swinging."""
    agent = scene.agent(WALKER)
    base = np.array(state.qpos[agent.base])
    away_m = WALK_M_S * abs((time_s + 1.5) % 3.0 - 1.5)
    base[1] -= away_m
    swing = {"left_hip_flexion": 0.4, "right_hip_flexion": -0.4, "left_knee": 0.2, "right_knee": 0.2}
    phase = math.sin(2 * math.pi * 0.9 * time_s)
    changes = {agent.joints[joint]: state.qpos[agent.joints[joint]] + by * phase for joint, by in swing.items()}
    return state.replace(changes, at=agent.base, to=base)


def carried(scene: Scene, state: State, time_s: float) -> State:
    """The carrier's forearm swings, and a thing goes with her palm."""
    agent, name = scene.agent(CARRIER), scene.objects[0]
    elbow = agent.joints["right_elbow"]
    state = state.replace({elbow: 1.2 + 0.3 * math.sin(2 * math.pi * 0.5 * time_s)})
    palm = Stage(scene, state).site(agent.arm("right").palm_site).position
    place = np.array(state.qpos[scene.object_slice(name)])
    place[:3] = palm
    return state.replace(at=scene.object_slice(name), to=place)


def trembled(model: mujoco.MjModel, qpos: Array, rng: np.random.Generator) -> Array:
    """All positions with noise."""
    found = np.array(qpos)
    for joint in range(model.njnt):
        at, kind = int(model.jnt_qposadr[joint]), int(model.jnt_type[joint])
        if kind == int(mujoco.mjtJoint.mjJNT_FREE):
            found[at : at + 3] += rng.normal(0.0, NOISE_M, 3)
            mujoco.mju_quatIntegrate(found[at + 3 : at + 7], rng.normal(0.0, NOISE_RAD, 3), 1.0)
        else:
            found[at] += rng.normal(0.0, NOISE_RAD)
    return found
