"""Command lines as people write them down, parsed by the real parser without running anything."""

from __future__ import annotations

import re
import shlex

from typer.core import TyperCommand, TyperGroup
from typer.main import get_command

from taskgist.cli.app import app


def commands() -> dict[str, TyperCommand]:
    group = get_command(app)
    assert isinstance(group, TyperGroup)
    found = {name: command for name, command in group.commands.items() if isinstance(command, TyperCommand)}
    assert len(found) == len(group.commands)
    return found


def parse(line: str) -> dict[str, object]:
    """What a line such as ``taskgist learn RECORDING... [-k FILE]  # comment`` passes to its command.

    Raises:
        Exception: What the parser raises: no such command or option, a missing argument, a bad value.
    """
    program, name, *words = shlex.split(re.sub(r"\.\.\.|[\[\]]", " ", line), comments=True)
    assert program == "taskgist", line
    if name.startswith("-"):
        return {}
    with commands()[name].make_context(name, words) as context:
        return dict(context.params)
