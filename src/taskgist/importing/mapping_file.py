"""Reads a mapping file: from TOML that may extend other TOML to an ``ImportMapping``."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping
from collections.abc import Mapping as AnyMapping
from dataclasses import replace
from pathlib import Path, PurePath
from typing import Any

from taskgist.common.files import read_whole
from taskgist.common.text import clean_name
from taskgist.common.toml import Document, TomlTable, is_finite_number, parse_toml
from taskgist.errors import InputError, MappingError, UnknownNameError
from taskgist.importing.mapping import (
    Clock,
    Columns,
    Confidence,
    ImportMapping,
    Name,
    Person,
    Rotation,
    SignalColumn,
    Source,
    TableFormat,
    Timeline,
)
from taskgist.importing.mapping_fields import read_column, read_columns, read_frame
from taskgist.importing.mapping_people import read_person
from taskgist.importing.mapping_things import ANGLE_UNITS_RAD, read_robot, read_support, read_thing
from taskgist.importing.readers import CONVERSIONS, READERS, SUFFIXES
from taskgist.importing.skeletons import SKELETONS
from taskgist.importing.takes import CONFIDENCE, POSITION, ROTATION, TIME
from taskgist.recording.recording import Label, Provenance
from taskgist.settings import DEFAULT, Limits

# --- From mapping files to one plain TOML document: ``extends``, ``like`` and parameters are gone after this.

RESERVED = frozenset({"person", "point", "axis", "AXIS"})
"""Placeholders that are filled while tables are read, and cannot be parameters."""

_SINGULAR = {"sources": "source", "people": "person", "robots": "robot", "objects": "object"}
"""Sections whose tables may be ``like`` another one."""

_PERSONAL = ("person", "stature_m", "unknown", "like")  # said of one person: never copied by ``like``


def read_document(
    file: Path, parameters: Mapping[str, str], *, limits: Limits = DEFAULT.limits
) -> tuple[dict[str, Any], str, tuple[Path, ...]]:
    """The merged document of a mapping file and those it extends, the text of them all, and their paths.

    Args:
        file: The mapping file.
        parameters: Values for its parameters, before those of the file itself.
        limits: How large a file may be.

    Raises:
        MappingError: A file is missing, too large or no TOML; a parameter lacks its value; files extend each other in a
            circle.
        UnknownNameError: A parameter that the mapping does not have; ``like`` names nothing.
    """
    try:
        document, text, files = _extended(file, (), limits)
        document = _with_parameters(document, parameters, file)
        for section in _SINGULAR:
            tables = document.get(section, {})
            if isinstance(tables, dict):
                document[section] = {name: _like(section, name, tables, file, ()) for name in tables}
    except RecursionError as problem:
        raise MappingError("is nested too deep", where=file, hint="see docs/howto/import.md") from problem
    return document, text, files


def merged(base: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """Both tables, the second one winning; tables inside are merged likewise."""
    result = dict(base)
    for key, value in over.items():
        both = isinstance(value, dict) and isinstance(base.get(key), dict)
        result[key] = merged(base[key], value) if both else value
    return result


def _extended(file: Path, seen: tuple[Path, ...], limits: Limits) -> tuple[dict[str, Any], str, tuple[Path, ...]]:
    document, text = _parsed(file, limits)
    if any(file.samefile(other) for other in seen):
        raise MappingError("mapping files extend each other in a circle", where=file, field="extends")
    base = document.pop("extends", None)
    if base is None:
        return document, text, (file,)
    if not isinstance(base, str):
        raise MappingError("must be a file name", where=file, field="extends", value=base)
    below, text_below, files = _extended(file.parent / base, (*seen, file), limits)
    return merged(below, document), f"{text_below}\n# --- {file.name}, which extends it\n{text}", (file, *files)


def _parsed(file: Path, limits: Limits) -> tuple[dict[str, Any], str]:
    content = read_whole(file, most_bytes=limits.toml_bytes, setting="toml_bytes", error=MappingError)
    document = parse_toml(content, file, MappingError, most_bytes=limits.toml_bytes)
    return document, content.decode("utf-8-sig")


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


TIME_UNITS_S = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
KINDS = {".csv": "csv", ".tsv": "csv", ".txt": "csv", ".npz": "npz", ".npy": "npy", ".mat": "mat"}
"""Formats of tables by the ends of their names."""
ROTATION_LETTERS = {"xyzw": "xyzw", "wxyz": "wxyz", "rotation_vector": "xyz", "matrix": "012345678"}


def read_source(name: str, section: TomlTable) -> Source:
    """One source, checked as far as that goes without its files.

    Raises:
        MappingError: A field is missing, unknown or out of range.
    """
    file = _file(section)
    suffix = PurePath(file).suffix.lower()
    kind = section.choice("format", {*KINDS.values(), *READERS}, KINDS.get(suffix) or SUFFIXES.get(suffix))
    if kind is None:
        raise section.error("cannot tell the format from the file's name", "file", file, _format_hint(suffix))
    numbers = _take_numbers(section, kind) if kind in READERS else _table_numbers(section, kind)
    source = Source(
        name,
        file,
        kind,
        *numbers,
        frame=read_frame(section),
        names=_names(section),
        missing=_missing(section),
        smooth_s=section.number("smooth_s", 0.0, least=0.0, most=1.0),
    )
    section.done()
    return source


Numbers = tuple[TableFormat, Clock, Columns, Rotation | None, Confidence | None]
"""How to take a file apart, and where times, positions, orientations and confidence stand in it."""


def _table_numbers(section: TomlTable, kind: str) -> Numbers:
    """Of a table, as the mapping says."""
    return (
        _table(section),
        _clock(section),
        read_columns(section, "position", "xyz", ["x", "y", "z"] if kind == "csv" else [0, 1, 2]),
        _rotation(section.table("rotation"), kind) if "rotation" in section else None,
        _confidence(section.table("confidence")) if "confidence" in section else None,
    )


def _take_numbers(section: TomlTable, kind: str) -> Numbers:
    """Of a format that says itself where its numbers stand."""
    confidence = None
    if "confidence" in section:
        table = section.table("confidence")
        confidence = Confidence(CONFIDENCE, table.number("least"))
        table.done()
    clock = Clock(column=TIME, offset_s=section.number("offset_s", 0.0))
    return TableFormat(), clock, POSITION, ROTATION if READERS[kind].oriented else None, confidence


def _format_hint(suffix: str) -> str:
    return CONVERSIONS.get(suffix, f'add format = "csv" (known: {", ".join(sorted({*KINDS.values(), *READERS}))})')


def _file(section: TomlTable) -> str:
    file: str = section.text("file")
    for placeholder in re.findall(r"\{(\w*)\}", file):
        if placeholder not in {"person", "point"}:
            hint = f'add [parameters] with {placeholder} = "..." (known: person, point)'
            raise section.error(f"nothing fills {{{placeholder}}}", "file", file, hint)
    return file


def _table(section: TomlTable) -> TableFormat:
    where = section.table("where").values.items()
    return TableFormat(
        delimiter=_delimiter(section),
        header=section.flag("header", False) if "header" in section else None,
        skip_rows=section.integer("skip_rows", 0),
        comment=section.any("comment", "#"),
        decimal=section.choice("decimal", {".", ","}, "."),
        where=tuple((column, str(value)) for column, value in where),
        array=section.text("array", None),
        layout=_layout(section, "layout"),
    )


def _delimiter(section: TomlTable) -> str | None:
    delimiter: str | None = section.text("delimiter", None)
    if delimiter is not None and delimiter != "whitespace" and len(delimiter) != 1:
        raise section.error("must be one character", "delimiter", delimiter, 'or "whitespace" for runs of blanks')
    return delimiter


def _layout(section: TomlTable, key: str) -> tuple[Name, ...]:
    layout = section.any(key, [])
    words = {"time", "value", "{person}", "{point}"}
    good = isinstance(layout, list) and all(
        item in words if isinstance(item, str) else isinstance(item, int) and not isinstance(item, bool)
        for item in layout
    )
    if not good or (layout and layout.count("time") != 1):
        hint = 'name every axis of the array, "time" once: ["time", "{person}", "{point}", "value"], or an index'
        raise section.error("does not describe the axes of an array", key, layout, hint)
    return tuple(layout)


def _clock(section: TomlTable) -> Clock:
    offset_s = section.number("offset_s", 0.0)
    rate_hz = section.number("rate_hz", None, least=0.1, most=10_000)
    if "time" not in section:
        if rate_hz is None:
            hint = 'add time = { column = "t", unit = "ms" }, or rate_hz = 120 where rows have no time'
            raise section.error("the source has neither a time column nor a rate", "time", hint=hint)
        return Clock(rate_hz=rate_hz, offset_s=offset_s)
    if rate_hz is not None:
        raise section.error("the source has both a time and a rate", "rate_hz", rate_hz, "keep one of them")
    time = section.table("time")
    unit_s = TIME_UNITS_S[time.choice("unit", TIME_UNITS_S)]
    column = read_column(time, "column")
    repeated = time.choice("repeated", {"first", "last"}) if "repeated" in time else None
    time.done()
    return Clock(column=column, unit_s=unit_s, offset_s=offset_s, repeated=repeated)


def _rotation(section: TomlTable, table: str) -> Rotation:
    if "array" in section and table not in ("npz", "mat"):
        hint = "name its columns, as columns = [...]: only NPZ and MAT files hold several arrays"
        raise section.error("this source has no arrays", "array", section.any("array"), hint)
    kind = section.choice("kind", {*ROTATION_LETTERS, "euler_intrinsic", "euler_extrinsic"})
    euler = kind.startswith("euler")
    order = section.text("order") if euler else ""
    if euler and (len(order) != 3 or set(order.lower()) - set("xyz")):
        raise section.error("is no order of three axes", "order", order, 'give one such as "zyx"')
    angular = euler or kind == "rotation_vector"
    unit_rad = ANGLE_UNITS_RAD[section.choice("unit", ANGLE_UNITS_RAD)] if angular else 1.0
    columns = read_columns(section, "columns", order.lower() if euler else ROTATION_LETTERS[kind])
    identity_is_lost = section.flag("identity_is_lost", False) if "identity_is_lost" in section else None
    array = section.text("array", None)
    section.done()
    return Rotation(columns, kind, order.lower(), unit_rad, identity_is_lost, array)


def _confidence(section: TomlTable) -> Confidence:
    confidence = Confidence(read_column(section, "column"), section.number("least"))
    section.done()
    return confidence


def _names(section: TomlTable) -> tuple[str, ...]:
    names = section.texts("names")
    if len(set(names)) < len(names):
        raise section.error("holds a name twice", "names", list(names))
    return names


def _missing(section: TomlTable) -> tuple[float, ...] | None:
    if "missing" not in section:
        return None
    value = section.any("missing")
    values = value if isinstance(value, list) else [value]
    if not all(map(is_finite_number, values)):
        hint = "give a number that stands for it, such as 0 or -9999 (empty cells and NaN always do)"
        raise section.error("must be a number, or a list of numbers", "missing", value, hint)
    return tuple(float(item) for item in values)


# --- Reads a mapping file: every section once, in the order of ``docs/howto/import.md``.

_SECTIONS = ("about", "time", "sources", "people", "robots", "objects", "supports", "signals", "label")


def load_mapping(
    path: str | Path,
    *,
    data_dir: str | Path | None = None,
    parameters: AnyMapping[str, str] | None = None,
) -> ImportMapping:
    """Read a mapping file; the tables that it names are not opened yet.

    Args:
        path: The TOML file.
        data_dir: Folder at which its relative file names start; default: the folder of the mapping.
        parameters: Values of its [parameters].

    Raises:
        MappingError: The file is missing or no TOML; a field is missing, unknown or out of range.
        UnknownNameError: A source, landmark, part or parameter that does not exist.
        LabelError: The label contradicts itself.
    """
    file = Path(path)
    base = file.parent if data_dir is None else Path(data_dir)
    document, text, files = read_document(file, parameters or {})
    top = TomlTable(document, Document(file, MappingError, "docs/howto/import.md", largest=math.inf))
    top.only(_SECTIONS)
    sources = {name: read_source(name, section) for name, section in top.tables_by_name("sources").items()}
    about = top.table("about")
    people = {name: read_person(name, section, sources) for name, section in top.tables_by_name("people").items()}
    sources = _named_points(top, sources, people)
    robots = {
        name: read_robot(name, section, sources, file.parent) for name, section in top.tables_by_name("robots").items()
    }
    things = {name: read_thing(name, section, sources, base) for name, section in top.tables_by_name("objects").items()}
    mapping = ImportMapping(
        name=about.text("name", clean_name(file.stem) or "recording"),
        file=file,
        files=files,
        data_dir=base,
        about=_about(about, text),
        timeline=_timeline(top.table("time")),
        sources=tuple(sources.values()),
        people=tuple(people.values()),
        objects=tuple(things.values()),
        supports=tuple(read_support(name, section) for name, section in top.tables_by_name("supports").items()),
        signals=tuple(_signal(name, section, sources) for name, section in top.tables_by_name("signals").items()),
        label=_label(top.table("label"), [*people, *robots], things) if "label" in top else None,
        robots=tuple(robots.values()),
    )
    _check_whole(top, mapping)
    return mapping


def _named_points(top: TomlTable, sources: dict[str, Source], people: AnyMapping[str, Person]) -> dict[str, Source]:
    """The sources, those that list no names with the names of the skeleton that is mapped from them."""
    named = dict(sources)
    for person in people.values():
        for ref in (ref for point in person.points if point.landmark in person.preset for ref in point.refs):
            names = SKELETONS[person.skeleton].names
            if not sources[ref.source].names and named[ref.source].names not in ((), names):
                hint = "list the source's names: names = [...]"
                raise top.error("two skeletons are mapped from one source", f"sources.{ref.source}.names", hint=hint)
            named[ref.source] = replace(sources[ref.source], names=sources[ref.source].names or names)
    return named


def _about(section: TomlTable, text: str) -> Provenance:
    about = Provenance(
        source=section.text("source", ""),
        licence=section.text("licence", ""),
        citation=section.text("citation", ""),
        simulated=section.flag("simulated", False),
        notes=section.texts("notes"),
        mapping=text,
    )
    section.done()
    return about


def _timeline(section: TomlTable) -> Timeline:
    timeline = Timeline(
        rate_hz=section.number("rate_hz", 30.0, least=1.0, most=1000.0),
        max_gap_s=section.number("max_gap_s", 0.2, least=0.0),
        start_s=section.number("start_s", None),
        end_s=section.number("end_s", None),
    )
    section.done()
    if timeline.start_s is not None and timeline.end_s is not None and timeline.end_s <= timeline.start_s:
        raise section.error("ends before it starts", "end_s", timeline.end_s, "give a time after start_s")
    return timeline


def _signal(name: str, section: TomlTable, sources: Collection[str]) -> SignalColumn:
    source = section.text("source")
    if source not in sources:
        raise UnknownNameError("source", str(source), sources, where=f"{section.place}.source")
    column = section.any("column")
    if isinstance(column, bool) or not isinstance(column, str | int):
        raise section.error("must be a column's name, or its index from 0", "column", column)
    signal = SignalColumn(name, source, column, section.number("scale", 1.0), section.text("unit", ""))
    section.done()
    return signal


def _label(section: TomlTable, people: Collection[str], objects: Collection[str]) -> Label:
    try:
        label = Label(
            task=section.any("task"),
            performing_agent=section.any("performing_agent"),
            target_agents=section.any("target_agent", None),
            target_objects=section.any("target_object"),
            start_s=section.any("start_s"),
            end_s=section.any("end_s"),
            how=section.text("how", "set in the mapping file"),
        )
        label.check(agents=people, objects=objects)
    except InputError as problem:
        problem.where = problem.where or section.place
        raise
    section.done()
    return label


OF_THE_ROOM = ("world", "floor")
"""Names that the imported room gives to parts of its own."""


def _check_whole(top: TomlTable, mapping: ImportMapping) -> None:
    if not mapping.people and not mapping.objects and not mapping.robots:
        raise top.error("the mapping brings in nobody and nothing", hint="add [people.NAME] and [objects.NAME]")
    names = [*(a.name for a in mapping.agents), *(t.name for t in mapping.objects), *(s.name for s in mapping.supports)]
    for name in names:
        if names.count(name) > 1:
            raise top.error("two of people, robots, objects and supports have the same name", value=name)
        if name in OF_THE_ROOM:
            raise top.error("the room itself has that name", value=name, hint="name it otherwise")
        if not name.replace("_", "").replace("-", "").isalnum():
            raise top.error("a name must consist of letters, digits, - and _", value=name)
