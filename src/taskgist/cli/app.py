"""The commands of ``taskgist``."""

from __future__ import annotations

from importlib import metadata
from typing import Annotated

import typer

from taskgist.cli.agent import agent_app
from taskgist.cli.check import check
from taskgist.cli.common import console, say_that_it_compiles
from taskgist.cli.demo import demo
from taskgist.cli.explain import explain
from taskgist.cli.facts import facts
from taskgist.cli.import_ import import_
from taskgist.cli.label import label
from taskgist.cli.learn import learn
from taskgist.cli.map_ import map_
from taskgist.cli.query import query
from taskgist.cli.see import see
from taskgist.common.compiled import when_compiling

app = typer.Typer(
    name="taskgist",
    help=(
        "Learn what a task means for another person: what changes in what they can see, reach and grasp, "
        "and with how much effort."
    ),
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


def _print_version(wanted: bool) -> None:
    if wanted:
        console.print(f"taskgist {metadata.version('taskgist')}")
        raise typer.Exit


@app.callback()
def options(
    _version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    """Take the options that stand before a command."""
    when_compiling(say_that_it_compiles)


app.command("demo")(demo)
app.command("import")(import_)
app.command("label")(label)
app.command("check")(check)
app.command("facts")(facts)
app.command("learn")(learn)
app.command("explain")(explain)
app.command("see")(see)
app.command("query")(query)
app.command("map")(map_)
app.add_typer(agent_app, name="agent")
for _entry in metadata.entry_points(group="taskgist.commands"):
    app.command(_entry.name)(_entry.load())
