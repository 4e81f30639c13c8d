"""The exception tree: one base, a class per meaning, each message with its way out.

The text is built in ``__str__`` from plain fields, so that an error survives pickling and a process pool.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence
from pathlib import Path


class TaskgistError(Exception):
    """Base of every error that taskgist raises on purpose."""


class InputError(TaskgistError):
    """Bad input: says where it stands, what is wrong, and the way out.

    Args:
        problem: What is wrong, in one clause.
        where: File (and line or record) that holds it, if any.
        field: Name of the field, column or option, if any.
        value: The offending value, if any.
        hint: The way out.
    """

    def __init__(
        self,
        problem: str,
        *,
        where: str | Path | None = None,
        field: str | None = None,
        value: object = None,
        hint: str | None = None,
    ) -> None:
        super().__init__(problem)
        self.problem = problem
        self.where = None if where is None else str(where)
        self.field = field
        self.value = value
        self.hint = hint

    def __reduce__(self) -> tuple[object, ...]:
        """Restore keyword fields when unpickled."""
        return (_rebuild, (type(self), self.problem, self.where, self.field, self.value, self.hint))

    def __str__(self) -> str:
        place = ": ".join(_shortened(part) for part in (self.where, self.field) if part)
        text = f"{place}: {_shortened(self.problem)}" if place else _shortened(self.problem)
        if self.value is not None:
            text += f" (got {_shortened(repr(self.value))})"
        if not self.hint:
            return text
        return f"{text} {self.hint}" if self.hint.startswith("(") else f"{text}; {self.hint}"


class WorkerError(InputError):
    """A process that ended before the work that it was given was done."""


class SceneError(InputError):
    """A scene, model or profile that cannot be used."""


class MappingError(InputError):
    """An import mapping, or the tables that it names, that cannot be used."""


class RecordingError(InputError):
    """A recording that cannot be read, or does not hold what was asked of it."""


class LabelError(InputError):
    """A label that is missing, outside of its recording, or not supported."""


class FactsError(InputError):
    """Facts from elsewhere that do not fit the hypothesis tree."""


class KnowledgeError(InputError):
    """Knowledge that cannot be read, or does not fit the present settings or tree."""


class ContradictionError(KnowledgeError):
    """Answers about a task that cannot all be true."""


class UnknownNameError(InputError):
    """A name that does not exist; the message offers the one that was meant, and lists the nearest known ones.

    Args:
        kind: What was looked for: "agent", "object", "task".
        name: The name that was given.
        known: The names that exist.
        where: File that was searched, if any.
    """

    def __init__(self, kind: str, name: str, known: Iterable[str], where: str | Path | None = None) -> None:
        self.kind, self.name, self.known = kind, name, tuple(sorted(known))
        problem = f"no {kind} {_shortened(repr(name))}"
        super().__init__(problem, where=where, hint=f"{_guess(name, self.known)}(known: {_listed(name, self.known)})")

    def __reduce__(self) -> tuple[object, ...]:
        """Restore from the constructor's own arguments when unpickled."""
        return (type(self), (self.kind, self.name, self.known, self.where))


def nearest(name: str, known: Iterable[str]) -> str | None:
    """The known name that was probably meant, whatever its case; None if none is like it.

    Long names must agree in most letters; of names of three letters or fewer half is enough, so that P3 leads to P2.
    """
    by_folded = {each.casefold(): each for each in known}
    alike = 0.5 if len(name) <= 3 else 0.6
    found = difflib.get_close_matches(name.casefold(), by_folded, n=1, cutoff=alike)
    return by_folded[found[0]] if found else None


LONGEST = 600
"""Letters of a value, a name or a place that a message shows."""


def _shortened(text: str) -> str:
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}..."


def _rebuild(
    kind: type[InputError], problem: str, where: str | None, field: str | None, value: object, hint: str | None
) -> InputError:
    return kind(problem, where=where, field=field, value=value, hint=hint)


# --- The way out of a wrong name: the one that was meant, and the nearest others.

MOST_NAMES = 5
"""Names that a message lists."""


def most_read(limit: int, setting: str) -> str:
    """The way out of what is too large, such as "at most 4,096 bytes are read (setting limits.table_bytes)"."""
    unit = " bytes" if setting.endswith("_bytes") else ""
    return f"at most {limit:,}{unit} are read (setting limits.{setting})"


def allowed_names(given: object, allowed: Iterable[str]) -> str:
    """Text such as "did you mean 'Sitting'? (allowed: Standing, Sitting)"."""
    names = tuple(allowed)
    return f"{_guess(str(given), names)}(allowed: {_listed(str(given), names)})"


def _guess(given: str, names: Sequence[str]) -> str:
    near = nearest(given, names)
    return f"did you mean {near!r}? " if near else ""


def _listed(given: str, names: Sequence[str]) -> str:
    """Names in their order; of many only the nearest, and how many more there are."""
    if len(names) <= MOST_NAMES:
        return ", ".join(map(_shortened, names)) or "none"
    folded = given[:LONGEST].casefold()
    by_likeness = sorted(names, key=lambda name: -_likeness(folded, name[:LONGEST].casefold()))
    kept = set(by_likeness[:MOST_NAMES])
    listed = ", ".join(_shortened(name) for name in names if name in kept)
    return f"{listed} and {len(names) - MOST_NAMES} more"


def _likeness(one: str, other: str) -> float:
    return difflib.SequenceMatcher(None, one, other).ratio()
