"""Compressed JSON documents, from anybody: unpacked up to a limit, and taken apart without a traceback."""

from __future__ import annotations

import gzip
import json
import zlib
from pathlib import Path
from typing import Any

from taskgist.common.files import reading
from taskgist.errors import InputError


def read_packed_json(
    path: Path, *, most_bytes: int, problem: str, hint: str, error: type[InputError] = InputError
) -> dict[str, Any]:
    """The object in a ``.json.gz`` file.

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
    with reading(path, error=error, hint=hint) as stream:
        try:
            text = gzip.GzipFile(fileobj=stream).read(most_bytes + 1)
            document = json.loads(text) if len(text) <= most_bytes else None
        except (gzip.BadGzipFile, EOFError, zlib.error, ValueError, RecursionError) as cause:
            raise error(f"{problem}: {type(cause).__name__}: {cause}", where=path, hint=hint) from cause
    if len(text) > most_bytes:
        limit = f"at most {most_bytes:,} bytes are unpacked (setting limits.document_bytes)"
        raise error(f"{problem}: it is too large", where=path, hint=limit)
    if not isinstance(document, dict):
        raise error(f"{problem}: no object", where=path, value=document, hint=hint)
    return document
