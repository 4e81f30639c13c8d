"""Files: what is written appears whole or not at all, and what is read is a regular file.

A new file is written as a *draft* beside its target, synced, and given its name at the end. While a process writes a
draft it holds a lock on it; a draft that nobody holds was left by a process that was killed, and the next that writes
the same target takes it away.

What is read in ``keeping_inputs`` is never overwritten there, by whatever name, and whatever is given.
"""

from __future__ import annotations

import errno
import fcntl
import os
import re
import secrets
import stat
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path
from typing import BinaryIO

from taskgist.errors import InputError, most_read

DRAFT = ".draft"
"""How the names of drafts end."""
LONGEST_NAME = 100
"""Bytes of a target's name in the name of its draft: file systems allow 255."""
KINDS = {
    stat.S_IFDIR: "a folder",
    stat.S_IFIFO: "a pipe",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFSOCK: "a socket",
}
_inputs: ContextVar[set[tuple[int, int]] | None] = ContextVar("inputs", default=None)
"""Device and inode of each file that was read, where inputs are kept."""


@contextmanager
def keeping_inputs() -> Iterator[None]:
    """Refuse to write what was read: the frame of a command."""
    token = _inputs.set(set())
    try:
        yield
    finally:
        _inputs.reset(token)


# --- Writing.


@contextmanager
def writing(target: Path, *, replace: bool, error: type[InputError] = InputError) -> Iterator[BinaryIO]:
    """A stream whose content gets the target's name when all went well, and vanishes otherwise.

    A link is followed: what it points to is written. A file that is replaced passes on its mode, and its owner where
    that is allowed; a new one has what the umask leaves.

    Args:
        target: The file to write; what it held stays until the new one is complete.
        replace: Whether a file that is there already may be replaced.
        error: The class of the errors.

    Raises:
        InputError: There is such a file, and it may not be replaced, or is an input; it is a folder, a device or a
            pipe; or it cannot be written: no such folder, no permission, a full disk.
    """
    try:
        final = target.resolve()
        before = _replaced(final, target, replace=replace, error=error)
        draft, stream = _draft(final)
    except (OSError, ValueError, RuntimeError) as problem:
        raise _unwritable(problem, target, error) from problem
    try:
        with stream:
            yield stream
            stream.flush()
            if before is not None:
                _pass_on(before, stream.fileno())
            os.fsync(stream.fileno())
            _name(draft, final, target, replace=replace, error=error)
    except OSError as problem:
        if problem.filename is not None and not str(problem.filename).startswith(str(draft)):
            raise  # about another file, of whoever writes
        raise _unwritable(problem, target, error) from problem
    finally:
        draft.unlink(missing_ok=True)
    _sync_folder(final.parent)


def check_replaceable(target: Path, *, replace: bool, error: type[InputError] = InputError) -> None:
    """Refuse a target that ``writing`` would refuse, before any long work.

    Raises:
        InputError: As ``writing``.
    """
    try:
        final = target.resolve()
        _replaced(final, target, replace=replace, error=error)
        if not os.access(final.parent, os.W_OK):
            final.parent.stat()
            raise PermissionError(errno.EACCES, "")
    except (OSError, ValueError, RuntimeError) as problem:
        raise _unwritable(problem, target, error) from problem


def check_no_input(target: Path, inputs: Iterable[Path], error: type[InputError] = InputError) -> None:
    """Refuse a target that is one of the files that will be read, by whatever name.

    Raises:
        InputError: It is.
    """
    for path in inputs:
        with suppress(OSError, ValueError):
            if path.samefile(target):
                raise _is_input(target, error)


def _is_input(target: Path, error: type[InputError]) -> InputError:
    return error("is read by the same command", where=target, hint="name another file to write")


def _replaced(final: Path, target: Path, *, replace: bool, error: type[InputError]) -> os.stat_result | None:
    """What is known of the file that is there; None if there is none."""
    try:
        found = final.stat()
    except FileNotFoundError:
        return None
    kind = KINDS.get(stat.S_IFMT(found.st_mode))
    if kind:
        raise error(f"cannot be written: it is {kind}", where=target, hint="name a file")
    if (found.st_dev, found.st_ino) in (_inputs.get() or ()):
        raise _is_input(target, error)
    if not replace:
        raise error("is there already", where=target, hint="name another file, or say that it may be replaced")
    return found


def _draft(final: Path) -> tuple[Path, BinaryIO]:
    """A new draft of a file, locked; those that nobody writes any longer are gone."""
    prefix = f".{os.fsencode(final.name)[:LONGEST_NAME].decode(errors='ignore')}."
    ours = re.compile(re.escape(prefix) + r"[0-9a-f]{12}" + re.escape(DRAFT))
    for left in final.parent.iterdir():
        if ours.fullmatch(left.name) and stat.S_ISREG(left.lstat().st_mode):
            with suppress(OSError), left.open("rb") as held:
                fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
                left.unlink()
    while True:
        draft = final.parent / f"{prefix}{secrets.token_hex(6)}{DRAFT}"
        stream = draft.open("xb")  # open for as long as the draft is written
        fcntl.flock(stream, fcntl.LOCK_EX)
        if _is_same(draft, stream):  # else another took it away before it was locked
            return draft, stream
        stream.close()


