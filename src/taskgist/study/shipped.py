"""The recordings that come with taskgist."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

from taskgist.errors import UnknownNameError


def shipped_recordings(task: str) -> tuple[Path, ...]:
    """Paths of the shipped recordings of a task, by name.

    Raises:
        UnknownNameError: None are shipped for that task.
    """
    root = Path(str(resources.files("taskgist") / "data" / "recordings"))
    tasks = sorted(folder.name for folder in root.iterdir() if folder.is_dir())
    if task not in tasks:
        raise UnknownNameError("shipped task", task, tasks)
    return tuple(sorted((root / task).glob("*.mcap")))
