"""Reading TOML, with errors that name file, field, value and the way out: scenes, profiles of bodies, mappings.

A ``TomlTable`` hands out typed values and refuses fields that are not known::

    table = TomlTable.parse(text, "room.toml", most_bytes=2**20).table("agents").table("P1")
    position_m = table.pair("position_m", (0.0, 0.0))  # a default makes a field optional
    profile = table.text("profile")
    table.done()  # refuses every field that was never asked for

``Attempts`` reads on after a mistake, so that a report names every one of them.
"""

from __future__ import annotations

import math
import sys
import tomllib
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from taskgist.common.text import COMMANDS, UNSEEN, fault_of_name
from taskgist.errors import InputError, SceneError, UnknownNameError, allowed_names, most_read

T = TypeVar("T")
REQUIRED: Any = object()
"""Stands for the default of a field that has none."""
UNREADABLE = ""
"""Stands for a name that could not be read: no document can give it, as texts are not empty."""
COUNTS = {2: "two", 3: "three", 4: "four"}


@dataclass(frozen=True)
class Document:
    """What the tables of a file have in common.

    Attributes:
        where: The file, for messages.
        error: The class of its errors.
        pages: The pages of the docs that show its fields.
        largest: No number in it is larger.
    """

    where: str | Path
    error: type[InputError] = SceneError
    pages: str = "docs/howto/scenes.md and docs/howto/bodies.md"
    largest: float = 1e6


