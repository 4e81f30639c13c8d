"""Conditions under which demonstrations are watched: a name, what it means, and what it does to a recording."""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from taskgist.recording import Recording
from taskgist.study.evaluation.noise import calmed, gapped, mistimed, shaken, thinned
from taskgist.study.evaluation.sample import CLEAN

SMOOTHING_S = 0.5
"""Window of the smoothing conditions: what removes most of the shaking and still keeps a hand's motion."""
GAP_S = 1.0
OFFSETS_S = {"label-off": 0.3, "label-off-1s": 1.0}


@dataclass(frozen=True)
class Condition:
    """A way in which recordings are worse than they could be.

    Args:
        name: Its name.
        text: What it means, in a few words.
        spoil: What it does to a recording.
    """

    name: str
    text: str
    spoil: Callable[[Recording, np.random.Generator], Recording]

    def applied(self, recording: Recording, *, seed: int, number: int) -> Recording:
        """The recording under this condition; the same for the same task, seed and number."""
        task = recording.label.task if recording.label else ""
        return self.spoil(recording, np.random.default_rng([seed, number, *_words(task), *_words(self.name)]))


def _shaken(position_m: float, angle_deg: float, *, smoothing_s: float = 0.0) -> Callable[..., Recording]:
    def spoil(recording: Recording, rng: np.random.Generator) -> Recording:
        noisy = shaken(recording, rng, position_m=position_m, angle_rad=math.radians(angle_deg))
        return calmed(noisy, smoothing_s)

    return spoil


def _mistimed(offset_s: float) -> Callable[..., Recording]:
    return lambda recording, rng: mistimed(recording, rng, offset_s=offset_s)


def _all() -> tuple[Condition, ...]:
    smoothing = f"smoothed over {SMOOTHING_S:g} s"
    return (
        Condition(CLEAN, "as demonstrated", lambda recording, _: recording),
        Condition("noise-1cm", "tracker noise of 1 cm and 2°", _shaken(0.01, 2.0)),
        Condition("noise-3cm", "tracker noise of 3 cm and 6°", _shaken(0.03, 6.0)),
        Condition("noise-1cm-smoothed", f"1 cm and 2°, {smoothing}", _shaken(0.01, 2.0, smoothing_s=SMOOTHING_S)),
        Condition("noise-3cm-smoothed", f"3 cm and 6°, {smoothing}", _shaken(0.03, 6.0, smoothing_s=SMOOTHING_S)),
        Condition("lost-10", "10 % of the frames lost", lambda recording, rng: thinned(recording, rng, share=0.10)),
        Condition("lost-30", "30 % of the frames lost", lambda recording, rng: thinned(recording, rng, share=0.30)),
        Condition("gap", f"{GAP_S:g} s lost in one piece", lambda recording, rng: gapped(recording, rng, gap_s=GAP_S)),
        *(
            Condition(name, f"label ends off by ±{offset_s:g} s, within what was recorded", _mistimed(offset_s))
            for name, offset_s in OFFSETS_S.items()
        ),
    )


CONDITIONS: Mapping[str, Condition] = MappingProxyType({each.name: each for each in _all()})
"""All conditions by name, the clean one first."""


def _words(text: str) -> tuple[int]:
    return (zlib.crc32(text.encode()),)
