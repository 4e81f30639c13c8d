"""``taskgist evaluate``: how well are tasks learned, and performed?"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table as RichTable

from taskgist.cli.common import (
    JsonOption,
    ReplaceOption,
    check_target,
    command,
    console,
    make_folder,
    print_json,
    progress_bar,
)
from taskgist.common.workers import Progress
from taskgist.errors import InputError, UnknownNameError
from taskgist.learning.task_clauses import RULES
from taskgist.learning.understanding import PAPER
from taskgist.pipeline.shipped import TASKS
from taskgist_lab.evaluation.asking import asking
from taskgist_lab.evaluation.clause_learning import clause_learning
from taskgist_lab.evaluation.episodes import episodes
from taskgist_lab.evaluation.experiments import demonstrations_needed, transfer
from taskgist_lab.evaluation.learner import Coded
from taskgist_lab.evaluation.noise import CONDITIONS
from taskgist_lab.evaluation.odd_ones import odd_ones
from taskgist_lab.evaluation.performing.means_rooms import TASK_OF
from taskgist_lab.evaluation.performing.trials import ROBOTS, TrialsFound, performed_trials
from taskgist_lab.evaluation.performing.trials import sheets as trial_sheets
from taskgist_lab.evaluation.pool import (
    BACKGROUND,
    HELD_OUT_EVERY,
    SOURCES,
    UNFAMILIAR,
    Pool,
    Wanted,
    empty_pool,
    kept_pool,
)
from taskgist_lab.evaluation.recognition import recognition
from taskgist_lab.evaluation.robustness import compared, makers, robustness
from taskgist_lab.evaluation.sheets import Sheet, sheets_of
from taskgist_lab.evaluation.under_way import under_way
from taskgist_lab.evaluation.values import CLEAN, Result

HELD_OUT_SEED = 1000
"""Seed of the demonstrations that nothing was developed on; smaller ones are for development."""
LEARNED_FROM = tuple(name for name in SOURCES if name not in (BACKGROUND, UNFAMILIAR))
"""Sources of demonstrations of the paper's tasks."""
UNFAMILIAR_COUNT = 20
"""Manipulations of each kind that nobody has taught."""


@dataclass(frozen=True)
class How:
    """How an experiment on learning is made.

    Args:
        runs: Random orders in which each task is learned.
        seed: Their seed.
        processes: How many to use; None: one for each core.
        unfamiliar: Manipulations of kinds that nothing is compared with; none where nobody asks for them.
    """

    runs: int
    seed: int
    processes: int | None
    unfamiliar: Pool


Experiment = Callable[[Coded, How, Progress], Result]

RECOGNITION = "recognition"
"""The one of them that also needs manipulations that nobody has taught."""
ASKING = "asking"
IF_NAMED = (ASKING, "episodes", "under-way")
"""Those that take minutes more, and are run if they are named."""
EXPERIMENTS: Mapping[str, Experiment] = {
    "needed": lambda coded, how, _: demonstrations_needed(coded, runs=how.runs, seed=how.seed),
    "transfer": lambda coded, how, _: transfer(coded, runs=how.runs, seed=how.seed),
    "robustness": lambda coded, how, progress: robustness(coded, runs=how.runs, seed=how.seed, progress=progress),
    "peers": lambda coded, how, progress: compared(
        coded, runs=how.runs, seed=how.seed, peers=makers(how.seed), progress=progress
    ),
    "clauses": lambda coded, how, progress: clause_learning(coded, runs=how.runs, seed=how.seed, progress=progress),
    "odd": lambda coded, how, progress: odd_ones(coded, runs=how.runs, seed=how.seed, progress=progress),
    RECOGNITION: lambda coded, how, progress: recognition(
        coded, how.unfamiliar, runs=how.runs, seed=how.seed, progress=progress
    ),
    ASKING: lambda coded, how, progress: asking(coded, runs=how.runs, seed=how.seed, progress=progress),
    "episodes": lambda coded, how, progress: episodes(coded, processes=how.processes, progress=progress),
    "under-way": lambda coded, how, progress: under_way(coded, processes=how.processes, progress=progress),
}
"""The experiments on learning by name, in their order."""
PERFORM = "perform"
"""The experiment on performing, which needs no demonstrations, and is run if it is named."""


