"""JSON from elsewhere: finite numbers, each name once, not too deep, and unpacked up to a limit."""

from __future__ import annotations

import gzip
import json
import zlib
from pathlib import Path
from typing import Any, NoReturn

from taskgist.common.files import reading
from taskgist.errors import InputError, most_read

DEEPEST = 64
"""Lists and objects within each other, at most (ours: facts and recordings hold six)."""


class DocumentError(ValueError):
    """A text that is no JSON, or not of the kind that is read; its message is one clause."""


def parse_json(text: str | bytes, *, any_number: bool = False) -> Any:
    """The value of a JSON text.

    Args:
        text: The text.
        any_number: Let pass numbers that are not finite, which the caller refuses by name.

    Raises:
        DocumentError: It is no JSON (``NaN`` and ``Infinity`` are none), gives a name twice in one object, holds a
            number that is not finite or half of a character, or is nested deeper than ``DEEPEST``.
    """
    try:
        numbers: dict[str, Any] = {} if any_number else {"parse_constant": _no_number, "parse_float": _finite}
        value = json.loads(text, object_pairs_hook=_object, **numbers)
    except RecursionError as error:
        raise DocumentError(f"nested deeper than {DEEPEST}") from error
    except DocumentError:
        raise
    except ValueError as error:
        raise DocumentError(f"not JSON: {error}") from error
    _check_depth(value)
    if (b"\\u" if isinstance(text, bytes) else "\\u") in text:  # type: ignore[operator]  # both of one kind
        _check_characters(value)
    return value


def _no_number(constant: str) -> NoReturn:
    raise DocumentError(f"{constant} is no number")


def _finite(text: str) -> float:
    number = float(text)
    if number - number != 0.0:  # of infinity it is NaN
        raise DocumentError(f"{text[:20]} is no finite number")
    return number


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise DocumentError(f"{twice!r} is given twice")
    return found


def _check_depth(value: Any) -> None:
    """Level by level, so that no depth is too deep to be refused."""
    level = [value]
    for _ in range(DEEPEST + 1):
        level = [
            inner
            for each in level
            if isinstance(each, dict | list)
            for inner in (each.values() if isinstance(each, dict) else each)
            if isinstance(inner, dict | list)
        ]
        if not level:
            return
    raise DocumentError(f"nested deeper than {DEEPEST}")


def _check_characters(value: Any) -> None:
    """JSON can escape halves of characters, which no file, terminal or database takes."""
    try:
        json.dumps(value, ensure_ascii=False).encode("utf-8")
    except UnicodeEncodeError as error:
        half = error.object[error.start : error.end]
        raise DocumentError(f"a text that is no Unicode: {half!r}") from error


# --- Compressed documents.


def read_packed_json(
    path: Path, *, most_bytes: int, problem: str, hint: str, error: type[InputError] = InputError
) -> dict[str, Any]:
    """The object in a ``.json.gz`` file, which whoever reads it may write anew.

    Args:
        path: The file.
        most_bytes: What it may unpack to.
        problem: What is told where it is none: "not a pool".
        hint: The way out then.
        error: The class of the errors.

    Raises:
        InputError: It is no regular file, cannot be read, is damaged, too large, no JSON, nested too deep, or no
            object.
    """
    with reading(path, error=error, hint=hint, is_input=False) as stream:
        try:
            text = gzip.GzipFile(fileobj=stream).read(most_bytes + 1)
            document = parse_json(text) if len(text) <= most_bytes else None
        except (gzip.BadGzipFile, EOFError, zlib.error, ValueError) as cause:
            raise error(f"{problem}: {type(cause).__name__}: {cause}", where=path, hint=hint) from cause
    if len(text) > most_bytes:
        raise error(f"{problem}: it is too large", where=path, hint=most_read(most_bytes, "document_bytes"))
    if not isinstance(document, dict):
        raise error(f"{problem}: no object", where=path, value=document, hint=hint)
    return document
