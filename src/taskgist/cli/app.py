"""The commands of ``taskgist``: listed by name, and imported only when they are called.

A command is an entry point, ours (``OWN``) and those of other packages alike (group ``taskgist.commands``): a name, and
where its function stands. ``taskgist --help`` reads what each is for from the function's docstring *in its source*, so
that no command's module runs: an import of MuJoCo or of somebody's drivers costs those who use it, and what is broken
there breaks nothing here. Only where the source does not say it (the function is made elsewhere, or by a factory) is
the command loaded for its help.
"""

from __future__ import annotations

import _thread
import ast
import importlib.util
import inspect
import signal
import sys
import threading
import traceback
import warnings
from collections.abc import Iterator, Mapping
from importlib import metadata
from importlib.machinery import PathFinder
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from taskgist.common.compile_notice import when_compiling
from taskgist.common.text import escaped

GROUP = "taskgist.commands"
"""The entry points by which packages add commands."""

OWN = tuple(
    metadata.EntryPoint(name, f"taskgist.cli.{where}", GROUP)
    for name, where in {
        "demo": "demo:demo",
        "import": "import_:import_",
        "label": "label:label",
        "check": "check:check",
        "facts": "facts:facts",
        "learn": "learn:learn",
        "explain": "explain:explain",
        "recognise": "recognise:recognise",
        "ask": "ask:ask",
        "perform": "perform:perform",
        "offer": "offer:offer",
        "see": "see:see",
        "query": "query:query",
        "map": "map_:map_",
        "agent": "agent:agent_app",
    }.items()
)
PLAIN: Mapping[str, Any] = {"add_completion": False, "pretty_exceptions_enable": False, "rich_markup_mode": None}
"""How typer shows helps and errors: as text."""


class Commands(TyperGroup):
    """A group whose commands are loaded when they are called, or their own help is asked for."""

    def __init__(self, **attributes: Any) -> None:
        super().__init__(**attributes)
        self.commands: Any = Loaded()

    def list_commands(self, ctx: Any) -> list[str]:  # noqa: ARG002 - as typer calls it
        """The names, in the order in which the help lists them."""
        return list(self.commands)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Find the command that was called; one that cannot be loaded is told as misuse is, by exit code 2."""
        try:
            return super().resolve_command(ctx, args)
        except BrokenCommandError as error:
            sys.stderr.write(f"error: {error}\n")
            raise typer.Exit(2) from error

    def format_commands(self, ctx: Any, formatter: Any) -> None:  # noqa: ARG002
        """Write one line for each command."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, self.commands.purpose(name)) for name in self.commands])


class BrokenCommandError(Exception):
    """The module of a command cannot be imported, or does not hold the command."""

    def __init__(self, entry: metadata.EntryPoint, cause: Exception) -> None:
        owner = f" of package {entry.dist.name!r}" if entry.dist else ""
        super().__init__(
            f"command {entry.name!r}{owner} cannot be loaded: {type(cause).__name__}: {cause} (in {entry.value})"
        )


class Loaded(Mapping[str, Any]):
    """Commands by name, each loaded when it is looked up. Of two with one name, ours is meant."""

    def __init__(self) -> None:
        own = {entry.name: entry for entry in OWN}
        others = {entry.name: entry for entry in sorted(metadata.entry_points(group=GROUP), key=lambda e: e.name)}
        self._entries = own | others | own
        self._loaded: dict[str, Any] = {}

    def __getitem__(self, name: str) -> Any:
        entry = self._entries[name]
        if name not in self._loaded:
            try:
                self._loaded[name] = _command(entry)
            except Exception as error:  # somebody else's module may fail in any way
                raise BrokenCommandError(entry, error) from error
        return self._loaded[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)

    def purpose(self, name: str) -> str:
        """What a command is for: the first paragraph of its help; or why it cannot be said."""
        text = _help_in_source(self._entries[name])
        if text is None:
            try:
                text = self[name].help or ""
            except BrokenCommandError as error:
                return str(error)
        return " ".join(inspect.cleandoc(text).partition("\n\n")[0].split())


def _command(entry: metadata.EntryPoint) -> Any:
    """A command as typer runs it, from a function, or from a ``typer.Typer`` with commands of its own."""
    found, group = entry.load(), typer.Typer(**PLAIN)
    if isinstance(found, typer.Typer):
        group.add_typer(found, name=entry.name)
    else:
        group.command(entry.name)(found)
    return typer.main.get_group(group).commands[entry.name]


