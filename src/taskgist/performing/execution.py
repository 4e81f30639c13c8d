"""Carrying a plan out, in thought: its phases become frames, people react, physics has what is let go.

The motion is kinematic: bodies follow the plan exactly, and what a hand holds goes with it. When the hand opens, MuJoCo
takes the thing: where it comes to rest is where it lies from then on, and a plan counts on no more than a few
millimetres of that. The target agent looks where the assumption about its attention says. What comes out is a
recording as of any demonstration, whose provenance says that it is kinematic.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from taskgist.common.arrays import Array
from taskgist.moving.gaze import TURN_S, Fixation, Onlooker, looked
from taskgist.moving.motion import minimum_jerk
from taskgist.planning.judging import Attention
from taskgist.planning.plan import RATE_HZ, Plan
from taskgist.planning.settling import Settled, settled
from taskgist.recording.recording import Label, Provenance, Recording
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist.world.state import Hold, State

BEFORE_S, AFTER_S = 1.0, 1.2
"""Recorded before the first motion, and after the last one: facts are confirmed over time."""
FASTEST_HEAD_RAD_S = 5.0
"""How fast a head turns, at most, to look at something (of the order of [Guitton & Volle 1987])."""
LABEL_BEFORE_S, LABEL_AFTER_S = 0.5, 0.8
"""The label begins so long before the first motion, and ends so long after the last one."""
SOURCE = "planned and carried out by taskgist, kinematically: held things follow the hand, released ones physics"


@dataclass(frozen=True, eq=False)
class Execution:
    """A plan carried out.

    Attributes:
        recording: What happened, labelled.
        holds: Which hands hold what, frame by frame.
        settled: What physics made of each thing that was let go, in order.
    """

    recording: Recording
    holds: tuple[frozenset[Hold], ...]
    settled: tuple[Settled, ...]


def carried_out(scene: Scene, plan: Plan, *, attention: Attention, name: str = "") -> Execution:
    """Carry a plan out.

    Args:
        scene: The scene that it was made for.
        plan: The plan.
        attention: What the target agent looks at meanwhile.
        name: Name of the recording.
    """
    frames, holds = _filmed(plan)
    times = np.arange(len(frames)) / RATE_HZ
    let_go = _let_go(scene, frames, holds)
    for target in plan.targets:
        _look(scene, plan, target, times, frames, attention)
    label = Label(
        task=plan.task,
        performing_agent=plan.performer,
        target_agents=plan.targets,
        target_objects=plan.things,
        start_s=BEFORE_S - LABEL_BEFORE_S,
        end_s=round(float(times[-1]) - AFTER_S + LABEL_AFTER_S, 3),
        how=f"from {LABEL_BEFORE_S:g} s before the first motion to {LABEL_AFTER_S:g} s after the last",
    )
    notes = ("kinematic", f"attention of {' and '.join(plan.targets)}: {attention}", *plan.notes)
    provenance = Provenance(source=SOURCE, licence="Apache-2.0", simulated=True, notes=notes)
    recording = Recording(
        scene=scene, times_s=times, qpos=frames, label=label, provenance=provenance, name=name or plan.task
    )
    return Execution(recording, tuple(holds), let_go)


def phase_frames(plan: Plan) -> tuple[range, ...]:
    """Of each phase the frames of the recording in which it happens; before the first and after the last is rest."""
    found, first = [], round(BEFORE_S * RATE_HZ)
    for phase in plan.phases:
        found.append(range(first, first + len(phase.qpos)))
        first += len(phase.qpos)
    return tuple(found)


def _filmed(plan: Plan) -> tuple[Array, list[frozenset[Hold]]]:
    """Frames of the performer and what it holds, (n, nq), and which hand holds what in each."""
    first, last = plan.phases[0].qpos[:1], plan.phases[-1].qpos[-1:]
    before, after = (round(seconds * RATE_HZ) for seconds in (BEFORE_S, AFTER_S))
    frames, holds = [np.repeat(first, before, axis=0)], [plan.phases[0].holds] * before
    for phase in plan.phases:
        frames.append(phase.qpos)
        holds += [phase.holds] * len(phase.qpos)
    frames.append(np.repeat(last, after, axis=0))
    holds += [plan.phases[-1].holds] * after
    return np.concatenate(frames), holds


def _let_go(scene: Scene, frames: Array, holds: list[frozenset[Hold]]) -> tuple[Settled, ...]:
    """What is let go, and what it touches, moves by physics from then on, until somebody takes it."""
    found = []
    for index in range(1, len(frames)):
        held = {hold.object for hold in holds[index]}
        for thing, hand in sorted({hold.object: f"{hold.agent}/{hold.side}_arm" for hold in holds[index - 1]}.items()):
            if thing not in held:
                found.append(settled(scene, State(frames[index]), thing, passing=[hand]))
                for name, motion in found[-1].motions.items():
                    taken = (i for i in range(index, len(frames)) if name in {hold.object for hold in holds[i]})
                    until = next(taken, len(frames))
                    times_s = np.arange(until - index) / RATE_HZ
                    frames[index:until, scene.object_slice(name)] = motion.at(times_s)
    return tuple(found)


def _look(scene: Scene, plan: Plan, target: str, times: Array, frames: Array, attention: Attention) -> None:
    """Turn a target agent's head, from how it is at the start to what catches its eye."""
    agent = scene.agent(target)
    pan, tilt = agent.profile.pan, agent.profile.tilt
    if attention == "stays" or pan is None or tilt is None:
        return
    fixations = [Fixation(0.0, plan.performer), Fixation(BEFORE_S, plan.performer)]
    if attention == "thing":
        fixations = _followed(scene, plan, target, times, frames)
        fixations.append(Fixation(float(times[-1]) - AFTER_S, plan.things[-1]))  # what all was about, once it is done
    columns = [agent.joints[pan.joint], agent.joints[tilt.joint]]
    start = frames[:, columns].copy()
    begins_s = fixations[1].from_s if len(fixations) > 1 else float(times[-1])
    turned = minimum_jerk((times - begins_s) / TURN_S)[:, None]
    frames[:, columns] = _unhurried(start + turned * (looked(scene, target, times, frames, fixations) - start))


def _followed(scene: Scene, plan: Plan, target: str, times: Array, frames: Array) -> list[Fixation]:
    """What a target agent looks at as it follows one action after the other."""
    stage, found, spans = Stage(scene), list[Fixation](), phase_frames(plan)
    ends, phases = [0], 0
    for action in plan.actions:
        phases += len(action.phases)
        ends.append(spans[phases - 1].stop)
    ends[-1] = len(times)
    for action, (first, last) in zip(plan.actions, pairwise(ends), strict=True):
        onlooker = Onlooker(target, action.performer, f"{action.performer}/{action.side}_arm", action.thing)
        subject = found[-1].subject if found else action.performer
        found += onlooker.fixations(stage, times[first:last], frames[first:last], subject)[1 if found else 0 :]
    return found


def _unhurried(angles: Array) -> Array:
    """Angles, (n, 2), as a head follows them: what passes behind somebody turns it no faster than heads turn."""
    followed, most = np.array(angles), FASTEST_HEAD_RAD_S / RATE_HZ
    for index in range(1, len(angles)):
        followed[index] = followed[index - 1] + np.clip(angles[index] - followed[index - 1], -most, most)
    return followed
