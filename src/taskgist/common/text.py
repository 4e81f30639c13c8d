"""Text that others wrote: how a terminal may show it, and what is a name.

Characters that move the cursor, that turn the direction of writing around, or that are halves of others are not seen.
No name holds them, and a terminal is shown them as escapes, so that nothing in a text is a command to it.

Unicode writes an accented letter as one character or as two, and editors leave spaces at the ends; neither makes
another name.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence
from typing import TypeVar

DIRECTIONS = "\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069"
"""Marks that turn the direction of the text around them."""
ENDS = "\u2028\u2029"
"""Ends of lines and paragraphs that few know."""
HALVES = "\ud800-\udfff"
UNSEEN = re.compile(f"[\0-\x1f\x7f-\x9f{DIRECTIONS}{ENDS}{HALVES}]")
"""What no name holds."""
COMMANDS = re.compile(f"[\0-\x08\x0b-\x1f\x7f-\x9f{DIRECTIONS}{ENDS}{HALVES}]")
"""The same in running text, which holds tabulators and ends of lines."""

LONGEST_NAME = 200
"""Characters of a name (ours: three lines of a terminal)."""


def clean_name(text: str) -> str:
    """The one spelling of a name: composed (NFC), without spaces at its ends, without what is not seen."""
    return unicodedata.normalize("NFC", UNSEEN.sub("", text)).strip()


def fault_of_name(text: str) -> str | None:
    """What keeps a text from being a name, as a clause; None if nothing does."""
    if UNSEEN.search(text):
        return "holds a character that is not seen"
    if not clean_name(text):
        return "is empty"
    return f"is longer than {LONGEST_NAME} characters" if len(text) > LONGEST_NAME else None


def escaped(text: str) -> str:
    r"""Running text with each character that is not seen as ``\x1b`` or ``\u202e``."""
    return COMMANDS.sub(lambda found: _escape(ord(found[0])), text)


def escaped_in_json(text: str) -> str:
    r"""A JSON document with each of these characters as ``\u001b``: it means the same."""
    return COMMANDS.sub(lambda found: f"\\u{ord(found[0]):04x}", text)


def _escape(code: int) -> str:
    return f"\\x{code:02x}" if code < 256 else f"\\u{code:04x}"


MOST_SHOWN = 12
"""Names that a message lists."""


def shortened(names: Sequence[str], most: int = MOST_SHOWN) -> str:
    """The first of some names, and that there are more."""
    return ", ".join(names[:most]) + (", ..." if len(names) > most else "")


Value = TypeVar("Value")


def one_or_list(values: Sequence[Value]) -> Value | list[Value]:
    """One value as it is, several as a list: so documents have the targets of a task, and what is of each."""
    return values[0] if len(values) == 1 else list(values)
