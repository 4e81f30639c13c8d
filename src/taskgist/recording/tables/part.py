"""What text and arrays have in common: the part of a table that belongs to one point."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from taskgist.recording.mapping.source_model import Name


class Part(Protocol):
    """Rows of one point, whatever they are stored in."""

    @property
    def where(self) -> str:
        """Mapping, source and file, for messages."""

    def numbers(self, columns: Sequence[Name]) -> NDArray[np.float64]:
        """Numbers in these columns, (rows, columns); NaN where there are none."""

    def place(self, row: int) -> str:
        """Where a row stands, for messages."""
