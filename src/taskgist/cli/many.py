"""Many files in one command: worked on in one process on all cores, and told in a table.

What one file does wrong stops no other: its message stands in the table at the end, and the exit code says so.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, TypeVar

from rich.text import Text

from taskgist.cli.common import FAILED, MISUSED, OK, console, progress_bar
from taskgist.common.workers import in_order
from taskgist.errors import TaskgistError

R = TypeVar("R")


@dataclass(frozen=True)
class Done(Generic[R]):
    """What the work on a file gave."""

    path: Path
    result: R


@dataclass(frozen=True)
class Refused:
    """Why a file was refused."""

    path: Path
    problem: TaskgistError | OSError

    def document(self, key: str = "recording") -> dict[str, str]:
        """The file, under a key, and the error."""
        return {key: str(self.path), "error": str(self.problem)}


Outcome = Done[R] | Refused
"""What came of one file."""


def one_by_one(
    paths: Sequence[Path], work: Callable[[int], R], what: str, *, quiet: bool = False
) -> Iterator[Outcome[R]]:
    """What comes of each file, in their order, worked on by all cores.

    Args:
        paths: The files.
        work: Does that of the file with a number; what it gives must bear pickling.
        what: What is being done, for the progress bar.
        quiet: Show no progress.
    """

    def attempt(number: int) -> Outcome[R]:
        try:
            return Done(paths[number], work(number))
        except (TaskgistError, OSError) as problem:
            return Refused(paths[number], problem)

    with progress_bar(quiet=quiet) as progress:
        progress(f"{what} {len(paths)} files", 0.0)
        for number, outcome in enumerate(in_order(attempt, len(paths)), start=1):
            progress(f"{what} {number} of {len(paths)}", number / len(paths))
            yield outcome


def exit_code(outcomes: Sequence[Outcome[R]], *, good: Callable[[R], bool]) -> int:
    """2 if any file was refused, else 1 if the answer of any is no, else 0."""
    if any(isinstance(outcome, Refused) for outcome in outcomes):
        return MISUSED
    return OK if all(good(outcome.result) for outcome in outcomes if isinstance(outcome, Done)) else FAILED


def print_table(
    outcomes: Sequence[Outcome[R]], columns: Sequence[str], cells: Callable[[R], Sequence[str | Text]], done: str
) -> None:
    """A row for each file, and how many were done and refused.

    Args:
        outcomes: What came of each file.
        columns: Titles of what ``cells`` gives of a result.
        cells: The cells of a file that was not refused.
        done: What the others are, such as "imported".
    """
    rows = [[Text(str(each.path)), *map(_text, cells(each.result))] for each in outcomes if isinstance(each, Done)]
    if rows:
        _print_columns([[Text(title, style="bold") for title in ("file", *columns)], *rows])
    refused = [outcome for outcome in outcomes if isinstance(outcome, Refused)]
    for outcome in refused:
        about = "" if str(outcome.path) in str(outcome.problem) else f"{outcome.path}: "
        console.print(Text.assemble(("refused: ", "bold red"), f"{about}{outcome.problem}"))
    console.print(f"{len(outcomes) - len(refused)} {done}, {len(refused)} refused")


def _text(cell: str | Text) -> Text:
    return cell if isinstance(cell, Text) else Text(cell)


def _print_columns(rows: Sequence[Sequence[Text]]) -> None:
    """Rows in columns; lines are never folded, so that they can be searched and cut."""
    widths = [max(row[k].cell_len for row in rows if k < len(row)) for k in range(len(rows[0]))]
    for row in rows:
        line = Text()
        for cell, width in zip(row, widths, strict=False):
            line.append_text(cell).append(" " * (width - cell.cell_len + 2))
        line.rstrip()
        console.print(line)
