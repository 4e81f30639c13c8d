"""Names that people and other programs give: of tasks, agents and objects. One name has one spelling.

Unicode writes an accented letter as one character or as two, and editors leave spaces at the ends; neither makes
another name. Characters that move the cursor or turn the direction of writing are no part of one.
"""

from __future__ import annotations

import unicodedata

UNSEEN = frozenset({"Cc", "Cs", "Zl", "Zp"})
"""Categories of Unicode that no name holds: controls, halves of characters, ends of lines and paragraphs."""
DIRECTIONS = frozenset("\u061c\u200e\u200f\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069")
"""Marks that turn the direction of the text around them."""


def clean_name(text: str) -> str:
    """The one spelling of a name: composed (NFC), without spaces at its ends, without what is not seen."""
    seen = "".join(character for character in text if not is_unseen(character))
    return unicodedata.normalize("NFC", seen).strip()


def unseen_in(text: str) -> str | None:
    """The first character of a text that no name holds; None if there is none."""
    return next((character for character in text if is_unseen(character)), None)


def is_unseen(character: str) -> bool:
    """Whether a character moves the cursor, turns the direction of writing, or is none at all."""
    return unicodedata.category(character) in UNSEEN or character in DIRECTIONS
