"""XML documents of models, read and checked before MuJoCo sees them, and written anew for it.

MuJoCo's reader expands, opens and allocates what a document asks for. It is therefore never given a file or somebody's
text, only what was parsed here: no entities, bounded in size, depth and elements, every number finite, every name
printable. Elements keep their lines, so that MuJoCo's messages name those of the file.
"""

from __future__ import annotations

import logging
import math
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from xml.etree.ElementTree import Element
from xml.parsers import expat

import mujoco

from taskgist.common.text import UNSEEN
from taskgist.errors import SceneError, most_read
from taskgist.settings import DEFAULT, Limits

COMMENT = re.compile(rb"<!--.*?-->", re.DOTALL)
"""Comments are taken out before the parser meets them: MuJoCo allows ``--`` inside of them, XML does not."""
HEAD = re.compile(rb"<mujoco\b[^>]*>\s*<!--(.*?)-->", re.DOTALL)
"""A comment at the head of a model: who made it, and under which licence."""
LATE_DECLARATION = re.compile(rb"\A(\s+)<\?xml\b[^>]*\?>")
"""A declaration after empty lines, which XML does not allow, and readers of robot descriptions do."""
ESCAPES = str.maketrans({"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;"})
NUMBER = re.compile(
    r"[+-]?(?:(?P<none>nan(?:\(\w*\))?|inf(?:inity)?)|0x[0-9a-f.]+(?:p[+-]?\d+)?|(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)",
    re.IGNORECASE | re.ASCII,
)
TEXTS = frozenset(
    ("name", "class", "childclass", "model", "prefix", "data", "key", "value", "file", "mesh", "hfield", "material")
    + ("texture", "body", "body1", "body2", "joint", "joint1", "joint2", "geom", "site", "target", "link", "filename")
)
"""Attributes whose value is a text, whatever it looks like."""
TEXTS_IN_URDF = TEXTS - {"value"}


class Marked(Element):
    """An element.

    Attributes:
        line: Its line in the document; 0 if it comes from another.
        comment: Of a document's root: what stands at its head, which MuJoCo keeps.
    """

    line: int = 0
    comment: str = ""

    def __repr__(self) -> str:
        name = self.get("name")
        return f"<{self.tag}> {name!r}" if name else f"<{self.tag}>"


def parse_markup(
    data: bytes, *, where: str | Path, limits: Limits = DEFAULT.limits, most_elements: int | None = None
) -> Marked:
    """The root element of an XML document.

    Args:
        data: The document.
        where: File for error messages.
        limits: Bounds of size, depth and elements.
        most_elements: In place of the limit for models.

    Raises:
        SceneError: It is not XML, is too large or too deep, or defines entities.
    """
    if len(data) > limits.document_bytes:
        hint = most_read(limits.document_bytes, "document_bytes")
        raise SceneError("is too large", where=where, value=f"{len(data):,} bytes", hint=hint)
    most = limits.model_elements if most_elements is None else most_elements
    builder = _Builder(where, most, limits.model_depth)
    text = COMMENT.sub(lambda comment: b"\n" * comment[0].count(b"\n"), data)
    text = LATE_DECLARATION.sub(rb"\1", text)
    try:
        builder.parser(_encoding(text)).Parse(text, True)
    except (expat.ExpatError, ValueError, LookupError) as error:  # the latter two: an encoding that is none
        raise SceneError(f"not valid XML: {error}", where=where, hint="save it as XML in UTF-8") from error
    assert builder.root is not None
    head = HEAD.search(data)
    if head is not None:
        builder.root.comment = head[1].decode("utf-8", "replace").replace("\r\n", "\n")
    return builder.root


def _encoding(text: bytes) -> str | None:
    """The encoding of a document that does not say it and is not UTF-8; old editors wrote Latin-1."""
    if text.startswith((b"\xff\xfe", b"\xfe\xff")) or b"encoding" in text[:200].partition(b"?>")[0]:
        return None
    try:
        text.decode("utf-8")
    except UnicodeDecodeError:
        return "iso-8859-1"
    return None


