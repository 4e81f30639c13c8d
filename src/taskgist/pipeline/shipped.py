"""What comes with taskgist: recordings of the study, simulated, real handovers, and a room to perform in."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import resources
from pathlib import Path

from taskgist.errors import UnknownNameError

TASKS = ("show", "hide", "make accessible", "give", "put away", "hide away")
"""Tasks of the study, in the paper's order."""
REAL = "give"
"""The task of which real recordings exist."""


def shipped_recordings(task: str) -> tuple[Path, ...]:
    """Paths of the shipped recordings of a task, by name: real ones where there are any, else those of the study.

    Raises:
        UnknownNameError: None are shipped for that task.
    """
    if task == REAL:
        return _recordings(_root() / REAL)
    study = shipped_study()
    if task not in study:
        raise UnknownNameError("shipped task", task, sorted(study))
    return study[task]


def shipped_study() -> Mapping[str, tuple[Path, ...]]:
    """Paths of the 23 simulated recordings of the paper's study by task, in its order."""
    return {task: _recordings(_root() / "study" / task.replace(" ", "_")) for task in TASKS}


def shipped_room() -> Path:
    """Path of a living room with a robot, Jido, and a person, P2, in which what was learned can be performed."""
    return _root().with_name("rooms") / "living_room.toml"


def _root() -> Path:
    return Path(str(resources.files("taskgist") / "data" / "recordings"))


def _recordings(folder: Path) -> tuple[Path, ...]:
    return tuple(sorted(folder.glob("*.mcap")))
