"""Notes of the library on standard error: a file of its own, for ``--help`` and ``--version`` need no logging."""

from __future__ import annotations

import logging
import sys

from taskgist.common.text import escaped

WORLD = "taskgist.world"


class Notes(logging.Handler):
    """Shows what is told of a user's models, each once; what takes long is shown in a terminal alone.

    MuJoCo's own warnings, which come by a logger below, are not among them.
    """

    def __init__(self) -> None:
        super().__init__()
        self._shown: set[str] = set()

    def emit(self, record: logging.LogRecord) -> None:
        """Write one line."""
        is_note = record.levelno >= logging.WARNING
        text = f"note: {record.getMessage()}" if is_note else record.getMessage()
        if record.name == WORLD and text not in self._shown and (is_note or sys.stderr.isatty()):
            self._shown.add(text)
            sys.stderr.write(escaped(text) + "\n")


def show_notes() -> None:
    """Show them from now on."""
    logger = logging.getLogger(WORLD)
    for handler in logger.handlers[:]:
        if isinstance(handler, Notes):  # of a command before, in the same process
            logger.removeHandler(handler)
    logger.addHandler(Notes())
    logger.setLevel(logging.INFO)
