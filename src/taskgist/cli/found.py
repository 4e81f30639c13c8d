"""Which files a command line means: names, folders, and patterns."""

from __future__ import annotations

import errno
import os
from collections.abc import Sequence
from glob import glob, has_magic
from pathlib import Path

from taskgist.errors import InputError, RecordingError


def files(given: Sequence[Path], *, suffix: str = "", each_by_itself: bool = False) -> list[Path]:
    """The files that are meant, each once: as named, and those that match patterns such as ``takes/*.c3d``, by name.

    Shells write such patterns out; where they do not (in quotes, or on Windows) it is done here.

    Args:
        given: Names and patterns.
        suffix: With one, such as ".mcap", a folder stands for all files below it whose names end so.
        each_by_itself: Whether one that is not there keeps nobody from the others: whoever reads it says so.

    Raises:
        InputError: Nothing matches a pattern, or one of several is not there.
        RecordingError: A folder holds no such file.
    """
    found = list(dict.fromkeys(path for name in given for path in _meant(name, suffix)))
    lost = next((path for path in found if not os.path.lexists(path)), None)
    if lost is not None and len(found) > 1 and not each_by_itself:  # of one file, whoever reads it says so
        reason = f"cannot be read: {os.strerror(errno.ENOENT)}"
        raise InputError(reason, where=lost, hint="check the path; nothing was done with the others")
    return found


def _meant(name: Path, suffix: str) -> list[Path]:
    if suffix and name.is_dir():
        inside = sorted(name.rglob(f"*{suffix}"))
        if not inside:
            hint = "name a recording, or a folder that holds some"
            raise RecordingError(f"no recordings (*{suffix}) in this folder", where=name, hint=hint)
        return inside
    if name.exists() or not has_magic(str(name)):
        return [name]
    matching = matches(str(name))
    if not matching:
        raise InputError("no file matches", where=name, hint="check the folder and the end of the name")
    return matching


def matches(pattern: str) -> list[Path]:
    """Files and folders that match a pattern, by name."""
    return [Path(name) for name in sorted(glob(pattern, recursive=True))]  # noqa: PTH207 - absolute ones, too
