"""How the fuzzer spoils any file: its bytes, and the tokens of text. ``fuzz_mutations`` spoils structures."""

from __future__ import annotations

import json
import random
import re
from collections.abc import Callable, Mapping

Mutation = Callable[[random.Random, bytes], bytes]
LARGEST = 4 * 2**20
"""Bytes of a spoiled file, but for those that unpack to more."""

NUMBERS = (
    *("nan", "inf", "-inf", "NaN", "Infinity", "1e308", "-1e308", "1e-320", "-0", "0", "-1", "1", "2", "255"),
    *("1e9", "1e19", "4294967296", "9223372036854775808", "1" + 400 * "0", "1_0", "0x10", "1e", "--1", "1.2.3", ""),
    *(
        "١٢",
        "４２",
        "²",
        "½",
        "1,5",
        "0.5",
        "0.1",
        "-0.3",
        "3",
        "10",
        "90",
        "1000",
        "1e400",
        "30000",
        "99999999",
        "0.0000001",
        "true",
        '"1"',
        "[1]",
        "{}",
    ),
)
"""What stands for a number when it is spoiled."""
WORDS = (
    *(
        "",
        " ",
        "\x00",
        "a\x00b",
        "\x1b[31mred\x1b[0m",
        "\x9b31m",
        "\x07",
        "\u202egnp",
        "\ud7ff",
        "é",
        "e\u0301",
        "\ufeff",
    ),
    *("../../../../etc/passwd", "/etc/passwd", "/dev/zero", ".", "..", "~", "a/b", "a" * 300, "a" * 70_000, "'", '"'),
    *("[", "]", "{", "}", "{{point}}", "{nobody}", "%s", "$(id)", "null", "true", "1", "-", "--help", "package://x/y"),
    *("world", "P1", "P2", "cup", "room.toml", "room.xml", "__class__", "\r\n", "\n", "\t", "#", "<!--", "]]>", "&lt;"),
    *("&x;", "<include file='/etc/passwd'/>", "=", "a = 1", "inf", "nan"),
)
"""What stands for a word when it is spoiled."""


# --- Bytes.


def flipped(rng: random.Random, data: bytes) -> bytes:
    """One to eight bytes are others."""
    spoiled = bytearray(data)
    for _ in range(rng.randint(1, 8)):
        if spoiled:
            spoiled[rng.randrange(len(spoiled))] ^= rng.randint(1, 255)
    return bytes(spoiled)


def inserted(rng: random.Random, data: bytes) -> bytes:
    """Some bytes stand between others."""
    at = rng.randint(0, len(data))
    return data[:at] + rng.randbytes(rng.choice((1, 4, 100))) + data[at:]


def deleted(rng: random.Random, data: bytes) -> bytes:
    """Some bytes are missing."""
    start, end = _part(rng, len(data))
    return data[:start] + data[end:]


def duplicated(rng: random.Random, data: bytes) -> bytes:
    """Some bytes stand there twice, or a hundred times."""
    start, end = _part(rng, len(data))
    return (data[:end] + data[start:end] * rng.choice((1, 2, 100)) + data[end:])[:LARGEST]


def truncated(rng: random.Random, data: bytes) -> bytes:
    """The end is missing."""
    return data[: rng.randint(0, len(data))]


def spliced(rng: random.Random, data: bytes) -> bytes:
    """Some bytes are those of another place."""
    start, end = _part(rng, len(data))
    at = rng.randint(0, len(data))
    return data[:at] + data[start:end] + data[at + end - start :]


def zeroed(rng: random.Random, data: bytes) -> bytes:
    """Some bytes are all 0, or all 255."""
    start, end = _part(rng, len(data))
    return data[:start] + rng.choice((b"\x00", b"\xff")) * (end - start) + data[end:]


