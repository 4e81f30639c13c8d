"""``taskgist paper``: every published result beside ours."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import typer

from taskgist.cli.files import check_target, make_folder
from taskgist.cli.output import FAILED, OK, JsonOption, command, print_json, progress_bar
from taskgist.errors import InputError, KnowledgeError
from taskgist.recording import Progress
from taskgist.study.paper import (
    Draws,
    Judged,
    digest_of,
    judge_study,
    measure,
    outdated,
    read_draws,
    report,
    shipped_draws,
    write_draws,
)
from taskgist.study.shipped import shipped_study

MOST_DRAWS = 10_000


@command
def paper(
    draws: Annotated[
        int | None,
        typer.Option(
            "--draws", min=1, max=MOST_DRAWS, help="Displace all demonstrations so often, now: it takes long."
        ),
    ] = None,
    save: Annotated[
        Path | None, typer.Option("--save", help="Keep these draws in a file, and go on from what it holds.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="Folder for pictures of scenes and trees; made if new.")
    ] = None,
    as_json: JsonOption = False,
) -> int:
    """Compare every published result with ours.

    Judges the 23 recreated demonstrations of the paper's study, learns its six tasks, and puts clauses, figures and
    tables beside the printed ones. Each result is equal, or differs and is explained, or fails; if one fails, the exit
    code is 1.

    How well the clauses bear that people and things are moved was measured beforehand, and is held to a goal of 95 %:
    one that is clearly missed gives exit code 1, too. --draws 200 measures it anew, on all cores, which takes two of
    them a quarter of an hour; with --save it can be stopped and taken up again.

    Example: taskgist paper

    Example: taskgist paper --draws 200 --save draws.json.gz

    Example: taskgist paper -o pictures --json
    """
    _check(draws, save, out)
    with progress_bar(quiet=as_json) as progress:
        judged = judge_study(progress=progress)
        drawn = shipped_draws() if draws is None else _drawn(judged, draws, save, progress)
        found = report(judged, drawn)
        pictures = _pictures(judged, out, progress) if out else ()
    if as_json:
        print_json({**found.to_json(), "pictures": [str(path) for path in pictures]})
    else:
        from taskgist.cli.paper_tables import print_report

        print_report(found, pictures)
    return FAILED if found.failed else OK


def _check(draws: int | None, save: Path | None, out: Path | None) -> None:
    """Refuse what could not be written, before any long work."""
    if save is not None:
        if draws is None:
            hint = "add --draws 200"
            raise InputError("there are no new draws to keep", field="--save", value=str(save), hint=hint)
        check_target(save, "--save")
    if out is not None:
        make_folder(out, "--out")


def _drawn(judged: Mapping[str, tuple[Judged, ...]], count: int, save: Path | None, progress: Progress) -> Draws:
    study = digest_of(judged)
    known = read_draws(save) if save and save.exists() else Draws(study)
    problem = outdated(known, study)
    if problem:
        hint = "name another file, or remove this one"
        raise KnowledgeError(f"was measured with {problem}", where=save, field="--save", hint=hint)
    for more in measure(known, count, progress=progress):
        known = more
        if save:
            write_draws(known, save)
    return known


def _pictures(judged: Mapping[str, tuple[Judged, ...]], folder: Path, progress: Progress) -> tuple[Path, ...]:
    from taskgist.view.study import study_pictures  # with matplotlib, which only pictures should wait for

    return tuple(study_pictures(shipped_study(), judged, folder, progress))
