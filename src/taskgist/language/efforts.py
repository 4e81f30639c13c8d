"""One sentence that explains an effort: why this level, and why not with less."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from taskgist.perspective.actions import LEAN, MOVE, NO_ACTION, PAN, SIT, STAND, TILT, TURN
from taskgist.perspective.effort import NO_KNOWN_LEVEL, Effort
from taskgist.perspective.viewpoint import Standpoint

VERBS: Mapping[str, str] = {"see": "sees", "reach": "reaches", "grasp": "grasps"}
STRETCH = "Stretch_Out_Arm("


def why(here: Standpoint, effort: Effort) -> str:
    """Explain an effort.

    Args:
        here: The standpoint from which the effort was found.
        effort: The effort.

    Returns:
        A sentence without its full stop: "P1 reaches the cup by leaning forward 29° and stretching out the left arm;
        with less: 0.86 m from the left shoulder, 0.14 m beyond the arm".
    """
    if effort.level is None:
        return f"it is unknown whether {_claim(effort)}: {effort.reason}"
    if effort.level == NO_KNOWN_LEVEL:
        return f"{effort.agent} cannot {effort.ability} the {effort.target}: {_hindrance(effort)}"
    if effort.actions == (NO_ACTION,):
        return f"{_claim(effort)} without effort: {_now(effort)}"
    return f"{_claim(effort)} by {listed(gerunds(here, effort))}; {_with_less(effort)}"


def gerunds(here: Standpoint, effort: Effort) -> list[str]:
    """What an agent does, action by action, with amounts: "standing up", "leaning forward 29°"."""
    telling: Mapping[str, Callable[[], str]] = {
        PAN: lambda: f"turning the head {_degrees(_turned(here, effort, PAN))}",
        TILT: lambda: f"tilting the head {_degrees(_turned(here, effort, TILT))}",
        TURN: lambda: f"turning the torso {_degrees(_turned(here, effort, TURN))}",
        LEAN: lambda: _leaning(_turned(here, effort, LEAN)),
        STAND: lambda: "standing up",
        SIT: lambda: "sitting down",
        MOVE: lambda: _moving(effort),
    }
    return [_stretching(action) if action.startswith(STRETCH) else telling[action]() for action in effort.actions]


def listed(parts: Sequence[str]) -> str:
    """The parts as one enumeration: "a, b and c"."""
    return f"{', '.join(parts[:-1])} and {parts[-1]}" if len(parts) > 1 else "".join(parts)


def _claim(effort: Effort) -> str:
    return f"{effort.agent} {VERBS[effort.ability]} the {effort.target}"


def _now(effort: Effort) -> str:
    """What already is so at level 0."""
    evidence: Mapping[str, Any] = effort.evidence
    if effort.ability != "see":
        return f"it is in {effort.agent}'s {evidence['arm']} hand"
    seen, alone = evidence["visible_px"], evidence["unoccluded_px"]
    shown = "all" if seen == alone else f"{seen}"
    return f"it is in the gaze cone, and {shown} of its {alone} pixels are visible"


def _with_less(effort: Effort) -> str:
    """Why nothing less does."""
    return f"{effort.agent} does not hold it" if effort.reason == "not held" else f"with less: {effort.reason}"


def _hindrance(effort: Effort) -> str:
    """What stands in the way of the nearest miss, and of going elsewhere."""
    found = _covered(effort) or effort.reason
    tried: Sequence[str] = effort.evidence["not_with_less"]  # type: ignore[assignment]
    elsewhere = tried[-1]
    if len(tried) != NO_KNOWN_LEVEL or elsewhere == "cannot move about":
        return found
    if elsewhere == effort.reason:
        return f"{found}, from every place that {effort.agent} can get to"
    return f"{found}; elsewhere: {elsewhere}"


def _covered(effort: Effort) -> str | None:
    """What covers the object in the image of the nearest miss, where being hidden is the reason."""
    miss: Mapping[str, Any] = effort.evidence["miss"]  # type: ignore[assignment]
    if "occluders" not in miss:
        return None
    by = [f"the {owner}" for owner, _ in miss["occluders"]]
    return f"{listed(by)} {'hides' if len(by) == 1 else 'hide'} all of its {miss['unoccluded_px']} pixels"


def _turned(here: Standpoint, effort: Effort, action: str) -> float:
    """How far the joint of a virtual action turns, signed, radians."""
    profile = here.agent.profile
    axis = {PAN: profile.pan, TILT: profile.tilt, TURN: profile.turn, LEAN: profile.lean}[action]
    assert axis is not None, "an agent without a joint has no action that moves it"
    return effort.joints_rad[axis.joint] - float(here.state.qpos[here.agent.joints[axis.joint]])


def _degrees(angle_rad: float) -> str:
    degrees = math.degrees(abs(angle_rad))
    return f"{degrees:.0f}°" if degrees >= 0.5 else "less than 1°"


def _leaning(angle_rad: float) -> str:
    return f"leaning {'forward' if angle_rad > 0 else 'back'} {_degrees(angle_rad)}"


def _moving(effort: Effort) -> str:
    assert effort.amount is not None, "an effort with actions has an amount"
    turn = f"turning {_degrees(effort.amount.turned_rad)}"
    return f"going {effort.amount.moved_m:.2f} m and {turn}" if effort.amount.moved_m else f"{turn} on the spot"


def _stretching(action: str) -> str:
    return f"stretching out the {action.removeprefix(STRETCH).removesuffix(')')} arm"
