"""Facts from elsewhere: a simulator, an ontology or an annotator says what was observed, in a JSON file.

A file of the format ``taskgist.facts/1`` holds one demonstration::

    {
      "schema": "taskgist.facts/1",
      "task": "show", "demonstration": "show-1",
      "performing_agent": "P1", "target_agent": "P2", "target_object": "mug",
      "start": {"see.effort": "Head_Effort", "visibility.score": 0.0, "posture": "Sitting",
                "hands": {"left": "Free_of_Object", "right": null}},
      "end":   {"see.effort": "No_Effort_Required", "visibility.score": 0.02, "posture": "Sitting",
                "motion": {"value": "Static", "evidence": {"speed_m_s": 0.01}}}
    }

Each attribute is given as its value, as ``{"value", "evidence"}``, or as ``null`` where it is unknown; one that is
left out is unknown, too. ``facts_schema`` gives the JSON Schema.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from taskgist.common.documents import DocumentError, parse_json
from taskgist.common.files import read_whole
from taskgist.common.frozen import FrozenMap, Json, canonical_text, freeze
from taskgist.common.text import clean_name, fault_of_name
from taskgist.errors import FactsError, allowed_names
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import Episode, HypothesisTree, Snapshot
from taskgist.facts.values import NOT_OBSERVED, Observation, Raw
from taskgist.settings import DEFAULT, Limits

FACTS_FORMAT = "taskgist.facts/1"
"""Name and version of the file format."""

NAMES = ("task", "demonstration", "performing_agent", "target_agent", "target_object")
FIELDS = ("schema", *NAMES, "start", "end")


def read_facts(path: str | Path, tree: HypothesisTree = STANDARD_TREE, *, limits: Limits = DEFAULT.limits) -> Episode:
    """The episode that a facts file describes.

    Args:
        path: The file.
        tree: Whose attributes may be filled.
        limits: What is refused before memory is taken for it.

    Raises:
        FactsError: The file is missing, no regular file, too large, no JSON, or does not fit the tree.
    """
    text = read_whole(Path(path), most_bytes=limits.document_bytes, error=FactsError)
    try:
        document = parse_json(text, any_number=True)  # attributes refuse theirs by name
    except DocumentError as error:
        raise FactsError(str(error), where=path, hint=f"write a {FACTS_FORMAT} file") from error
    return parse_facts(document, tree, where=path)


def parse_facts(document: object, tree: HypothesisTree = STANDARD_TREE, *, where: str | Path | None = None) -> Episode:
    """The episode that a decoded ``taskgist.facts/1`` document describes.

    Args:
        document: What the ``json`` module gives.
        tree: Whose attributes may be filled.
        where: Name of the file, for errors.

    Raises:
        FactsError: A field is missing, unknown or not what it should be; names file, field and value.
    """
    _check_text(document, where)
    fields = _object(document, where, None)
    _check_fields(fields, where)
    start, end = (_snapshot(fields, part, tree, where) for part in ("start", "end"))
    names = {name: _name(fields[name], where, name) for name in NAMES}
    _check_sense(names, start, end, where)
    content: Json = {**names, "start": _plain(start), "end": _plain(end)}
    digest = hashlib.sha256(canonical_text(content).encode()).hexdigest()[:16]
    return Episode(**names, start=start, end=end, source=f"facts:{digest}")


def facts_schema(tree: HypothesisTree = STANDARD_TREE) -> dict[str, Json]:
    """JSON Schema (2020-12) of a facts file for this tree."""
    attributes = {name: _attribute_schema(attribute.schema()) for name, attribute in tree.attributes.items()}
    snapshot: Json = {"type": "object", "properties": attributes, "additionalProperties": False}
    name: Json = {"type": "string", "minLength": 1}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": FACTS_FORMAT,
        "type": "object",
        "properties": {
            "schema": {"const": FACTS_FORMAT},
            **dict.fromkeys(NAMES, name),
            "start": snapshot,
            "end": snapshot,
        },
        "required": list(FIELDS),
        "additionalProperties": False,
    }


def _attribute_schema(value: dict[str, Json]) -> Json:
    known_or_null: Json = {"anyOf": [value, {"type": "null"}]}
    wrapped: Json = {
        "type": "object",
        "properties": {"value": known_or_null, "evidence": {"type": "object"}},
        "required": ["value"],
        "additionalProperties": False,
    }
    return {"anyOf": [value, {"type": "null"}, wrapped]}


def _check_fields(fields: Mapping[str, object], where: str | Path | None) -> None:
    for name in fields:
        if name not in FIELDS:
            raise FactsError("no such field", where=where, field=name, hint=allowed_names(name, FIELDS))
    for name in FIELDS:
        if name not in fields:
            hint = f"a {FACTS_FORMAT} file has the fields {', '.join(FIELDS)}"
            raise FactsError("missing", where=where, field=name, hint=hint)
    if fields["schema"] != FACTS_FORMAT:
        hint = f"this release reads {FACTS_FORMAT!r}"
        raise FactsError("another format", where=where, field="schema", value=fields["schema"], hint=hint)


def _name(value: object, where: str | Path | None, field: str) -> str:
    if isinstance(value, list):
        hint = "several at once are not supported yet: write one file for each"
        raise FactsError("not one name", where=where, field=field, value=value, hint=hint)
    if not isinstance(value, str):
        raise FactsError("not a name", where=where, field=field, value=value, hint="give a text")
    name = clean_name(value)
    if fault := fault_of_name(name):
        raise FactsError(fault, where=where, field=field, value=value, hint="give a short text")
    return name


def _snapshot(
    fields: Mapping[str, object], part: str, tree: HypothesisTree, where: str | Path | None
) -> dict[str, Observation[Raw]]:
    snapshot: dict[str, Observation[Raw]] = {}
    for name, given in _object(fields[part], where, part).items():
        place = f"{part}.{name}"
        if name not in tree.attributes:
            hint = allowed_names(name, tree.attributes)
            raise FactsError("no such attribute", where=where, field=place, hint=hint)
        value, evidence = _unwrapped(given, where, place)
        if value is None:
            snapshot[name] = Observation(NOT_OBSERVED.value, evidence)
        else:
            raw = tree.attributes[name].read(value, where=where, field=place)
            snapshot[name] = Observation(raw, evidence)
    return snapshot


def _unwrapped(given: object, where: str | Path | None, field: str) -> tuple[object, Mapping[str, Json]]:
    """Value and evidence of ``value`` or ``{"value", "evidence"}``."""
    if not (isinstance(given, dict) and "value" in given):
        return given, {}
    for name in given:
        if name not in ("value", "evidence"):
            hint = allowed_names(name, ("value", "evidence"))
            raise FactsError("no such field", where=where, field=f"{field}.{name}", hint=hint)
    return given["value"], _evidence(given.get("evidence", {}), where, f"{field}.evidence")


def _evidence(given: object, where: str | Path | None, field: str) -> Mapping[str, Json]:
    evidence = _object(given, where, field)
    try:
        return FrozenMap({name: freeze(value) for name, value in evidence.items()})
    except TypeError as error:
        hint = "evidence is JSON with finite numbers"
        raise FactsError(f"not plain data: {error}", where=where, field=field, hint=hint) from error


def _object(value: object, where: str | Path | None, field: str | None) -> dict[str, Any]:
    if not isinstance(value, dict):
        hint = 'give an object: {"name": value, ...}'
        raise FactsError("not an object", where=where, field=field, value=value, hint=hint)
    return value


def _plain(snapshot: Mapping[str, Observation[Raw]]) -> Json:
    return {name: observation.to_json() for name, observation in snapshot.items()}


SCHEMA = facts_schema()
"""JSON Schema of a facts file for the standard tree."""


def _check_text(document: object, where: str | Path | None) -> None:
    """JSON can escape halves of characters, which no file or database holds."""
    try:
        json.dumps(document, ensure_ascii=False).encode("utf-8")
    except UnicodeEncodeError as error:
        hint = "replace the lone surrogate"
        raise FactsError(
            "a text that is no Unicode", where=where, value=error.object[error.start : error.end], hint=hint
        ) from error
    except (TypeError, ValueError, RecursionError):
        return  # what else is wrong is told where the field is read


def _check_sense(names: Mapping[str, str], start: Snapshot, end: Snapshot, where: str | Path | None) -> None:
    """Refuse what could teach nothing: one agent doing something for itself, or no fact at all."""
    if names["performing_agent"] == names["target_agent"]:
        hint = "name the other agent, for whom the task is performed"
        raise FactsError(
            "performing and target agent are the same",
            where=where,
            field="target_agent",
            value=names["target_agent"],
            hint=hint,
        )
    if not start and not end:
        raise FactsError("no facts", where=where, field="start, end", hint="give at least one attribute")