@command
def evaluate(
    experiments: Annotated[
        list[str] | None,
        typer.Argument(help=f"Which: {', '.join(EXPERIMENTS)}, {PERFORM}; by default all but the last four."),
    ] = None,
    pool: Annotated[
        Path | None, typer.Option("--pool", help="File of judged demonstrations: reused, extended, made if missing.")
    ] = None,
    demonstrations: Annotated[
        int, typer.Option("--demonstrations", "-n", help="Demonstrations of each task; every third is held out.")
    ] = 45,
    seed: Annotated[
        int, typer.Option("--seed", help="Seed. The default one is held out: smaller ones were developed on.")
    ] = HELD_OUT_SEED,
    runs: Annotated[int, typer.Option("--runs", help="Random orders in which each task is learned.")] = 200,
    source: Annotated[
        str, typer.Option("--source", help=f"Where demonstrations come from: {', '.join(LEARNED_FROM)}.")
    ] = "generator",
    unfamiliar: Annotated[
        Path | None,
        typer.Option("--unfamiliar", help="recognition: file of manipulations that nobody has taught, like --pool."),
    ] = None,
    watched: Annotated[
        list[str] | None,
        typer.Option("--condition", help=f"clauses: watched like this as well: {', '.join(list(CONDITIONS)[1:])}."),
    ] = None,
    rooms: Annotated[int, typer.Option("--rooms", help="perform: rooms for each task and robot.")] = 40,
    robots: Annotated[
        list[str] | None, typer.Option("--robot", help=f"perform: {', '.join(ROBOTS)}; both by default.")
    ] = None,
    tasks: Annotated[
        list[str] | None,
        typer.Option("--task", help=f"perform: a task of the study (all six by default), or {', '.join(TASK_OF)}."),
    ] = None,
    kept: Annotated[
        Path | None,
        typer.Option("--kept", help="perform: file of trials: reused, extended, made if missing."),
    ] = None,
    rule: Annotated[
        str, typer.Option("--rule", help=f"perform: rule by which the tasks are learned: {' or '.join(RULES)}.")
    ] = PAPER,
    processes: Annotated[
        int | None, typer.Option("--processes", help="Processes; one for each core by default.")
    ] = None,
    out: Annotated[Path | None, typer.Option("--out", "-o", help="Folder for pictures; made if new.")] = None,
    replace: ReplaceOption = False,
    as_json: JsonOption = False,
) -> None:
    """Measure how well tasks are learned and performed.

    needed: how many demonstrations it takes to understand a task as people do (Table 4 of the paper).

    transfer: whether a learned clause holds in demonstrations that were held out, and not in those of other tasks.

    robustness: the same under tracker noise, lost frames, labels that are off and wrong demonstrations, by several
    rules, the paper's first.

    peers: other learners on the very same facts (pip install 'taskgist[peers]', and 'taskgist[orange]'); what is not
    installed is left out.

    clauses: whole clauses, learned by comparing with neutral manipulations and other tasks, beside the paper's rule,
    judged by the task that a demonstration was played as, and by all that it fulfils. Beside them a forest that is told
    all that each fulfils: what it misses is hardly in the facts.

    odd: whether a demonstration with a wrong label among ten looks odd, and right ones do not.

    recognition: whether held-out demonstrations are recognised as what they fulfil, with which probability, and
    manipulations of kinds that nobody has taught as none of the tasks, beside a forest, nearest demonstrations and
    naive Bayes on the very same facts (of taskgist[peers]).

    asking: what three answers of a simulated teacher, who knows the generator's intention alone, are worth in
    demonstrations.

    episodes: whether what is done in held-out recordings is found without their labels, and recognised.

    under-way: what is said of held-out demonstrations after 25, 50, 75 and 90 % of their time.

    perform: in how many random rooms that can be solved robots perform the tasks of the study, how cleanly for a second
    auditor, whether what was performed is the task by lines of sight and distances, and in what time of the processor.
    The tasks cover, clear and relay are hide and show by these means alone, in rooms that are made for it. Half a
    minute for each room, task and robot.

    The demonstrations are generated. Every number is a mean over random orders, with its spread. The first run makes
    the demonstrations, which takes minutes; --pool keeps them.

    Example: taskgist evaluate needed transfer --pool pool.json.gz -o pictures

    Example: taskgist evaluate perform --rooms 5 --robot jido --task hide
    """
    performing = PERFORM in (experiments or ())
    chosen = _chosen([each for each in experiments or () if each != PERFORM], all_by_default=not performing)
    _check(demonstrations, runs, processes, rooms, out, replace=replace)
    for given, kind, known in (
        ([source], "source", LEARNED_FROM),
        (watched, "condition", CONDITIONS),
        (robots, "robot that is measured", ROBOTS),
        (tasks, "task of the study", (*TASKS, *TASK_OF)),
        ([rule], "rule", RULES),
    ):
        for name in given or ():
            if name not in known:
                raise UnknownNameError(kind, name, known)
    for path, option in ((kept, "--kept"), (pool, "--pool"), (unfamiliar, "--unfamiliar")):
        if path is not None:
            check_target(path, option, replace=True)
    if performing:
        with progress_bar(quiet=as_json) as progress:
            trials = performed_trials(
                count=rooms,
                seed=seed,
                tasks=[task for task in (*TASKS, *TASK_OF) if (task in tasks if tasks else task in TASKS)],
                robots=[robot for robot in ROBOTS if not robots or robot in robots],
                rule=rule,
                processes=processes,
                kept=kept,
                progress=progress,
            )
        if not chosen:
            _tell({}, {PERFORM: trials}, as_json=as_json)
            return
    performed = {PERFORM: trials} if performing else {}
    conditions = tuple(CONDITIONS) if "robustness" in chosen else (CLEAN, *(watched or ()))
    wanted = Wanted(source, seed, demonstrations, conditions)
    with progress_bar(quiet=as_json) as progress:
        judged = kept_pool(pool, wanted, processes=processes, progress=progress)
        others = _untaught(unfamiliar, seed, processes, progress) if RECOGNITION in chosen else empty_pool(source, seed)
        coded, how = Coded.of(judged), How(runs, seed, processes, others)
        results = {name: EXPERIMENTS[name](coded, how, progress) for name in chosen}
    pictures = _pictures(results, out) if out else ()
    if not as_json:
        _print_pool(judged)
    about = {"pool": _about(judged), "runs": runs, "pictures": [str(path) for path in pictures]}
    _tell(about, results | performed, as_json=as_json)
    for path in () if as_json else pictures:
        console.print(f"picture: {path}")


