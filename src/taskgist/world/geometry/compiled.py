"""Compiled functions: loops over rays and shapes that numpy can only do by way of large arrays.

Numba translates them at their first call and keeps the result beside the source, or in the user's cache folder; a
change of the source makes it anew. What is decorated is plain Python all the same: it can be read, and run, as such.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import ParamSpec, TypeVar, cast

import numba

P = ParamSpec("P")
R = TypeVar("R")


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """Let numba compile a function when it is first called; division by zero gives infinity, as in numpy."""
    return cast(Callable[P, R], numba.njit(cache=True, error_model="numpy")(function))
