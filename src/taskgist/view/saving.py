"""Saving pictures: atomically, and the same bytes for the same picture."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from taskgist.errors import InputError

DPI = 100


def save_figure(figure: Figure, path: Path) -> Path:
    """Write a figure as PNG; the file appears whole or not at all.

    Raises:
        InputError: The folder does not exist or cannot be written.
    """
    FigureCanvasAgg(figure)
    try:
        handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
        with os.fdopen(handle, "wb") as file:
            figure.savefig(file, format="png", dpi=DPI, metadata={"Software": None})
        os.replace(temporary, path)  # noqa: PTH105 - atomic on every platform
    except OSError as error:
        raise InputError(
            f"cannot be written: {error.strerror}", where=path, hint="name a file in a folder that exists"
        ) from error
    return path
