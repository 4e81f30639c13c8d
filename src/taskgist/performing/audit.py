"""The audit: whether a motion could be carried out as it is, by somebody who believes nothing that its planner said.

Facts say that a task is done even where an arm went through the table. So every motion is looked at again, on every
frame and between them, from its frames alone: penetrations (``penetrations.py``), limits of joints, speeds and
accelerations, whether held things stay put in the hand and free ones where they are, jumps, rest, and whether all is
in the end where the plan has it. A motion with a finding is not performed. What is looked at is what a recording keeps
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

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.common.frozen import FrozenMap
from taskgist.errors import InputError, UnknownNameError
from taskgist.performing.findings import Audit, Finding, Kind, MotionLimits, Tolerances
from taskgist.performing.penetrations import Grip, Motion, Penetrations
from taskgist.recording.recording import free_slices, rounded
from taskgist.settings import DEFAULT, Contact
from taskgist.world import Hold, Scene, Stage, State, hand_gap_m
from taskgist.world.contacts import rest_of
from taskgist.world.geometry.transforms import matrix_from_wxyz

GRAVITY_M_S2 = 9.81


def audit(
    scene: Scene,
    times_s: ArrayLike,
    qpos: ArrayLike,
    holding: Sequence[Collection[Hold]],
    performers: Mapping[str, MotionLimits],
    *,
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
        performers: Who moves by plan, and how fast each may.
        planned: Where everything is in the end as planned, (nq,); of this, things count. None: nothing is known of it.
        tolerances: What is let pass; None: ``Tolerances()``.
        contact: When a hand is near enough to hold, and what rests.

    Raises:
        InputError: Frames, times, holds and a planned end that do not fit together.
        UnknownNameError: No such agent, joint or object.
    """
    times_s, qpos = np.asarray(times_s, dtype=float), np.asarray(qpos, dtype=float)
    _check(scene, times_s, qpos, holding, performers)
    if planned is not None and np.shape(planned) != (scene.nq,):
        raise InputError("a planned end is one frame", value=np.shape(planned), hint=f"give ({scene.nq},)")
    tolerances = Tolerances() if tolerances is None else tolerances
    motion = Motion(scene, _as_written(scene, qpos))
    grips = tuple(_grips(motion, holding, tolerances))
    by_plan = [grip for grip in grips if grip.hold.agent in performers]
    carried = {name: _carried(motion, name, grips, tolerances) for name in motion.moved_objects()}
    search = Penetrations(motion, performers, grips, tolerance_m=tolerances.depth_m, in_hand_m=tolerances.in_hand_m)
    findings = [
        *_penetrations(motion, search, times_s),
        *_joints(motion, _steps(motion.model, qpos), times_s, performers, tolerances),
        *_held(motion, times_s, by_plan, tolerances, contact),
        *_jumps(motion, times_s, carried, tolerances),
        *_unrest(motion, times_s, holding, carried, tolerances, contact),
        *(() if planned is None else _elsewhere(motion, times_s, np.asarray(planned, dtype=float), tolerances)),
    ]
    duration_s = float(times_s[-1] - times_s[0])
    return Audit(_worst(findings), len(qpos), search.looked, duration_s, FrozenMap(search.gaps_m))


