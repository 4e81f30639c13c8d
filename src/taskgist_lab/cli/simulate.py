"""``taskgist simulate``: demonstrations by scripted demonstrators, in any number."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table as RichTable

from taskgist.cli.common import JsonOption, check_target, command, console, print_json, progress_bar
from taskgist.errors import InputError
from taskgist.recording.mcap import read
from taskgist_lab.generator.simulation import SEVERAL, WAYS, Series, Written, simulate_files


@command
def simulate(
    task: Annotated[str | None, typer.Argument(help="Name of a task; --list names them.")] = None,
    count: Annotated[int, typer.Option("--count", "-n", help="How many demonstrations.")] = 10,
    seed: Annotated[int, typer.Option("--seed", "-s", help="Everything random follows from it.")] = 0,
    means: Annotated[str | None, typer.Option("--means", help="Only by this means; --list names them.")] = None,
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the recordings.")] = Path("simulated"),
    replace: Annotated[bool, typer.Option("--replace", help="Replace recordings of the same names.")] = False,
    processes: Annotated[
        int | None, typer.Option("--processes", help="Processes; one for each core by default.")
    ] = None,
    picture: Annotated[
        Path | None, typer.Option("--picture", help="PNG file: how the first twelve end, seen from the side.")
    ] = None,
    listed: Annotated[
        bool, typer.Option("--list", help="Name the tasks and their means, and do nothing else.")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Make demonstrations of a task in random rooms.

    Scripted demonstrators reach their intention by several means, and never ask for the facts. The recordings are
    labelled and say that they are simulated. The same task, seed and number give the same demonstration, whatever the
    count and however many cores.

    Example: taskgist simulate hide --count 20 --seed 7 -o hide

    Example: taskgist simulate show --means turn --picture turned.png

    Example: taskgist simulate --list
    """
    if listed:
        _list(as_json=as_json)
        return
    if task is None:
        raise InputError("no task to simulate", hint="name one; 'taskgist simulate --list' names them")
    if picture is not None:
        check_target(picture, "--picture", replace=replace, suffix=".png", what="pictures")
    started = time.perf_counter()
    with progress_bar(quiet=as_json) as progress:
        coming = simulate_files(
            Series(task, seed, means), out, count=count, replace=replace, processes=processes, progress=progress
        )
        written = list(coming)
    seconds = time.perf_counter() - started
    if picture is not None:
        _draw(written, picture, f"{task}, seed {seed}")
    if as_json:
        print_json(_document(task, seed, out, written, seconds))
    else:
        _print(task, out, written, seconds)


def _list(*, as_json: bool) -> None:
    known = {task: [way.name for way in (*ways, *SEVERAL.get(task, ()))] for task, ways in WAYS.items()}
    if as_json:
        print_json(known)
        return
    table = RichTable("task", "means", box=None)
    for task, names in known.items():
        table.add_row(task, ", ".join(names))
    console.print(table)


def _draw(written: Sequence[Written], path: Path, title: str) -> None:
    from taskgist_lab.view import MOST, contact_sheet  # with matplotlib, which only pictures wait for

    titles = [f"{each.path.stem}: {each.means}" for each in written[:MOST]]
    contact_sheet([read(each.path) for each in written[:MOST]], titles, path, title=title)


def _by_means(written: Sequence[Written]) -> Mapping[str, tuple[int, float]]:
    """How many demonstrations there are of each means, and how many rooms one took."""
    names = sorted({each.means for each in written})
    attempts = {name: [each.attempts for each in written if each.means == name] for name in names}
    return {name: (len(tried), sum(tried) / len(tried)) for name, tried in attempts.items()}


def _document(task: str, seed: int, folder: Path, written: Sequence[Written], seconds: float) -> dict[str, Any]:
    means = {name: {"count": count, "rooms_tried": tried} for name, (count, tried) in _by_means(written).items()}
    recordings = [
        {"file": str(each.path), "means": each.means, "rooms_tried": each.attempts, "duration_s": each.duration_s}
        for each in written
    ]
    return {
        "task": task,
        "seed": seed,
        "folder": str(folder),
        "seconds": seconds,
        "means": means,
        "recordings": recordings,
    }


def _print(task: str, folder: Path, written: Sequence[Written], seconds: float) -> None:
    table = RichTable("means", box=None)
    table.add_column("demonstrations", justify="right")
    table.add_column("rooms tried for each", justify="right")
    for name, (count, tried) in _by_means(written).items():
        table.add_row(name, str(count), f"{tried:.1f}")
    console.print(table)
    each = seconds / len(written)
    console.print(f"{len(written)} demonstrations of {task} in {folder}: {seconds:.1f} s, {each:.2f} s for each")
