"""Values: symbols, raw attribute values, and *unknown*, a third value beside true and false."""

from __future__ import annotations

import copy
import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from decimal import Decimal
from enum import Enum
from pathlib import Path
from typing import Final, Generic, Literal, NoReturn, TypeAlias, TypeVar, cast

from taskgist.common.frozen import FrozenMap, Json, freeze, thaw
from taskgist.errors import FactsError, allowed_names
from taskgist.settings import Settings, Vision


class Unknown(Enum):
    """The type of ``UNKNOWN``. An enumeration, so that it stays one object through pickle and copy."""

    UNKNOWN = "unknown"

    def __bool__(self) -> NoReturn:
        raise TypeError("UNKNOWN is neither true nor false; compare it with `is UNKNOWN`")

    def __repr__(self) -> str:
        return "UNKNOWN"


UNKNOWN: Final[Literal[Unknown.UNKNOWN]] = Unknown.UNKNOWN
"""What could not be observed. It is never counted, and its truth value is an error."""

Value: TypeAlias = str | Unknown
"""What a node of the tree can be: a symbol, or unknown."""

Raw: TypeAlias = str | bool | float | Mapping[str, str | None] | Unknown
"""What an attribute is observed as: a symbol, truth, score, status by side (None: unknown), or unknown."""

V = TypeVar("V", bound=Raw)
V_co = TypeVar("V_co", bound=Raw, covariant=True)


@dataclass(frozen=True)
class Observation(Generic[V_co]):
    """What one attribute or node is, and what shows it.

    Args:
        value: ``Raw`` for an attribute at one instant, ``Value`` for a node of the tree.
        evidence: Plain JSON data behind the value: who occludes, which joint angles, which contact.
    """

    value: V_co
    evidence: Mapping[str, Json] = field(default_factory=FrozenMap)

    def __post_init__(self) -> None:
        object.__setattr__(self, "evidence", freeze(self.evidence))
        if isinstance(self.value, Mapping):
            object.__setattr__(self, "value", freeze(self.value))

    def and_also(self, value: V) -> Observation[V]:
        """Another value that the same evidence shows."""
        other = cast(Observation[V], copy.copy(self))
        object.__setattr__(other, "value", freeze(value) if isinstance(value, Mapping) else value)
        return other

    def to_json(self) -> dict[str, Json]:
        """Plain data with the keys ``value`` (null when unknown) and ``evidence``."""
        value = None if self.value is UNKNOWN else thaw(cast(Json, self.value))
        return {"value": value, "evidence": thaw(self.evidence)}


NOT_OBSERVED: Final[Observation[Unknown]] = Observation(UNKNOWN)
"""An attribute of which nothing is known."""


# Attributes (level 3): what is observed at one instant, and how it becomes a symbol (5.1-5.3).

NEGLIGIBLE = "≈ 0"
"""Symbol of a visibility score too small to count (Eq. 38: "≈ 0")."""


@dataclass(frozen=True)
class Attribute(ABC):
    """One observable property of the target agent or object.

    Args:
        name: Under which observations give it: ``"reach.effort"``, ``"posture"``.
        values: The symbols that it may take, in canonical order; empty where any text will do.
    """

    name: str
    values: tuple[str, ...] = ()

    @abstractmethod
    def read(self, raw: object, *, where: str | Path | None = None, field: str | None = None) -> Raw:
        """Check a raw value and give it in the form that comparisons expect.

        Raises:
            FactsError: The value is not one that this attribute can take.
        """

    @abstractmethod
    def symbol(self, raw: Raw, settings: Settings, /) -> Value:
        """Symbol of a raw value that ``read`` has returned."""

    @abstractmethod
    def schema(self) -> dict[str, Json]:
        """JSON Schema of the raw value."""


@dataclass(frozen=True)
class SymbolAttribute(Attribute):
    """Observed as a symbol; truth values give the symbols ``True`` and ``False``."""

    def read(self, raw: object, *, where: str | Path | None = None, field: str | None = None) -> Raw:
        """Check that the value is one of the symbols."""
        text = str(raw) if isinstance(raw, bool) else raw
        if not isinstance(text, str) or not text:
            raise FactsError("not a symbol", where=where, field=field, value=raw, hint=self._hint(raw))
        if self.values and text not in self.values:
            raise FactsError("no such value", where=where, field=field, value=raw, hint=self._hint(raw))
        return text

    def symbol(self, raw: Raw, _settings: Settings, /) -> Value:
        """The value itself."""
        assert isinstance(raw, str), raw
        return raw

    def schema(self) -> dict[str, Json]:
        """Text, one of the values; truth values too where they are values."""
        if not self.values:
            return {"type": "string", "minLength": 1}
        truths = [text == "True" for text in self.values if text in ("True", "False")]
        return {"enum": [*self.values, *truths]}

    def _hint(self, raw: object) -> str:
        return allowed_names(raw, self.values) if self.values else "give a text that is not empty"


