"""The way out of a wrong name: the nearest right one, and all of them."""

from __future__ import annotations

from collections.abc import Iterable

from taskgist.errors import nearest


def allowed_names(given: object, allowed: Iterable[str]) -> str:
    """Text such as "did you mean 'Sitting'? (allowed: Standing, Sitting)"."""
    names = tuple(allowed)
    near = nearest(str(given), names)
    guess = f"did you mean {near!r}? " if near else ""
    return f"{guess}(allowed: {', '.join(names)})"
