"""What the commands print with: console, progress bars, JSON, and errors that end with the right exit code."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from typing import Annotated, Any, ParamSpec

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.text import Text

from taskgist.errors import TaskgistError

P = ParamSpec("P")

OK, FAILED, MISUSED = 0, 1, 2
"""Exit codes: done; done, and the answer is no; bad input or use."""

console = Console(highlight=False, soft_wrap=True, markup=False, emoji=False)
errors = Console(stderr=True, highlight=False, soft_wrap=True, markup=False, emoji=False)
"""Names and paths of users may hold brackets and colons: nothing in a text is markup, styles are given apart."""

JsonOption = Annotated[bool, typer.Option("--json", help="Print one JSON document instead of text.")]


def say_that_it_compiles() -> None:
    """Explain the wait before the first answers after installation."""
    if errors.is_terminal:
        errors.print("Preparing inner loops for this machine, once: about half a minute.", style="dim")


def print_json(document: Any) -> None:
    """Print one JSON document on standard output."""
    sys.stdout.write(json.dumps(document, ensure_ascii=False, indent=2) + "\n")


@contextmanager
def progress_bar(*, quiet: bool = False) -> Iterator[Callable[[str, float], None]]:
    """A progress bar on standard error, gone when done; yields a function of (what, share from 0 to 1).

    Args:
        quiet: Show nothing.
    """
    columns = (TextColumn("{task.description}", markup=False), BarColumn(bar_width=30), TimeElapsedColumn())
    with Progress(*columns, console=errors, transient=True, disable=quiet or not errors.is_terminal) as bar:
        task = bar.add_task("", total=1.0)

        def update(what: str, share: float) -> None:
            bar.update(task, description=what, completed=share)

        yield update


def command(function: Callable[P, int | None]) -> Callable[P, None]:
    """Make a function a command: expected errors become a message and exit code 2, a returned number the exit code."""

    @wraps(function)
    def run(*args: P.args, **kwargs: P.kwargs) -> None:
        try:
            code = function(*args, **kwargs)
        except TaskgistError as error:
            raise _refused(error) from error
        except BrokenPipeError:
            raise  # whoever reads has seen enough; the command line's frame ends quietly
        except OSError as error:
            raise _refused(error) from error
        raise typer.Exit(code or OK)

    return run


def _refused(error: Exception) -> typer.Exit:
    errors.print(Text.assemble(("error:", "bold red"), f" {error}"))
    return typer.Exit(MISUSED)