def _part(rng: random.Random, size: int) -> tuple[int, int]:
    start = rng.randint(0, size)
    return start, min(size, start + rng.choice((1, 2, 8, 64, max(1, size // 4))))


# --- Tokens of text.

TOKENS = re.compile(r"[-+]?\d[\w.+-]*|[^\W\d][\w.-]*|\s+|.", re.DOTALL)


def number_replaced(rng: random.Random, data: bytes) -> bytes:
    """A number is one that no file should hold, or that few expect."""
    return _replaced(rng, data, lambda token: token[0].isdigit() or (token[0] in "+-" and len(token) > 1), NUMBERS)


def number_nudged(rng: random.Random, data: bytes) -> bytes:
    """One or two numbers are somewhat others: what is still right as a file goes deeper."""
    tokens = TOKENS.findall(_text(data))
    places = [place for place, token in enumerate(tokens) if re.fullmatch(r"[-+]?\d+(\.\d+)?", token)]
    for place in rng.sample(places, min(len(places), rng.choice((1, 1, 2)))):
        old = tokens[place]
        new = float(old) * rng.choice((-1, 0, 0.1, 0.5, 0.9, 1.1, 2, 10, 1000)) + rng.choice((0, 0, 1, -1))
        tokens[place] = f"{new:.6g}" if "." in old or rng.random() < 0.2 else str(round(new))
    return "".join(tokens).encode("utf-8", "surrogatepass")


def word_replaced(rng: random.Random, data: bytes) -> bytes:
    """A word is another one: of the file, or one that is no word."""
    words = [token for token in TOKENS.findall(_text(data)) if token[0].isalpha()]
    return _replaced(rng, data, lambda token: token[0].isalpha(), words if words and rng.random() < 0.4 else WORDS)


def quoted_replaced(rng: random.Random, data: bytes) -> bytes:
    """A quoted text holds something else."""
    text = _text(data)
    found = list(re.finditer(r'"([^"\n]*)"', text))
    if not found:
        return word_replaced(rng, data)
    hit, other = rng.choice(found), rng.choice(found)
    new = other[1] if rng.random() < 0.3 else rng.choice((*WORDS, *NUMBERS))
    if rng.random() < 0.5:
        new = json.dumps(new)[1:-1]  # escaped, so that it comes through
    return (text[: hit.start(1)] + new + text[hit.end(1) :]).encode("utf-8", "surrogatepass")


def value_retyped(rng: random.Random, data: bytes) -> bytes:
    """What stands behind a sign of equality, or a colon, is of another type."""
    text = _text(data)
    found = list(re.finditer(r"(?:=|:)\s*([^\n,}]+)", text))
    if not found:
        return word_replaced(rng, data)
    hit = rng.choice(found)
    new = rng.choice(
        ('"x"', "1", "[]", "[[1]]", "{}", "{ a = 1 }", "true", "1979-05-27", '""', "[1, 2]", '["a", 1]', "-1")
    )
    return (text[: hit.start(1)] + new + text[hit.end(1) :]).encode("utf-8", "surrogatepass")


def line_moved(rng: random.Random, data: bytes) -> bytes:
    """A line is missing, stands twice, elsewhere, or a thousand times."""
    lines = _text(data).splitlines(keepends=True) or [""]
    at, to = rng.randrange(len(lines)), rng.randrange(len(lines))
    count = rng.choice((0, 0, 2, 2, 1000))
    moved = lines[:at] + lines[at : at + 1] * count + lines[at + 1 :]
    if rng.random() < 0.3:
        moved.insert(to, lines[at])
    return "".join(moved).encode("utf-8", "surrogatepass")[:LARGEST]


def element_moved(rng: random.Random, data: bytes) -> bytes:
    """An element of XML, or what stands in brackets, is missing, stands twice, or in another."""
    text = _text(data)
    found = list(
        re.finditer(r"<(\w+)\b[^<>]*/>|<(\w+)\b[^<>]*>[^<>]*</\2>|\[[^\[\]\n]*\]|\{[^{}\n]*\}|\w+=\"[^\"]*\"", text)
    )
    if not found:
        return line_moved(rng, data)
    hit, other = rng.choice(found), rng.choice(found)
    new = rng.choice(("", hit[0] * 2, hit[0] * 300, other[0], hit[0][:1] + hit[0]))
    return (text[: hit.start()] + new + text[hit.end() :]).encode("utf-8", "surrogatepass")[:LARGEST]


def deepened(rng: random.Random, data: bytes) -> bytes:
    """Something stands very deep in brackets, or in elements."""
    text = _text(data)
    tokens = TOKENS.findall(text) or [""]
    at, depth = rng.randrange(len(tokens)), rng.choice((10, 300, 20_000, 100_000))
    before, after = rng.choice(
        (("[", "]"), ('{"a":', "}"), ("{a=", "}"), ("<body>", "</body>"), ("(", ")"), ("a.", ""))
    )
    tokens[at] = before * depth + tokens[at] + after * depth
    return "".join(tokens).encode("utf-8", "surrogatepass")[:LARGEST]


def _text(data: bytes) -> str:
    return data.decode("utf-8", "replace")


def _replaced(rng: random.Random, data: bytes, fits: Callable[[str], bool], new: tuple[str, ...] | list[str]) -> bytes:
    tokens = TOKENS.findall(_text(data))
    places = [place for place, token in enumerate(tokens) if fits(token)]
    for _ in range(min(len(places), rng.choice((1, 1, 1, 2, 5)))):
        tokens[rng.choice(places)] = rng.choice(new)
    return "".join(tokens).encode("utf-8", "surrogatepass")[:LARGEST]


OF_BYTES: Mapping[str, Mutation] = {
    each.__name__: each for each in (flipped, inserted, deleted, duplicated, truncated, spliced, zeroed)
}
OF_TEXT: Mapping[str, Mutation] = {
    each.__name__: each
    for each in (
        number_replaced,
        number_nudged,
        word_replaced,
        quoted_replaced,
        value_retyped,
        line_moved,
        element_moved,
        deepened,
    )
}
