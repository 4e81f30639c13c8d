"""Text that others wrote, as a terminal may show it: nothing in it is a command to the terminal."""

from __future__ import annotations

import re

COMMANDS = re.compile(
    "[\0-\x08\x0b-\x1f\x7f-\x9f"  # control characters, but for tabulators and ends of lines
    "\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069"  # what turns the direction of the text around
    "\u2028\u2029\ud800-\udfff]"  # ends of lines that few know; halves of characters
)


def escaped(text: str) -> str:
    r"""Text with each of these characters as ``\x1b`` or ``\u202e``."""
    return COMMANDS.sub(lambda found: _escape(ord(found[0])), text)


def escaped_in_json(text: str) -> str:
    r"""A JSON document with each of these characters as ``\u001b``: it means the same."""
    return COMMANDS.sub(lambda found: f"\\u{ord(found[0]):04x}", text)


def _escape(code: int) -> str:
    return f"\\x{code:02x}" if code < 256 else f"\\u{code:04x}"
