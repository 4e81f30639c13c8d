"""Compiled functions: loops over rays and shapes that numpy can only do by way of large arrays.

Numba translates them at their first call and keeps the result beside the source, or in the user's cache folder; a
change of any source that holds compiled functions makes them anew. What is decorated is plain Python all the same: it
can be read, and run, as such.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import ParamSpec, TypeVar, cast

import numba

P = ParamSpec("P")
R = TypeVar("R")
PACKAGE = Path(__file__).parents[2]
MARK = b"@compiled"


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """Let numba compile a function when it is first called; division by zero gives infinity, as in numpy."""
    dispatcher = numba.njit(cache=True, error_model="numpy")(function)
    if hasattr(dispatcher, "_cache"):  # numba looks at the function's own file only, not at those of what it calls
        dispatcher._cache._cache_file._source_stamp = _stamp_of_sources()
    return cast(Callable[P, R], dispatcher)


@lru_cache(maxsize=1)
def _stamp_of_sources() -> str:
    """Digest of all sources of the package that hold compiled functions."""
    digest = hashlib.sha256()
    for path in sorted(PACKAGE.rglob("*.py")):
        text = path.read_bytes()
        if MARK in text:
            digest.update(text)
    return digest.hexdigest()
