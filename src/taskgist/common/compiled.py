"""Compiled functions: loops over rays and shapes that numpy can only do by way of large arrays.

Numba translates them at their first call and keeps the result beside the source, in the user's cache folder, or in a
temporary folder of the user's, whichever can be written to first; a change of any source that holds compiled functions
makes them anew. What is decorated is plain Python all the same: it can be read, and run, as such.
"""

from __future__ import annotations

import gc
import hashlib
import os
import re
import stat
import tempfile
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, ParamSpec, TypeVar, cast

import numba
from numba.core import event, types
from numba.core.caching import FunctionCache

from taskgist.common.compile_notice import compiling

P = ParamSpec("P")
R = TypeVar("R")
PACKAGE = Path(__file__).parents[1]
MARK = b"@compiled"
IMPORT = re.compile(rb"^from taskgist\.([\w.]+) import", re.MULTILINE)
OPTIONS: Mapping[str, Any] = {"error_model": "numpy", "no_cfunc_wrapper": True}
"""How numba compiles: without errors for a division by zero, and without the entry that only C code would use."""
_not_kept: list[str] = []
"""Functions whose machine code has nowhere to go."""


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """Let numba compile a function when it is first called; division by zero gives infinity, as in numpy."""
    return cast(Callable[P, R], _dispatcher(function))


def compiled_for_threads(function: Callable[P, R]) -> Callable[P, R]:
    """As ``compiled``, for long work: other threads run meanwhile, those that do another part of it among them."""
    return cast(Callable[P, R], _dispatcher(function, nogil=True))


def compiled_part(function: Callable[P, R]) -> Callable[P, R]:
    """As ``compiled``, for a function that only compiled ones call: it becomes part of each of these.

    That is faster to compile, and to run: a call of its own would count, for each array that is passed on, one more
    that holds it and one less, together longer than many a formula takes. It has no entry for Python, which checks and
    unpacks all arguments. Called from there it raises ``TypeError``; its ``py_func`` may be called.
    """
    dispatcher = _dispatcher(function, no_cpython_wrapper=True, forceinline=True)
    dispatcher._insert = _no_entry
    dispatcher._compile_for_args = partial(_refused, function.__qualname__)
    return cast(Callable[P, R], dispatcher)


def _dispatcher(function: Callable[..., Any], **options: Any) -> Any:
    """What numba makes of a function, with our cache."""
    dispatcher: Any = numba.njit(**OPTIONS, **options)(function)
    dispatcher.get_call_template = partial(_without_literals, dispatcher.get_call_template)
    try:
        dispatcher._cache = _MachineCode(function)
    except RuntimeError:  # neither the package's folder nor the user's cache folder can be written to
        folder = _own_temporary_folder()
        if folder is None:
            _not_kept.append(function.__qualname__)
        else:
            numba.config.CACHE_DIR = str(folder)  # type: ignore[attr-defined]
            dispatcher._cache = _MachineCode(function)
    return dispatcher


@lru_cache(maxsize=1)
def _own_temporary_folder() -> Path | None:
    """A folder for machine code that this user alone can write to: what is kept there will be run. None without one."""
    with suppress(OSError):
        folder = Path(tempfile.gettempdir()) / f"taskgist-{os.getuid()}"
        folder.mkdir(mode=0o700, exist_ok=True)
        found = folder.lstat()
        ours = stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid() and not found.st_mode & 0o022
        if ours and os.access(folder, os.W_OK | os.X_OK):
            return folder
    return None


def _no_entry(*_: Any) -> None:
    """Keep numba's table of entries for Python empty: it would jump to address 0."""


def _refused(name: str, *_: Any, **__: Any) -> None:
    raise TypeError(f"{name} has no entry for Python: mark it @compiled, or call its py_func")


def _without_literals(
    template: Callable[[tuple[Any, ...], dict[str, Any]], Any], args: tuple[Any, ...], kws: dict[str, Any]
) -> Any:
    """Let a call with a number that is written there, ``near(x, 0)``, share the machine code of all others.

    Numba would compile the function once more for each such number, and what it calls, too. Where a number known
    beforehand is worth it, LLVM finds out when it inlines.
    """
    plain: Callable[[Any], Any] = types.unliteral
    return template(tuple(map(plain, args)), {name: plain(kind) for name, kind in kws.items()})


class _MachineCode(FunctionCache):
    """What is kept of one function: as new as *all* our sources, and never the end of a run.

    Numba looks at the function's own file only, not at those of what it calls. And it unpickles what an earlier version
    left behind before it asks how old that is: a module that was moved since, or a file that was cut off, would end
    every command. Here what cannot be read is made anew, and what cannot be written is not kept.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)  # type: ignore[no-untyped-call]
        self._cache_file._source_stamp = _stamp_of_sources()

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Load what was kept for a signature; none if there is nothing, or nothing of use."""
        try:
            return super().load_overload(sig, target_context)  # type: ignore[no-untyped-call]
        except Exception:  # unpickling runs what was written: it may fail in any way
            with suppress(OSError):
                self.flush()  # type: ignore[no-untyped-call]  # or saving would read it once more
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep what was compiled for a signature."""
        with suppress(OSError):
            super().save_overload(sig, data)  # type: ignore[no-untyped-call]


class _Listener(event.Listener):
    """Says that something is compiled, and keeps the garbage collector away from it meanwhile.

    A compiler holds large graphs of small objects that all stay alive until it is done: to look through them again and
    again takes a fifth of the time.
    """

    def __init__(self) -> None:
        self._depth, self._collecting = 0, True

    def on_start(self, event: event.Event) -> None:  # noqa: ARG002 - as numba calls it
        """Begin: with the first of functions that call each other."""
        compiling(kept=not _not_kept)
        if self._depth == 0:
            self._collecting = gc.isenabled()
            gc.disable()
        self._depth += 1

    def on_end(self, event: event.Event) -> None:  # noqa: ARG002 - as numba calls it
        """End."""
        self._depth -= 1
        if self._depth == 0 and self._collecting:
            gc.enable()


event.register("numba:compile", _Listener())  # type: ignore[no-untyped-call]


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
