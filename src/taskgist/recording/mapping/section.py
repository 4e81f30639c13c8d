"""One table of a mapping file: hands out typed values, and refuses what nobody asked for."""

from __future__ import annotations

import math
import sys
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path
from typing import Any

from taskgist.errors import MappingError, nearest

_REQUIRED: Any = object()


class Section:
    """A TOML table while it is being read.

    Every getter takes a key and checks its type; ``done`` then refuses each key that was never asked for, with the
    nearest one that was. All errors name the mapping file, the field and the value.

    Args:
        values: The table.
        file: The mapping file, for messages.
        path: Dotted name of the table in the file, for messages.
    """

    def __init__(self, values: Mapping[str, Any], file: Path, path: str = "") -> None:
        self.values = dict(values)
        self.file = file
        self.path = path
        self._asked: set[str] = set()

    def __contains__(self, key: str) -> bool:
        self._asked.add(key)
        return key in self.values

    def error(self, problem: str, key: str = "", value: object = None, hint: str | None = None) -> MappingError:
        """The error to raise about one of the table's fields."""
        field = ".".join(part for part in (self.path, key) if part)
        return MappingError(problem, where=self.file, field=field, value=value, hint=hint)

    def any(self, key: str, default: Any = _REQUIRED) -> Any:
        """The value as it stands."""
        if key in self:
            return self.values[key]
        if default is _REQUIRED:
            raise self.error("is missing", key, hint=f"add {key} = ... (see docs/import.md)")
        return default

    def text(self, key: str, default: Any = _REQUIRED) -> Any:
        """A string that is not empty, or the default."""
        value = self.any(key, default)
        if value is not default and (not isinstance(value, str) or not value):
            raise self.error("must be a text", key, value, 'write it in quotes, as "..."')
        return value

    def flag(self, key: str, default: bool) -> bool:
        """True or false."""
        value = self.any(key, default)
        if not isinstance(value, bool):
            raise self.error("must be true or false", key, value)
        return value

    def choice(self, key: str, choices: Iterable[str], default: Any = _REQUIRED) -> Any:
        """One of several words, or the default."""
        value = self.any(key, default)
        known = sorted(choices)
        if value is not default and value not in known:
            near = nearest(str(value), known)
            guess = f"did you mean {near!r}? " if near else ""
            raise self.error("is none of the choices", key, value, f"{guess}(known: {', '.join(known)})")
        return value

    def number(self, key: str, default: Any = _REQUIRED, *, least: float = -math.inf, most: float = math.inf) -> Any:
        """A finite number within limits, or the default."""
        value = self.any(key, default)
        if value is default:
            return value
        if not is_number(value):
            raise self.error("must be a number", key, value)
        if not least <= value <= most:
            raise self.error("is out of range", key, value, f"give a number {_limits(least, most)}")
        return float(value)

    def integer(self, key: str, default: Any = _REQUIRED, *, least: int = 0) -> Any:
        """A whole number, or the default."""
        value = self.number(key, default, least=least)
        if value is not default and value != int(value):
            raise self.error("must be a whole number", key, value)
        return value if value is default else int(value)

    def vector(self, key: str, length: int, default: Any = _REQUIRED, *, least: float = -math.inf) -> Any:
        """A tuple of finite numbers, or the default."""
        value = self.any(key, default)
        if value is default:
            return value
        if not isinstance(value, list) or len(value) != length or not all(map(is_number, value)):
            raise self.error(f"must be a list of {length} numbers", key, value)
        if min(value) < least:
            raise self.error("is out of range", key, value, f"give numbers {_limits(least, math.inf)}")
        return tuple(float(item) for item in value)

    def section(self, key: str) -> Section:
        """The table under a key; empty if there is none."""
        value = self.any(key, {})
        path = f"{self.path}.{key}" if self.path else key
        if not isinstance(value, dict):
            raise self.error("must be a table", key, value, f"write [{path}], or {key} = {{ ... }}")
        return Section(value, self.file, path)

    def sections(self, key: str) -> dict[str, Section]:
        """The named tables under a key, such as every [people.NAME]."""
        parent = self.section(key)
        return {name: parent.section(name) for name in parent.values}

    def done(self) -> None:
        """Refuse the keys that were never asked for.

        Raises:
            MappingError: There is one.
        """
        self.only(self._asked)

    def only(self, known: Collection[str]) -> None:
        """Refuse keys that are not among these.

        Raises:
            MappingError: There is one.
        """
        for key in sorted(self.values.keys() - set(known)):
            near = nearest(key, known)
            guess = f"did you mean {near!r}? " if near else ""
            raise self.error("no such field", key, self.values[key], f"{guess}(known: {', '.join(sorted(known))})")


def is_number(value: object) -> bool:
    """Whether a TOML value is a finite number (true and false are not, nor is an integer beyond all floats)."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) < sys.float_info.max if isinstance(value, int) else math.isfinite(value)


def _limits(least: float, most: float) -> str:
    if math.isinf(most):
        return f"of at least {least:g}"
    return f"between {least:g} and {most:g}"
