"""States: immutable snapshots of where everything is, alone and in order of time."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
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
    """

    qpos: Array
    time_s: float = 0.0
    untracked: frozenset[str] = frozenset()
    holding: frozenset[Hold] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "qpos", _frozen(np.array(self.qpos, dtype=float)))

    def __reduce__(self) -> tuple[object, ...]:
        return State, (np.array(self.qpos), self.time_s, self.untracked, self.holding)

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
        return State(self.qpos, self.time_s, self.untracked.union(names), self.holding)

    def with_holding(self, holding: Iterable[Hold] | None) -> State:
        """The same state with another word on who holds what."""
        return State(self.qpos, self.time_s, self.untracked, None if holding is None else frozenset(holding))

    def known(self, names: Iterable[str]) -> bool:
        """Whether all of these objects, agents and parts were tracked (a part of an untracked agent was not)."""
        return not any(name in self.untracked or name.partition("/")[0] in self.untracked for name in names)


def _frozen(array: Array) -> Array:
    array.flags.writeable = False
    return array


# --- Frames: states of one scene in order of time, any of which can be asked for.


class Frames(Protocol):
    """A sequence of states; a recording is one."""

    @property
    def times_s(self) -> Array:
        """Times of the frames in seconds, strictly increasing, (n,)."""

    def state(self, index: int) -> State:
        """The state in a frame."""