def _check(
    scene: Scene,
    times_s: Array,
    qpos: Array,
    holding: Sequence[Collection[Hold]],
    performers: Mapping[str, MotionLimits],
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


# --- Hands on things.


def _grips(motion: Motion, holding: Sequence[Collection[Hold]], tolerances: Tolerances) -> Iterator[Grip]:
    """Each time that a hand holds a thing, and how long only its fingers move before and after that."""
    for hold in sorted(set().union(*map(frozenset, holding))):
        held = np.concatenate(([False], [hold in each for each in holding], [False]))
        edges = np.flatnonzero(held[1:] != held[:-1])
        for first, last in zip(edges[::2].tolist(), (edges[1::2] - 1).tolist(), strict=True):
            yield Grip(hold, first, last, _opens(motion, hold, first, last, tolerances))


def _opens(motion: Motion, hold: Hold, first: int, last: int, tolerances: Tolerances) -> tuple[int, int]:
    def stays(frame: int, other: int) -> bool:
        moved_m, turned_rad = _slips(motion, hold, [other, frame])
        return bool(moved_m[1] <= tolerances.drift_m and turned_rad[1] <= tolerances.drift_rad)

    begin, end = first, last
    while begin > 0 and stays(begin - 1, first):
        begin -= 1
    while end + 1 < len(motion.qpos) and stays(end + 1, last):
        end += 1
    return begin, end


def _slips(motion: Motion, hold: Hold, frames: Sequence[int] | Indices) -> tuple[Array, Array]:
    """How far a thing is, against the first of some frames, from its place in a palm: metres and radians, (n,)."""
    palm = motion.sites[frames, motion.scene.agent(hold.agent).arm(hold.side).palm_site]
    thing = motion.bodies[frames, motion.scene.object_body(hold.object)]
    return _apart(palm[:, :3], palm[:, 3:].reshape(-1, 3, 3), thing)


def _apart(positions: Array, matrices: Array, things: Array) -> tuple[Array, Array]:
    """How far things (n, 7) move and turn in frames, against the first one: metres and radians, (n,)."""
    local = np.einsum("nji,nj->ni", matrices, things[:, :3] - positions)
    turned = np.einsum("nji,njk->nik", matrices, matrix_from_wxyz(things[:, 3:]))
    cosines = (np.einsum("nij,ij->n", turned, turned[0]) - 1) / 2
    return np.linalg.norm(local - local[0], axis=1), np.arccos(np.clip(cosines, -1.0, 1.0))


def _held(
    motion: Motion, times_s: Array, grips: Iterable[Grip], tolerances: Tolerances, contact: Contact
) -> Iterator[Finding]:
    """Things that slip in a hand, or that it does not even touch."""
    scene = motion.scene
    for grip in grips:
        frames, hold = np.arange(grip.first, grip.last + 1), grip.hold
        hand = f"{hold.agent}'s {hold.side} hand"
        slips = zip(_slips(motion, hold, frames), (tolerances.drift_m, tolerances.drift_rad), ("m", "rad"), strict=True)
        for slipped, allowed, unit in slips:
            for frame in frames[slipped > allowed].tolist():
                amount = float(slipped[frame - grip.first])
                yield Finding("drift", hold.object, hand, frame, float(times_s[frame]), amount, allowed, unit)
        stage = Stage(scene, State(motion.qpos[grip.first]))
        gap_m = hand_gap_m(stage, scene.agent(hold.agent).arm(hold.side), hold.object, limit_m=1.0)
        if gap_m >= contact.grip_m:
            at = grip.first
            yield Finding("grip", hold.object, hand, at, float(times_s[at]), gap_m, contact.grip_m, "m")


# --- Penetrations and joints.


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


def _joints(
    motion: Motion, steps: Array, times_s: Array, performers: Mapping[str, MotionLimits], tolerances: Tolerances
) -> Iterator[Finding]:
    """Joints beyond their limits, and joints and bases that move too fast, by steps (n − 1, nv) from frame to frame."""
    model = motion.model
    durations = np.diff(times_s)[:, None]
    speeds = steps / durations
    # At rest before and after: of speeds between frames, the differences take as long as from middle to middle.
    resting = np.zeros((1, model.nv))
    around = np.concatenate((durations[:1], durations, durations[-1:]))
    changes = np.diff(np.concatenate((resting, speeds, resting)), axis=0) / ((around[1:] + around[:-1]) / 2)
    following = _followers(model)
    for name, limits in performers.items():
        for joint in _joints_of(motion.scene, name):
            unit = UNITS.get(int(model.jnt_type[joint]))
            if unit and model.jnt_limited[joint] and joint not in following:
                (low, high), positions = model.jnt_range[joint], motion.qpos[:, model.jnt_qposadr[joint]]
                beyond = np.maximum(low - positions, positions - high)
                yield from _beyond("joint limit", _label(model, joint), times_s, beyond, tolerances.limit, unit)
        for dof, label, unit, speed, acceleration in _dofs(motion.scene, name, limits):
            jump = tolerances.jump_m_s if unit == "m" else tolerances.jump_rad_s
            jumps = np.abs(speeds[:, dof]) > jump
            moved = np.where(jumps, np.abs(steps[:, dof]), 0.0)
            yield from _beyond("jump", label, times_s, moved, 0.0, unit)
            rates = np.where(jumps, 0.0, np.abs(speeds[:, dof]))
            yield from _beyond("speed", label, times_s, rates, speed, f"{unit}/s", 1 + tolerances.rate)
            rates = np.abs(changes[:, dof])
            yield from _beyond("acceleration", label, times_s, rates, acceleration, f"{unit}/s²", 1 + tolerances.rate)


UNITS = {int(mujoco.mjtJoint.mjJNT_HINGE): "rad", int(mujoco.mjtJoint.mjJNT_SLIDE): "m"}
"""Units of joints with one degree of freedom."""


def _followers(model: mujoco.MjModel) -> frozenset[int]:
    """Joints that the model has follow another one (URDF's mimic): that one's limit counts.

    Published models give followers limits that their own coupling breaks, as the PR2's fingers do.
    """
    coupled = (model.eq_type == int(mujoco.mjtEq.mjEQ_JOINT)) & (model.eq_obj2id >= 0)
    return frozenset(model.eq_obj1id[coupled].tolist())


def _joints_of(scene: Scene, name: str) -> list[int]:
    return np.flatnonzero(np.isin(scene.model.jnt_bodyid, scene.agent(name).bodies)).tolist()


def _label(model: mujoco.MjModel, joint: int) -> str:
    return str(model.joint(joint).name)


def _dofs(scene: Scene, name: str, limits: MotionLimits) -> Iterator[tuple[int, str, str, float, float]]:
    """Each degree of freedom of an agent: its index, name and unit, its highest speed and acceleration."""
    model = scene.model
    for joint in _joints_of(scene, name):
        dof, label, unit = int(model.jnt_dofadr[joint]), _label(model, joint), UNITS.get(int(model.jnt_type[joint]))
        if unit:
            short = label.removeprefix(f"{name}/")
            yield dof, label, unit, limits.speeds.get(short, np.inf), limits.accelerations.get(short, np.inf)
        else:
            for axis in range(3):
                yield dof + axis, f"{name}'s base", "m", limits.base_m_s, limits.base_m_s2
                yield dof + 3 + axis, f"{name}'s base", "rad", limits.base_rad_s, limits.base_rad_s2


def _beyond(
    kind: Kind, what: str, times_s: Array, amounts: Array, allowed: float, unit: str, slack: float = 1.0
) -> Iterator[Finding]:
    """A finding for each frame in which an amount is more than allowed."""
    for frame in np.flatnonzero(amounts > allowed * slack).tolist():
        yield Finding(kind, what, None, frame, float(times_s[frame]), float(amounts[frame]), allowed, unit)


# --- Free things: they fall, or stay; and come to rest.


def _jumps(
    motion: Motion, times_s: Array, carried: Mapping[str, Sequence[bool]], tolerances: Tolerances
) -> Iterator[Finding]:
    """Things that move although no hand holds them, nor what they are in or on.

    Left alone, a thing gains speed by gravity alone, never rises above where it was left, and goes aside or turns
    only as it falls.
    """
    scene, durations = motion.scene, np.diff(times_s).tolist()
    for name in motion.moved_objects():
        bodies = motion.bodies[:, scene.object_body(name)]
        moved_m = np.linalg.norm(np.diff(bodies[:, :3], axis=0), axis=1).tolist()
        turned_rad = _angles(bodies[1:, 3:], bodies[:-1, 3:]).tolist()
        left, before = bodies[0], (0.0, 0.0)  # its pose when it was let go, and its speeds in the frame before
        for frame, duration_s in enumerate(durations):
            speeds = moved_m[frame] / duration_s, turned_rad[frame] / duration_s
            if carried[name][frame]:
                left = bodies[frame + 1]
            else:
                gains = GRAVITY_M_S2 * duration_s + tolerances.resting_m_s, tolerances.falling_rad_s2 * duration_s
                if any(speed > past + gain for speed, past, gain in zip(speeds, before, gains, strict=True)):
                    amount, unit = _larger(moved_m[frame], turned_rad[frame], tolerances)
                    yield Finding("jump", name, "no hand", frame, float(times_s[frame]), amount, 0.0, unit)
                    left, speeds = bodies[frame + 1], (0.0, 0.0)
                elif not _falls(left, bodies[frame + 1], tolerances):
                    moved, turned = bodies[frame + 1, :3] - left[:3], _angles(bodies[frame + 1, 3:], left[3:])
                    amount, unit = _larger(float(np.linalg.norm(moved)), float(turned), tolerances)
                    yield Finding("free motion", name, None, frame + 1, float(times_s[frame + 1]), amount, 0.0, unit)
            before = speeds


def _falls(left: Array, now: Array, tolerances: Tolerances) -> bool:
    """Whether a thing may have come from one pose (7,) to another by itself: settled a little, or fallen."""
    aside_m, drop_m = float(np.hypot(*(now[:2] - left[:2]))), float(left[2] - now[2])
    tipped = drop_m > tolerances.settling_m or _angles(now[3:], left[3:]) <= tolerances.settling_rad
    return bool(tipped and drop_m > -tolerances.depth_m and aside_m <= tolerances.settling_m + 2 * max(drop_m, 0.0))


def _larger(moved_m: float, turned_rad: float, tolerances: Tolerances) -> tuple[float, str]:
    """What is worth telling of a motion: how far it went, or else by how much it turned."""
    return (moved_m, "m") if moved_m > tolerances.drift_m else (turned_rad, "rad")


def _angles(one: Array, other: Array) -> Array:
    """Angles between orientations (..., 4), radians, (...)."""
    return np.asarray(2 * np.arccos(np.clip(np.abs((one * other).sum(axis=-1)), 0.0, 1.0)))


def _carried(motion: Motion, name: str, grips: Sequence[Grip], tolerances: Tolerances) -> list[bool]:
    """From each frame to the next, whether a hand holds a thing, or holds what the thing rides on, or in.

    What rides touches what is held, and stays where it was there: from frame to frame, and since the hand took hold.
    """
    carried = [False] * (len(motion.qpos) - 1)
    own, thing = motion.scene.solid_geoms_of(name), motion.scene.object_body(name)
    for first, last, other in ((grip.first, grip.last, grip.hold.object) for grip in grips):
        if other == name:
            carried[first:last] = [True] * (last - first)
            continue
        frames = np.arange(first, last + 1)
        carrier = motion.bodies[frames, motion.scene.object_body(other)]
        moved_m, turned_rad = _apart(carrier[:, :3], matrix_from_wxyz(carrier[:, 3:]), motion.bodies[frames, thing])
        rides = np.abs(np.diff(moved_m)) <= tolerances.drift_m
        rides &= (moved_m[1:] <= tolerances.settling_m) & (turned_rad[1:] <= tolerances.settling_rad)
        others, within_m = motion.scene.solid_geoms_of(other), tolerances.riding_m
        for frame in frames[:-1][rides].tolist():
            stage = Stage(motion.scene, State(motion.qpos[frame]))
            carried[frame] = carried[frame] or stage.closest(own, others, limit_m=within_m)[0] < within_m
    return carried


def _unrest(
    motion: Motion,
    times_s: Array,
    holding: Sequence[Collection[Hold]],
    carried: Mapping[str, Sequence[bool]],
    tolerances: Tolerances,
    contact: Contact,
) -> Iterator[Finding]:
    """Things that were moved, and hang in the air for a while, or at first, or in the end; or still move then."""
    scene, last = motion.scene, len(motion.qpos) - 1
    durations = np.diff(times_s)
    for name in motion.moved_objects():
        positions = motion.bodies[:, scene.object_body(name), :3]
        speeds_m_s = np.linalg.norm(np.diff(positions, axis=0), axis=1) / durations
        if speeds_m_s[-1] > tolerances.resting_m_s:
            speed, allowed = float(speeds_m_s[-1]), tolerances.resting_m_s
            yield Finding("rest", name, None, last, float(times_s[last]), speed, allowed, "m/s")
        free = [not each for each in carried[name]]
        whiles = [*_whiles(np.array(free) & (speeds_m_s <= tolerances.resting_m_s)), (last, last)]
        for begin, end in whiles:
            if begin > 0 and end < last and times_s[end] - times_s[begin] < tolerances.hanging_s:
                continue
            for frame in _looked_at(begin, end, [any(hold.object == name for hold in each) for each in holding]):
                rest = rest_of(Stage(scene, State(motion.qpos[frame])), name, contact)
                if rest.support is None and rest.container is None:
                    yield Finding("rest", name, None, frame, float(times_s[frame]), 0.0, 0.0, "")
                    break


def _looked_at(begin: int, end: int, held: Sequence[bool]) -> list[int]:
    """At which frames, of a while in which a thing stands still, its rest is looked at.

    At the while's ends a hand may hold it, or have just let it go: so amid it, and last; first if the motion begins so.
    """
    frames = [frame for frame in range(begin, end + 1) if not held[frame]]
    if not frames:
        return []
    first = frames[:1] if begin == 0 else []
    return sorted({*first, frames[len(frames) // 2], frames[-1]})


def _elsewhere(motion: Motion, times_s: Array, planned: Array, tolerances: Tolerances) -> Iterator[Finding]:
    """Things that are not where a plan has them in the end, the others among them."""
    scene, last = motion.scene, len(motion.qpos) - 1
    for name in scene.objects:
        now, wanted = motion.qpos[last, scene.object_slice(name)], planned[scene.object_slice(name)]
        moved_m = float(np.linalg.norm(now[:3] - wanted[:3]))
        turned_rad = float(_angles(now[3:], wanted[3:] / np.linalg.norm(wanted[3:])))
        if moved_m > tolerances.settling_m:
            yield Finding("end", name, None, last, float(times_s[last]), moved_m, tolerances.settling_m, "m")
        if turned_rad > tolerances.settling_rad:
            yield Finding("end", name, None, last, float(times_s[last]), turned_rad, tolerances.settling_rad, "rad")


def _whiles(flags: Mask) -> list[tuple[int, int]]:
    """First and last frame of each while in which all steps from frame to frame (n,) have a flag."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], flags, [False])).astype(np.int8)))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))
