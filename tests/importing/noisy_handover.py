"""A handover as a depth camera sees it: 34 noisy keypoints per person, a mug, and who really held it when.

P1 (at x < 0) lifts a mug from a table with its right hand and hands it to P2, who takes it with its right hand and
draws it near. All in the room's axes and metres.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from taskgist.world.geometry.transforms import about_z, matrix_from_wxyz
from tests.importing.skeletons import NAMES, RATE_HZ, standing

Array = NDArray[np.float64]

TIMES_S = np.arange(100) / RATE_HZ
LIFTED_S, TAKEN_S, LET_GO_S = 0.6, 1.5, 1.9
"""When P1 lifts the mug, P2's hand closes around it, and P1's hand opens."""
TABLE_TOP_M, MUG_RADIUS_M, MUG_LENGTH_M = 0.95, 0.04, 0.1
START, MEET, KEPT = (-0.2, -0.08, TABLE_TOP_M + MUG_LENGTH_M / 2), (0.0, 0.0, 1.2), (0.17, 0.05, 1.15)
PALM_M = (0.085, 0.07)
"""How far the mug's centre is before the wrist, and beside it."""
HIDDEN = ("WRIST", "HAND", "HANDTIP", "THUMB")


@dataclass(frozen=True, eq=False)
class Handover:
    """Keypoints (frames, 2, 34, 3) with NaN where lost, and the mug's place (frames, 3)."""

    keypoints: Array
    mug: Array


def handover(
    *,
    noise_m: float = 0.0,
    hidden_s: tuple[float, float] = (0.0, 0.0),
    seed: int = 0,
    hands_m: float = 0.0,
    correlated_s: float = 0.0,
) -> Handover:
    """The handover, with noise, with points of the face that come and go, and wrists hidden for a while.

    Args:
        noise_m: White noise of each point.
        hidden_s: From when to when the points of the hands are lost.
        seed: Of the noise.
        hands_m: Noise of each hand as a whole, as of hands that a depth camera guesses.
        correlated_s: How long that noise lasts: 0 is white.
    """
    rng = np.random.default_rng(seed)
    mug = _path([(0.0, START), (LIFTED_S, START), (1.3, MEET), (LET_GO_S + 0.1, MEET), (2.6, KEPT)])
    first = _body(-0.5, 0.0, grips=mug, closes_s=0.0, opens_s=LET_GO_S)
    second = _body(0.5, np.pi, grips=mug, closes_s=TAKEN_S, opens_s=np.inf)
    keypoints = np.stack([first, second], axis=1)
    keypoints += noise_m * rng.normal(size=keypoints.shape)
    hands = [_lasting(rng, hands_m, correlated_s) for _ in range(4)]
    for number, side in enumerate(("LEFT", "RIGHT", "LEFT", "RIGHT")):
        for name in HIDDEN if hands_m else ():
            keypoints[:, number // 2, NAMES.index(f"{side}_{name}")] += hands[number]
    if noise_m:
        for name in ("NOSE", "LEFT_EAR", "RIGHT_EYE"):
            start = rng.integers(len(TIMES_S) - 20)
            keypoints[start : start + 18, :, NAMES.index(name)] = np.nan
    hidden = np.clip(TIMES_S, hidden_s[0], hidden_s[1] - 1e-9) == TIMES_S
    for name in HIDDEN:
        for side in ("LEFT", "RIGHT"):
            keypoints[hidden, :, NAMES.index(f"{side}_{name}")] = np.nan
    return Handover(keypoints, mug)


def _lasting(rng: np.random.Generator, deviation_m: float, correlated_s: float) -> Array:
    """Noise whose correlation falls by a factor of e in a while, (frames, 3)."""
    kept = np.exp(-1.0 / RATE_HZ / correlated_s) if correlated_s > 0.0 else 0.0
    noise = rng.normal(0.0, deviation_m, (len(TIMES_S), 3)) if deviation_m else np.zeros((len(TIMES_S), 3))
    for frame in range(1, len(noise)):
        noise[frame] = kept * noise[frame - 1] + np.sqrt(1.0 - kept**2) * noise[frame]
    return noise


def _path(knots: list[tuple[float, tuple[float, float, float]]]) -> Array:
    """From knot to knot with minimum jerk."""
    places = np.tile(knots[-1][1], (len(TIMES_S), 1)).astype(float)
    for (start_s, start), (end_s, end) in reversed(list(pairwise(knots))):
        share = np.clip((TIMES_S - start_s) / (end_s - start_s), 0.0, 1.0)
        eased = share**3 * (10 - 15 * share + 6 * share**2)
        before = np.searchsorted(TIMES_S, end_s)
        places[:before] = (np.array(start) + eased[:, None] * (np.array(end) - np.array(start)))[:before]
    return places


def _body(x: float, yaw_rad: float, *, grips: Array, closes_s: float, opens_s: float) -> Array:
    """A person whose right hand comes to the mug, holds it and goes away, (frames, 34, 3)."""
    turn, place = matrix_from_wxyz(about_z(yaw_rad)), np.array([x, 0.0, 0.0])
    points = np.tile(standing() @ turn.T + place, (len(TIMES_S), 1, 1))
    forward, palm = turn[:, 0], turn[:, 1]
    at = {name: NAMES.index(f"RIGHT_{name}") for name in ("SHOULDER", "ELBOW", *HIDDEN)}
    rest = points[0, at["WRIST"]]
    gripping = grips - PALM_M[0] * forward - PALM_M[1] * palm
    comes = np.clip((TIMES_S - closes_s + 0.7) / 0.7, 0.0, 1.0) if closes_s > 0.0 else np.ones(len(TIMES_S))
    share = np.minimum(comes, np.clip(1.0 - (TIMES_S - opens_s) / 0.5, 0.0, 1.0))[:, None]
    wrist = rest + share**2 * (3 - 2 * share) * (gripping - rest)
    points[:, at["WRIST"]] = wrist
    points[:, at["ELBOW"]] = _elbow(points[:, at["SHOULDER"]], wrist, out=-palm)
    bent = forward * 0.125 + palm * 0.05
    points[:, at["HAND"]] = wrist + 0.088 * forward
    points[:, at["HANDTIP"]] = wrist + bent
    points[:, at["THUMB"]] = wrist + 0.07 * forward + 0.03 * palm + (0.0, 0.0, 0.06)
    return points


def _elbow(shoulder: Array, wrist: Array, out: Array, upper_m: float = 0.295, fore_m: float = 0.27) -> Array:
    """Of a two-link arm, down and to the outside."""
    along = wrist - shoulder
    distance = np.linalg.norm(along, axis=1, keepdims=True)
    along /= distance
    first = (upper_m**2 - fore_m**2 + distance**2) / (2 * distance)
    down = np.array([0.0, 0.0, -1.0]) + 0.5 * out
    down = down - along * (along @ down)[:, None]
    down /= np.linalg.norm(down, axis=1, keepdims=True)
    return np.asarray(shoulder + first * along + np.sqrt(np.maximum(upper_m**2 - first**2, 0.0)) * down)
