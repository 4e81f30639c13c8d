"""Things in an audit: free ones fall, or stay, and come to rest; what a hand carries goes with it.

A thing is carried while a hand holds it, or holds what it rides on, or in. Left alone it gains speed by gravity alone,
never rises above where it was left, and goes aside or turns only as it falls; it stands still only where something
carries it.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence

import numpy as np

from taskgist.common.arrays import Array, Mask
from taskgist.performing.findings import Finding, Tolerances
from taskgist.performing.holds import apart
from taskgist.performing.penetrations import Grip, Motion
from taskgist.settings import Contact
from taskgist.world import Hold, Stage, State
from taskgist.world.contacts import Rest, rest_of
from taskgist.world.geometry.transforms import matrix_from_wxyz

GRAVITY_M_S2 = 9.81
NOTHING = Rest(support=None, container=None)


def jumps(
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


def carried_in(motion: Motion, name: str, grips: Sequence[Grip], tolerances: Tolerances) -> list[bool]:
    """From each frame to the next, whether a hand holds a thing, or holds what the thing rides on, or in.

    What rides touches what is held, and stays where it was there: from frame to frame, and since the hand took hold.
    """
    carried = [False] * (len(motion.qpos) - 1)
    own, thing = motion.scene.solid_geoms_of(name), motion.scene.object_body(name)
    for grip in grips:
        first, last, other = grip.first, grip.last, grip.hold.object
        if other == name:
            carried[first:last] = [True] * (last - first)
            continue
        frames = np.arange(first, last + 1)
        carrier = motion.bodies[frames, motion.scene.object_body(other)]
        moved_m, turned_rad = apart(carrier[:, :3], matrix_from_wxyz(carrier[:, 3:]), motion.bodies[frames, thing])
        rides = np.abs(np.diff(moved_m)) <= grip.drift.moved_m
        rides &= (moved_m[1:] <= tolerances.settling_m) & (turned_rad[1:] <= tolerances.settling_rad)
        others, within_m = motion.scene.solid_geoms_of(other), tolerances.riding_m
        stage = Stage(motion.scene)
        for frame in frames[:-1][rides].tolist():
            stage.show(State(motion.qpos[frame]))
            carried[frame] = carried[frame] or stage.closest(own, others, limit_m=within_m)[0] < within_m
    return carried


def unrest(
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
                if rest == NOTHING:
                    yield Finding("rest", name, None, frame, float(times_s[frame]), 0.0, 0.0, "")
                    break


def left_behind(motion: Motion, times_s: Array, tolerances: Tolerances, contact: Contact) -> Iterator[Finding]:
    """Things that stay where they are, in the air, when what they rest on, or in, at first is taken away."""
    scene, moved = motion.scene, motion.moved_objects()
    stage = Stage(scene)
    for name in (each for each in scene.objects if each not in moved):
        rest = rest_of(stage.show(State(motion.qpos[0])), name, contact)
        for carrier in (each for each in moved if each in (rest.support, rest.container)):
            bodies = motion.bodies[:, scene.object_body(carrier)]
            away = np.linalg.norm(bodies[:, :3] - bodies[0, :3], axis=1) > tolerances.riding_m
            away |= _angles(bodies[:, 3:], bodies[0, 3:]) > tolerances.settling_rad
            frames = np.flatnonzero(away).tolist()
            for frame in sorted({*frames[:1], *frames[len(frames) // 2 :][:1], *frames[-1:]}):
                if rest_of(stage.show(State(motion.qpos[frame])), name, contact) == NOTHING:
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


def elsewhere(motion: Motion, times_s: Array, planned: Array, tolerances: Tolerances) -> Iterator[Finding]:
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