def _help_in_source(entry: metadata.EntryPoint) -> str | None:
    """The docstring of a function, or the ``help`` of a typer app, as written; none if it is not there."""
    try:
        statements = ast.parse(_source(entry.module)).body
    except (ImportError, SyntaxError, ValueError):
        return None
    for node in statements:
        if isinstance(node, ast.FunctionDef) and node.name == entry.attr:
            return ast.get_docstring(node)
        if isinstance(node, ast.Assign) and [ast.unparse(target) for target in node.targets] == [entry.attr]:
            keywords = node.value.keywords if isinstance(node.value, ast.Call) else []
            written = {keyword.arg: keyword.value for keyword in keywords}.get("help")
            return written.value if isinstance(written, ast.Constant) and isinstance(written.value, str) else None
    return None


def _source(module: str) -> str:
    """A module's text, without running it or the packages around it; nothing where it cannot be had."""
    top, *inner = module.split(".")
    spec = importlib.util.find_spec(top)
    for name in inner:
        if spec is None or spec.submodule_search_locations is None:
            return ""
        spec = PathFinder.find_spec(f"{spec.name}.{name}", spec.submodule_search_locations)
    get_source = getattr(spec.loader, "get_source", None) if spec else None
    return (get_source(module) or "") if get_source else ""


app = typer.Typer(
    cls=Commands,
    name="taskgist",
    help=(
        "Learn what a task means for another person: what changes in what they can see, reach and grasp, "
        "and with how much effort."
    ),
    no_args_is_help=True,
    **PLAIN,
)


def _print_version(wanted: bool) -> None:
    if wanted:
        sys.stdout.write(f"taskgist {metadata.version('taskgist')}\n")
        raise typer.Exit


@app.callback()
def options(
    _version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Show the version and exit.")
    ] = False,
    _debug: Annotated[
        bool, typer.Option("--debug", help="Show where errors arise; may stand anywhere on the command line.")
    ] = False,
) -> None:
    """Take the options that stand before a command."""
    from taskgist.cli.notes import show_notes

    silence_libraries()
    show_notes()
    keep_interrupts()
    when_compiling(_say_that_it_compiles)


def _say_that_it_compiles(kept: bool) -> None:
    """Explain the wait before the first answers after installation."""
    if sys.stderr.isatty():
        how_often = "once" if kept else "for this run only, as no cache can be written (set NUMBA_CACHE_DIR)"
        sys.stderr.write(f"Preparing inner loops for this machine, {how_often}: about ten seconds.\n")


# --- The frame of all commands: what nobody expected ends in one line, and in an exit code of its own.

UNEXPECTED, INTERRUPTED = 3, 130
"""Exit codes: a fault of ours; ended by Ctrl-C."""
DEBUG = "--debug"
LONGEST = 300
SOON_S = 0.01
"""When an interrupt that was dropped comes again."""


class Debugging:
    """Whether to show where errors arise.

    Attributes:
        on: Whether.
    """

    on = False


def take_debug_option() -> None:
    """Take ``--debug``, which may stand anywhere, from the command line."""
    Debugging.on = DEBUG in sys.argv[1:]
    sys.argv[1:] = [argument for argument in sys.argv[1:] if argument != DEBUG]


def keep_interrupts() -> None:
    """Let no Ctrl-C get lost.

    Python drops what is raised while it calls back for a weak reference or an object that is deleted, as libraries have
    them do. An interrupt that is dropped there comes again.
    """
    otherwise = sys.unraisablehook

    def interrupted_or(dropped: sys.UnraisableHookArgs) -> None:
        if issubclass(dropped.exc_type, KeyboardInterrupt):
            threading.Timer(SOON_S, interrupt_main).start()
        else:
            otherwise(dropped)

    sys.unraisablehook = interrupted_or


def interrupt_main() -> None:
    """Interrupt the main thread, also where it waits for something, if the system can do that."""
    if hasattr(signal, "pthread_kill"):
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)
    else:
        _thread.interrupt_main()


def silence_libraries() -> None:
    """Let libraries warn of nothing but where errors are looked for: what users need to know, we say."""
    import logging  # which --version need not wait for

    if not Debugging.on:
        logging.getLogger().addHandler(logging.NullHandler())
        if not sys.warnoptions:
            warnings.simplefilter("ignore")


def show_where(error: BaseException) -> None:
    """Print the traceback of an error, if that is asked for."""
    if Debugging.on:
        sys.stderr.write(escaped("".join(traceback.format_exception(error))))


def unexpected(error: Exception) -> int:
    """Tell of an error that is our fault; the exit code."""
    show_where(error)
    said = " ".join(f"{type(error).__name__}: {error}".split())[:LONGEST]
    report = "please report it with what it says above" if Debugging.on else f"please report it with {DEBUG}'s output"
    sys.stderr.write(f"unexpected: {escaped(said)}; this is our fault, {report}\n")
    return UNEXPECTED
