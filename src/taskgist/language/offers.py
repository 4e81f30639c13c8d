"""Sentences on offers: what somebody is after, what that takes, which task would lower it, and who could do it."""

from __future__ import annotations

from taskgist.language.efforts import gerunds, listed
from taskgist.language.phrases import EFFORTS, plain
from taskgist.perspective.effort import EFFORT_NAMES, NO_KNOWN_LEVEL, Ability, Effort
from taskgist.planning.offers import Helper, Lowering, Offers

WANTS: dict[str | None, str] = {"reaching": "reaches for", "walking": "walks to"}
"""What an agent does, by the behaviour that was seen."""
NOTHING: dict[str, str] = {
    "own act": "nothing is offered: {agent}'s own next act does it",
    "unknown effort": "nothing is offered: what it takes is unknown",
    "no task": "no known task lowers that",
    "nobody": "nobody else could do it",
}
"""Why nothing is offered."""


def aim(offers: Offers, behaviour: str | None = None) -> str:
    """What an agent is after, and what it takes now: ``"P2 reaches for the cup, which takes standing up (level 3)"``.

    Args:
        offers: What can be offered.
        behaviour: What tells that it is after the thing; None: that was given.
    """
    effort = offers.effort
    what = WANTS.get(behaviour, f"wants to {effort.ability}")
    return f"{effort.agent} {what} the {effort.target}, {_takes(effort)}"


def _takes(effort: Effort) -> str:
    if effort.level is None:
        return f"of which it is unknown what it takes ({effort.reason})"
    if effort.level == NO_KNOWN_LEVEL:
        return f"which no known action achieves (level {NO_KNOWN_LEVEL})"
    if effort.level == 0:
        return "which takes no effort (level 0)"
    return f"which takes {listed(gerunds(effort))} (level {effort.level})"


def would_lower(task: Lowering, ability: Ability) -> str:
    """What a task would make of the effort: ``"give: would lower that to no effort (level 0), with it in hand"``."""
    in_all = None if task.level_in_all is None else _at_most(ability, task.level_in_all)
    if task.level is None:
        return f"{task.task}: as in all its demonstrations, would lower that to {in_all}"
    more = f"; as in all its demonstrations, to {in_all}" if in_all else ""
    held = ", with it in hand" if task.in_hand else ""
    return f"{task.task}: would lower that to {_at_most(ability, task.level)}{held}{more}"


def _at_most(ability: Ability, level: int) -> str:
    name = EFFORT_NAMES[ability][level]
    told = EFFORTS.get(name, plain(name)).removeprefix("takes ")
    return f"{told} (level {level})" if level == 0 else f"{told} at most (level {level})"


def could_do(helper: Helper) -> str:
    """Who could do it, and what it takes: ``"P1, who grasps it by stretching out the left arm (level 1)"``."""
    if helper.has_it:
        return f"{helper.name}, who has it"
    return f"{helper.name}, who grasps it by {listed(gerunds(helper.grasping))} (level {helper.grasping.level})"


def declined(offers: Offers) -> str | None:
    """Why nothing is offered; None where something is."""
    return None if offers.declined is None else NOTHING[offers.declined].format(agent=offers.effort.agent)