def parse_toml(
    data: bytes | str, where: str | Path, error: type[InputError] = InputError, *, most_bytes: int
) -> dict[str, Any]:
    """What a TOML document holds.

    Args:
        data: The document; bytes are UTF-8.
        where: File for error messages.
        error: The class of the errors.
        most_bytes: The document may not be larger (setting ``limits.toml_bytes``).

    Raises:
        InputError: It is not TOML, nested too deep, or too large.
    """
    if len(data) > most_bytes:
        hint = most_read(most_bytes, "toml_bytes")
        raise error("is too large", where=where, value=f"{len(data):,} bytes", hint=hint)
    try:
        return tomllib.loads(data if isinstance(data, str) else data.decode("utf-8-sig"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as problem:
        raise error(f"not valid TOML: {problem}", where=where, hint="save it as TOML in UTF-8") from problem
    except ValueError:  # of Python's, about whole numbers of thousands of digits
        raise error("a number of too many digits", where=where, hint="give ordinary numbers") from None
    except RecursionError:
        raise error("nested too deep", where=where, hint="no field needs more than a few levels") from None


class TomlTable:
    """A table of a TOML document, with typed access.

    Every getter takes a key, and a default for where the table has no such field; without one it must be there. All
    errors name the file, the field and the value.

    Args:
        values: Its content.
        document: The file that it stands in.
        path: Dotted name of the table in the file, such as ``agents.P1``.
    """

    def __init__(self, values: Mapping[str, Any], document: Document, path: str = "") -> None:
        self.values = dict(values)
        self.document = document
        self.path = path
        self._asked: set[str] = set()
        for key in self.values:
            if fault := fault_of_name(key):
                raise self.error(f"a name that {fault}", value=key, hint="name it otherwise")

    @classmethod
    def parse(cls, data: bytes | str, where: str | Path, *, most_bytes: int) -> TomlTable:
        """The whole of a scene file or profile, of at most that size.

        Raises:
            SceneError: It is not TOML, or too large.
        """
        return cls(parse_toml(data, where, SceneError, most_bytes=most_bytes), Document(where))

    @property
    def place(self) -> str:
        """File and table, for messages."""
        return f"{self.document.where}: {self.path}" if self.path else str(self.document.where)

    def __contains__(self, key: str) -> bool:
        self._asked.add(key)
        return key in self.values

    def __iter__(self) -> Iterator[str]:
        return iter(self.values)

    def error(self, problem: str, key: str = "", value: object = None, hint: str | None = None) -> InputError:
        """The error to raise about one of the table's fields."""
        return self.document.error(
            problem, where=self.document.where, field=self.path_of(key) or None, value=value, hint=hint
        )

    def path_of(self, key: str) -> str:
        """Dotted name of a field in the file."""
        return ".".join(part for part in (self.path, key) if part)

    def any(self, key: str, default: Any = REQUIRED) -> Any:
        """The value as it stands."""
        if key in self:
            return self.values[key]
        if default is REQUIRED:
            raise self.error("is missing", key, hint=f"add {key} = ... (see {self.document.pages})")
        return default

    def text(self, key: str, default: T = REQUIRED) -> str | T:
        """A text that is not empty."""
        if key not in self and default is not REQUIRED:
            return default
        value = self.any(key)
        if not isinstance(value, str) or not value:
            raise self.error("must be a text", key, value, 'write it in quotes, as "..."')
        return self._printable(key, value)

    def name(self, key: str, default: T = REQUIRED) -> str | T:
        """A text of one line."""
        value = self.text(key, default)
        if isinstance(value, str) and UNSEEN.search(value):
            raise self.error("holds a control character", key, value, "leave it out")
        return value

    def texts(self, key: str) -> tuple[str, ...]:
        """A list of texts; empty where there is none."""
        value = self.any(key, [])
        if not isinstance(value, list) or not all(isinstance(text, str) for text in value):
            raise self.error("must be a list of texts", key, value, 'as ["...", "..."]')
        return tuple(self._printable(key, text) for text in value)

    def flag(self, key: str, default: bool) -> bool:
        """True or false."""
        value = self.any(key, default)
        if not isinstance(value, bool):
            raise self.error("must be true or false", key, value)
        return value

    def choice(self, key: str, choices: Iterable[str], default: T = REQUIRED) -> str | T:
        """One of several words."""
        if key not in self and default is not REQUIRED:
            return default
        value = self.any(key)
        known = sorted(choices)
        if value not in known:
            raise self.error("is none of the choices", key, value, allowed_names(value, known))
        return str(value)

    def number(self, key: str, default: T = REQUIRED, *, least: float = -math.inf, most: float = math.inf) -> float | T:
        """A finite number within limits."""
        if key not in self and default is not REQUIRED:
            return default
        value = self.any(key)
        if not self._is_number(value):
            raise self.error("must be a finite number", key, value)
        if not least <= value <= most:
            raise self.error("is out of range", key, value, f"give a number {_limits(least, most)}")
        return float(value)

    def integer(self, key: str, default: int = REQUIRED, *, least: int = 0) -> int:
        """A whole number."""
        value = self.number(key, default, least=least)
        if value != int(value):
            raise self.error("must be a whole number", key, value)
        return int(value)

    def pair(self, key: str, default: tuple[float, float] = REQUIRED) -> tuple[float, float]:
        """Two finite numbers."""
        first, second = self._numbers(key, 2, default)
        return first, second

    def triple(self, key: str, default: T = REQUIRED, *, least: float = -math.inf) -> tuple[float, float, float] | T:
        """Three finite numbers."""
        if key not in self and default is not REQUIRED:
            return default
        first, second, third = self._numbers(key, 3)
        if min(first, second, third) < least:
            hint = f"give numbers {_limits(least, math.inf)}"
            raise self.error("is out of range", key, self.values[key], hint)
        return first, second, third

    def quadruple(self, key: str) -> tuple[float, float, float, float]:
        """Four finite numbers."""
        first, second, third, fourth = self._numbers(key, 4)
        return first, second, third, fourth

    def table(self, key: str) -> TomlTable:
        """A table within; empty where there is none."""
        return self.inner(self.any(key, {}), key)

    def tables(self, key: str) -> tuple[TomlTable, ...]:
        """A list of tables within; empty where there is none."""
        value = self.any(key, [])
        if not isinstance(value, list):
            raise self.error("must be a list of tables", key, value, f"write [[{self.path_of(key)}]]")
        return tuple(self.inner(item, key) for item in value)

    def tables_by_name(self, key: str) -> dict[str, TomlTable]:
        """The named tables under a key, such as every [people.NAME]."""
        parent = self.table(key)
        return {name: parent.table(name) for name in parent}

    def inner(self, value: object, key: str) -> TomlTable:
        """A value that stands under a key, as a table."""
        path = self.path_of(key)
        if not isinstance(value, Mapping):
            raise self.error("must be a table", key, value, f"write [{path}], or {key} = {{ ... }}")
        return TomlTable(value, self.document, path)

    def done(self) -> None:
        """Refuse the fields that were never asked for.

        Raises:
            UnknownNameError: There is one.
        """
        self.only(self._asked)

    def only(self, known: Collection[str]) -> TomlTable:
        """The same table, refused if it has a field that is not known.

        Raises:
            UnknownNameError: There is one.
        """
        for key in self.values:
            if key not in known:
                place = f"{self.document.where}: [{self.path}]" if self.path else self.document.where
                raise UnknownNameError("field", key, known, where=place)
        return self

    def _printable(self, key: str, text: str) -> str:
        if COMMANDS.search(text):
            raise self.error("holds a control character", key, text, "leave it out")
        return text

    def _numbers(self, key: str, count: int, default: Any = REQUIRED) -> tuple[float, ...]:
        value = self.any(key, default)
        if not isinstance(value, list | tuple) or len(value) != count or not all(map(self._is_number, value)):
            raise self.error(f"must be {COUNTS[count]} finite numbers", key, value)
        return tuple(float(number) for number in value)

    def _is_number(self, value: object) -> bool:
        return is_finite_number(value) and abs(value) <= self.document.largest  # type: ignore[arg-type]


def is_finite_number(value: object) -> bool:
    """Whether a TOML value is a finite number (true and false are not, nor is an integer beyond all floats)."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) < sys.float_info.max if isinstance(value, int) else math.isfinite(value)


def _limits(least: float, most: float) -> str:
    if math.isinf(most):
        return f"of at least {least:g}"
    return f"between {least:g} and {most:g}"


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
