"""Reading TOML with errors that name file, field, value and the way out."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

from taskgist.errors import SceneError, UnknownNameError

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
            raise self.error("missing", key, hint="docs/scenes.md and docs/bodies.md show every field")
        return default


def is_number(value: object) -> bool:
    """Whether a value is a finite number of a size that a scene can have."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) <= LARGEST if isinstance(value, int) else math.isfinite(value) and abs(value) <= LARGEST
