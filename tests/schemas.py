"""The JSON Schemas of what commands print with --json (docs/reference/schemas), and holding documents to them."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

from jsonschema import Draft202012Validator
from referencing import Registry, Resource

FOLDER = Path(__file__).parent.parent / "docs" / "reference" / "schemas"


def schema_of(command: str) -> Any:
    """The schema of a command's document."""
    return json.loads((FOLDER / f"{command.replace(' ', '_')}.json").read_text(encoding="utf-8"))


@cache
def _validator(command: str) -> Draft202012Validator:
    common = Resource.from_contents(schema_of("common"))
    return Draft202012Validator(schema_of(command), registry=Registry().with_resource("common.json", common))


def hold_to_schema(command: str, document: Any) -> None:
    """Refuse a document that is not what the command's schema says, and name the innermost place that differs.

    Raises:
        AssertionError: It differs.
    """
    errors = _validator(command).iter_errors(document)
    problems = [inner for error in errors for inner in (error, *(error.context or ()))]
    told = "\n".join(f"{'/'.join(map(str, each.absolute_path))}: {each.message[:300]}" for each in problems)
    assert not problems, f"taskgist {command} --json:\n{told}"
