"""Where demonstrations come from: the generator, or the paper's own study with everything displaced."""

from __future__ import annotations

import math
import zlib
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Protocol

import numpy as np

from taskgist.demonstrator.generator import TASKS, simulate
from taskgist.demonstrator.study import STUDY
from taskgist.recording import Recording
from taskgist.study.evaluation.pool import HELD_OUT_EVERY
from taskgist.study.intuition import INTUITION
from taskgist.study.paper.draws import ANGLE_RAD, DISTANCE_M

MEANS = "means: "
"""How a demonstrator's note on the means begins."""


class Player(Protocol):
    """Plays demonstrations."""

    def __call__(self, task: str, *, seed: int, number: int) -> Recording:
        """The demonstration of this number; raises a SceneError where it cannot be played."""


@dataclass(frozen=True)
class Source:
    """Where demonstrations come from.

    Args:
        name: Its name.
        text: What it is, in a few words.
        tasks: Which tasks of the paper it knows.
        play: Plays one demonstration.
        distinct: By task, how many distinct demonstrations there are, which come by turns; none where each is another.
    """

    name: str
    text: str
    tasks: tuple[str, ...]
    play: Player
    distinct: Mapping[str, int] = field(default_factory=dict)

    def kind(self, task: str, number: int) -> int:
        """Which of its distinct demonstrations one displaces; its own number where each is another."""
        return turn(number, self.distinct[task]) if task in self.distinct else number


def displaced(task: str, *, seed: int, number: int) -> Recording:
    """A demonstration of the paper's study, each by turns, with people and things displaced each time.

    Raises:
        SceneError: The displaced arrangement leaves no way to do it.
    """
    rng = np.random.default_rng([seed, zlib.crc32(task.encode()), number])
    staged = STUDY[task][turn(number, len(STUDY[task]))]
    return staged.record(int(rng.integers(2**31)), distance_m=DISTANCE_M, angle_rad=ANGLE_RAD)


def turn(number: int, count: int) -> int:
    """Which of ``count`` demonstrations comes with this number: each as often as others, also among those held out."""
    return (number + number // math.lcm(count, HELD_OUT_EVERY)) % count


def means_of(recording: Recording) -> str:
    """What its demonstrator noted as the means; the recording's name where it noted none."""
    noted = (note.removeprefix(MEANS) for note in recording.provenance.notes if note.startswith(MEANS))
    return next(noted, recording.name)


def _known(tasks: Collection[str]) -> tuple[str, ...]:
    return tuple(task for task in INTUITION if task in tasks)


SOURCES: Mapping[str, Source] = MappingProxyType(
    {
        each.name: each
        for each in (
            Source("generator", "generated demonstrations in random rooms", _known(TASKS), simulate),
            Source(
                "study",
                "the paper's study, all displaced by up to 3 cm and 5°",
                _known(STUDY),
                displaced,
                MappingProxyType({task: len(staged) for task, staged in STUDY.items()}),
            ),
        )
    }
)
"""All sources by name, the usual one first."""