def _pass_on(before: os.stat_result, descriptor: int) -> None:
    """Give a file the mode and owner of the one that it replaces."""
    with suppress(PermissionError):
        os.fchown(descriptor, before.st_uid, before.st_gid)
    os.fchmod(descriptor, stat.S_IMODE(before.st_mode))


def _name(draft: Path, final: Path, target: Path, *, replace: bool, error: type[InputError]) -> None:
    """Give a draft its name, which, unless it may be replaced, nobody must have taken meanwhile."""
    if replace:
        draft.replace(final)
        return
    try:
        final.hardlink_to(draft)
    except FileExistsError:
        _replaced(final, target, replace=False, error=error)
        raise
    except OSError as problem:
        if problem.errno not in (errno.EPERM, errno.EOPNOTSUPP, errno.ENOSYS, errno.EMLINK):
            raise
        draft.replace(final)  # a file system without links


def _sync_folder(folder: Path) -> None:
    """Let a new name outlast a power failure, where folders can be synced."""
    with suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def _unwritable(problem: Exception, target: Path, error: type[InputError]) -> InputError:
    reason, hint = _reason(problem), "name a file in a folder that you may write to"
    number = problem.errno if isinstance(problem, OSError) else None
    if number in (errno.ENOSPC, errno.EDQUOT):
        hint = "free some space, or name a file on another disk"
    elif number == errno.ENAMETOOLONG:
        hint = "give it a shorter name"
    elif number in (errno.ENOENT, errno.ENOTDIR):
        reason = f"there is no folder {str(target.parent)!r}"
    elif number == errno.EROFS or (number in (errno.EACCES, errno.EPERM) and not os.access(target.parent, os.W_OK)):
        reason = f"the folder {str(target.parent)!r} is read-only"
    return error(f"cannot be written: {reason}", where=shown_path(target), hint=hint)


# --- Reading.


def is_file(path: Path) -> bool:
    """Whether a path names a regular file; a name that no file can have does not."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


@contextmanager
def reading(
    path: Path, *, error: type[InputError] = InputError, hint: str = "check the path", is_input: bool = True
) -> Iterator[BinaryIO]:
    """A regular file, open for reading; pipes, devices and folders are refused by name, without waiting for them.

    Args:
        path: The file; links are followed.
        error: The class of the errors.
        hint: The way out if it is not there.
        is_input: Whether the file is to be kept; what a command itself extends, such as a store, is not.

    Raises:
        InputError: It is no regular file, or cannot be read.
    """
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    except (OSError, ValueError) as problem:
        raise _unreadable(problem, path, error, hint) from problem
    found = os.fstat(descriptor)
    kind = KINDS.get(stat.S_IFMT(found.st_mode))
    inputs = _inputs.get()
    if inputs is not None and is_input:
        inputs.add((found.st_dev, found.st_ino))
    if kind:
        os.close(descriptor)
        raise error(f"cannot be read: it is {kind}", where=shown_path(path), hint="name a file")
    with os.fdopen(descriptor, "rb") as stream:
        try:
            yield stream
        except OSError as problem:
            if problem.filename is not None:
                raise
            raise _unreadable(problem, path, error, hint) from problem


def read_whole(
    path: Path,
    *,
    most_bytes: int,
    setting: str = "document_bytes",
    error: type[InputError] = InputError,
    hint: str = "check the path",
) -> bytes:
    """The content of a regular file.

    Args:
        path: The file.
        most_bytes: It may not be larger.
        setting: The limit that says so, for the message.
        error: The class of the errors.
        hint: The way out if it is not there.

    Raises:
        InputError: It is no regular file, cannot be read, or is too large.
    """
    with reading(path, error=error, hint=hint) as stream:
        size = os.fstat(stream.fileno()).st_size
        if size > most_bytes:
            raise error(
                "is too large",
                where=path,
                value=f"{size:,} bytes",
                hint=most_read(most_bytes, setting),
            )
        return stream.read(most_bytes)


def _unreadable(problem: Exception, path: Path, error: type[InputError], hint: str) -> InputError:
    return error(f"cannot be read: {_reason(problem)}", where=shown_path(path), hint=hint)


def _reason(problem: Exception) -> str:
    return (problem.strerror if isinstance(problem, OSError) else None) or str(problem)


def shown_path(path: Path) -> str:
    """A path as text that can be printed, even with a NUL in it."""
    return str(path).replace("\0", "\\0")


# --- Changing a file in place.


@contextmanager
def changing(path: Path, *, error: type[InputError] = InputError) -> Iterator[BinaryIO]:
    """A regular file that is read and then replaced: whoever else is about to change it waits.

    Raises:
        InputError: It is no regular file, or cannot be read.
    """
    while True:
        with reading(path, error=error, is_input=False) as stream:
            fcntl.flock(stream, fcntl.LOCK_EX)
            if _is_same(path, stream):  # else it was replaced while this process waited
                yield stream
                return


def _is_same(path: Path, stream: BinaryIO) -> bool:
    """Whether a path still names the file that is open."""
    with suppress(OSError):
        return os.path.samestat(path.stat(), os.fstat(stream.fileno()))
    return False
