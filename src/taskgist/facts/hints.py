"""The way out of a wrong name: the nearest right one, and all of them."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


def allowed_names(given: object, allowed: Iterable[str]) -> str:
    """Text such as "did you mean 'Sitting'? (allowed: Standing, Sitting)"."""
    names = tuple(allowed)
    near = difflib.get_close_matches(str(given), names, n=1)
    guess = f"did you mean {near[0]!r}? " if near else ""
    return f"{guess}(allowed: {', '.join(names)})"
