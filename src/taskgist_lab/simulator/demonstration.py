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
        also_for: Further target agents; they watch, and return to, what the first one does.
        also_with: Further target objects.
    """

    task: str
    performer: str
    target: str
    thing: str
    steps: tuple[Step, ...]
    target_watches: str | None = None
    means: str = ""
    target_returns_to: str | None = None
    also_for: tuple[str, ...] = ()
    also_with: tuple[str, ...] = ()


BEFORE_S, AFTER_S = 1.0, 1.0
"""Recorded before the first movement, and after the last one."""
LABEL_BEFORE_S, LABEL_AFTER_S = 0.5, 0.7
"""The label begins so long before the first movement, and ends so long after everything has come to rest."""
NOTICED_BEFORE_S = 0.8
"""So long before the next thing is taken the hand that sets out for it is noticed."""
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
    """Turn the heads: the performer's by its script, the target agents' by what catches their attention."""
    scene = acting.scene
    looks = {script.performer: acting.looks}
    for target in (script.target, *script.also_for):
        caught = _caught(script, acting, target, times, frames)
        if script.target_returns_to is not None:
            caught = _returning(caught, acting.last_carry().until_s + LINGERING_S, script.target_returns_to)
        looks[target] = caught
    for name, fixations in looks.items():
        profile, joints = scene.agent(name).profile, scene.agent(name).joints
        if profile.pan is not None and profile.tilt is not None:  # some robots have no neck to turn
            angles = looked(scene, name, times, frames, fixations)
            frames[:, [joints[profile.pan.joint], joints[profile.tilt.joint]]] = angles


def _caught(script: Script, acting: Acting, target: str, times: Array, frames: Array) -> list[Fixation]:
    """What catches a target agent's attention: the acting hand and what it moves, one thing after the other."""
    stage, found = Stage(acting.scene), [Fixation(0.0, script.target_watches or script.performer)]
    for hand, thing, since_s in _moved(script, acting):
        found = [fixation for fixation in found if fixation.from_s <= since_s]
        onlooker = Onlooker(target, script.performer, f"{script.performer}/{hand}_arm", thing)
        during = times >= since_s
        found += onlooker.fixations(stage, times[during], frames[during], found[-1].subject)[1:]
    return found


def _moved(script: Script, acting: Acting) -> list[tuple[str, str, float]]:
    """What the performer moves, which need not be the thing that it is all about: hand, thing, and from when on."""
    if not script.also_with:
        thing = acting.carries[-1].thing if acting.carries else script.thing
        return [(acting.acting_side, thing, 0.0)]
    own = [carry for carry in acting.carries if carry.agent is None]
    return [(each.side, each.thing, 0.0 if each is own[0] else each.from_s - NOTICED_BEFORE_S) for each in own]


def _returning(caught: list[Fixation], since_s: float, subject: str) -> list[Fixation]:
    """Fixations of somebody who is busy with a subject: from some time on, nothing else catches its eyes."""
    return [*(fixation for fixation in caught if fixation.from_s < since_s), Fixation(since_s, subject)]


def _label(script: Script, acting: Acting) -> Label:
    until = AT_REST.format(after=LABEL_AFTER_S) if acting.over_s is None else MEANWHILE
    return Label(
        task=script.task,
        performing_agent=script.performer,
        target_agents=(script.target, *script.also_for),
        target_objects=(script.thing, *script.also_with),
        start_s=round(float(acting.motions[0].start_s - LABEL_BEFORE_S), 3),
        end_s=round(float(acting.motions[-1].end_s + LABEL_AFTER_S if acting.over_s is None else acting.over_s), 3),
        how=HOW.format(before=LABEL_BEFORE_S, until=until),
    )


def _provenance(script: Script, seed: int) -> Provenance:
    notes = (f"means: {script.means}", f"seed: {seed}") if script.means else (f"seed: {seed}",)
    return Provenance(source=SOURCE, licence="Apache-2.0", simulated=True, notes=notes)
