"""Arrays by what they hold: the names that annotations use everywhere."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""Numbers; the docstring beside says shape and unit."""
Indices = NDArray[np.intp]
"""Positions in other arrays: ids of bodies and shapes, columns, rows."""
Mask = NDArray[np.bool_]
"""Truth values: which of something."""
