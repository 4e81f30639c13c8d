"""A user's own predicates, such as *the object is on top of the white box* (end of 5.3), added from outside.

The symbolic half is a ``Subtree``; the other half, a function that observes it in a world state, travels with it
and is called by whoever observes. A package offers its predicates by an entry point of the group
``taskgist.predicates``; a script calls ``register``, or simply extends a tree:
``STANDARD_TREE.extended(predicate_subtree("on_box"))``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from importlib import metadata
from typing import Any

from taskgist.errors import FactsError
from taskgist.facts.standard import compare_statuses
from taskgist.facts.tree import Comparison, HypothesisTree, Leaf, Nature, NatureOf, Relation, Subtree
from taskgist.facts.values import SymbolAttribute

ENTRY_POINTS = "taskgist.predicates"
"""Group of the entry points that offer a ``Predicate``."""

_REGISTERED: dict[str, Predicate] = {}


@dataclass(frozen=True)
class Predicate:
    """A user's own aspect of the world.

    Args:
        subtree: What the tree is extended by.
        observe: Observes the subtree's attribute in a world state; None where facts come from elsewhere. Its
            arguments are those that the observing room documents.
    """

    subtree: Subtree
    observe: Callable[..., Any] | None = None


def predicate_subtree(
    name: str,
    values: tuple[str, ...] = ("True", "False"),
    *,
    compare: Comparison | None = None,
    nature: NatureOf | None = None,
    version: str = "1",
) -> Subtree:
    """Subtree of a user's own predicate, with the nodes ``name.class``, ``name.value.1`` and ``name.value.2``.

    Args:
        name: Name of subtree and attribute: ``"on_white_box"``.
        values: The symbols that it may take. Truth values observed as ``True`` and ``False`` are the symbols of
            that name.
        compare: Level 2; by default ``Maintaining(v)`` or ``Gaining(v2) & Losing(v1)``, as Eq. 20.
        nature: Level 1; none by default.
        version: To be raised when one of the functions changes its meaning.

    Raises:
        FactsError: The name is no identifier, or there are fewer than two values.
    """
    if not name.isidentifier():
        raise FactsError("not a name", field="name", value=name, hint="use letters, digits and underscores")
    if len(set(values)) < 2:
        raise FactsError("too few values", field=name, value=values, hint="a predicate needs two values or more")
    title = "_".join(part.capitalize() for part in name.split("_"))
    attribute = SymbolAttribute(name, values)
    return Subtree(
        name=name,
        attribute=attribute,
        relation=Relation(f"Relative_{title}", compare or compare_statuses),
        leaf=Leaf(attribute, "value", (f"Initial_{title}", f"Final_{title}")),
        nature=Nature(f"Nature_{title}", nature) if nature else None,
        version=version,
    )


def register(predicate: Predicate) -> None:
    """Make a predicate known to ``known_predicates``; one of the same name is replaced."""
    _REGISTERED[predicate.subtree.name] = predicate


def known_predicates() -> tuple[Predicate, ...]:
    """All predicates registered by call or offered by installed packages, by name.

    Raises:
        FactsError: An entry point cannot be loaded, or gives something else.
    """
    offered = (_load(entry) for entry in metadata.entry_points(group=ENTRY_POINTS))
    by_name = {predicate.subtree.name: predicate for predicate in offered} | _REGISTERED
    return tuple(by_name[name] for name in sorted(by_name))


def with_predicates(tree: HypothesisTree, predicates: Iterable[Predicate] | None = None) -> HypothesisTree:
    """A tree extended by predicates: by default by all that are known.

    Raises:
        FactsError: A name is taken, or as ``known_predicates``.
    """
    chosen = known_predicates() if predicates is None else predicates
    return tree.extended(*(predicate.subtree for predicate in chosen))


def _load(entry: metadata.EntryPoint) -> Predicate:
    where = f"entry point {entry.group}: {entry.name}"
    try:
        predicate = entry.load()
    except Exception as error:  # whatever a foreign module raises, its name belongs in the message
        hint = "mend or uninstall the package that offers it"
        raise FactsError(f"cannot be loaded: {error}", where=where, value=entry.value, hint=hint) from error
    if not isinstance(predicate, Predicate):
        hint = "let the entry point name a taskgist.facts.Predicate"
        raise FactsError("not a predicate", where=where, value=predicate, hint=hint)
    return predicate
