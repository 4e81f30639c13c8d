"""States: immutable snapshots of where everything is, alone and in order of time."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from taskgist.common.arrays import Array


@dataclass(frozen=True, order=True)
class Hold:
    """One hand holds one object."""

    agent: str
    side: str
    object: str


@dataclass(frozen=True)
class EyeTurn:
    """How an agent's eyes are turned in its head: about an axis square to where the head looks, without rolling.

    Attributes:
        left_rad: How far to the left, radians; negative to the right.
        up_rad: How far up; negative down.
        towards: The thing that they are assumed to look at, where the gaze was inferred; None where it was recorded.
    """

    left_rad: float = 0.0
    up_rad: float = 0.0
    towards: str | None = None

    @property
    def turned_rad(self) -> float:
        """The angle between the gaze and the head's direction, radians."""
        return math.hypot(self.left_rad, self.up_rad)


AHEAD = EyeTurn()
"""Eyes that are known to look where the head does."""
HEADS_ALONE: Mapping[str, EyeTurn] = MappingProxyType({})
"""Nothing is said of anybody's eyes: the gaze is the head's direction."""


@dataclass(frozen=True, eq=False)
class State:
    """Where everything in a scene is at one time.

    Attributes:
        qpos: Generalised positions in MuJoCo's order, (nq,), read-only.
        time_s: Seconds since the recording's origin.
        untracked: What is not known: an object ("cup"), an agent ("P1") or a part of one ("P1/left_arm").
            Its numbers in ``qpos`` are fillers.
        holding: Who holds what, where it was decided over time (``observe/carrying.py``); None leaves it to the
            distances of this one state.
        eyes: How the eyes of agents are turned in their heads, by agent, where that was recorded, or inferred over
            time (``observe/eyes.py``). The others' look where their heads do.
    """

    qpos: Array
    time_s: float = 0.0
    untracked: frozenset[str] = frozenset()
    holding: frozenset[Hold] | None = None
    eyes: Mapping[str, EyeTurn] = field(default_factory=lambda: HEADS_ALONE)

    def __post_init__(self) -> None:
        object.__setattr__(self, "qpos", _frozen(np.array(self.qpos, dtype=float)))
        object.__setattr__(self, "eyes", _eyes(self.eyes))

    def __reduce__(self) -> tuple[object, ...]:
        return State, (np.array(self.qpos), self.time_s, self.untracked, self.holding, dict(self.eyes))

    def replace(
        self, changes: Mapping[int, float] | None = None, *, at: slice | None = None, to: ArrayLike = ()
    ) -> State:
        """A state with some positions changed.

        Args:
            changes: New values by index into qpos.
            at: A slice of qpos to replace as a whole, with ``to``.
            to: Values for ``at``.
        """
        qpos = np.array(self.qpos)
        for index, value in (changes or {}).items():
            qpos[index] = value
        if at is not None:
            qpos[at] = to
        return self._with(_frozen(qpos))

    def _with(self, qpos: Array) -> State:
        """The same at other positions, an array that is read-only and nobody else's: spares copying it."""
        state = object.__new__(State)
        state.__dict__.update(self.__dict__, qpos=qpos)
        return state

    def without(self, names: Iterable[str]) -> State:
        """The same state, of which these objects, agents or parts are not known."""
        return State(self.qpos, self.time_s, self.untracked.union(names), self.holding, self.eyes)

    def with_holding(self, holding: Iterable[Hold] | None) -> State:
        """The same state with another word on who holds what."""
        decided = None if holding is None else frozenset(holding)
        return State(self.qpos, self.time_s, self.untracked, decided, self.eyes)

    def with_eyes(self, eyes: Mapping[str, EyeTurn]) -> State:
        """The same state with another word on how eyes are turned, of all agents."""
        return State(self.qpos, self.time_s, self.untracked, self.holding, eyes)

    def looking_ahead(self, agent: str) -> State:
        """The same state in which an agent's eyes look where its head does: after it has turned the head."""
        if agent not in self.eyes or not self.eyes[agent].turned_rad:
            return self
        return self.with_eyes({name: turn for name, turn in self.eyes.items() if name != agent})

    def known(self, names: Iterable[str]) -> bool:
        """Whether all of these objects, agents and parts were tracked (a part of an untracked agent was not)."""
        return not any(name in self.untracked or name.partition("/")[0] in self.untracked for name in names)


def _frozen(array: Array) -> Array:
    array.flags.writeable = False
    return array


def _eyes(eyes: Mapping[str, EyeTurn]) -> Mapping[str, EyeTurn]:
    """A read-only copy, unless it is one already."""
    return eyes if isinstance(eyes, MappingProxyType) else MappingProxyType(dict(eyes))


# --- Frames: states of one scene in order of time, any of which can be asked for.


class Frames(Protocol):
    """A sequence of states; a recording is one."""

    @property
    def times_s(self) -> Array:
        """Times of the frames in seconds, strictly increasing, (n,)."""

    def state(self, index: int) -> State:
        """The state in a frame."""
