"""Compiled functions: loops over rays and shapes that numpy can only do by way of large arrays.

Numba translates them at their first call and keeps the result beside the source, or in the user's cache folder; a
change of any source that holds compiled functions makes them anew. What is decorated is plain Python all the same: it
can be read, and run, as such.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import ParamSpec, TypeVar, cast

import numba
from numba.core import event

P = ParamSpec("P")
R = TypeVar("R")
PACKAGE = Path(__file__).parents[1]
MARK = b"@compiled"
IMPORT = re.compile(rb"^from taskgist\.([\w.]+) import", re.MULTILINE)


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """Let numba compile a function when it is first called; division by zero gives infinity, as in numpy."""
    dispatcher = numba.njit(cache=True, error_model="numpy")(function)
    file = getattr(getattr(dispatcher, "_cache", None), "_cache_file", None)
    if file is not None:  # numba looks at the function's own file only, not at those of what it calls
        file._source_stamp = _stamp_of_sources()
    return cast(Callable[P, R], dispatcher)


class _Once(event.Listener):
    """Calls somebody at the first of some events."""

    def __init__(self, tell: Callable[[], None]) -> None:
        self._tell: Callable[[], None] | None = tell

    def on_start(self, event: event.Event) -> None:  # noqa: ARG002 - as numba calls it
        """Tell, and forget."""
        tell, self._tell = self._tell, None
        if tell is not None:
            tell()

    def on_end(self, event: event.Event) -> None:
        """Nothing."""


def when_compiling(tell: Callable[[], None]) -> None:
    """Have somebody told, once, that functions must be compiled before the work goes on: it takes a while."""
    event.register("numba:compile", _Once(tell))  # type: ignore[no-untyped-call]


@lru_cache(maxsize=1)
def _stamp_of_sources() -> str:
    """Digest of all sources of the package that hold compiled functions, or from which these take constants."""
    texts = {path: path.read_bytes() for path in sorted(PACKAGE.rglob("*.py"))}
    holders = [path for path, text in texts.items() if MARK in text]
    imported = {PACKAGE.joinpath(*name.decode().split(".")) for path in holders for name in IMPORT.findall(texts[path])}
    counted = {*holders, *(path.with_suffix(".py") for path in imported)}
    digest = hashlib.sha256()
    for path, text in texts.items():
        if path in counted:
            digest.update(text)
    return digest.hexdigest()
