"""Takes of the handover of ``noisy_handover``, imported from bare keypoints as anybody's, with noise of any kind."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from taskgist.importing import import_recording, load_mapping
from taskgist.recording import Recording
from tests.importing import noisy_handover as truth
from tests.importing.skeletons import NAMES, POINTS, RATE_HZ, mapping_file

CHANGES_S = (truth.TAKEN_S + truth.LET_GO_S) / 2
"""When the mug changes hands: the middle of the time in which both hands are around it."""
HANDS = "".join(
    f'{side}_{ours} = "{side.upper()}_{theirs}"\n'
    for side in ("left", "right")
    for ours, theirs in (("hand", "HAND"), ("thumb", "THUMB"), ("hip", "HIP"), ("heel", "HEEL"), ("toe", "FOOT"))
)


def take(folder: Path, *, hands_m: float, correlated_s: float, seed: int) -> Recording:
    """One take; what was written for it stays in a folder.

    Args:
        folder: An empty folder.
        hands_m: Deviation of each coordinate of each hand, metres.
        correlated_s: How long errors last; 0 is white noise.
        seed: Of the noise.
    """
    seen = truth.handover(noise_m=0.003, hands_m=hands_m, correlated_s=correlated_s, seed=seed)
    mug = np.concatenate((seen.mug, np.tile([1.0, 0.0, 0.0, 0.0], (len(seen.mug), 1))), axis=1)
    np.savez(folder / "take.npz", P1=seen.keypoints[:, 0], P2=seen.keypoints[:, 1], mug=mug)
    names = ", ".join(f'"{name}"' for name in NAMES)
    body = f"""
[time]
max_gap_s = 1.0
[sources.body]
file = "take.npz"
array = "{{person}}"
rate_hz = {RATE_HZ}
units = "m"
smooth_s = 0.2
names = [{names}]
[sources.mug]
file = "take.npz"
array = "mug"
rate_hz = {RATE_HZ}
units = "m"
rotation = {{ kind = "wxyz", columns = [3, 4, 5, 6] }}
[people.P1]
source = "body"
[people.P1.points]
{POINTS}{HANDS}
[people.P2]
like = "P1"
[objects.mug]
source = "mug"
shape = {{ type = "cylinder", radius_m = {truth.MUG_RADIUS_M}, length_m = {truth.MUG_LENGTH_M} }}
[supports.table]
size_m = [0.4, 0.8, 0.04]
position_m = [-0.2, 0.0, {truth.TABLE_TOP_M - 0.02}]
"""
    return import_recording(load_mapping(mapping_file(folder, body)))
