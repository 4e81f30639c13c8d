"""Command lines as people write them down, parsed by the real parser without running anything."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from functools import cache

from typer.core import TyperCommand, TyperGroup
from typer.main import get_command

from taskgist.cli.app import app


@cache
def commands() -> dict[str, TyperCommand]:
    """Every command by its name; those of a group by the group's name and theirs."""
    group = get_command(app)
    assert isinstance(group, TyperGroup)
    return dict(_below(group))


def _below(group: TyperGroup, above: str = "") -> Iterator[tuple[str, TyperCommand]]:
    for name, command in group.commands.items():
        if isinstance(command, TyperGroup):
            yield from _below(command, f"{above}{name} ")
        else:
            assert isinstance(command, TyperCommand)
            yield f"{above}{name}", command


def parse(line: str) -> dict[str, object]:
    """What a line such as ``taskgist learn RECORDING... [-k FILE]  # comment`` passes to its command.

    Raises:
        Exception: What the parser raises: no such command or option, a missing argument, a bad value.
    """
    program, name, *words = shlex.split(re.sub(r"\.\.\.|[\[\]]", " ", line), comments=True)
    assert program == "taskgist", line
    if name.startswith("-"):
        return {}
    known = commands()
    if name not in known and words:
        name, *words = f"{name} {words[0]}", *words[1:]
    with known[name].make_context(name, words) as context:
        return dict(context.params)
