"""Results as plain data."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any


@dataclass(frozen=True)
class Result:
    """What an experiment found."""

    def to_json(self) -> dict[str, Any]:
        """Plain data: numbers, texts, lists and dictionaries."""
        return asdict(self)
