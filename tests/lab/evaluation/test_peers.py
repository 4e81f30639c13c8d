"""Peers: behind their doors, and what they learn where they are installed."""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Callable
from types import ModuleType

import numpy as np
import pytest
from numpy.typing import NDArray

from taskgist.errors import InputError
from taskgist_lab.evaluation.learner import Coded, Codes
from taskgist_lab.evaluation.peers import Cn2, DecisionTree, Peer
from taskgist_lab.evaluation.robustness import MOST_RUNS, compared, makers
from taskgist_lab.evaluation.sheets import sheets_of
from tests.lab.evaluation.pools import study_pool

CODED = Coded.of(study_pool(12))


class Exact:
    """Holds where it saw the very same demonstration."""

    name, text = "exact", "remembers"

    def __init__(self) -> None:
        self.closed = False

    def judge(self, positives: Codes, negatives: Codes, tests: Codes) -> NDArray[np.bool_]:
        del negatives
        return np.asarray((tests[:, None] == positives[None]).all(axis=2).any(axis=1))

    def close(self) -> None:
        self.closed = True


def test_who_remembers_recognises_nothing_new(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(MOST_RUNS, "exact", 3)
    peer = Exact()
    found = compared(CODED, runs=5, seed=0, peers={"exact": lambda: peer})
    exact = [each for each in found.learners if each.name == "exact"]
    assert [each.negatives for each in exact] == [False, True]
    assert {table.overall.recall.mean for each in exact for table in each.tables} == {0.0}
    assert {each.runs for each in exact} == {3}
    assert peer.closed
    assert {each.runs for each in found.learners[:3]} == {5}


def test_the_paper_is_plain_intersection_up_to_six_demonstrations() -> None:
    """With one dissent, or more, among up to six, everything is irrelevant by its rule."""
    ours, _, plain = compared(CODED, runs=10, seed=0, peers={}).learners
    assert [each.name for each in (ours, plain)] == ["taskgist", "intersection"]
    assert ours.tables[:4] == plain.tables[:4]


def test_what_is_not_installed_is_told_with_the_way_to_it(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> ModuleType:
        raise ImportError(name)

    monkeypatch.setattr(importlib, "import_module", missing)
    monkeypatch.setattr(importlib.util, "find_spec", lambda _: None)
    found = compared(CODED, runs=2, seed=0, peers=makers(0))
    assert set(found.absent) == {"decision tree", "CN2", "Popper"}
    for name in ("decision tree", "CN2"):
        assert "pip install 'taskgist[" in found.absent[name]
    (sheet,) = sheets_of(found)
    assert "Popper" in sheet.note


def told_apart(peer: Peer) -> None:
    own = [CODED.of_task(task, held_out=False) for task in ("hide", "show")]
    tests = np.concatenate([CODED.of_task(task, held_out=True) for task in ("hide", "show")])
    assert peer.judge(own[0], own[1], tests).tolist() == [True] * 4 + [False] * 4
    assert peer.judge(own[0], own[1][:0], tests).all()


@pytest.mark.parametrize(("make", "module"), [(lambda: DecisionTree(0), "sklearn"), (Cn2, "Orange")])
def test_peers_learn_what_can_be_told_apart(make: Callable[[], Peer], module: str) -> None:
    if importlib.util.find_spec(module) is None:
        with pytest.raises(InputError, match="is not installed"):
            make()
        return
    peer = make()
    try:
        told_apart(peer)
    finally:
        peer.close()
