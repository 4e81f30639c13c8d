"""Names of columns, as a mapping gives them: a list, a template over the axes, or a block per point."""

from __future__ import annotations

from taskgist.recording.mapping.section import Section
from taskgist.recording.mapping.source_model import Columns, Name


def read_columns(section: Section, key: str, letters: str, default: object = None) -> Columns:
    """As many columns as there are letters; ``{axis}`` in a template stands for each letter in turn."""
    value = section.any(key) if default is None else section.any(key, default)
    if isinstance(value, dict):
        return _block(section.section(key), len(letters))
    if isinstance(value, str):
        if "{axis}" not in value and "{AXIS}" not in value:
            hint = f'write it as "{{point}}_{{axis}}", or list the {len(letters)} columns'
            raise section.error("one text must hold {axis}", key, value, hint)
        value = [value.replace("{axis}", letter).replace("{AXIS}", letter.upper()) for letter in letters]
    good = isinstance(value, list) and len(value) == len(letters) and all(map(is_column, value))
    if not good:
        hint = "names, or indices from 0"
        raise section.error(f"must list {len(letters)} columns", key, value, hint)
    return Columns(tuple(value))


def _block(section: Section, count: int) -> Columns:
    first = section.integer("first")
    step = section.integer("step", 0)
    section.done()
    return Columns(tuple(range(first, first + count)), step)


def read_column(section: Section, key: str) -> Name:
    """One column, by name or index."""
    value = section.any(key)
    if not is_column(value):
        raise section.error("must be a column's name, or its index from 0", key, value)
    name: Name = value
    return name


def is_column(value: object) -> bool:
    """Whether a TOML value can name a column."""
    return (isinstance(value, str) and value != "") or (
        isinstance(value, int) and not isinstance(value, bool) and value >= 0
    )
