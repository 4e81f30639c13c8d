"""Tables in Markdown."""

from __future__ import annotations

from collections.abc import Iterator


def header(*titles: str) -> Iterator[str]:
    """The first two lines of a table."""
    yield row(*titles)
    yield row(*["---"] * len(titles))


def row(*cells: object) -> str:
    """One line of a table."""
    return f"| {' | '.join(map(str, cells))} |"
