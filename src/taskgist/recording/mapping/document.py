"""From mapping files to one plain TOML document: ``extends``, ``like`` and parameters are gone after this."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from taskgist.errors import MappingError, UnknownNameError

RESERVED = frozenset({"person", "point", "axis", "AXIS"})
"""Placeholders that are filled while tables are read, and cannot be parameters."""

_SINGULAR = {"sources": "source", "people": "person", "objects": "object"}
"""Sections whose tables may be ``like`` another one."""

_PERSONAL = ("person", "stature_m", "unknown", "like")  # said of one person: never copied by ``like``


def read_document(file: Path, parameters: Mapping[str, str]) -> tuple[dict[str, Any], str]:
    """The merged document of a mapping file and those it extends, and the text of them all.

    Args:
        file: The mapping file.
        parameters: Values for its parameters, before those of the file itself.

    Raises:
        MappingError: A file is missing or no TOML; a parameter lacks its value; files extend each other in a circle.
        UnknownNameError: A parameter that the mapping does not have; ``like`` names nothing.
    """
    document, text = _extended(file, ())
    document = _with_parameters(document, parameters, file)
    for section in _SINGULAR:
        tables = document.get(section, {})
        if isinstance(tables, dict):
            document[section] = {name: _like(section, name, tables, file, ()) for name in tables}
    return document, text


def merged(base: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """Both tables, the second one winning; tables inside are merged likewise."""
    result = dict(base)
    for key, value in over.items():
        both = isinstance(value, dict) and isinstance(base.get(key), dict)
        result[key] = merged(base[key], value) if both else value
    return result


def _extended(file: Path, seen: tuple[Path, ...]) -> tuple[dict[str, Any], str]:
    if file.resolve() in seen:
        raise MappingError("mapping files extend each other in a circle", where=file, field="extends")
    document, text = _parsed(file)
    base = document.pop("extends", None)
    if base is None:
        return document, text
    if not isinstance(base, str):
        raise MappingError("must be a file name", where=file, field="extends", value=base)
    below, text_below = _extended(file.parent / base, (*seen, file.resolve()))
    return merged(below, document), f"{text_below}\n# --- {file.name}, which extends it\n{text}"


def _parsed(file: Path) -> tuple[dict[str, Any], str]:
    try:
        text = file.read_text(encoding="utf-8-sig")
        return tomllib.loads(text), text
    except OSError as problem:
        reason = problem.strerror or str(problem)
        raise MappingError("cannot read the mapping", where=file, value=reason, hint="check the path") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as problem:
        raise MappingError(f"not valid TOML: {problem}", where=file, hint="see docs/import.md") from None


def _with_parameters(document: dict[str, Any], given: Mapping[str, str], file: Path) -> dict[str, Any]:
    declared = document.pop("parameters", {})
    if not isinstance(declared, dict) or RESERVED & declared.keys():
        hint = f'write [parameters] with name = "value"; reserved names: {", ".join(sorted(RESERVED))}'
        raise MappingError("cannot be used", where=file, field="parameters", value=declared, hint=hint)
    for name in given:
        if name not in declared:
            raise UnknownNameError("parameter", name, declared, where=file)
    values = {name: str(value) for name, value in (declared | dict(given)).items()}
    for name, value in values.items():
        if not value:
            hint = f"give it with --set {name}=VALUE"
            raise MappingError("the parameter has no value", where=file, field=f"parameters.{name}", hint=hint)
    filled = _filled(document, values)
    assert isinstance(filled, dict)
    return filled


def _filled(value: Any, parameters: Mapping[str, str]) -> Any:
    if isinstance(value, dict):
        return {key: _filled(item, parameters) for key, item in value.items()}
    if isinstance(value, list):
        return [_filled(item, parameters) for item in value]
    if isinstance(value, str):
        for name, text in parameters.items():
            value = value.replace("{" + name + "}", text)
    return value


def _like(section: str, name: str, tables: dict[str, Any], file: Path, seen: tuple[str, ...]) -> Any:
    table = tables[name]
    if not isinstance(table, dict) or "like" not in table:
        return table
    model = table["like"]
    if not isinstance(model, str) or model not in tables:
        raise UnknownNameError(_SINGULAR[section], str(model), tables, where=f"{file}: {section}.{name}.like")
    if model in (*seen, name):
        raise MappingError("refers to itself", where=file, field=f"{section}.{name}.like", value=model)
    copied = _like(section, model, tables, file, (*seen, name))
    if not isinstance(copied, dict):
        raise MappingError("must be a table", where=file, field=f"{section}.{model}", value=copied)
    if section == "people":
        copied = {key: value for key, value in copied.items() if key not in _PERSONAL}
    own = {key: value for key, value in table.items() if key != "like"}
    return merged(copied, own)
