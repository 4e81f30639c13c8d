"""What the commands share, and what commands of other packages may use: arguments, output, errors, exit codes.

A command is a function as typer takes it, under ``@command``: expected errors become one line on standard error and
exit code 2, what it returns is the exit code, and what it reads it never overwrites. It prints with ``console``, or
with ``print_json`` where ``--json`` asks for a document, and shows long work by ``progress_bar``.
"""

from __future__ import annotations

import json
import math
import shlex
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import wraps
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any, ParamSpec

import typer
from rich.console import Console, ConsoleOptions, RenderableType
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.segment import Segment
from rich.text import Text

from taskgist.cli.app import INTERRUPTED, show_where
from taskgist.cli.found import files
from taskgist.common.files import check_no_input, check_replaceable, keeping_inputs, shown_path
from taskgist.common.text import COMMANDS, clean_name, escaped, escaped_in_json
from taskgist.errors import InputError, RecordingError, TaskgistError

if TYPE_CHECKING:  # recordings and scenes bring numpy and MuJoCo, which not every command needs
    from taskgist.facts.tree import TreeOf
    from taskgist.learning.knowledge import Knowledge
    from taskgist.recording.recording import Recording
    from taskgist.world.stage import Stage

P = ParamSpec("P")

RecordingArgument = Annotated[Path, typer.Argument(help="A recording (.mcap).", show_default=False)]
RecordingsArgument = Annotated[
    list[Path], typer.Argument(help="Recordings (.mcap), folders of them, or patterns such as take_*.mcap.")
]
WhereArgument = Annotated[
    Path, typer.Argument(metavar="SCENE", help="A scene (.toml) or a recording (.mcap).", show_default=False)
]
AtOption = Annotated[float | None, typer.Option(help="Time in a recording, seconds; default: its start.")]
KnowledgeOption = Annotated[
    str, typer.Option("--knowledge", "-k", help="The knowledge file, or the URL of a shared database.")
]
KNOWLEDGE = "knowledge.db"
ReplaceOption = Annotated[bool, typer.Option("--replace", help="Replace files that are there already.")]
RuleOption = Annotated[
    str | None,
    typer.Option(
        help="How to learn: bayes (what is no chance) or paper (what demonstrations agree in); "
        "default: bayes, where there is anything to compare with."
    ),
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print one JSON document instead of text.")]
MomentOption = Annotated[
    str | None, typer.Option(help="Time in a recording: seconds, or percent of the labelled time, such as 50%.")
]
NO_OPTIONS: Mapping[str, str] = MappingProxyType({})

OK, FAILED, MISUSED = 0, 1, 2
"""Exit codes: done; done, and the answer is no; bad input or use."""


class SafeConsole(Console):
    """Shows control characters in texts, which others may have written, as escapes."""

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterable[Segment]:
        """Render, as rich does."""
        for segment in super().render(renderable, options):
            if segment.control is None and COMMANDS.search(segment.text):
                yield Segment(escaped(segment.text), segment.style)
            else:
                yield segment


console = SafeConsole(highlight=False, soft_wrap=True, markup=False, emoji=False)
errors = SafeConsole(stderr=True, highlight=False, soft_wrap=True, markup=False, emoji=False)
"""Names and paths of users may hold brackets and colons: nothing in a text is markup, styles are given apart."""


def print_json(document: Any) -> None:
    """Print one JSON document on standard output."""
    sys.stdout.write(escaped_in_json(json.dumps(document, ensure_ascii=False, indent=2)) + "\n")


def task_named(known: Knowledge, name: str) -> str:
    """A task as it is known, however its name is spelled; as it is spelled if none is known by it."""
    return name if name in known.tasks else clean_name(name)


def print_left_out(tasks: Iterable[tuple[str, TreeOf]], where: str) -> None:
    """Print which tasks were left aside because answers about them contradict each other, and how to look at those.

    Args:
        tasks: Their names, and whose trees the answers are about.
        where: The knowledge.
    """
    for task, of in tasks:
        options = ["--of", of] if of == "performer" else []
        listing = shlex.join(["taskgist", "ask", task, "--list", *options, "-k", where])
        console.print(Text(f"left out: {task} (answers contradict each other: {listing})", style="dim"))


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
            with keeping_inputs():
                code = function(*args, **kwargs)
        except TaskgistError as error:
            raise _refused(error) from error
        except BrokenPipeError:
            raise  # whoever reads has seen enough; the command line's frame ends quietly
        except OSError as error:
            raise _refused(error) from error
        except KeyboardInterrupt as error:
            errors.print("interrupted")
            raise typer.Exit(INTERRUPTED) from error
        raise typer.Exit(code or OK)

    return run


def _refused(error: Exception) -> typer.Exit:
    show_where(error)
    errors.print(Text.assemble(("error:", "bold red"), f" {error}"))
    return typer.Exit(MISUSED)


def read_all(paths: Sequence[Path]) -> dict[Path, Recording]:
    """Read recordings, folders of them and patterns, by path and in order: all of them, before any long work.

    Raises:
        InputError: Nothing matches, or one of several is not there.
        RecordingError: One cannot be read, or a folder holds none.
    """
    from taskgist.recording.mcap import read

    return {path: read(path) for path in files(paths, suffix=".mcap")}


@contextmanager
def about(path: Path | str, options: Mapping[str, str] = NO_OPTIONS) -> Iterator[None]:
    """Let errors from inside name the file, and the command's option in place of the library's field.

    Args:
        path: The file that was named on the command line.
        options: Options by the fields that they set.
    """
    try:
        yield
    except InputError as error:
        if str(path) not in (error.where or ""):
            error.where = f"{path}: {error.where}" if error.where else str(path)
        error.field = options.get(error.field or "", error.field)
        raise


def make_folder(folder: Path, option: str, *, replace: bool) -> None:
    """Make a folder for pictures unless it is there, before any long work.

    Raises:
        InputError: It cannot be made, or holds pictures already, which are not to be replaced.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        pictures = sorted(path.name for path in folder.glob("*.png"))
    except (OSError, ValueError) as error:
        reason = (error.strerror if isinstance(error, OSError) else None) or error
        raise InputError(
            f"cannot be made: {reason}", where=shown_path(folder), field=option, hint="name a folder"
        ) from error
    if pictures and not replace:
        hint = "name another folder, or add --replace"
        raise InputError(f"holds {pictures[0]} already", where=folder, field=option, hint=hint)


def check_target(
    path: Path, option: str, *, replace: bool, suffix: str = "", what: str = "", inputs: Iterable[Path] = ()
) -> None:
    """Refuse a file that could not be written, before any long work.

    Args:
        path: The file.
        option: The option that names it.
        replace: Whether it may be there already.
        suffix: How its name has to end, such as ".png"; any if empty.
        what: What has such names.
        inputs: Files that the command reads; what it has read by now is known.

    Raises:
        InputError: Its folder does not exist or may not be written to; it is a folder, pipe or device, or an input; it
            is there and not to be replaced; or its name ends otherwise.
    """
    try:
        check_no_input(path, inputs)
        check_replaceable(path, replace=replace)
    except InputError as error:
        error.field = option
        if "there already" in error.problem:
            error.hint = "name another file, or add --replace"
        raise
    if suffix and path.suffix.lower() != suffix:
        raise InputError(f"{what} are {suffix[1:].upper()}", where=path, field=option, hint=f"name it {suffix}")


def moment_s(recording: Recording, at: str) -> float:
    """A time that is given in seconds, or in percent of the labelled time, or of a recording without a label.

    Raises:
        InputError: It is neither.
    """
    label = recording.label
    first_s, last_s = (
        (label.start_s, label.end_s) if label else (float(recording.times_s[0]), float(recording.times_s[-1]))
    )
    text = at.strip()
    try:
        number = float(text.removesuffix("%"))
    except ValueError:
        number = math.nan
    if not math.isfinite(number) or (text.endswith("%") and not 0.0 <= number <= 100.0):
        hint = "give seconds, such as 4.5, or percent from 0% to 100%"
        raise InputError("is no time", field="--at", value=at, hint=hint)
    return first_s + number / 100.0 * (last_s - first_s) if text.endswith("%") else number


def open_stage(where: Path, at: float | str | None, *, confirmed: bool = True) -> Stage:
    """A scene as it is placed, or as it was at a time of a recording.

    Args:
        where: The scene, or the recording.
        at: When, seconds, or as ``moment_s`` takes it; the recording's begin if left out.
        confirmed: Whether it is decided over time who holds what then and where eyes look, as for the recording's
            facts; otherwise one moment decides, and eyes look where heads do.

    Raises:
        SceneError: The scene cannot be read.
        RecordingError: The recording cannot be read or does not have that time, or a scene is asked for one.
    """
    from taskgist.observe.observer import Observer
    from taskgist.recording.mcap import read
    from taskgist.world.scene import Scene
    from taskgist.world.stage import Stage

    with about(where, {"time_s": "--at"}):
        if where.suffix.lower() == ".toml":
            if at is not None:
                raise RecordingError("a scene has no time", where=where, field="--at", value=at, hint="leave --at out")
            return Stage(Scene.load(where))
        recording = read(where)
        if isinstance(at, str):
            at = moment_s(recording, at)
        state = recording.at(float(recording.times_s[0]) if at is None else at)
        observer = Observer(recording.scene, recording)
        return Stage(recording.scene, observer.as_confirmed(state) if confirmed else state.with_eyes({}))
