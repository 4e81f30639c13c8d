"""A plan: what a robot does, phase by phase. A value that planning makes and performing carries out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from taskgist.common.arrays import Array
from taskgist.moving.acting import RATE_HZ
from taskgist.planning.candidates import Candidate
from taskgist.world.state import Hold

__all__ = ["RATE_HZ", "Phase", "PhaseName", "Plan"]

PhaseName = Literal[
    "drive",
    "open",
    "reach",
    "approach",
    "close",
    "lift",
    "carry",
    "transport",
    "transfer",
    "lower",
    "take",
    "retreat",
    "fold",
    "withdraw",
]


@dataclass(frozen=True, eq=False)
class Phase:
    """One motion: of the base, of an arm, or of a hand that closes or opens.

    Attributes:
        name: What it is for.
        qpos: Positions of everything, ``RATE_HZ`` a second, (n, nq); read-only.
        holds: What is in which hands meanwhile; in two hands while it is handed over.
    """

    name: PhaseName
    qpos: Array
    holds: frozenset[Hold]

    def __post_init__(self) -> None:
        qpos = np.array(self.qpos, dtype=float)
        qpos.flags.writeable = False
        object.__setattr__(self, "qpos", qpos)

    @property
    def duration_s(self) -> float:
        """How long it takes."""
        return len(self.qpos) / RATE_HZ


@dataclass(frozen=True, eq=False)
class Plan:
    """What a robot does to perform a task.

    Attributes:
        task: Its name.
        performer: Who performs it.
        target: For whom.
        thing: With what.
        side: The hand.
        candidate: Where the thing is in the end.
        phases: One motion after the other.
        notes: What was chosen, in words.
    """

    task: str
    performer: str
    target: str
    thing: str
    side: str
    candidate: Candidate
    phases: tuple[Phase, ...]
    notes: tuple[str, ...] = ()

    @property
    def duration_s(self) -> float:
        """How long it takes, seconds."""
        return sum(phase.duration_s for phase in self.phases)