@dataclass(frozen=True)
class ScoreAttribute(Attribute):
    """Observed as a fraction of the image; becomes a logarithmic bin (5.1.1, Fig. 9)."""

    def read(self, raw: object, *, where: str | Path | None = None, field: str | None = None) -> Raw:
        """Check that the value is a number from 0 to 1."""
        number = isinstance(raw, int | float) and not isinstance(raw, bool)
        if not (number and 0.0 <= cast(float, raw) <= 1.0):
            hint = "give the object's pixels / all pixels of the image, a number from 0 to 1"
            raise FactsError("not a visibility score", where=where, field=field, value=raw, hint=hint)
        return float(cast(float, raw))

    def symbol(self, raw: Raw, settings: Settings, /) -> Value:
        """Bin of the score, such as ``"0.64-1.3 %"``, or ``"≈ 0"``."""
        assert isinstance(raw, float), raw
        return score_bin(raw, settings.vision)

    def schema(self) -> dict[str, Json]:
        """A number from 0 to 1."""
        return {"type": "number", "minimum": 0, "maximum": 1}


SIDES = ("left", "right")
"""Sides of a body, each with a hand."""


@dataclass(frozen=True)
class SidedAttribute(Attribute):
    """Observed by side, ``{"left": s, "right": s}``, with None for a side that is not known (5.2.2)."""

    def read(self, raw: object, *, where: str | Path | None = None, field: str | None = None) -> Raw:
        """Check that there is at least one side and that each is one of the symbols or None."""
        if not isinstance(raw, Mapping) or not raw:
            hint = f"give a value for each side, such as {{'left': {self.values[0]!r}, 'right': None}}"
            raise FactsError("not a status by side", where=where, field=field, value=raw, hint=hint)
        for side, status in raw.items():
            place = f"{field or self.name}.{side}"
            if side not in SIDES:
                raise FactsError("no such side", where=where, field=place, hint=allowed_names(side, SIDES))
            if not (status is None or status in self.values):
                hint = allowed_names(status, self.values)
                raise FactsError("no such value", where=where, field=place, value=status, hint=hint)
        return FrozenMap({str(side): raw[side] for side in sorted(raw)})

    def symbol(self, raw: Raw, _settings: Settings, /) -> Value:
        """The common value where all sides agree, else each by its side; unknown if any side is."""
        assert isinstance(raw, Mapping), raw
        statuses = [status for status in raw.values() if status is not None]
        if len(statuses) < len(raw):
            return UNKNOWN
        if len(set(statuses)) == 1:
            return statuses[0]
        return ", ".join(f"{side}: {raw[side]}" for side in sorted(raw))

    def schema(self) -> dict[str, Json]:
        """An object of sides."""
        side: dict[str, Json] = {"enum": [*self.values, None]}
        sides: dict[str, Json] = dict.fromkeys(SIDES, side)
        return {"type": "object", "minProperties": 1, "properties": sides, "additionalProperties": False}


def score_bin(score: float, vision: Vision) -> str:
    """Fixed logarithmic bin of a visibility score (design: the bins depend on no demonstration).

    Args:
        score: Fraction of the image, 0 to 1.
        vision: Gives the negligible score, where the bins begin, and their width.
    """
    if score < vision.negligible_score:
        return NEGLIGIBLE
    doublings = math.log2(score / vision.negligible_score)
    return _bin_label(math.floor(doublings * vision.bins_per_doubling), vision)


def score_bins(vision: Vision) -> tuple[str, ...]:
    """All bins of a visibility score, from ``"≈ 0"`` to that of the whole image."""
    most = math.floor(-math.log2(vision.negligible_score) * vision.bins_per_doubling)
    return (NEGLIGIBLE, *(_bin_label(index, vision) for index in range(most + 1)))


def _bin_label(index: int, vision: Vision) -> str:
    low, high = (
        100.0 * vision.negligible_score * 2.0 ** (edge / vision.bins_per_doubling) for edge in (index, index + 1)
    )
    # Finer bins need more digits, so that no two of them share a label.
    digits = 2 + max(0, math.ceil(math.log10(vision.bins_per_doubling)))
    return f"{_rounded(low, digits)}-{_rounded(min(high, 100.0), digits)} %"


def _rounded(number: float, digits: int) -> str:
    """Text with this many significant digits, without an exponent."""
    return format(Decimal(f"{number:.{digits}g}"), "f")
