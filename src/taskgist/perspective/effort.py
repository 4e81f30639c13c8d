"""Effort: what it takes an agent to see, reach or grasp an object, as a value with its evidence (5.1.5, Fig. 6)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, fields
from functools import cached_property, partial
from typing import Any, Literal, get_args

from taskgist.perspective.acting.virtual_actions import Amount
from taskgist.world import Posture

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
