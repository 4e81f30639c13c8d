"""The audit: whether a motion could be carried out as it is, by somebody who believes nothing that its planner said.

Facts say that a task is done even where an arm went through the table. So every motion is looked at again, on every
frame and between them, from its frames alone: penetrations (``penetrations.py``), limits of joints, speeds and
accelerations, fingers that are driven together, whether held things stay put in the hand and free ones where they are,
jumps, rest, whether anything moves that nobody moves, and whether all is in the end where the plan has it. A motion
with a finding is not performed. What is looked at is what a recording keeps
of the motion, a tenth of a millimetre and a hundredth of a milliradian, but for speeds and accelerations: a tenth of a
millimetre is much in a thirtieth of a second. Example::

    found = audit(scene, times_s, qpos, holding, {"PR2": MotionLimits(...)})
    reasons = [finding.text for finding in found.findings]  # "at 1.20 s PR2/r_wrist_link is 14.2 mm deep in table"
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from taskgist.common.arrays import Array
from taskgist.common.frozen import FrozenMap
from taskgist.errors import InputError, UnknownNameError
from taskgist.performing.findings import Audit, Finding, MotionLimits, Tolerances
from taskgist.performing.holds import grips_of, held
from taskgist.performing.joints import joints, strays
from taskgist.performing.penetrations import Motion, Penetrations
from taskgist.performing.things import carried_in, elsewhere, jumps, left_behind, unrest
from taskgist.recording.recording import free_slices, rounded
from taskgist.settings import DEFAULT, Contact
from taskgist.world import Hold, Scene


def audit(
    scene: Scene,
    times_s: ArrayLike,
    qpos: ArrayLike,
    holding: Sequence[Collection[Hold]],
    performers: Mapping[str, MotionLimits],
    *,
    soft: Collection[str] = (),
    planned: ArrayLike | None = None,
    tolerances: Tolerances | None = None,
    contact: Contact = DEFAULT.contact,
) -> Audit:
    """Look at a motion, which begins and ends at rest.

    Args:
        scene: The scene.
        times_s: Times of the frames, seconds, increasing, (n,).
        qpos: Where everything is, (n, nq).
        holding: Who holds what in each frame, n of them.
        performers: Who moves by plan, takers among them, and how fast each may. Of all others nothing moves but the
            head.
        soft: Those of them whose hands give, as people's do: things slip and turn more in them.
        planned: Where everything is in the end as planned, (nq,); of this, things count. None: nothing is known of it.
        tolerances: What is let pass; None: ``Tolerances()``.
        contact: When a hand is near enough to hold, and what rests.

    Raises:
        InputError: Frames, times, holds and a planned end that do not fit together.
        UnknownNameError: No such agent, joint or object.
    """
    times_s, qpos = np.asarray(times_s, dtype=float), np.asarray(qpos, dtype=float)
    _check(scene, times_s, qpos, holding, performers, soft)
    if planned is not None and np.shape(planned) != (scene.nq,):
        raise InputError("a planned end is one frame", value=np.shape(planned), hint=f"give ({scene.nq},)")
    tolerances = Tolerances() if tolerances is None else tolerances
    motion = Motion(scene, _as_written(scene, qpos))
    grips = tuple(grips_of(motion, holding, soft, tolerances))
    carried = {name: carried_in(motion, name, grips, tolerances) for name in motion.moved_objects()}
    search = Penetrations(motion, performers, grips, tolerance_m=tolerances.depth_m, in_hand_m=tolerances.in_hand_m)
    findings = [
        *_penetrations(motion, search, times_s),
        *joints(motion, _steps(motion.model, qpos), times_s, performers, tolerances),
        *strays(motion, times_s, performers, tolerances),
        *held(motion, times_s, grips, contact),
        *jumps(motion, times_s, carried, tolerances),
        *unrest(motion, times_s, holding, carried, tolerances, contact),
        *left_behind(motion, times_s, tolerances, contact),
        *(() if planned is None else elsewhere(motion, times_s, np.asarray(planned, dtype=float), tolerances)),
    ]
    duration_s = float(times_s[-1] - times_s[0])
    return Audit(_worst(findings), len(qpos), search.looked, duration_s, FrozenMap(search.gaps_m))


def _check(
    scene: Scene,
    times_s: Array,
    qpos: Array,
    holding: Sequence[Collection[Hold]],
    performers: Mapping[str, MotionLimits],
    soft: Collection[str],
) -> None:
    count = len(times_s)
    if times_s.ndim != 1 or count < 2 or qpos.shape != (count, scene.nq) or len(holding) != count:
        shapes = f"{times_s.shape}, {qpos.shape}, {len(holding)}"
        hint = f"give (n,), (n, {scene.nq}) and n of two frames or more"
        raise InputError("times, frames and holds are one each", value=shapes, hint=hint)
    if not (np.isfinite(qpos).all() and (np.diff(times_s) > 0).all()):
        raise InputError("frames are finite, and their times increase", field="times_s")
    for hold in set().union(*map(frozenset, holding)):
        scene.agent(hold.agent).arm(hold.side)
        scene.object_body(hold.object)
    for name in soft:
        scene.agent(name)
    for name, limits in performers.items():
        for joint in {*limits.speeds, *limits.accelerations}:
            if joint not in scene.agent(name).joints:
                raise UnknownNameError("joint", joint, scene.agent(name).joints, where=name)


def _as_written(scene: Scene, qpos: Array) -> Array:
    """Frames as a recording keeps them, (n, nq), their quaternions of length 1."""
    written = rounded(qpos, scene)
    for free in free_slices(scene):
        turns = written[:, free.start + 3 : free.stop]
        turns /= np.linalg.norm(turns, axis=1, keepdims=True)
    return written


def _steps(model: mujoco.MjModel, qpos: Array) -> Array:
    """How each degree of freedom changes from frame to frame, (n − 1, nv)."""
    steps = np.zeros((len(qpos) - 1, model.nv))
    for frame, step in enumerate(steps):
        mujoco.mj_differentiatePos(model, step, 1.0, qpos[frame], qpos[frame + 1])
    return steps


def _worst(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Of findings of one kind about the same two things the worst, in order of time."""
    groups: dict[tuple[str, str, str | None, str], list[Finding]] = {}
    for each in findings:
        groups.setdefault((each.kind, each.what, each.other, each.unit), []).append(each)
    worst = []
    for group in groups.values():
        top = max(group, key=lambda each: each.amount - each.allowed)
        worst.append(replace(top, frames=len({each.frame for each in group})))
    return tuple(sorted(worst, key=lambda each: (each.time_s, each.kind, each.what)))


def _penetrations(motion: Motion, search: Penetrations, times_s: Array) -> Iterator[Finding]:
    for each in search.find():
        what, other = (_named(motion.scene, geom) for geom in each.geoms)
        step_s = times_s[each.frame + 1] - times_s[each.frame] if each.share else 0.0
        time_s = float(times_s[each.frame] + each.share * step_s)
        yield Finding("penetration", what, other, each.frame, time_s, each.depth_m, each.allowed_m, "m")


def _named(scene: Scene, geom: int) -> str:
    """A shape by its owner, for agents by its link: "PR2/base_link", "table"."""
    owner = scene.owners[geom]
    return str(scene.model.body(int(scene.model.geom_bodyid[geom])).name) if owner in scene.agents else owner
