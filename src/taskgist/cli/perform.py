"""``taskgist perform``: let a robot do in a room what a task means."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
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
    ReplaceOption,
    RuleOption,
    WhereArgument,
    about,
    command,
    console,
    open_stage,
    print_json,
    progress_bar,
    task_named,
)
from taskgist.cli.performance_files import check_files, check_pddl, write_files, write_pddl
from taskgist.cli.performance_request import (
    attention_of,
    check_names,
    helpers_of,
    joined,
    means_of,
    none_or_names,
    spared_of,
    when_and_where,
)
from taskgist.common.text import one_or_list
from taskgist.errors import InputError, UnknownNameError
from taskgist.facts.predicates import known_predicates, with_predicates
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.values import Unknown
from taskgist.language.phrases import listed
from taskgist.learning.explanation import Context
from taskgist.learning.task_clauses import BY_RULE, RULES, learned_clause
from taskgist.learning.understanding import Clause
from taskgist.settings import DEFAULT

if TYPE_CHECKING:  # with MuJoCo, which a wrong name should not wait for
    from taskgist.pipeline.performing import Outcome, Performance
    from taskgist.planning.plan import Action, Plan

MOST_WAYS = 12


@command
def perform(
    task: Annotated[str, typer.Argument(help="The task, as it was learned.")],
    where: WhereArgument,
    knowledge: KnowledgeOption = KNOWLEDGE,
    robot: Annotated[
        str, typer.Option(help="Who performs it: an agent of the room; or a profile, which --at places there.")
    ] = "",
    target: Annotated[
        list[str] | None, typer.Option("--for", help="For whom: another agent of the room; once for each of several.")
    ] = None,
    thing: Annotated[
        list[str] | None, typer.Option("--object", help="With what: an object of the room; once for each of several.")
    ] = None,
    out: Annotated[Path | None, typer.Option("--out", "-o", help="Write the performance here (.mcap).")] = None,
    trajectory: Annotated[
        Path | None, typer.Option(help="Write trajectories of arms, lift, grippers and base, as ROS has them (.json).")
    ] = None,
    plan: Annotated[
        Path | None, typer.Option(help="Write the plan: phases, poses, grasp, attach, detach, stands (.json).")
    ] = None,
    positions: Annotated[
        Path | None, typer.Option(help="Write MuJoCo's positions and the whole model, for numpy (.npz).")
    ] = None,
    picture: Annotated[
        Path | None, typer.Option(help="Draw its moments, and what --for sees before and after (.png).")
    ] = None,
    film: Annotated[Path | None, typer.Option(help="Draw a short film of it (.webp or .gif).")] = None,
    pddl: Annotated[
        Path | None, typer.Option(help="Write the same problem for other planners: domain, problem, places (folder).")
    ] = None,
    ways: Annotated[int, typer.Option(min=1, max=MOST_WAYS, help="How many different ways.")] = 1,
    attention: Annotated[
        str, typer.Option(help="What --for looks at in the end: stays, thing or performer.")
    ] = "thing",
    allow: Annotated[list[str] | None, typer.Option(help="Only on, or in, this; may be given again.")] = None,
    prefer: Annotated[list[str] | None, typer.Option(help="First on, or in, this; may be given again.")] = None,
    means: Annotated[
        str,
        typer.Option(help="By what: some of move, cover, clear, relay, slide, with commas; moving alone comes first."),
    ] = "",
    helpers: Annotated[
        list[str] | None,
        typer.Option(help="Who may help in a relay, people only if named; may be given again (default: all robots)."),
    ] = None,
    spare: Annotated[
        str, typer.Option(help="Whose effort decides which place is first: nobody, performer, target or both.")
    ] = "nobody",
    seed: Annotated[int, typer.Option(min=0, help="Of all searches; the same seed gives the same plan.")] = 0,
    at: Annotated[
        list[str] | None,
        typer.Option(
            help="Seconds into a recording (default: its start); or X,Y,YAW in metres and degrees, where a --robot "
            "that is not in the room is placed.",
        ),
    ] = None,
    rule: RuleOption = None,
    replace: ReplaceOption = False,
    as_json: JsonOption = False,
) -> int:
    """Let a robot do in a room what a task means.

    Looks for a place of the object with which the learned clause holds for --for, and for a way of the robot to bring
    it there; carries that out, audits every motion, and judges what happened by the facts that explain demonstrations.
    The exit code is 1 if there is no way; what stood in the way is told.

    Of several agents the clause must hold for each: one place for all. Several objects are brought one after the
    other, and what is done is not undone. A robot that is not in the room is placed there: --robot pr2 --at 1,0.5,90.

    --rule says by which rule the task is understood, as in explain. Beside a whole clause (bayes) what is usual, and
    what else was so in all demonstrations, is wanted where it can be had, and told where it cannot.

    Example: taskgist perform hide room.toml --robot PR2 --for P2 --object cup

    Example: taskgist perform give room.toml --robot J --for P2 --object cup

    Example: taskgist perform show day.mcap --at 3 --robot J --for P2 --object cup

    Example: taskgist perform hide r.toml --robot J --for P2 --for P3 --object cup
    """
    if rule is not None and rule not in RULES:
        raise UnknownNameError("rule", rule, RULES, where="--rule")
    assumed = attention_of(attention)
    files = {
        "--out": out,
        "--trajectory": trajectory,
        "--plan": plan,
        "--positions": positions,
        "--picture": picture,
        "--film": film,
    }
    asked = {option: path for option, path in files.items() if path is not None}
    check_files(asked, ways, replace=replace, inputs=[where, Path(knowledge)])
    check_pddl(pddl, replace=replace)
    clause = _clause(knowledge, task, rule)
    time_s, place = when_and_where(at or [])
    stage = open_stage(where, time_s, confirmed=False)  # whoever is planned for holds still, and looks as is assumed
    from taskgist.pipeline.performing import perform as performed
    from taskgist.planning.requests import Request, check_one_problem

    with about(where):
        if place is not None:
            stage, robot = joined(stage, robot, place)
        targets, things = target or [""], thing or [""]
        check_names(stage.scene, robot, targets, things)
        request = Request(
            clause,
            robot,
            targets[0],
            things[0],
            assumed,
            none_or_names(allow),
            tuple(prefer or ()),
            seed,
            means=means_of(means),
            helpers=helpers_of(helpers, stage.scene.agents),
            spare=spared_of(spare),
            also_for=tuple(targets[1:]),
            also_with=tuple(things[1:]),
        )
        if pddl is not None:
            check_one_problem(request)
        with progress_bar(quiet=as_json) as progress:
            outcome = performed(
                stage.scene,
                request,
                state=stage.state,
                ways=ways,
                tree=with_predicates(STANDARD_TREE),
                predicates=known_predicates(),
                progress=progress,
            )
    with progress_bar(quiet=as_json) as progress:
        written = write_files(asked, outcome.performances, replace=replace, progress=progress)
        problem = None if pddl is None else write_pddl(outcome, pddl, replace=replace)
    if as_json:
        print_json(outcome_document(outcome, written, problem))
    else:
        print_outcome(outcome, written)
        if problem is not None:
            console.print(f"saved {problem}")
    return OK if outcome.performances else FAILED


def _clause(knowledge: str, task: str, rule: str | None) -> Clause:
    from taskgist.store.address import shown
    from taskgist.store.database import load

    tree = with_predicates(STANDARD_TREE)
    known = load(knowledge, expected=Context.of(DEFAULT, tree), evidence=False)
    with about(shown(knowledge)):
        clause = learned_clause(known, task_named(known, task), rule, tree)
    if not clause.literals:
        other = next(each for each in RULES if each != clause.rule)
        hint = f"its demonstrations have nothing in common by this rule; see taskgist explain, or give --rule {other}"
        raise InputError(
            "nothing was learned of this task", where=shown(knowledge), field="task", value=task, hint=hint
        )
    return clause


def print_outcome(outcome: Outcome, written: Sequence[Mapping[str, Path]]) -> None:
    """Print what was chosen and done, way by way, and the files that were written; or why there is none."""
    from taskgist.language.performing import as_shown, assumed, chosen, cost, refused, steps, would_help

    tree, request = with_predicates(STANDARD_TREE), outcome.request
    console.print(Text(f"{request.clause}   {BY_RULE.get(request.clause.rule, '')}".rstrip()))
    for note in _notes(outcome):
        console.print(Text("note ", style="yellow") + Text(note))
    for number, found in enumerate(outcome.performances):
        plan, count = found.plan, len(outcome.performances)
        console.print(Text(f"{f'way {number + 1}: ' if count > 1 else ''}{chosen(plan)}", style="bold"))
        console.print(f"  {'' if len(plan.actions) > 1 else f'{plan.performer} '}{', '.join(steps(plan))}")
        console.print(f"  cost: {cost(plan)}")
        console.print(f"  audited in {len(found.execution.recording.times_s)} frames and between them: clean")
        so = f"what {request.clause.task} means for {listed(request.targets)} is so"
        console.print(f"  judged by its facts: {so}; {_strict(found)}")
        if told := as_shown(found.circumstances, request.targets, tree):
            console.print(f"  {told}")
        for path in written[number].values():
            console.print(f"  saved {path}")
    if outcome.performances:
        console.print(f"{assumed(request)}; {_counted(outcome.search.places, 'place')} judged")
        return
    console.print(Text(f"{request.performer} finds no way to {request.clause.task}:", style="bold"))
    for sentence in refused(request, outcome.goal, outcome.search, outcome.spoiled, tree):
        console.print(f"  {sentence}")
    for sentence in would_help(outcome.helps):
        console.print(Text("  what would help: ", style="yellow") + Text(sentence))


def _notes(outcome: Outcome) -> tuple[str, ...]:
    """What is not as it was demonstrated, or usually is."""
    from taskgist.language.performing import not_as_demonstrated, not_had

    tree = with_predicates(STANDARD_TREE)
    return (*not_as_demonstrated(outcome.goal, tree), *not_had(outcome.dropped, tree))


def _strict(found: Performance) -> str:
    if found.strict is True:
        return "the whole clause holds"
    if found.strict is not False:
        return "whether the clause as a whole does is not known"
    return "the clause as a whole does not, for not all is here as it was when it was learned"


def outcome_document(
    outcome: Outcome, written: Sequence[Mapping[str, Path]], problem: Path | None = None
) -> dict[str, Any]:
    """What came of a request, as plain data.

    Args:
        outcome: What came of it.
        written: Of each way, the files that were written, by kind.
        problem: The folder with the problem for other planners; None: there is none.
    """
    from taskgist.language.performing import assumed, reason, refused, why_not, would_help

    request, tree, search = outcome.request, with_predicates(STANDARD_TREE), outcome.search
    return {
        "task": request.clause.task,
        "rule": request.clause.rule,
        "clause": request.clause.to_json(),
        "performer": request.performer,
        "target": one_or_list(request.targets),
        "object": one_or_list(request.things),
        "attention": request.attention,
        "assumed": assumed(request),
        "notes": list(_notes(outcome)),
        "given": [{"literal": str(each.literal), "holds": _known(each.holds)} for each in outcome.goal.given],
        "wanted": [str(literal) for literal in outcome.goal.controllable],
        "dropped": [{"literal": str(each.literal), "why": each.why} for each in outcome.dropped],
        "ways": [_way_document(found, files) for found, files in zip(outcome.performances, written, strict=True)],
        "search": {
            "places": search.places,
            "wanted": search.wanted,
            "tried": search.tried,
            "unknown": search.unknown,
            "out_of_hand": search.out_of_hand,
            "out_of_hold": search.out_of_hold or None,
            "out_of_reach": search.out_of_reach,
            "details": list(search.details),
            "failed": [{"literal": str(literal), "count": count} for literal, count in search.missed.most_common()],
            "refusals": [{"reason": reason(why, tree), "count": count} for why, count in search.refusals.most_common()],
            "thrown_away": list(outcome.spoiled),
            "others": [
                {"what": each.what, "places": each.places, "why": why_not(each, tree)} for each in search.others
            ],
        },
        "pddl": None if problem is None else str(problem),
        "why_not": [] if outcome.performances else list(refused(request, outcome.goal, search, outcome.spoiled, tree)),
        "would_help": list(would_help(outcome.helps)),
    }


def _counted(count: int, what: str) -> str:
    return f"1 {what} was" if count == 1 else f"{count} {what}s were"


def _known(truth: bool | Unknown) -> bool | None:
    return None if isinstance(truth, Unknown) else truth


def _way_document(found: Performance, files: Mapping[str, Path]) -> dict[str, Any]:
    from taskgist.language.performing import chosen, cost, steps
    from taskgist.performing.outputs import cost_document

    plan = found.plan
    return {
        "text": chosen(plan),
        "steps": list(steps(plan)),
        "actions": [_action_document(plan, action) for action in plan.actions],
        "cost": cost_document(plan.cost) | {"text": cost(plan)},
        "duration_s": round(plan.duration_s, 3),
        "audit": found.audit.to_json(),
        "strict": _known(found.strict),
        "circumstances": [
            {"literal": str(literal), "holds": _known(holds)} for literal, holds in found.circumstances.items()
        ],
        "files": {name: str(path) for name, path in files.items()},
    }


def _action_document(plan: Plan, action: Action) -> dict[str, Any]:
    from taskgist.language.performing import acted
    from taskgist.performing.outputs import hold_document

    candidate = action.candidate
    return {
        "text": acted(plan, action),
        "purpose": action.purpose,
        "performer": action.performer,
        "side": action.side,
        "object": action.thing,
        "effort": action.effort,
        "place": {
            "means": candidate.means,
            "carrier": candidate.carrier,
            "position_m": [round(value, 4) for value in candidate.pose[:3].tolist()],
            "wxyz": [round(value, 5) for value in candidate.pose[3:].tolist()],
        },
        "phases": [
            {
                "name": phase.name,
                "duration_s": round(phase.duration_s, 3),
                "holds": [hold_document(hold) for hold in sorted(phase.holds)],
            }
            for phase in action.phases
        ],
    }
