"""One sentence that explains an effort: why this level, and why not with less."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

from taskgist.perspective.effort import (
    BEND,
    CROUCH,
    LEAN,
    LIFT,
    LOOK,
    MOVE,
    NO_ACTION,
    NO_KNOWN_LEVEL,
    PAN,
    PUSH,
    SIDLE,
    SIT,
    STAND,
    TILT,
    TURN,
    Amount,
    Effort,
    Held,
    Occlusion,
    Reason,
    Visibility,
    assumed_gaze,
)

VERBS: Mapping[str, str] = {"see": "sees", "reach": "reaches", "grasp": "grasps"}
STRETCH = "Stretch_Out_Arm("


def why(effort: Effort) -> str:
    """Explain an effort.

    Args:
        effort: The effort.

    Returns:
        A sentence without its full stop: "P1 reaches the cup by leaning forward 29° and stretching out the left arm;
        with less: 0.86 m from the left shoulder, 0.14 m beyond the arm".
    """
    if effort.level is None:
        return f"it is unknown whether {_claim(effort)}: {effort.reason}"
    if effort.level == NO_KNOWN_LEVEL:
        untried = f" ({effort.evidence.untried} was not tried)" if effort.evidence.untried else ""
        return f"{effort.agent} cannot {effort.ability} the {effort.target}: {_hindrance(effort)}{untried}"
    if effort.actions == (NO_ACTION,):
        return f"{_claim(effort)} without effort: {_now(effort)}"
    return f"{_claim(effort)} by {listed(gerunds(effort))}{_prepared(effort)}; {_with_less(effort)}"


def gerunds(effort: Effort) -> list[str]:
    """What an agent does, action by action, with amounts: "standing up", "leaning forward 29°"."""
    turns = effort.turns_rad
    telling: Mapping[str, Callable[[], str]] = {
        PAN: lambda: f"turning the head {_degrees(turns[PAN])}",
        TILT: lambda: f"tilting the head {_degrees(turns[TILT])}",
        LOOK: lambda: "turning the eyes ahead",
        TURN: lambda: f"turning the torso {_degrees(turns[TURN])}",
        LEAN: lambda: f"leaning {'forward' if turns[LEAN] > 0 else 'back'} {_degrees(turns[LEAN])}",
        STAND: lambda: "standing up",
        BEND: lambda: f"bending at the hips {_degrees(_amount(effort).bent_rad)}",
        CROUCH: lambda: f"crouching by {_amount(effort).lowered_m:.2f} m",
        LIFT: lambda: f"moving the torso up or down by {_amount(effort).lowered_m:.2f} m",
        PUSH: lambda: "pushing the seat back",
        SIDLE: lambda: "moving along the seat",
        SIT: lambda: "sitting down",
        MOVE: lambda: _moving(effort),
    }
    arms = [action for action in effort.actions if action.startswith(STRETCH)]
    told = [telling[action]() for action in effort.actions if action not in arms]
    return [*told, *(["stretching out both arms"] if len(arms) > 1 else map(_stretching, arms))]


def listed(parts: Sequence[str]) -> str:
    """The parts as one enumeration: "a, b and c"."""
    return f"{', '.join(parts[:-1])} and {parts[-1]}" if len(parts) > 1 else "".join(parts)


def _claim(effort: Effort) -> str:
    return f"{effort.agent} {VERBS[effort.ability]} the {effort.target}"


def _now(effort: Effort) -> str:
    """What already is so at level 0."""
    found = effort.evidence.attained
    if isinstance(found, Held):
        return f"it is in {effort.agent}'s {found.arm} hand"
    assert isinstance(found, Visibility), "what is not held at level 0 is seen"
    shown = "all" if found.visible_px == found.unoccluded_px else _number(found.visible_px)
    assumed = "" if found.eyes_towards is None else f" ({assumed_gaze(found.eyes_towards, found.eyes_rad)})"
    return f"it is in the gaze cone{assumed}, and {shown} of its {_number(found.unoccluded_px)} pixels are visible"


def _number(pixels: float) -> str:
    """Whole pixels, or parts of one where there are few."""
    return f"{pixels:.0f}" if pixels >= 10 else f"{pixels:.2g}"


def _prepared(effort: Effort) -> str:
    """What is done to the object before a hand grasps it."""
    prepared = effort.evidence.prepared
    return f", once it is {prepared}" if prepared else ""


def _with_less(effort: Effort) -> str:
    """Why nothing less does."""
    told = effort.evidence.told
    not_held = told is not None and told.reason is Reason.NOT_HELD
    return f"{effort.agent} does not hold it" if not_held else f"with less: {effort.reason}"


def _hindrance(effort: Effort) -> str:
    """What stands in the way of the nearest miss, and of going elsewhere."""
    found, elsewhere = _covered(effort) or effort.reason, effort.evidence.misses[-1]
    if elsewhere.reason is Reason.NO_WALKING:
        return found
    if elsewhere.text == effort.reason:
        return f"{found}, from every place that {effort.agent} can get to"
    return f"{found}; elsewhere: {elsewhere.text}"


def _covered(effort: Effort) -> str | None:
    """What covers the object in the image of the nearest miss, where being hidden is the reason."""
    hindrance = effort.evidence.told and effort.evidence.told.hindrance
    if not isinstance(hindrance, Occlusion):
        return None
    by = [f"the {owner}" for owner, _ in hindrance.occluders]
    return f"{listed(by)} {'hides' if len(by) == 1 else 'hide'} all of its {_number(hindrance.unoccluded_px)} pixels"


def _degrees(angle_rad: float) -> str:
    degrees = math.degrees(abs(angle_rad))
    return f"{degrees:.0f}°" if degrees >= 0.5 else "less than 1°"


def _amount(effort: Effort) -> Amount:
    assert effort.amount is not None, "an effort with actions has an amount"
    return effort.amount


def _moving(effort: Effort) -> str:
    amount = _amount(effort)
    turn = f"turning {_degrees(amount.turned_rad)}"
    return f"going {amount.moved_m:.2f} m and {turn}" if amount.moved_m else f"{turn} on the spot"


def _stretching(action: str) -> str:
    return f"stretching out the {action.removeprefix(STRETCH).removesuffix(')')} arm"
