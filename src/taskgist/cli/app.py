"""The commands of ``taskgist``."""

from __future__ import annotations

import typer

from taskgist.cli.check import check
from taskgist.cli.demo import demo
from taskgist.cli.explain import explain
from taskgist.cli.facts import facts
from taskgist.cli.import_ import import_
from taskgist.cli.label import label
from taskgist.cli.learn import learn
from taskgist.cli.see import see

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
for name, function in {
    "demo": demo,
    "import": import_,
    "label": label,
    "check": check,
    "facts": facts,
    "learn": learn,
    "explain": explain,
    "see": see,
}.items():
    app.command(name)(function)


def main() -> None:
    """Run the command line."""
    app()
