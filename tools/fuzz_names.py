"""Names as nobody means them, in all places at once: in the files that give them and in the command that asks."""

from __future__ import annotations

import json
import random
import re
from collections.abc import Mapping
from pathlib import Path
from xml.sax.saxutils import quoteattr

NAMES = (
    *(
        "\x1b[31mred\x1b[0m",
        "a\x9b5m",
        "bell\x07",
        "new\nline",
        "car\rriage",
        "tab\there",
        "a\x00b",
        "del\x7f",
        "\u2028",
    ),
    *("\u202egnp", "\u2066mug\u2069", "\u200fcup", "\u061ccup", "c\u200bup", "\ufeffcup", "c\U000e0075p", "\u3164"),
    *("\u0441up", "\u03a11", "Ｐ1", "ﬁsh", "e\u0301", "cup\u0338", "İ", "ß", "😀" * 300, "a" + "\u0301" * 5_000),
    *("a" * 300, "a" * 100_000, "é" * 50_000, "a b " * 25_000, "/".join("ab" * 1_000)),
    *("", " ", "  P1  ", ".", "..", "../x", "/etc/passwd", "a/b", "a\\b", "a.b", "a,b", "'", '"', "`", "#", "{}", "%s"),
    *("[bold]cup[/bold]", "[/x]", "<b>", "&amp;", "]]>", "--json", "-x", "-1", "1e9", "nan", "null", "true", "None"),
    *("world", "P1", "P2", "R", "cup", "mug", "show", "hide", "scene", "floor", "root", "label", "taskgist.label"),
)
"""What stands for a name: control characters, other directions, look-alikes, what is too long, what means something."""
LONGEST = 120_000
"""Characters of an argument that a system passes on."""


def renamed(
    rng: random.Random, files: Mapping[str, bytes], names: tuple[str, ...], command: tuple[str, ...]
) -> tuple[dict[str, bytes], tuple[str, ...]]:
    """Files in which a name, or two, is another one, and the command that asks for it by that, mostly.

    Args:
        rng: Decides.
        files: Files by name.
        names: Those that may be others.
        command: The command.

    Returns:
        The files that changed, and the command.
    """
    changed: dict[str, bytes] = {}
    for old in rng.sample(names, rng.choice((1, 1, 1, min(2, len(names))))):
        new = rng.choice(NAMES)
        for file, content in {**files, **changed}.items():
            if (data := _with_name(file, content, old, new)) != content:
                changed[file] = data
        argument = new.replace("\x00", "\\0")[:LONGEST]  # no system passes a NUL on
        if rng.random() < 0.85:
            command = tuple(argument if word == old else word for word in command)
    return changed, command


def _with_name(file: str, content: bytes, old: str, new: str) -> bytes:
    """A file's content with another name, as its format writes it."""
    suffix = Path(file).suffix
    if suffix not in (".toml", ".json", ".xml", ".urdf"):
        return content
    text = content.decode()
    if suffix in (".xml", ".urdf"):
        return text.replace(f'"{old}"', quoteattr(new)).encode("utf-8", "surrogatepass")
    quoted = json.dumps(new, ensure_ascii=False)
    if suffix == ".toml":
        quoted = quoted.replace("\x7f", "\\u007f")
        text = re.sub(rf"(?m)^(\[[^\]\n]*\.){old}(?=[\].])", lambda found: found[1] + quoted, text)
    return text.replace(f'"{old}"', quoted).encode("utf-8", "surrogatepass")
