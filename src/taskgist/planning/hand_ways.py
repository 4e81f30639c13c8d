"""What grasping finds: a hand at a thing, with its lines to and from there; or where grasps failed, in sentences."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from enum import Enum

from taskgist.common.arrays import Array, Indices
from taskgist.perspective.effort import Blocking
from taskgist.planning.performer import Grip, with_values

NAMED = 2
"""Names of what is in the way that a sentence tells."""


class Gate(Enum):
    """Where a grasp fails first, in the order of the questions; ``{thing}`` and ``{others}`` are filled in."""

    HAND_AT_START = "approaches to the {thing} where it lies are blocked by {others}"
    HAND_AT_GOAL = "approaches to the {thing} where it is to be are blocked by {others}"
    REACH = "grasps of the {thing} are out of the arm's reach"
    OPENING = "grasps of the {thing} are too wide for the fingers: {others}"
    KINEMATICS = "grasps of the {thing} are at angles to which the arm does not turn the hand"
    BODY = "grasps of the {thing} bring the robot against {others}"
    APPROACH = "approaches to the {thing} are blocked by {others}"
    JUMP = "approaches to the {thing} are more than the arm follows without a jump"
    FINGERS = "grasps of the {thing} bring fingers into it"
    LOOSE = "grasps of the {thing} leave the fingers {others} from it, which do not close so far"
    RISE = "ways up with the {thing} are blocked by {others}"


Failures = list[tuple[Gate, str | None]]
"""At which gates configurations failed, and what was in the way."""


@dataclass(frozen=True, eq=False)
class Tally:
    """How many grasps failed at each gate, and what was in the way."""

    counts: Counter[Gate] = field(default_factory=Counter)
    met: dict[Gate, Counter[str]] = field(default_factory=dict)

    def add(self, gate: Gate, other: str | None = None, count: int = 1) -> None:
        """Count grasps that failed at a gate."""
        self.counts[gate] += count
        if other is not None:
            self.met.setdefault(gate, Counter())[other] += count

    def text(self, thing: str) -> str:
        """A sentence: "every one of 48 approaches to the tape is blocked by the table"."""
        total = sum(self.counts.values())
        parts = []
        for gate in Gate:
            if count := self.counts[gate]:
                met = self.met.get(gate, Counter())
                telling = Counter({name: count for name, count in met.items() if name != f"the {thing}"}) or met
                others = " and ".join(name for name, _ in telling.most_common(NAMED))
                much = "all" if count == total else f"{count} of {total}"
                parts.append(f"{much} {gate.value.format(thing=thing, others=others)}")
        return "; ".join(parts)


@dataclass(frozen=True, eq=False)
class HandWay:
    """A hand at a thing, and its lines to and from there, by the joints of its arm's chain.

    Attributes:
        thing: What it grasps.
        side: The hand's side.
        grasp: Which of the thing's grasps.
        positions: Indices into qpos of the chain's joints, (k,).
        before: All positions before the arm moves, at the stand, with the thing where it is grasped or put, (nq,).
        line: From 10 cm off along the approach to the grasp, the hand open, (n, k).
        rise: From the grasp up, the thing in the hand, (m, k).
        open_hand: Joint values of the open hand, (f,).
        closed_hand: Those of the hand around the thing, (f,).
        hand_positions: Indices into qpos of the hand's joints, (f,).
        grip: The thing in the hand.
    """

    thing: str
    side: str
    grasp: int
    positions: Indices
    before: Array
    line: Array
    rise: Array
    open_hand: Array
    closed_hand: Array
    hand_positions: Indices
    grip: Grip

    def opened(self, values: Array) -> Array:
        """All positions, (nq,), with the arm so and the hand open; the thing stays where it is."""
        return with_values(with_values(self.before, self.positions, values), self.hand_positions, self.open_hand)

    def closed(self, values: Array) -> Array:
        """All positions, (nq,), with the arm so and the hand closed; the held thing is elsewhere: see ``carried``."""
        return with_values(with_values(self.before, self.positions, values), self.hand_positions, self.closed_hand)


class PickPose(HandWay):
    """How a thing is picked up."""

    @property
    def approach(self) -> Array:
        """Joints of the chain towards the thing, the hand open, (n, k)."""
        return self.line

    @property
    def lift(self) -> Array:
        """Joints of the chain upwards, the thing in the hand, (m, k)."""
        return self.rise


class PlacePose(HandWay):
    """How a thing is put down."""

    @property
    def lower(self) -> Array:
        """Joints of the chain downwards, the thing in the hand, (m, k)."""
        return self.rise[::-1]

    @property
    def retreat(self) -> Array:
        """Joints of the chain back from the thing, the hand open, (n, k)."""
        return self.line[::-1]


def farthest(failed: Failures) -> tuple[Gate, str | None]:
    """Of the gates at which a grasp's configurations failed, that which is passed last."""
    return max(failed, key=lambda each: list(Gate).index(each[0]))


def named(blocked: Blocking) -> str:
    """What a collision is with, for people."""
    owner, _, part = blocked.other.partition("/")
    return f"{owner}'s {part.replace('_', ' ')}" if part else f"the {owner}"
