"""Frozen plain data: JSON values that nobody can change, compare by content and can be hashed, pickled and copied."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Generic, TypeAlias, TypeVar

Json: TypeAlias = "bool | int | float | str | Sequence[Json] | Mapping[str, Json] | None"
"""What JSON can say. Numbers are finite."""

K = TypeVar("K")
V = TypeVar("V")


class FrozenMap(Mapping[K, V], Generic[K, V]):
    """A mapping that never changes; ``set`` and ``without`` give changed copies.

    Unlike ``types.MappingProxyType`` it owns its content, has a hash, and survives pickle and copy.
    """

    __slots__ = ("_items",)

    def __init__(self, items: Mapping[K, V] | None = None) -> None:
        self._items: dict[K, V] = dict(items or {})

    def __getitem__(self, key: K) -> V:
        return self._items[key]

    def __iter__(self) -> Iterator[K]:
        return iter(self._items)

    def __len__(self) -> int:
        return len(self._items)

    def __hash__(self) -> int:
        return hash(frozenset(self._items.items()))

    def __repr__(self) -> str:
        return f"FrozenMap({self._items!r})"

    def __reduce__(self) -> tuple[object, ...]:
        """Pickle by content."""
        return (FrozenMap, (self._items,))

    def to_dict(self) -> dict[K, V]:
        """A copy that may be changed; much faster than going through the mapping's items."""
        return self._items.copy()

    def set(self, key: K, value: V) -> FrozenMap[K, V]:
        """Copy in which ``key`` has ``value``."""
        return FrozenMap({**self._items, key: value})

    def without(self, key: K) -> FrozenMap[K, V]:
        """Copy that lacks ``key``."""
        return FrozenMap({other: value for other, value in self._items.items() if other != key})


def freeze(value: Json) -> Json:
    """Deeply frozen copy: mappings become ``FrozenMap``, sequences tuples.

    Raises:
        TypeError: What is given is not JSON (an array, a number that is not finite, a key that is no text).
    """
    if value is None or isinstance(value, str | bool | int):
        return value
    if isinstance(value, float) and math.isfinite(value):
        return float(value)  # a plain float, also where a subclass (numpy.float64) was given
    if isinstance(value, Mapping) and all(isinstance(key, str) for key in value):
        return FrozenMap({key: freeze(item) for key, item in value.items()})
    if isinstance(value, Sequence) and not isinstance(value, bytes | bytearray):
        return tuple(freeze(item) for item in value)
    raise TypeError(f"not JSON: {value!r} ({type(value).__name__})")


def thaw(value: Json) -> Json:
    """Deep copy out of plain dictionaries and lists, as the ``json`` module wants them."""
    if isinstance(value, Mapping):
        return {key: thaw(item) for key, item in value.items()}
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [thaw(item) for item in value]
    return value


def canonical_text(value: Json) -> str:
    """The one text of this value: sorted keys, no spaces; equal values give equal texts."""
    return plain_text(thaw(value))


def plain_text(value: Any) -> str:
    """The same of what is plain already, as the ``json`` module reads it: nothing is copied."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
