"""What ``taskgist perform`` is asked with: words on the command line, held to what the room has."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from taskgist.errors import InputError, UnknownNameError

if TYPE_CHECKING:  # with MuJoCo, which a wrong name should not wait for
    from taskgist.planning.judging import Attention
    from taskgist.planning.plan import Purpose
    from taskgist.planning.requests import Spared
    from taskgist.world.scene import Scene
    from taskgist.world.stage import Stage


def check_names(scene: Scene, robot: str, targets: Sequence[str], things: Sequence[str]) -> None:
    """See that all who are named are in the room, each once.

    Args:
        scene: The room.
        robot: Who performs; not given if empty, as the others.
        targets: For whom.
        things: With what.

    Raises:
        InputError: One is not given, twice, or performs for itself; or a robot is not in the room.
        UnknownNameError: There is no such agent or object.
    """
    from taskgist.world.bodies.profile import builtin_profiles

    for option, given, known in (
        ("--robot", robot, scene.agents),
        *(("--for", each, scene.agents) for each in targets),
        *(("--object", each, scene.objects) for each in things),
    ):
        if not given:
            raise InputError("not given", field=option, hint=f"one of {', '.join(known)}")
        if option == "--robot" and given in builtin_profiles() and given not in known:
            hint = "it is placed there by --at X,Y,YAW"
            raise InputError("is not in the room", field=option, value=given, hint=hint)
        if given not in known:
            raise UnknownNameError("object" if option == "--object" else "agent", given, known, where=option)
    if robot in targets:
        raise InputError("a task is performed for another", field="--for", value=robot, hint="name another agent")
    for option, names in (("--for", targets), ("--object", things)):
        if len(set(names)) < len(names):
            raise InputError("one stands twice", field=option, value=" ".join(names), hint="name each once")


def none_or_names(given: list[str] | None) -> tuple[str, ...] | None:
    """Names that were given; None if none were."""
    return tuple(given) if given else None


def means_of(text: str) -> tuple[Purpose, ...]:
    """Means that are named with commas; all if none are."""
    from taskgist.planning.requests import MEANS

    named = [each.strip() for each in text.split(",") if each.strip()]
    for each in named:
        if each not in MEANS:
            raise UnknownNameError("means", each, MEANS, where="--means")
    return tuple(means for means in MEANS if means in named) or MEANS


def helpers_of(given: list[str] | None, known: Sequence[str]) -> tuple[str, ...] | None:
    """Agents of the room who may help; None if none are named."""
    for name in given or ():
        if name not in known:
            raise UnknownNameError("agent", name, known, where="--helpers")
    return none_or_names(given)


def spared_of(text: str) -> Spared:
    """Whose effort decides."""
    from taskgist.planning.requests import SPARED

    for spared in SPARED:
        if text == spared:
            return spared
    raise UnknownNameError("choice", text, SPARED, where="--spare")


def when_and_where(given: Sequence[str]) -> tuple[float | None, tuple[float, float, float] | None]:
    """The time in a recording, and where a robot is placed: metres, metres, degrees."""
    times, places = [text for text in given if "," not in text], [text for text in given if "," in text]
    hint = "one time in seconds, such as 2.5, or one place as X,Y,YAW in metres and degrees, such as 1,0.5,90"
    found = []
    for texts, count in ((times, 1), (places, 3)):
        try:
            found.append([float(number) for text in texts for number in text.split(",")])
        except ValueError:
            raise InputError("no number", field="--at", value=" ".join(texts), hint=hint) from None
        if len(texts) > 1 or len(found[-1]) not in (0, count) or not all(map(math.isfinite, found[-1])):
            raise InputError("neither a time nor a place", field="--at", value=" ".join(texts), hint=hint)
    (time_s, place) = found
    return (time_s[0] if time_s else None), ((place[0], place[1], place[2]) if place else None)


def joined(stage: Stage, robot: str, place: tuple[float, float, float]) -> tuple[Stage, str]:
    """The room with a robot in it that is placed there, and its name; see ``Scene.joined_by``."""
    from taskgist.world.scene_file import AgentEntry
    from taskgist.world.stage import Stage

    if robot in stage.scene.agents:
        raise InputError("is in the room already, where it stays", field="--robot", value=robot, hint="leave --at out")
    name = Path(robot).stem
    x, y, yaw_deg = place
    entry = AgentEntry(name, robot, (x, y), math.radians(yaw_deg))
    scene, state = stage.scene.joined_by(entry, stage.state)
    return Stage(scene, state), name


def attention_of(text: str) -> Attention:
    """What the target agent is assumed to look at."""
    from taskgist.planning.judging import ATTENTIONS

    for attention in ATTENTIONS:
        if text == attention:
            return attention
    raise UnknownNameError("attention", text, ATTENTIONS, where="--attention")
