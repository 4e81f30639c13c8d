"""The text of a drafted profile: a line for each field with its reason beside it, and what is left open."""

from __future__ import annotations

import json
import math
from collections.abc import Collection
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from taskgist.common.arrays import Array

MOST_CHOICES = 6
"""Names that a line lists."""


@dataclass
class Lines:
    """A profile as text that grows.

    Attributes:
        text: Its lines.
        open: What its user has to say, each with its field.
    """

    text: list[str] = field(default_factory=list)
    open: list[str] = field(default_factory=list)

    def table(self, name: str, why: str = "") -> None:
        """Begin a table."""
        self.text += ["", f"{name}  # {_one_line(why)}" if why else name]

    def say(self, key: str, value: Any, why: str) -> None:
        """A field, and why it is that."""
        self.text.append(f"{key} = {toml_value(value)}  # {_one_line(why)}")

    def note(self, text: str) -> None:
        """A remark."""
        self.text.append(f"# {_one_line(text)}")

    def ask(self, path: str, example: Any, question: str) -> None:
        """A field that is left open: what may stand there, and what its user has to find out."""
        key = path.rpartition(".")[2]
        self.text.append(f"# {key} = {toml_value(example)}  # open: {_one_line(question)}")
        self.open.append(f"{path}: {_one_line(question)}")


def toml_value(value: Any) -> str:
    """A value as TOML: texts, flags, numbers, lists, and tables of these in one line."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {toml_value(each)}" for key, each in value.items()) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(toml_value(each) for each in value) + "]"
    if isinstance(value, float):
        return f"{value + 0.0:g}"
    return json.dumps(value, ensure_ascii=False)


def _one_line(text: str) -> str:
    return " ".join("".join(letter if letter.isprintable() else " " for letter in text).split())


def listed(names: Collection[str]) -> str:
    """Names in a line, not too many."""
    shown = list(names)[:MOST_CHOICES]
    more = f" and {len(names) - len(shown)} more" if len(names) > len(shown) else ""
    return ", ".join(shown) + more


def rpy_of(turn: Array) -> tuple[float, float, float]:
    """Roll, pitch and yaw of a rotation as URDF counts them, radians."""
    pitch = math.asin(float(np.clip(-turn[2, 0], -1.0, 1.0)))
    if abs(turn[2, 0]) > 1.0 - 1e-9:
        return 0.0, pitch, math.atan2(-float(turn[0, 1]), float(turn[1, 1]))
    return math.atan2(float(turn[2, 1]), float(turn[2, 2])), pitch, math.atan2(float(turn[1, 0]), float(turn[0, 0]))
