"""Effort: what it takes an agent to see, reach or grasp an object, as a value with its evidence (5.1.5, Fig. 6)."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass, field, fields
from functools import cached_property, partial
from typing import Any, Literal, Protocol, get_args

from taskgist.perspective.actions import Amount
from taskgist.perspective.candidates import Stances
from taskgist.world.bodies.profile import Posture
from taskgist.world.state import State

Ability = Literal["see", "reach", "grasp"]
ABILITIES: tuple[Ability, ...] = get_args(Ability)
Told = Callable[[], Mapping[str, object]]
NO_KNOWN_LEVEL = 5
"""Level of what no known action achieves."""

_LIMBS: Mapping[Ability, str] = {"see": "Head", "reach": "Arm", "grasp": "Arm"}
EFFORT_NAMES: Mapping[Ability, tuple[str, ...]] = {
    ability: (
        "No_Effort_Required",
        f"{limb}_Effort",
        f"{limb}_Torso_Effort",
        "Whole_Body_Effort",
        "Displacement_Effort",
        "No_Possible_Known_Effort",
    )
    for ability, limb in _LIMBS.items()
}
"""Effort types by level, 0 to 5 (Fig. 6)."""


@dataclass(frozen=True)
class Effort:
    """The least effort of one ability of one agent towards one object.

    Attributes:
        ability: ``see``, ``reach`` or ``grasp``.
        agent: Whose.
        target: The object.
        level: 0 to 5, or None where it is unknown: what would decide was not tracked.
        actions: Virtual actions A_v in order; ``No_Action_Required`` at level 0, ``No_Possible_Known_Action`` at 5,
            none if unknown.
        amount: How much of it; None at level 5 and if unknown.
        joints_rad: Angles in radians of the head's and the torso's joints in the attained state S, by name (an arm is
            stretched out without looking at its joints). At level 5 and if unknown, those of the current state.
        posture: Posture in that state; None if unknown.
        told: Tells the evidence; asked at most once, and only if somebody wants to know.
    """

    ability: Ability
    agent: str
    target: str
    level: int | None
    actions: tuple[str, ...]
    amount: Amount | None
    joints_rad: Mapping[str, float] = field(hash=False)
    posture: Posture | None
    told: Told = field(compare=False, repr=False)

    @cached_property
    def evidence(self) -> Mapping[str, object]:
        """Plain data, fit for JSON: what was found in the attained state, and why not with less."""
        return self.told()

    @property
    def reason(self) -> str:
        """A short sentence: why this level."""
        return str(self.evidence["reason"])

    @property
    def name(self) -> str | None:
        """Type of the effort, by its name in Fig. 6; None if unknown."""
        return None if self.level is None else EFFORT_NAMES[self.ability][self.level]

    @property
    def document(self) -> dict[str, object]:
        """All of it as plain data, fit for JSON."""
        values = {each.name: getattr(self, each.name) for each in fields(self) if each.name != "told"}
        amount = None if self.amount is None else asdict(self.amount)
        return values | {"amount": amount, "effort": self.name, "evidence": self.evidence, "reason": self.reason}

    def __reduce__(self) -> tuple[object, ...]:
        """To another process goes what is told, not who tells it."""
        values = {each.name: getattr(self, each.name) for each in fields(self)}
        return _effort, (values | {"told": dict(self.evidence)},)


def _effort(values: dict[str, Any]) -> Effort:
    """An effort whose evidence was told."""
    told = values.pop("told")
    return Effort(**values, told=partial(dict, told))


# --- What the judges of the three abilities share: how an ability is judged from stances, and what they answer.


@dataclass(frozen=True, eq=False)
class Outcome:
    """How the ability holds from a stance.

    Attributes:
        angles_rad: Angles of the head, by index into qpos, in the attained state; the others are the stance's.
        actions: Virtual actions after those of the stance, in order.
        head_rad: How far the head turned, radians.
        merit: Decides between equal amounts; less is better.
        evidence: Gives what was found, as plain data; only asked of the outcome that is chosen.
    """

    angles_rad: Mapping[int, float] = field(default_factory=dict)
    actions: tuple[str, ...] = ()
    head_rad: float = 0.0
    merit: float = 0.0
    evidence: Callable[[], Mapping[str, object]] = dict


@dataclass(frozen=True, order=True)
class Miss:
    """Why the ability does not hold in a state; the least ``shortfall`` of a level is the one worth telling.

    Attributes:
        shortfall: How far the ability is, for comparing misses of one ability.
        why: For people.
        evidence: Gives what shows it, as plain data; only asked of the miss that is told.
    """

    shortfall: float
    why: str
    evidence: Callable[[], Mapping[str, object]] = field(default=dict, compare=False)


NO_ARM = Miss(math.inf, "no arm may be stretched out")


Why = Callable[[], Miss]
"""Tells why the ability does not hold; only asked if somebody wants to know."""


class Among(Protocol):
    """Stances, passed over quickly where the ability surely does not hold."""

    def next(self, start: int, stop: int) -> int:
        """The first stance from ``start`` on from which the ability may hold; ``stop`` if none before it does."""

    def outcomes(self, index: int) -> Iterator[Outcome | Why]:
        """How it holds from that stance, best first; or why it does not."""

    def miss(self) -> Miss | None:
        """Why it does not hold from those passed over: the nearest miss; None if there were none. Asked at last."""


class Hopeless:
    """An ability that no stance can give, for one and the same reason."""

    def __init__(self, why: Miss) -> None:
        self._why = why

    def next(self, start: int, stop: int) -> int:  # noqa: ARG002 - as all of these
        """None."""
        return stop

    def outcomes(self, index: int) -> Iterator[Outcome | Why]:  # noqa: ARG002 - as all of these
        """Never."""
        yield self.miss

    def miss(self) -> Miss:
        """The reason."""
        return self._why


class Judge(Protocol):
    """Judges one ability towards one object. The stage may show anything before and after each call."""

    def unknown(self, level: int) -> str | None:
        """Why nothing can be said at an effort level, for want of tracking; None if something can."""

    def without_effort(self) -> Outcome | Why:
        """Level 0: whether the ability holds in the current state."""

    def among(self, stances: Stances) -> Among:
        """Look at stances."""


def untracked_parts(state: State, agent: str, parts: tuple[str, ...]) -> str | None:
    """Sentence about those parts of an agent that were not tracked; None if all were."""
    if not state.untracked:
        return None
    lost = [part for part in parts if not state.known([f"{agent}/{part}"])]
    return f"{agent}'s {' and '.join(lost)} not tracked" if lost else None
