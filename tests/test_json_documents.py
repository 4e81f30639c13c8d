"""Every command's JSON document has a schema, which is a schema, and which a wrong document does not pass."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from jsonschema import Draft202012Validator

from tests.cli.running import run_json
from tests.command_lines import commands
from tests.schemas import FOLDER, hold_to_schema, schema_of
from tests.shipped import PATHS

FILES = ("perform_trajectory", "perform_plan")
"""Documents that a command writes to a file: by the command and its option."""


def test_every_command_has_a_schema() -> None:
    printed = {name.replace(" ", "_") for name in commands()}
    assert {path.stem for path in FOLDER.glob("*.json")} == printed | {"common", *FILES}


@pytest.mark.parametrize("name", FILES)
def test_files_are_named_by_command_and_option(name: str) -> None:
    command, _, option = name.rpartition("_")
    assert f"--{option}" in {text for each in commands()[command].params for text in each.opts}


@pytest.mark.parametrize("name", [*commands(), "common", *FILES])
def test_schemas_are_schemas_and_closed(name: str) -> None:
    schema = schema_of(name)
    Draft202012Validator.check_schema(schema)
    assert schema["title"]
    for each in objects(schema):
        assert "additionalProperties" in each or each.keys() <= {"type", "description"}, each


def objects(schema: Any) -> Iterator[dict[str, Any]]:
    """Every schema of an object within a schema."""
    if isinstance(schema, dict):
        if schema.get("type") in ("object", ["object", "null"]):
            yield schema
        for inner in schema.values():
            yield from objects(inner)
    elif isinstance(schema, list):
        for inner in schema:
            yield from objects(inner)


def test_documents_that_differ_are_refused() -> None:
    document = run_json(f"query {PATHS['show_a']} --at 2 --agent P1 --object cup --ability see")
    (effort,) = document["efforts"]
    without_level = {name: value for name, value in effort.items() if name != "level"}
    many = {**effort["evidence"], "visible_px": "many"}
    for wrong in (without_level, effort | {"level": 6}, effort | {"extra": 1}, effort | {"evidence": many}):
        with pytest.raises(AssertionError, match="query --json"):
            hold_to_schema("query", {"efforts": [wrong]})
