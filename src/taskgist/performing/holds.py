"""Hands on things in an audit: what a hand holds stays put in it, and near it, in every frame."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence

import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.performing.findings import Finding, Tolerances
from taskgist.performing.penetrations import Drift, Grip, Motion
from taskgist.settings import Contact
from taskgist.world import Hold, Stage, State, hand_gap_m
from taskgist.world.geometry.transforms import matrix_from_wxyz

FAR_M = 1.0
"""Gaps between a hand and what it is said to hold are measured up to this."""


def grips_of(
    motion: Motion, holding: Sequence[Collection[Hold]], soft: Collection[str], tolerances: Tolerances
) -> Iterator[Grip]:
    """Each time that a hand holds a thing, and how long only its fingers move before and after that."""
    firm = Drift(tolerances.drift_m, tolerances.drift_rad)
    gives = Drift(tolerances.soft_drift_m, tolerances.soft_drift_rad)
    for hold in sorted(set().union(*map(frozenset, holding))):
        holds = np.concatenate(([False], [hold in each for each in holding], [False]))
        edges = np.flatnonzero(holds[1:] != holds[:-1])
        for first, last in zip(edges[::2].tolist(), (edges[1::2] - 1).tolist(), strict=True):
            drift = gives if hold.agent in soft else firm
            yield Grip(hold, first, last, _opens(motion, hold, first, last, drift), drift)


def _opens(motion: Motion, hold: Hold, first: int, last: int, drift: Drift) -> tuple[int, int]:
    def stays(frame: int, other: int) -> bool:
        moved_m, turned_rad = slips(motion, hold, [other, frame])
        return bool(moved_m[1] <= drift.moved_m and turned_rad[1] <= drift.turned_rad)

    begin, end = first, last
    while begin > 0 and stays(begin - 1, first):
        begin -= 1
    while end + 1 < len(motion.qpos) and stays(end + 1, last):
        end += 1
    return begin, end


def slips(motion: Motion, hold: Hold, frames: Sequence[int] | Indices) -> tuple[Array, Array]:
    """How far a thing is, against the first of some frames, from its place in a palm: metres and radians, (n,)."""
    palm = motion.sites[frames, motion.scene.agent(hold.agent).arm(hold.side).palm_site]
    thing = motion.bodies[frames, motion.scene.object_body(hold.object)]
    return apart(palm[:, :3], palm[:, 3:].reshape(-1, 3, 3), thing)


def apart(positions: Array, matrices: Array, things: Array) -> tuple[Array, Array]:
    """How far things (n, 7) move and turn in frames, against the first one: metres and radians, (n,)."""
    local = np.einsum("nji,nj->ni", matrices, things[:, :3] - positions)
    turned = np.einsum("nji,njk->nik", matrices, matrix_from_wxyz(things[:, 3:]))
    cosines = (np.einsum("nij,ij->n", turned, turned[0]) - 1) / 2
    return np.linalg.norm(local - local[0], axis=1), np.arccos(np.clip(cosines, -1.0, 1.0))


def held(motion: Motion, times_s: Array, grips: Iterable[Grip], contact: Contact) -> Iterator[Finding]:
    """Things that slip in a hand, or from which it is too far away, in any frame."""
    scene, stage = motion.scene, Stage(motion.scene)
    for grip in grips:
        frames, hold = np.arange(grip.first, grip.last + 1), grip.hold
        hand = f"{hold.agent}'s {hold.side} hand"
        kinds = zip(slips(motion, hold, frames), grip.drift, ("m", "rad"), strict=True)
        for slipped, allowed, unit in kinds:
            for frame in frames[slipped > allowed].tolist():
                amount = float(slipped[frame - grip.first])
                yield Finding("drift", hold.object, hand, frame, float(times_s[frame]), amount, allowed, unit)
        arm = scene.agent(hold.agent).arm(hold.side)
        for frame in frames.tolist():
            gap_m = hand_gap_m(stage.show(State(motion.qpos[frame])), arm, hold.object, limit_m=FAR_M)
            if gap_m >= contact.grip_m:
                yield Finding("grip", hold.object, hand, frame, float(times_s[frame]), gap_m, contact.grip_m, "m")
