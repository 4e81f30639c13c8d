"""Findings: what an audit says is wrong with a motion, as values and as sentences; and what it lets pass."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from taskgist.common.frozen import FrozenMap, Json

Kind = Literal[
    "penetration",
    "joint limit",
    "coupling",
    "speed",
    "acceleration",
    "stray",
    "drift",
    "grip",
    "jump",
    "free motion",
    "rest",
    "end",
]


@dataclass(frozen=True)
class MotionLimits:
    """How fast an agent may move; what is not named may move at any speed that is no jump.

    Attributes:
        speeds: Highest speed by joint, without the agent's prefix: rad/s or m/s.
        accelerations: Highest acceleration by joint: rad/s² or m/s².
        base_m_s: Highest speed of the base along each axis of the world.
        base_m_s2: Its highest acceleration.
        base_rad_s: How fast the base may turn.
        base_rad_s2: Its highest acceleration in turning.
    """

    speeds: Mapping[str, float] = field(default_factory=FrozenMap)
    accelerations: Mapping[str, float] = field(default_factory=FrozenMap)
    base_m_s: float = np.inf
    base_m_s2: float = np.inf
    base_rad_s: float = np.inf
    base_rad_s2: float = np.inf


@dataclass(frozen=True)
class Tolerances:
    """What an audit lets pass (ours, but for the first three, which are what a performed motion promises)."""

    depth_m: float = 0.002
    """Penetration beyond what is allowed."""
    drift_m: float = 0.002
    """How far a held thing may slip in the hand."""
    drift_rad: float = np.deg2rad(1.0)
    """How far it may turn there."""
    soft_drift_m: float = 0.006
    """How far it may slip in a hand that gives, as people's do (ours: so firmly the engine's people hold)."""
    soft_drift_rad: float = np.deg2rad(5.0)
    """How far it may turn there."""
    in_hand_m: float = 0.005
    """How deep a hand and what it holds may be in each other: fingers are collided as hulls, larger than they are, and
    close on things by their pads (measured: up to 4.5 mm)."""
    limit: float = 1e-3
    """How far a joint may be beyond its limits, off the one that it follows, or from where it is at first if nobody
    moves it: radians or metres."""
    rate: float = 0.02
    """By which share speeds and accelerations may exceed their limits: recordings have digits."""
    settling_m: float = 0.010
    """How far aside a free thing may settle, and how far from its planned place it may be in the end."""
    settling_rad: float = np.deg2rad(5.0)
    """How far it may turn as it settles, and be turned from its planned orientation in the end."""
    riding_m: float = 0.005
    """What rides on a held thing, or in it, is no farther from it."""
    resting_m_s: float = 0.02
    """What is slower than this at the end rests."""
    hanging_s: float = 0.2
    """A free thing may stand still in the air for less than this: where it is thrown to, say."""
    jump_rad_s: float = 12.0
    """What turns faster than this jumps."""
    jump_m_s: float = 5.0
    """What moves faster than this jumps."""
    falling_rad_s2: float = 200.0
    """What turns while it falls or tips gains speed by less than this: gravity at the rim of something small."""


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong with a motion, told where it is worst.

    Attributes:
        kind: What is wrong.
        what: A part of the performer, a joint, or a thing: "PR2/r_gripper_palm_link".
        other: What it concerns: the thing that is penetrated, the hand that holds; None where there is none.
        frame: The frame in which, or after which, it is worst.
        time_s: When that is.
        amount: How much: metres, radians, or these per second or second².
        allowed: How much would be right.
        unit: The unit of both.
        frames: In how many frames it is wrong.
    """

    kind: Kind
    what: str
    other: str | None
    frame: int
    time_s: float
    amount: float
    allowed: float
    unit: str
    frames: int = 1

    @property
    def text(self) -> str:
        """The finding as a sentence."""
        long = f" (wrong in {self.frames} frames)" if self.frames > 1 and self.kind != "rest" else ""
        return f"at {self.time_s:.2f} s {_SENTENCES[self.kind](self)}{long}"

    def to_json(self) -> dict[str, Json]:
        """As JSON values."""
        names = ("kind", "what", "other", "frame", "time_s", "amount", "allowed", "unit", "frames", "text")
        return {name: getattr(self, name) for name in names}


def _measure(amount: float, unit: str) -> str:
    """An amount as people write it: millimetres and degrees."""
    if unit.startswith("m"):
        return f"{1000 * amount:.1f} mm{unit[1:]}"
    return f"{np.degrees(amount):.1f}°{unit[3:]}"


_SENTENCES: Mapping[Kind, Callable[[Finding], str]] = {
    "penetration": lambda f: (
        f"{f.what} is {_measure(f.amount, f.unit)} deep in {f.other}"
        + (f", and may be {_measure(f.allowed, f.unit)}" if f.allowed else "")
    ),
    "joint limit": lambda f: f"{f.what} is {_measure(f.amount, f.unit)} beyond its limit",
    "coupling": lambda f: f"{f.what} is {_measure(f.amount, f.unit)} from where the joint that it follows has it",
    "stray": lambda f: f"{f.what} has moved by {_measure(f.amount, f.unit)}, and nobody moves it",
    "speed": lambda f: f"{f.what} moves at {_measure(f.amount, f.unit)}, and may at {_measure(f.allowed, f.unit)}",
    "acceleration": lambda f: (
        f"{f.what} is accelerated by {_measure(f.amount, f.unit)}, and may be by {_measure(f.allowed, f.unit)}"
    ),
    "drift": lambda f: f"{f.what} has moved by {_measure(f.amount, f.unit)} in {f.other}",
    "grip": lambda f: f"{f.other} holds {f.what} from {_measure(f.amount, f.unit)} away",
    "jump": lambda f: (
        f"{f.what} jumps by {_measure(f.amount, f.unit)}" + (f", although {f.other} holds it" if f.other else "")
    ),
    "free motion": lambda f: f"{f.what} has moved by {_measure(f.amount, f.unit)} although no hand holds it",
    "rest": lambda f: (
        f"{f.what} still moves at the end, at {_measure(f.amount, f.unit)}"
        if f.unit == "m/s"
        else f"{f.what} rests on nothing, and nobody holds it"
    ),
    "end": lambda f: f"{f.what} is {_measure(f.amount, f.unit)} from where the plan has it in the end",
}


@dataclass(frozen=True)
class Audit:
    """What an audit found.

    Attributes:
        findings: All that is wrong, in order of time; of each pair, joint or thing the worst.
        frames: Frames of the motion.
        looked: Configurations in which shapes were measured, those between frames included.
        duration_s: How long the motion takes.
        gaps_m: The smallest gaps below 2 cm between a performer or what it moves and anything else, by "one to other",
            metres; negative where they overlap. What touched at the start is not counted.
    """

    findings: tuple[Finding, ...]
    frames: int
    looked: int
    duration_s: float
    gaps_m: Mapping[str, float]

    @property
    def clean(self) -> bool:
        """Whether nothing is wrong."""
        return not self.findings

    def to_json(self) -> dict[str, Json]:
        """As JSON values."""
        return {
            "clean": self.clean,
            "findings": [finding.to_json() for finding in self.findings],
            "frames": self.frames,
            "looked": self.looked,
            "duration_s": self.duration_s,
            "gaps_m": dict(self.gaps_m),
        }
