"""One table of a mapping file: hands out typed values, and refuses what nobody asked for."""

from __future__ import annotations

import math
import sys
import tomllib
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, TypeVar

from taskgist.errors import InputError, MappingError, SceneError, UnknownNameError, nearest

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
            raise self.error("is missing", key, hint=f"add {key} = ... (see docs/howto/import.md)")
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
        if not is_finite_number(value):
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
        if not isinstance(value, list) or len(value) != length or not all(map(is_finite_number, value)):
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


def is_finite_number(value: object) -> bool:
    """Whether a TOML value is a finite number (true and false are not, nor is an integer beyond all floats)."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) < sys.float_info.max if isinstance(value, int) else math.isfinite(value)


def _limits(least: float, most: float) -> str:
    if math.isinf(most):
        return f"of at least {least:g}"
    return f"between {least:g} and {most:g}"


# --- Reading on after a mistake, so that a report names every one of them.

T = TypeVar("T")
UNREADABLE = ""
"""Stands for a name that could not be read: no document can give it, as texts are not empty."""


class Attempts:
    """Reads one field after the other and keeps what is wrong with them.

    Attributes:
        problems: Every mistake so far, in the order of reading.
    """

    def __init__(self) -> None:
        self.problems: list[InputError] = []

    def __call__(self, read: Callable[[], T], otherwise: T) -> T:
        """What ``read`` gives; where it fails, the mistake is kept and ``otherwise`` stands in."""
        try:
            return read()
        except InputError as error:
            self.problems.append(error)
            return otherwise


# --- Reading TOML with errors that name file, field, value and the way out.

LARGEST = 1e6
"""No number of a scene or profile is larger: metres, degrees, pixels."""


class TomlTable:
    """A table of a TOML document, with typed access.

    Args:
        values: Its content.
        where: File that it stands in, for messages.
        path: Name of the table in the file, such as ``agents.P1``.
    """

    def __init__(self, values: object, where: str | Path, path: str = "") -> None:
        if not isinstance(values, Mapping):
            raise SceneError("must be a table", where=where, field=path or None, value=values, hint=f"write [{path}]")
        self.values: Mapping[str, Any] = values
        self.where, self.path = where, path

    @classmethod
    def parse(cls, data: bytes | str, where: str | Path) -> TomlTable:
        """The whole of a TOML document.

        Raises:
            SceneError: It is not TOML.
        """
        try:
            return cls(tomllib.loads(data if isinstance(data, str) else data.decode("utf-8")), where)
        except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
            raise SceneError(f"not valid TOML: {error}", where=where, hint="save it as TOML in UTF-8") from error

    def __contains__(self, key: str) -> bool:
        return key in self.values

    def __iter__(self) -> Iterator[str]:
        return iter(self.values)

    def only(self, known: Collection[str]) -> TomlTable:
        """The same table, refused if it has a field that is not known."""
        for key in self.values:
            if key not in known:
                raise UnknownNameError("field", key, known, where=f"{self.where}: [{self.path}]")
        return self

    def text(self, key: str, default: str | None = None) -> str:
        """A text that is not empty."""
        value = self._get(key, default)
        if not isinstance(value, str) or not value:
            raise self.error("must be a text", key, value)
        return value

    def number(self, key: str, default: float | None = None) -> float:
        """A finite number."""
        value = self._get(key, default)
        if not is_number(value):
            raise self.error("must be a finite number", key, value)
        return float(value)

    def pair(self, key: str, default: tuple[float, float] | None = None) -> tuple[float, float]:
        """Two finite numbers."""
        first, second = self._numbers(key, default, 2, "two")
        return first, second

    def triple(self, key: str, default: tuple[float, float, float] | None = None) -> tuple[float, float, float]:
        """Three finite numbers."""
        first, second, third = self._numbers(key, default, 3, "three")
        return first, second, third

    def flag(self, key: str, *, default: bool) -> bool:
        """True or false."""
        value = self._get(key, default)
        if not isinstance(value, bool):
            raise self.error("must be true or false", key, value)
        return value

    def names(self, key: str) -> tuple[str, ...]:
        """A list of texts; empty where there is none."""
        value = self.values.get(key, ())
        if not isinstance(value, list | tuple) or not all(isinstance(name, str) for name in value):
            raise self.error("must be a list of names", key, value)
        return tuple(value)

    def table(self, key: str) -> TomlTable:
        """A table within; empty where there is none."""
        return TomlTable(self.values.get(key, {}), self.where, self._named(key))

    def tables(self, key: str) -> tuple[TomlTable, ...]:
        """A list of tables within; empty where there is none."""
        value = self.values.get(key, ())
        if not isinstance(value, list | tuple):
            raise self.error("must be a list of tables", key, value)
        return tuple(TomlTable(item, self.where, self._named(key)) for item in value)

    def error(self, problem: str, key: str, value: object = None, hint: str | None = None) -> SceneError:
        """An error about a field of this table."""
        return SceneError(problem, where=self.where, field=self._named(key), value=value, hint=hint)

    def _numbers(self, key: str, default: tuple[float, ...] | None, count: int, spelled: str) -> tuple[float, ...]:
        value = self._get(key, default)
        if not isinstance(value, list | tuple) or len(value) != count or not all(map(is_number, value)):
            raise self.error(f"must be {spelled} finite numbers", key, value)
        return tuple(float(number) for number in value)

    def _named(self, key: str) -> str:
        return f"{self.path}.{key}" if self.path else key

    def _get(self, key: str, default: Any) -> Any:
        if key in self.values:
            return self.values[key]
        if default is None:
            raise self.error("missing", key, hint="docs/howto/scenes.md and docs/howto/bodies.md show every field")
        return default


def is_number(value: object) -> bool:
    """Whether a value is a finite number of a size that a scene can have."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) <= LARGEST if isinstance(value, int) else math.isfinite(value) and abs(value) <= LARGEST
