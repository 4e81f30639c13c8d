"""Pages of docs/reference that say what the code says: commands, settings, JSON documents.

    python -m tools.reference_pages

A test holds the pages to what this writes.
"""

from __future__ import annotations

import ast
import dataclasses
import inspect
import json
import math
import re
from collections.abc import Iterator, Mapping
from itertools import pairwise
from pathlib import Path

from typer.core import TyperArgument, TyperCommand, TyperGroup
from typer.main import get_command

from taskgist import settings
from taskgist.cli.app import app
from tools.markdown import filled, header, row

ROOT = Path(__file__).parent.parent
REFERENCE = ROOT / "docs" / "reference"
SCHEMAS = REFERENCE / "schemas"


def main() -> None:
    """Rewrite the pages."""
    for path, text in pages().items():
        path.write_text(text, encoding="utf-8")


def pages() -> Mapping[Path, str]:
    """Each page as it should be."""
    parts = {"commands": commands, "settings": settings_tables, "json": json_documents}
    paths = {name: REFERENCE / f"{name}.md" for name in parts}
    return {path: filled(path.read_text(encoding="utf-8"), {name: parts[name]()}) for name, path in paths.items()}


# --- Commands


def commands() -> Iterator[str]:
    """A section for each command: what it does, its arguments and options, examples."""
    for name, command in all_commands().items():
        yield f"## taskgist {name}"
        yield ""
        about, examples = split_help(command.help or "")
        yield from about
        yield ""
        yield from header("argument, option", "what it says", "default")
        for each in command.params:
            if each.name != "help":
                default = "" if each.default in (None, False, ()) or each.required else f"`{each.default}`"
                names = ", ".join(f"`{text}`" for text in each.opts)
                shown = f"`{(each.name or '').upper()}`" if isinstance(each, TyperArgument) else names
                yield row(shown, (getattr(each, "help", None) or "").replace("|", "\\|"), default)
        yield ""
        for line in examples:
            yield f"    {line}"
        yield ""


def split_help(text: str) -> tuple[list[str], list[str]]:
    """A command's help: its paragraphs, and the examples in it."""
    paragraphs = [re.sub(r"\s+", " ", each).strip() for each in inspect.cleandoc(text).split("\n\n")]
    examples = [each.removeprefix("Example: ") for each in paragraphs if each.startswith("Example: ")]
    about = [line for each in paragraphs if not each.startswith("Example: ") for line in (each, "")]
    return about[:-1], examples


def all_commands() -> Mapping[str, TyperCommand]:
    """Every command by its name; those of a group by the group's name and theirs."""
    group = get_command(app)
    assert isinstance(group, TyperGroup)
    return dict(_below(group, ""))


def _below(group: TyperGroup, above: str) -> Iterator[tuple[str, TyperCommand]]:
    context = group.make_context("taskgist", [], resilient_parsing=True)
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        if isinstance(command, TyperGroup):
            yield from _below(command, f"{above}{name} ")
        elif isinstance(command, TyperCommand):
            yield f"{above}{name}", command


# --- Settings


def settings_tables() -> Iterator[str]:
    """A table for each stage's settings: name, default, what it is and where it comes from."""
    about = attribute_docstrings(inspect.getsource(settings))
    for stage in dataclasses.fields(settings.DEFAULT):
        values = getattr(settings.DEFAULT, stage.name)
        yield f"## {stage.name}"
        yield ""
        yield inspect.cleandoc(type(values).__doc__ or "")
        yield ""
        yield from header("setting", "default", "what it is")
        for each in dataclasses.fields(values):
            yield row(
                f"`{stage.name}.{each.name}`",
                setting_text(each.name, getattr(values, each.name)),
                about[type(values).__name__, each.name],
            )
        yield ""


def attribute_docstrings(source: str) -> dict[tuple[str, str], str]:
    """What stands below each attribute of each class, by class and attribute."""
    found = {}
    for node in ast.parse(source).body:
        if isinstance(node, ast.ClassDef):
            for field, text in pairwise(node.body):
                match field, text:
                    case ast.AnnAssign(target=ast.Name(id=name)), ast.Expr(value=ast.Constant(value=str(told))):
                        found[node.name, name] = re.sub(r"\s+", " ", told)
    return found


def setting_text(name: str, value: object) -> str:
    """A value, angles in degrees, too."""
    if name.endswith("_rad") and isinstance(value, float):
        return f"{value:.4g} ({math.degrees(value):.3g}°)"
    return f"{value}"


# --- JSON documents


def json_documents() -> Iterator[str]:
    """A row for each schema: the command, what its document says, and what is at its top."""
    yield from header("command", "its document", "what stands at its top", "schema")
    for path in sorted(SCHEMAS.glob("*.json")):
        schema = json.loads(path.read_text(encoding="utf-8"))
        if path.stem != "common":
            forms = "; or ".join(form_text(form) for form in schema.get("anyOf", [schema]))
            name = _written_by(path.stem)
            yield row(f"`taskgist {name}`", schema["title"], forms, f"[{path.name}](schemas/{path.name})")


def _written_by(stem: str) -> str:
    """The command that prints a document; or command and option, of one that it writes to a file."""
    name = stem.replace("_", " ")
    if name in all_commands():
        return name
    command, _, option = name.rpartition(" ")
    return f"{command} --{option}"


def form_text(form: Mapping[str, object]) -> str:
    """One form of a document, in a few words."""
    ref = str(form.get("$ref", ""))
    properties = form.get("properties")
    if ref:
        return f"an {ref.rpartition('/')[2]}" if ref.rpartition("/")[2][0] in "aeiou" else f"a {ref.rpartition('/')[2]}"
    if isinstance(properties, Mapping):
        return ", ".join(f"`{name}`" for name in properties)
    told = f" ({str(form['description']).rstrip('.')})" if "description" in form else ""
    kinds = {"array": "a list", "null": "`null`", "object": "an object by name"}
    return kinds[str(form["type"])] + told


if __name__ == "__main__":
    main()
