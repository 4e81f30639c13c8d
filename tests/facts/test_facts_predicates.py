"""A user's own predicates, by call and by entry point."""

from __future__ import annotations

from importlib import metadata
from typing import Any

import pytest

from taskgist.errors import FactsError
from taskgist.facts import (
    STANDARD_TREE,
    Observation,
    Predicate,
    known_predicates,
    predicate_subtree,
    predicates,
    register,
)

ON_BOX = Predicate(predicate_subtree("on_white_box"))


def test_truth_values_become_symbols_and_compare_as_placements_do() -> None:
    tree = STANDARD_TREE.extended(ON_BOX.subtree)
    nodes = tree.instantiate({"on_white_box": Observation(False)}, {"on_white_box": Observation(True)})
    assert nodes["on_white_box.value.1"].value == "False"
    assert nodes["on_white_box.class"].value == "Gaining(True) & Losing(False)"
    stays = tree.instantiate({"on_white_box": Observation(True)}, {"on_white_box": Observation("True")})
    assert stays["on_white_box.class"].value == "Maintaining(True)"
    assert "on_white_box.nature" not in nodes
    assert tree.node("on_white_box.value.2").title == "Final_On_White_Box"


def test_own_comparison_and_nature() -> None:
    subtree = predicate_subtree(
        "room",
        ("kitchen", "hall"),
        compare=lambda initial, final, _settings: "Same" if initial == final else "Other",
        nature=lambda relation, _final: f"Nature of {relation}",
    )
    nodes = STANDARD_TREE.extended(subtree).instantiate({"room": Observation("kitchen")}, {"room": Observation("hall")})
    assert (nodes["room.class"].value, nodes["room.nature"].value) == ("Other", "Nature of Other")


def test_unusable_declarations_are_refused() -> None:
    with pytest.raises(FactsError, match="use letters, digits and underscores"):
        predicate_subtree("on the box")
    with pytest.raises(FactsError, match="two values or more"):
        predicate_subtree("on_box", ("True", "True"))


class Entry:
    """Stands for an installed package's entry point."""

    group, name, value = predicates.ENTRY_POINTS, "box", "my_package:PREDICATE"

    def __init__(self, loaded: object) -> None:
        self.loaded = loaded

    def load(self) -> object:
        if isinstance(self.loaded, Exception):
            raise self.loaded
        return self.loaded


def offer(monkeypatch: pytest.MonkeyPatch, loaded: object) -> None:
    def entry_points(**given: Any) -> list[Entry]:
        assert given == {"group": "taskgist.predicates"}
        return [Entry(loaded)]

    monkeypatch.setattr(metadata, "entry_points", entry_points)
    monkeypatch.setattr(predicates, "_REGISTERED", {})


def test_registered_and_installed_predicates_are_found(monkeypatch: pytest.MonkeyPatch) -> None:
    offer(monkeypatch, ON_BOX)
    other = Predicate(predicate_subtree("in_sight"), observe=lambda: True)
    register(other)
    assert known_predicates() == (other, ON_BOX)


def test_an_own_registration_comes_before_an_installed_predicate(monkeypatch: pytest.MonkeyPatch) -> None:
    offer(monkeypatch, ON_BOX)
    own = Predicate(predicate_subtree("on_white_box", version="2"))
    register(own)
    assert known_predicates() == (own,)


@pytest.mark.parametrize(
    ("loaded", "problem"), [(ImportError("no box"), "cannot be loaded: no box"), ("x", "not a pred")]
)
def test_a_broken_entry_point_is_named(monkeypatch: pytest.MonkeyPatch, loaded: object, problem: str) -> None:
    offer(monkeypatch, loaded)
    with pytest.raises(FactsError, match=f"entry point taskgist.predicates: box: {problem}"):
        known_predicates()
