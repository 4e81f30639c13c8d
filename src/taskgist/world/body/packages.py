"""Finding files that robot descriptions name: ``package://`` as ROS means it, ``file://``, and relative paths.

The first part of ``package://NAME/rest`` is the folder of a package. It is searched among the folders of
``ROS_PACKAGE_PATH`` and ``AMENT_PREFIX_PATH``, around the file that names it, and where Python's packages keep their
shared data: the pip package ``example-robot-data`` (extra ``robots``) puts its robots there.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from pathlib import Path

from taskgist.errors import SceneError

PACKAGE = "package://"
FILE = "file://"
ROBOTS = "example-robot-data"
SHARES = ("cmeel.prefix/share", "share")
"""Where below a folder of Python's path, or its prefix, packages keep shared data."""


def find_file(uri: str, *, near: Path | None, where: str | Path, field: str) -> Path:
    """The file that a robot description, a profile or a scene names.

    Args:
        uri: ``package://NAME/path``, ``file:///path``, or a path relative to ``near``.
        near: Folder of the file that names it; None for what comes with taskgist.
        where: File for error messages.
        field: Field for error messages.

    Raises:
        SceneError: There is no such file.
    """
    if uri.startswith(PACKAGE):
        return _in_package(uri, near, where, field)
    path = Path(uri.removeprefix(FILE))
    path = path if near is None else near / path
    if path.is_file():
        return path
    raise SceneError("no such file", where=where, field=field, value=str(path), hint="paths are relative to the file")


def _in_package(uri: str, near: Path | None, where: str | Path, field: str) -> Path:
    name, _, rest = uri.removeprefix(PACKAGE).lstrip("/").partition("/")
    for root in _roots(near):
        for folder in (root / name, root):
            if (folder is not root or root.name == name) and (folder / rest).is_file():
                return folder / rest
    hint = f"add the folder that holds {name!r} to ROS_PACKAGE_PATH"
    if name == ROBOTS:
        hint = f"pip install 'taskgist[robots]', or {hint}"
    raise SceneError("no such file in any package", where=where, field=field, value=uri, hint=hint)


def _roots(near: Path | None) -> Iterator[Path]:
    """Folders that may hold a package, the surest first."""
    if near is not None:
        yield from (near.resolve(), *near.resolve().parents)
    for folder in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep):
        if folder:
            yield Path(folder)
    for folder in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        if folder:
            yield Path(folder) / "share"
    for folder in (*sys.path, sys.prefix):
        yield from (Path(folder) / share for share in SHARES)
