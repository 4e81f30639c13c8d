"""``taskgist offer``: what would help somebody who is after a thing?"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.text import Text

from taskgist.cli.common import (
    FAILED,
    KNOWLEDGE,
    OK,
    JsonOption,
    KnowledgeOption,
    MomentOption,
    RuleOption,
    WhereArgument,
    about,
    command,
    console,
    moment_s,
    open_stage,
    print_json,
    print_left_out,
)
from taskgist.errors import InputError, UnknownNameError
from taskgist.facts.predicates import known_predicates, with_predicates
from taskgist.facts.standard import STANDARD_TREE
from taskgist.learning.explanation import Context
from taskgist.learning.task_clauses import RULES, contradicted_tasks
from taskgist.learning.understanding import PAPER
from taskgist.perspective.effort import ABILITIES, Ability
from taskgist.settings import DEFAULT

if TYPE_CHECKING:  # with MuJoCo, which a wrong name should not wait for
    from taskgist.learning.understanding import Clause
    from taskgist.planning.offers import Offers

Told = tuple[str | None, "Offers"]
"""What tells that somebody is after a thing, None where that was given; and what can be offered."""


@command
def offer(
    where: WhereArgument,
    knowledge: KnowledgeOption = KNOWLEDGE,
    at: MomentOption = None,
    agent: Annotated[str | None, typer.Option("--for", help="Whom it would help; default: whoever is seen.")] = None,
    thing: Annotated[str | None, typer.Option("--object", help="What it is after; default: what is seen.")] = None,
    ability: Annotated[
        str | None, typer.Option(help="What it wants of it: see, reach or grasp; default: reach.")
    ] = None,
    rule: RuleOption = None,
    as_json: JsonOption = False,
) -> int:
    """Say which known task would help who is after a thing.

    What it takes the agent now, which tasks lower that and to which level at most, by what they mean, and who could do
    them. Nothing is offered where the agent's own next act does it: where it takes no more than stretching out an arm
    or turning the head. Name --for and --object; in a recording, without them, who reaches for or walks to something
    at that time is found, from what came before. No plan is made: taskgist perform tells whether there is a way.
    A task whose answers contradict each other is left out. The exit code is 1 if nothing is offered.

    Example: taskgist offer room.toml --for P2 --object cup -k knowledge.db

    Example: taskgist offer room.toml --for P2 --object cup --ability see

    Example: taskgist offer day.mcap --at 3.2

    Example: taskgist offer handover.mcap --at 50%
    """
    wanted: Ability | None = None if ability is None else _ability(ability)
    if rule is not None and rule not in RULES:
        raise UnknownNameError("rule", rule, RULES, where="--rule")
    clauses, left_out = _clauses(knowledge, rule)
    if agent is not None and thing is not None:
        found = _given(where, at, agent, thing, wanted or "reach", clauses)
    else:
        found = _seen(where, at, agent, thing, wanted, clauses)
    if as_json:
        print_json({"where": str(where), "offers": [_document(*each) for each in found], "left_out": left_out})
    else:
        from taskgist.store.address import shown

        _print(found, agent, thing)
        print_left_out(((task, "target") for task in left_out), shown(knowledge))
    return OK if any(offers.declined is None for _, offers in found) else FAILED


def _ability(text: str) -> Ability:
    for ability in ABILITIES:
        if text == ability:
            return ability
    raise UnknownNameError("ability", text, ABILITIES, where="--ability")


def _clauses(knowledge: str, rule: str | None) -> tuple[tuple[Clause, ...], list[str]]:
    """What the known tasks mean, and which of them are left out, because answers about them contradict each other."""
    from taskgist.pipeline.offers import known_clauses
    from taskgist.store.address import shown
    from taskgist.store.database import load

    tree = with_predicates(STANDARD_TREE)
    known = load(knowledge, expected=Context.of(DEFAULT, tree), evidence=False)
    with about(shown(knowledge)):
        clauses = known_clauses(known, rule, tree)
    return clauses, [] if rule == PAPER else list(contradicted_tasks(known, tree))


def _given(
    where: Path, at: str | None, agent: str, thing: str, ability: Ability, clauses: tuple[Clause, ...]
) -> list[Told]:
    """Offers to an agent that is known to be after a thing."""
    from taskgist.planning.offers import offers_for

    stage = open_stage(where, at, confirmed=False)
    with about(where):
        return [
            (
                None,
                offers_for(
                    stage,
                    agent,
                    thing,
                    ability,
                    clauses,
                    tree=with_predicates(STANDARD_TREE),
                    predicates=known_predicates(),
                ),
            )
        ]


def _seen(
    where: Path,
    at: str | None,
    agent: str | None,
    thing: str | None,
    ability: Ability | None,
    clauses: tuple[Clause, ...],
) -> list[Told]:
    """Offers to those who are seen to be after a thing in a recording."""
    from taskgist.pipeline.offers import offers_in
    from taskgist.recording.mcap import read

    if where.suffix.lower() == ".toml":
        option = "--for" if agent is None else "--object"
        hint = "name who is after what: --for P2 --object cup; only in a recording can that be seen"
        raise InputError("nobody moves in a scene", where=where, field=option, hint=hint)
    if at is None:
        raise InputError(
            "not given", where=where, field="--at", hint="the time of the recording to look at, in seconds, or as 50%"
        )
    with about(where, {"time_s": "--at"}):
        recording = read(where)
        if agent is not None:
            recording.scene.agent(agent)
        if thing is not None:
            recording.scene.object_body(thing)
        found = offers_in(recording, moment_s(recording, at), clauses, tree=with_predicates(STANDARD_TREE))
    return [
        (each.intention.behaviour, each.offers)
        for each in found
        if agent in (None, each.intention.agent)
        and thing in (None, each.intention.thing)
        and ability in (None, each.intention.ability)
    ]


def _print(found: list[Told], agent: str | None, thing: str | None) -> None:
    from taskgist.language.offers import aim, could_do, declined, would_lower

    if not found:
        who = "nobody is" if agent is None else f"{agent} is not"
        console.print(f"{who} seen to reach for or walk to {'a thing' if thing is None else f'the {thing}'}")
    for behaviour, offers in found:
        console.print(Text(aim(offers, behaviour), style="bold"))
        for task in offers.tasks:
            console.print(f"  {would_lower(task, offers.effort.ability)}")
        for helper in offers.helpers:
            console.print(f"  who could do it: {could_do(helper)}")
        for name in offers.unknown_helpers:
            console.print(f"  unknown whether {name} could do it")
        if told := declined(offers):
            console.print(f"  {told}")


def _document(behaviour: str | None, offers: Offers) -> dict[str, Any]:
    from taskgist.language.offers import aim, could_do, declined, would_lower

    effort = offers.effort
    return {
        "agent": effort.agent,
        "object": effort.target,
        "ability": effort.ability,
        "behaviour": behaviour,
        "level": effort.level,
        "effort": effort.name,
        "actions": list(effort.actions),
        "text": aim(offers, behaviour),
        "offered": offers.declined is None,
        "declined": offers.declined,
        "why_not": declined(offers),
        "tasks": [
            {
                "task": each.task,
                "level": each.level,
                "level_in_all": each.level_in_all,
                "in_hand": each.in_hand,
                "text": would_lower(each, effort.ability),
            }
            for each in offers.tasks
        ],
        "helpers": [
            {
                "agent": each.name,
                "robot": each.robot,
                "has_it": each.has_it,
                "level": each.grasping.level,
                "actions": list(each.grasping.actions),
                "text": could_do(each),
            }
            for each in offers.helpers
        ],
        "unknown_helpers": list(offers.unknown_helpers),
    }
