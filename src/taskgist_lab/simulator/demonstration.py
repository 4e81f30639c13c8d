"""A demonstration: a script played in a room, filmed and labelled."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from taskgist.common.arrays import Array
from taskgist.moving.acting import Acting, filmed
from taskgist.moving.gaze import Fixation, Onlooker, looked
from taskgist.recording.recording import Label, Provenance, Recording
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage

# --- Scripts: what a demonstrator does, step by step.
#
# A script is plain data; each step (``steps``) knows how to play itself on an ``Acting``::
#
#     Script("show", "P1", "P2", "cup", (Take("cup", "right"), HoldUp((0.1, 0.0, 1.1), 1.0)), means="held up")
#
# Places are chosen beforehand, by the demonstrator's own geometry (``places``, ``hiding``).


class Step(Protocol):
    """One step of a script."""

    def play(self, acting: Acting) -> None:
        """Work the step out, from the acting's present state on."""


@dataclass(frozen=True)
class Script:
    """A demonstration to be played.

    Attributes:
        task: Name of the task.
        performer: Who performs it.
        target: For whom.
        thing: With what.
        steps: What the performer does.
        target_watches: What the target agent looks at in the beginning, as a subject of ``gaze``; None: the performer.
        means: How the performer reaches its intention, in words.
        target_returns_to: What the target agent is busy with: it looks there again when the thing rests; None: nothing.
    """

    task: str
    performer: str
    target: str
    thing: str
    steps: tuple[Step, ...]
    target_watches: str | None = None
    means: str = ""
    target_returns_to: str | None = None


BEFORE_S, AFTER_S = 1.0, 1.0
"""Recorded before the first movement, and after the last one."""
LABEL_BEFORE_S, LABEL_AFTER_S = 0.5, 0.7
"""The label begins so long before the first movement, and ends so long after everything has come to rest."""
LINGERING_S = 0.5
"""How long eyes that are busy with something else stay with what has come to rest."""
SOURCE = "simulated by taskgist's scripted demonstrator"
HOW = "set by the script: from {before:g} s before the performer moves to {until}"
AT_REST, MEANWHILE = "{after:g} s after its last movement has ended", "while the thing still moves"


def demonstrate(script: Script, scene: Scene, *, seed: int, name: str = "") -> Recording:
    """Play a script and record it.

    Args:
        script: What is demonstrated.
        scene: Where.
        seed: Seed of the natural variation: tempo and sway.
        name: Name of the recording.

    Raises:
        SceneError: The performer takes nothing, or does not get where the script asks it to.
        UnknownNameError: The script names somebody or something that is not there.
    """
    acting = _played(script, scene, np.random.default_rng(seed))
    times, frames = filmed(acting)
    _look(script, acting, times, frames)
    return Recording(
        scene=scene,
        times_s=times,
        qpos=frames,
        label=_label(script, acting),
        provenance=_provenance(script, seed),
        name=name,
    )


def _played(script: Script, scene: Scene, rng: np.random.Generator) -> Acting:
    acting = Acting(scene, script.performer, script.target, rng)
    acting.look(script.target)
    acting.wait(BEFORE_S)
    for step in script.steps:
        step.play(acting)
    acting.wait(AFTER_S)
    return acting


def _look(script: Script, acting: Acting, times: Array, frames: Array) -> None:
    """Turn the heads: the performer's by its script, the target agent's by what catches its attention."""
    scene = acting.scene
    hand = f"{script.performer}/{acting.acting_side}_arm"
    onlooker = Onlooker(script.target, script.performer, hand, _moved(script, acting))
    caught = onlooker.fixations(Stage(scene), times, frames, script.target_watches or script.performer)
    if script.target_returns_to is not None:
        caught = _returning(caught, acting.last_carry().until_s + LINGERING_S, script.target_returns_to)
    for name, fixations in ((script.performer, acting.looks), (script.target, caught)):
        profile, joints = scene.agent(name).profile, scene.agent(name).joints
        if profile.pan is not None and profile.tilt is not None:  # some robots have no neck to turn
            angles = looked(scene, name, times, frames, fixations)
            frames[:, [joints[profile.pan.joint], joints[profile.tilt.joint]]] = angles


def _moved(script: Script, acting: Acting) -> str:
    """What the performer moves: what it carries, which need not be the thing that it is all about."""
    return acting.carries[-1].thing if acting.carries else script.thing


def _returning(caught: list[Fixation], since_s: float, subject: str) -> list[Fixation]:
    """Fixations of somebody who is busy with a subject: from some time on, nothing else catches its eyes."""
    return [*(fixation for fixation in caught if fixation.from_s < since_s), Fixation(since_s, subject)]


def _label(script: Script, acting: Acting) -> Label:
    until = AT_REST.format(after=LABEL_AFTER_S) if acting.over_s is None else MEANWHILE
    return Label(
        task=script.task,
        performing_agent=script.performer,
        target_agents=script.target,
        target_objects=script.thing,
        start_s=round(float(acting.motions[0].start_s - LABEL_BEFORE_S), 3),
        end_s=round(float(acting.motions[-1].end_s + LABEL_AFTER_S if acting.over_s is None else acting.over_s), 3),
        how=HOW.format(before=LABEL_BEFORE_S, until=until),
    )


def _provenance(script: Script, seed: int) -> Provenance:
    notes = (f"means: {script.means}", f"seed: {seed}") if script.means else (f"seed: {seed}",)
    return Provenance(source=SOURCE, licence="Apache-2.0", simulated=True, notes=notes)
