"""Who is told that functions are compiled: a file of its own, so that a command line can ask before numba is loaded."""

from __future__ import annotations

from collections.abc import Callable

Tell = Callable[[bool], None]
"""Is told whether what is compiled can be kept for the next run."""

_waiting: list[Tell] = []


def when_compiling(tell: Tell) -> None:
    """Have somebody told, once, that functions must be compiled before the work goes on: it takes a while."""
    _waiting[:] = [tell]


def compiling(*, kept: bool) -> None:
    """Tell, and forget, who waits.

    Args:
        kept: Whether what is compiled can be kept for the next run.
    """
    while _waiting:
        _waiting.pop()(kept)