class _Builder:
    """Builds elements from a parser's events."""

    def __init__(self, where: str | Path, most_elements: int, most_depth: int) -> None:
        self.root: Marked | None = None
        self._where, self._most_elements, self._most_depth = where, most_elements, most_depth
        self._open: list[Marked] = []
        self._texts: list[str] = []
        self._count = 0

    def parser(self, encoding: str | None) -> expat.XMLParserType:
        """A parser that builds."""
        parser = expat.ParserCreate(encoding)
        parser.buffer_text = True
        parser.StartElementHandler = lambda tag, attributes: self._start(tag, attributes, parser.CurrentLineNumber)
        parser.EndElementHandler = self._end
        parser.CharacterDataHandler = self._texts.append
        parser.StartDoctypeDeclHandler = self._doctype
        return parser

    def _start(self, tag: str, attributes: dict[str, str], line: int) -> None:
        self._count += 1
        if self._count > self._most_elements:
            raise self._beyond("too many elements", self._most_elements, "model_elements")
        if len(self._open) >= self._most_depth:
            raise self._beyond("nested too deep", self._most_depth, "model_depth")
        element = Marked(tag, {key: value for key, value in attributes.items() if key.partition(":")[0] != "xmlns"})
        element.line = line
        if self._open:
            self._open[-1].append(element)
        else:
            self.root = element
        self._open.append(element)
        self._texts.clear()

    def _end(self, _tag: str) -> None:
        element = self._open.pop()
        if not len(element):
            element.text = "".join(self._texts)
        self._texts.clear()

    def _doctype(self, _name: str, system: str | None, _public: str | None, inside: int) -> None:
        if system or inside:
            hint = "leave <!DOCTYPE ...> out, and write what its entities stand for"
            raise SceneError("a document type that may define entities", where=self._where, hint=hint)

    def _beyond(self, problem: str, most: int, setting: str) -> SceneError:
        return SceneError(problem, where=self._where, hint=most_read(most, setting))


def written(root: Element) -> str:
    """An XML document of elements and attributes, each on the line that it came from."""
    parts: list[str] = []
    line = 1
    rest: list[Element | str] = [root]
    while rest:
        each = rest.pop()
        if isinstance(each, str):
            parts.append(each)
            continue
        if isinstance(each, Marked) and each.line > line:
            parts.append("\n" * (each.line - line))
            line = each.line
        attributes = "".join(f' {key}="{value.translate(ESCAPES)}"' for key, value in each.items())
        if len(each):
            parts.append(f"<{each.tag}{attributes}>")
            rest.append(f"</{each.tag}>")
            rest += reversed(each)
        else:
            parts.append(f"<{each.tag}{attributes}/>")
    return "".join(parts)


def check_values(root: Element, *, where: str | Path, texts: frozenset[str] = TEXTS) -> None:
    """Refuse numbers that are not finite, and characters that no name holds.

    Args:
        root: The document.
        where: File for error messages.
        texts: Attributes whose value is no number.

    Raises:
        SceneError: There is one.
    """
    for element, key, value in _attributes(root):
        if UNSEEN.search(value):
            raise located(element, key, "holds a control character", value, where, "leave it out")
        if key not in texts and not _is_finite(value):
            raise located(element, key, "must be finite numbers", value, where, "give ordinary numbers")


def _attributes(root: Element) -> Iterator[tuple[Element, str, str]]:
    for element in root.iter():
        for key, value in element.items():
            yield element, key, value


def _is_finite(value: str) -> bool:
    """Whether a value holds only finite numbers, or something else than numbers."""
    found = [NUMBER.fullmatch(token) for token in value.split()]
    return not all(found) or all(each and not each["none"] and _fits(each[0]) for each in found)


def _fits(token: str) -> bool:
    try:
        return math.isfinite(float.fromhex(token) if "x" in token.lower() else float(token))
    except (ValueError, OverflowError):
        return False


# Otherwise MuJoCo prints its warnings, and writes a file of its own; with no handler at all, Python prints them.
_warnings = logging.getLogger("taskgist.world.mujoco")
_warnings.addHandler(logging.NullHandler())
mujoco.set_mju_user_warning(_warnings.warning)


@contextmanager
def asking_mujoco(problem: str, where: str | Path) -> Iterator[None]:
    """Let what MuJoCo says against a model come inside of ours, and nothing of what it merely mentions.

    Args:
        problem: What to say before its own words, such as "MuJoCo cannot read this model:".
        where: File for error messages.

    Raises:
        SceneError: MuJoCo refuses.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of attributes that will be gone, and of what it discards
            yield
    except SceneError as error:
        error.where = error.where or str(where)
        raise
    except Exception as error:  # of several kinds, and whatever its C++ throws on strange models
        told = "; ".join(filter(None, map(str.strip, str(error).splitlines()))) or type(error).__name__
        raise SceneError(f"{problem} {told}", where=where) from error


def located(
    element: Element, key: str, problem: str, value: object, where: str | Path, hint: str | None = None
) -> SceneError:
    """The error to raise about an attribute of an element."""
    line = element.line if isinstance(element, Marked) else 0
    place = f"{where}, line {line}" if line else where
    return SceneError(problem, where=place, field=f"{key} of {element!r}", value=value, hint=hint)
