"""The [sources.NAME] tables: how numbers are found in files, and what they mean."""

from __future__ import annotations

import math
import re
from pathlib import PurePath

from taskgist.recording.mapping.columns import read_column, read_columns
from taskgist.recording.mapping.frames import read_frame
from taskgist.recording.mapping.section import Section, is_number
from taskgist.recording.mapping.source_model import Clock, Confidence, Name, Rotation, Source, TableFormat

TIME_UNITS_S = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
ANGLE_UNITS_RAD = {"deg": math.pi / 180.0, "rad": 1.0}
KINDS = {".csv": "csv", ".tsv": "csv", ".txt": "csv", ".npz": "npz", ".npy": "npy"}
ROTATION_LETTERS = {"xyzw": "xyzw", "wxyz": "wxyz", "rotation_vector": "xyz", "matrix": "012345678"}


def read_source(name: str, section: Section) -> Source:
    """One source, checked as far as that goes without its files.

    Raises:
        MappingError: A field is missing, unknown or out of range.
    """
    file = _file(section)
    kind = section.choice("format", {"csv", "npz", "npy"}, KINDS.get(PurePath(file).suffix.lower()))
    if kind is None:
        raise section.error("cannot tell the format from the file's name", "file", file, 'add format = "csv"')
    source = Source(
        name=name,
        file=file,
        kind=kind,
        table=_table(section),
        clock=_clock(section),
        position=read_columns(section, "position", "xyz", ["x", "y", "z"] if kind == "csv" else [0, 1, 2]),
        rotation=_rotation(section.section("rotation")) if "rotation" in section else None,
        confidence=_confidence(section.section("confidence")) if "confidence" in section else None,
        frame=read_frame(section),
        names=_names(section),
        missing=_missing(section),
        smooth_s=section.number("smooth_s", 0.0, least=0.0, most=1.0),
    )
    section.done()
    return source


def _file(section: Section) -> str:
    file: str = section.text("file")
    for placeholder in re.findall(r"\{(\w*)\}", file):
        if placeholder not in {"person", "point"}:
            hint = f'add [parameters] with {placeholder} = "..." (known: person, point)'
            raise section.error(f"nothing fills {{{placeholder}}}", "file", file, hint)
    return file


def _table(section: Section) -> TableFormat:
    where = section.section("where").values.items()
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


def _delimiter(section: Section) -> str | None:
    delimiter: str | None = section.text("delimiter", None)
    if delimiter is not None and delimiter != "whitespace" and len(delimiter) != 1:
        raise section.error("must be one character", "delimiter", delimiter, 'or "whitespace" for runs of blanks')
    return delimiter


def _layout(section: Section, key: str) -> tuple[Name, ...]:
    layout = section.any(key, [])
    words = {"time", "value", "{person}", "{point}"}
    good = isinstance(layout, list) and all(
        item in words or (isinstance(item, int) and not isinstance(item, bool)) for item in layout
    )
    if not good or (layout and layout.count("time") != 1):
        hint = 'name every axis of the array, "time" once: ["time", "{person}", "{point}", "value"], or an index'
        raise section.error("does not describe the axes of an array", key, layout, hint)
    return tuple(layout)


def _clock(section: Section) -> Clock:
    offset_s = section.number("offset_s", 0.0)
    rate_hz = section.number("rate_hz", None, least=0.1, most=10_000)
    if "time" not in section:
        if rate_hz is None:
            hint = 'add time = { column = "t", unit = "ms" }, or rate_hz = 120 where rows have no time'
            raise section.error("the source has neither a time column nor a rate", "time", hint=hint)
        return Clock(rate_hz=rate_hz, offset_s=offset_s)
    if rate_hz is not None:
        raise section.error("the source has both a time and a rate", "rate_hz", rate_hz, "keep one of them")
    time = section.section("time")
    unit_s = TIME_UNITS_S[time.choice("unit", TIME_UNITS_S)]
    column = read_column(time, "column")
    time.done()
    return Clock(column=column, unit_s=unit_s, offset_s=offset_s)


def _rotation(section: Section) -> Rotation:
    kind = section.choice("kind", {*ROTATION_LETTERS, "euler_intrinsic", "euler_extrinsic"})
    euler = kind.startswith("euler")
    order = section.text("order") if euler else ""
    if euler and (len(order) != 3 or set(order.lower()) - set("xyz")):
        raise section.error("is no order of three axes", "order", order, 'give one such as "zyx"')
    angular = euler or kind == "rotation_vector"
    unit_rad = ANGLE_UNITS_RAD[section.choice("unit", ANGLE_UNITS_RAD)] if angular else 1.0
    columns = read_columns(section, "columns", order.lower() if euler else ROTATION_LETTERS[kind])
    section.done()
    return Rotation(columns, kind, order.lower(), unit_rad)


def _confidence(section: Section) -> Confidence:
    confidence = Confidence(read_column(section, "column"), section.number("least"))
    section.done()
    return confidence


def _names(section: Section) -> tuple[str, ...]:
    names = section.any("names", [])
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise section.error("must be a list of texts", "names", names)
    if len(set(names)) < len(names):
        raise section.error("holds a name twice", "names", names)
    return tuple(names)


def _missing(section: Section) -> tuple[float, ...] | None:
    if "missing" not in section:
        return None
    value = section.any("missing")
    values = value if isinstance(value, list) else [value]
    if not all(map(is_number, values)):
        hint = "give a number that stands for it, such as 0 or -9999 (empty cells and NaN always do)"
        raise section.error("must be a number, or a list of numbers", "missing", value, hint)
    return tuple(float(item) for item in values)
