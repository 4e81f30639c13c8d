"""Saving pictures: whole or not at all, and the same bytes for the same picture."""

from __future__ import annotations

from pathlib import Path

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from taskgist.errors import InputError
from taskgist.files import replacing

DPI = 100


def save_figure(figure: Figure, path: Path) -> Path:
    """Write a figure as PNG.

    Raises:
        InputError: The folder does not exist or cannot be written to.
    """
    FigureCanvasAgg(figure)
    try:
        with replacing(path) as stream:
            figure.savefig(stream, format="png", dpi=DPI, metadata={"Software": None})
    except OSError as error:
        hint = "name a file in a folder that exists and may be written to"
        raise InputError(f"cannot be written: {error.strerror}", where=path, hint=hint) from error
    return path