def _untaught(path: Path | None, seed: int, processes: int | None, progress: Progress) -> Pool:
    """Manipulations of kinds that nothing is compared with, those that the file has and those that are made now."""
    wanted = Wanted(UNFAMILIAR, seed, UNFAMILIAR_COUNT, (CLEAN,))
    return kept_pool(path, wanted, processes=processes, progress=progress)


def _tell(about: Mapping[str, Any], results: Mapping[str, Result], *, as_json: bool) -> None:
    """Print what was found: one document, or tables."""
    if as_json:
        print_json({**about, **{name: result.to_json() for name, result in results.items()}})
        return
    for result in results.values():
        for sheet in trial_sheets(result) if isinstance(result, TrialsFound) else sheets_of(result):
            print_sheet(sheet)


def _chosen(names: list[str], *, all_by_default: bool) -> tuple[str, ...]:
    for name in names:
        if name not in EXPERIMENTS:
            raise UnknownNameError("experiment", name, (*EXPERIMENTS, PERFORM))
    by_default = EXPERIMENTS.keys() - {*IF_NAMED} if all_by_default and not names else ()
    return tuple(name for name in EXPERIMENTS if name in names or name in by_default)


def _check(
    demonstrations: int, runs: int, processes: int | None, rooms: int, out: Path | None, *, replace: bool
) -> None:
    if demonstrations < HELD_OUT_EVERY:
        hint = f"every {HELD_OUT_EVERY}rd is held out: give {HELD_OUT_EVERY} or more, better 30"
        raise InputError("too few", field="--demonstrations", value=demonstrations, hint=hint)
    for name, value in (("--runs", runs), ("--processes", processes), ("--rooms", rooms)):
        if value is not None and value < 1:
            raise InputError("too few", field=name, value=value, hint="give 1 or more")
    if out is not None:
        make_folder(out, "--out", replace=replace)


def _about(pool: Pool) -> dict[str, Any]:
    clean = [each.task for each in pool.samples if each.condition == CLEAN]
    return {
        "source": pool.source,
        "seed": pool.seed,
        "settings": pool.context.settings_digest,
        "tree": pool.context.tree_version,
        "demonstrations": {task: clean.count(task) for task in pool.tasks},
        "failures": [f"{each.task} {each.number} {each.condition}: {each.problem}" for each in pool.failures],
    }


def _print_pool(pool: Pool) -> None:
    counts = ", ".join(f"{task} {count}" for task, count in _about(pool)["demonstrations"].items())
    console.print(f"{SOURCES[pool.source].text}, seed {pool.seed}: {counts}")
    if pool.failures:
        first = pool.failures[0]
        problem = f"{first.task} {first.number} {first.condition}: {first.problem}"
        console.print(f"{len(pool.failures)} could not be played or watched, such as {problem}", style="dim")
    console.print()


def print_sheet(sheet: Sheet) -> None:
    """Print a table with its title and note."""
    table = RichTable(title=sheet.title, title_justify="left", title_style="bold", box=None, pad_edge=False)
    for column in sheet.header:
        table.add_column(column, overflow="fold")
    for row in sheet.rows:
        table.add_row(*row)
    console.print(table)
    if sheet.note:
        console.print(sheet.note, style="dim")
    console.print()


def _pictures(results: Mapping[str, Result], folder: Path) -> tuple[Path, ...]:
    from taskgist_lab.view import DRAWN, picture_of  # with matplotlib, which only pictures should wait for

    drawn = {name: result for name, result in results.items() if type(result) in DRAWN}
    return tuple(picture_of(result, folder / f"evaluation_{name}.png") for name, result in drawn.items())
