"""Reading on after a mistake, so that a report names every one of them."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from taskgist.errors import InputError

T = TypeVar("T")
UNREADABLE = ""
"""Stands for a name that could not be read: no document can give it, as texts are not empty."""


class Attempts:
    """Reads one field after the other and keeps what is wrong with them.

    Attributes:
        problems: Every mistake so far, in the order of reading.
    """

    def __init__(self) -> None:
        self.problems: list[InputError] = []

    def __call__(self, read: Callable[[], T], otherwise: T) -> T:
        """What ``read`` gives; where it fails, the mistake is kept and ``otherwise`` stands in."""
        try:
            return read()
        except InputError as error:
            self.problems.append(error)
            return otherwise
