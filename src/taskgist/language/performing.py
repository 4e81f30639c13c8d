"""What was chosen when a task was performed, and what it does; or why it cannot be performed: in sentences."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from typing import TYPE_CHECKING

from taskgist.facts import vocabulary as v
from taskgist.facts.tree import HypothesisTree
from taskgist.facts.values import UNKNOWN
from taskgist.language.phrases import listed, phrase_of
from taskgist.learning.literals import SetLiteral
from taskgist.learning.understanding import AnyLiteral, Literal

if TYPE_CHECKING:  # with NumPy, and words need none
    from taskgist.planning.goal import Dropped, Goal, Truth
    from taskgist.planning.helping import Help
    from taskgist.planning.judging import Reason
    from taskgist.planning.plan import Action, PhaseName, Plan
    from taskgist.planning.requests import Request, Search, Tried

DOINGS = {
    "drive": "drives to the {thing}",
    "open": "opens its hand",
    "reach": "reaches out",
    "approach": "brings its {side} hand around the {thing}",
    "close": "closes it",
    "lift": "lifts the {thing}",
    "slide": "slides the {thing}",
    "carry": "draws it near",
    "transport": "drives with it",
    "transfer": "brings it over its place",
    "lower": "lowers it",
    "take": "waits until {taker} has taken it",
    "draw near": "waits until {taker} has drawn it near",
    "retreat": "draws the hand back",
    "fold": "folds its arm",
    "withdraw": "drives back to where it was",
}
"""What each phase is, in words."""
SLIDING = {"close": "closes its hand", "approach": "presses its fingers on the {thing}"}
"""The same where a closed hand slides a thing."""
MEANS = {
    "put_on": "puts the {thing} on the {carrier}",
    "put_in": "puts the {thing} into the {carrier}",
    "slide_out": "slides the {thing} out over an edge of the {carrier}",
    "hold_up": "holds the {thing} up for {target}",
    "hand_over": "hands the {thing} over to {carrier}",
    "put_over": "puts the {thing} over the {covered}",
}
NONE_BY = {
    "cover": "there is nothing to cover the {thing} with",
    "clear": "nothing is in the way that could be cleared",
    "relay": "there is nobody who could help",
    "slide": "what is slid out over an edge must be brought somewhere, too",
}
"""Why something is not performed by a means of which nothing could be tried."""
ATTENTION = {
    "stays": "{target} assumed to keep the head as it is",
    "thing": "{target} assumed to look at the {thing} once it is there",
    "performer": "{target} assumed to look at {performer}",
}


def chosen(plan: Plan) -> str:
    """What is done: "PR2 puts the tape on the table, its middle at (0.31, −0.20, 0.75) m"; action after action."""
    return "; then ".join(acted(plan, action) for action in plan.actions)


def acted(plan: Plan, action: Action) -> str:
    """One action of a plan, and what it is for where that is not plain."""
    candidate = action.candidate
    words = {
        "thing": action.thing,
        "carrier": candidate.carrier,
        "target": listed(plan.targets),
        "covered": action.about,
    }
    x, y, z = candidate.pose[:3]
    how = f"{action.performer} {MEANS[candidate.means].format(**words)}, its middle at ({x:.2f}, {y:.2f}, {z:.2f}) m"
    then = plan.actions[(plan.actions.index(action) + 1) % len(plan.actions)]
    why = {"clear": ", out of the way", "relay": f", where {then.performer} takes it", "slide": ", to get hold of it"}
    return how + why.get(action.purpose, "")


def steps(plan: Plan) -> tuple[str, ...]:
    """The phases one by one, with the time that each takes; where several act, the first of each action says who."""
    told = []
    for action in plan.actions:
        for number, (name, phases) in enumerate(groupby(action.phases, key=lambda phase: phase.name)):
            seconds = sum(phase.duration_s for phase in phases)
            who = f"{action.performer} " if number == 0 and len(plan.actions) > 1 else ""
            told.append(f"{who}{doing(action, name)} ({seconds:.1f} s)")
    return tuple(told)


def doing(action: Action, name: PhaseName) -> str:
    """What its performer does in a phase of an action: "lifts the tape"."""
    doings = {**DOINGS, **SLIDING} if action.purpose == "slide" else DOINGS
    return doings[name].format(thing=action.thing, side=action.side, taker=action.taker)


def cost(plan: Plan) -> str:
    """What a plan costs: "1 action; effort level 4 of PR2"."""
    efforts = [f"{level} of {name}" for name, level in plan.cost.efforts.items()]
    count = plan.cost.actions
    return f"{count} action{'s' if count > 1 else ''}; effort {listed(efforts)}"


def assumed(request: Request) -> str:
    """What the target agents are assumed to look at."""
    who = f"{listed(request.targets)} {'is' if len(request.targets) == 1 else 'are'}"
    words = {"target": who, "thing": request.things[-1], "performer": request.performer}
    return ATTENTION[request.attention].format(**words)


def not_as_demonstrated(goal: Goal, tree: HypothesisTree) -> tuple[str, ...]:
    """Given literals that do not hold here, and literals that nobody can judge."""
    told = [
        f"in the demonstrations {_said(given.literal, tree)}; here "
        + ("that is not known" if given.holds is UNKNOWN else f"it is {given.found}")
        for given in goal.given
        if given.holds is not True
    ]
    return (*told, *(f"{each.literal} is not judged: {each.why}" for each in goal.unjudged))


def not_had(dropped: Sequence[Dropped], tree: HypothesisTree) -> tuple[str, ...]:
    """Circumstances that could not be asked for, and why."""
    return tuple(
        f"in all demonstrations {_said(each.literal, tree)}, which is not asked for here: {each.why}"
        for each in dropped
    )


def as_shown(circumstances: Mapping[AnyLiteral, Truth], targets: Sequence[str], tree: HypothesisTree) -> str:
    """Which circumstances are so, and which are not, where a task was performed; empty if there are none.

    Args:
        circumstances: They, and whether each is so.
        targets: For whom it was performed, whose circumstances they are.
        tree: The tree of their nodes.
    """
    parts = (
        ("as in all demonstrations", True),
        ("otherwise than in all demonstrations, where", False),
        ("it is not known whether as in all demonstrations", UNKNOWN),
    )
    so = [(how, [literal for literal, holds in circumstances.items() if holds is truth]) for how, truth in parts]
    told = ((how, [_said(literal, tree) for literal in literals]) for how, literals in so)
    parts_told = [f"{how} {listed(said)}" for how, said in told if said]
    return f"for {listed(targets)}, {'; '.join(parts_told)}" if parts_told else ""


def refused(
    request: Request, goal: Goal, search: Search, spoiled: Sequence[str], tree: HypothesisTree
) -> tuple[str, ...]:
    """Why nothing was found, one sentence for each gate, in their order."""
    if goal.impossible:
        return tuple(each.why for each in goal.impossible)
    told = [search.out_of_hold] if search.out_of_hold else list(_places_refused(request, search, tree))
    alike: dict[str, list[str]] = {}
    for each in search.others:
        alike.setdefault(why_not(each, tree), []).append(each.what)
    told += [f"{'; or '.join(ways)}: {why}" for why, ways in alike.items()]
    told += [f"1 plan was thrown away: {why}" for why in spoiled]
    return tuple(told) or tuple(NONE_BY[means].format(thing=search.thing) for means in request.means if means != "move")


def why_not(tried: Tried, tree: HypothesisTree) -> str:
    """Why another way than moving the thing alone does not do."""
    if isinstance(tried.why, Literal | SetLiteral):
        return f"it fails that {_said(tried.why, tree)}"
    return reason(tried.why, tree)


def reason(why: Reason, tree: HypothesisTree) -> str:
    """Why an action does not do."""
    if isinstance(why, str):
        return why
    return f"with {why.agent} where it is in the end, it fails that {_said(why.literal, tree)}"


def _places_refused(request: Request, search: Search, tree: HypothesisTree) -> Iterator[str]:
    """What became of the places to which the performer alone could bring the thing."""
    if "move" not in request.means:
        return
    if not search.places:
        yield f"there is no place for the {search.thing} in {listed(request.allow or ()) or 'this room'}"
        return
    yield f"{search.wanted} of {search.places} places would do"
    for literal, count in search.missed.most_common():
        nearest = search.nearest.get(literal)
        miss = f", the nearest with {_found(nearest.found)}" if nearest is not None else ""
        yield f"at {count} of them it fails that {_said(literal, tree)}{miss}"
    if search.unknown:
        yield f"at {search.unknown} of them it is not known, for not all that decides is tracked"
    if search.out_of_hand:
        told = [f"at {search.out_of_hand} of them {listed(request.targets, 'or')} could not take it"]
        yield ": ".join(told + [why for why, _ in search.not_taken.most_common(1)])
    if search.out_of_reach:
        those = "all of those" if search.out_of_reach == search.wanted else f"{search.out_of_reach} of those"
        yield f"{those} {search.wanted} are where {request.performer} does not get at it"
    for why, count in search.refusals.most_common():
        those = f"{count} of the {search.tried} that {request.performer} tried"
        yield f"{those} it does not bring about: {reason(why, tree)}"
    yield from search.details


def would_help(helps: Sequence[Help]) -> tuple[str, ...]:
    """Changes of the room in words: "the tape could be grasped if it stood 14 cm nearer to PR2"."""
    told = []
    for each in helps:
        where = f"{100 * each.shift_m:.0f} cm {'nearer to' if each.nearer else 'farther from'} {each.whom}"
        if each.so == "grasped":
            told.append(f"the {each.what} could be grasped if it stood {where}")
        else:
            told.append(f"a place on the {each.place} would do if the {each.what} stood {where}")
    return tuple(told)


def _said(literal: AnyLiteral, tree: HypothesisTree) -> str:
    """A literal in words."""
    return phrase_of(tree.node(literal.node), literal)


def _found(value: object) -> str:
    if isinstance(value, str):
        level = v.EFFORT_LEVELS.get(value)
        return value if level is None else f"effort level {level}"
    return f"a score of {value:.2g}" if isinstance(value, float) else str(value)
