"""A demonstration: a script played in a room, filmed and labelled."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taskgist.demonstrator.acting import Acting
from taskgist.demonstrator.attention import Onlooker
from taskgist.demonstrator.filming import filmed
from taskgist.demonstrator.gaze import looked
from taskgist.demonstrator.script import Script
from taskgist.recording import Label, Provenance, Recording
from taskgist.world import Scene, Stage

Array = NDArray[np.float64]

BEFORE_S, AFTER_S = 1.0, 1.0
"""Recorded before the first movement, and after the last one."""
LABEL_BEFORE_S, LABEL_AFTER_S = 0.5, 0.7
"""The label begins so long before the first movement, and ends so long after everything has come to rest."""
SOURCE = "simulated by taskgist's scripted demonstrator"
HOW = "set by the script: from {before:g} s before the performer moves to {after:g} s after its last movement has ended"


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
    """Turn the heads: the performer's by its script, the target agent's by what draws its attention."""
    scene = acting.scene
    hand = f"{script.performer}/{acting.last_carry().side}_arm"
    onlooker = Onlooker(script.target, script.performer, hand, script.thing)
    drawn = onlooker.fixations(Stage(scene), times, frames, script.target_watches or script.performer)
    for name, fixations in ((script.performer, acting.looks), (script.target, drawn)):
        profile, joints = scene.agent(name).profile, scene.agent(name).joints
        assert profile.pan is not None
        assert profile.tilt is not None
        angles = looked(scene, name, times, frames, fixations)
        frames[:, [joints[profile.pan.joint], joints[profile.tilt.joint]]] = angles


def _label(script: Script, acting: Acting) -> Label:
    return Label(
        task=script.task,
        performing_agent=script.performer,
        target_agent=script.target,
        target_object=script.thing,
        start_s=round(float(acting.motions[0].start_s - LABEL_BEFORE_S), 3),
        end_s=round(float(acting.motions[-1].end_s + LABEL_AFTER_S), 3),
        how=HOW.format(before=LABEL_BEFORE_S, after=LABEL_AFTER_S),
    )


def _provenance(script: Script, seed: int) -> Provenance:
    notes = (f"means: {script.means}", f"seed: {seed}") if script.means else (f"seed: {seed}",)
    return Provenance(source=SOURCE, licence="Apache-2.0", simulated=True, notes=notes)
