"""Pools are made once, extended, and never mixed with what would be made otherwise today."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from taskgist.errors import InputError, SceneError, UnknownNameError
from taskgist.pipeline import explain_recording
from taskgist.recording import Recording
from taskgist_lab.evaluation import pool as keeping
from taskgist_lab.evaluation import pool as making
from taskgist_lab.evaluation.pool import (
    NODES,
    SOURCES,
    Job,
    Source,
    Wanted,
    empty_pool,
    extended,
    kept_pool,
    means_of,
    read_pool,
)
from taskgist_lab.evaluation.values import CLEAN, Failure
from tests.lab.evaluation.standing import still


class Counting:
    """Plays nothing moving, counts, and fails at number 2."""

    def __init__(self) -> None:
        self.played: list[int] = []

    def __call__(self, task: str, *, seed: int, number: int) -> Recording:  # noqa: ARG002 - as players are called
        self.played.append(number)
        if number == 2:
            raise SceneError("no way", hint="run again")
        return still(task, number)


@pytest.fixture
def player(monkeypatch: pytest.MonkeyPatch) -> Counting:
    counting = Counting()
    sources = {**SOURCES, "still": Source("still", "nothing moves", ("hide",), counting)}
    monkeypatch.setattr(making, "SOURCES", sources)
    monkeypatch.setattr(keeping, "SOURCES", sources)
    return counting


def test_samples_are_what_was_judged(player: Counting) -> None:
    pool = extended(empty_pool("still", 7), 4, conditions=(CLEAN, "label-off"), processes=1)
    assert player.played == [0, 1, 2, 3]
    assert [(each.number, each.condition) for each in pool.samples] == [
        (number, condition) for number in (0, 1, 3) for condition in (CLEAN, "label-off")
    ]
    clean = pool.of("hide", held_out=False)[0]
    expected = explain_recording(still(), predicates=())
    assert clean.explanation(NODES, pool.context).values == expected.values
    assert clean.means == "standing still"
    assert pool.failures == (Failure("hide", 2, "", "no way; run again"),)


def test_a_pool_extended_is_the_pool_made_at_once(player: Counting) -> None:
    part = extended(empty_pool("still", 7), 2, processes=1)
    more = extended(part, 4, conditions=(CLEAN, "lost-30"), processes=1)
    assert more == extended(empty_pool("still", 7), 4, conditions=(CLEAN, "lost-30"), processes=1)
    player.played.clear()
    assert extended(more, 4, processes=1) is more
    assert player.played == []


def test_what_can_no_longer_be_made_is_not_extended(player: Counting) -> None:
    pool = extended(empty_pool("still", 7), 2, processes=1)
    changed = replace(pool.samples[0], values=(None, *pool.samples[0].values[1:]))
    with pytest.raises(InputError, match="not what it was"):
        extended(replace(pool, samples=(changed, *pool.samples[1:])), 3, processes=1)
    assert player.played[-1] == 0


def test_a_recording_that_cannot_be_judged_is_a_failure(player: Counting, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuses(*_: object, **__: object) -> None:
        raise SceneError("no such thing")

    monkeypatch.setattr(making, "explain_recording", refuses)
    samples, failures = Job("still", 0, "hide", 1, (CLEAN,)).done()
    assert (samples, failures) == ((), (Failure("hide", 1, CLEAN, "no such thing"),))
    assert player.played == [1]


def test_the_file_keeps_all_and_gives_what_is_wanted(player: Counting, tmp_path: Path) -> None:
    path = tmp_path / "pool.json.gz"
    four = kept_pool(path, Wanted("still", 7, 4, (CLEAN,)), processes=1)
    assert read_pool(path) == four
    player.played.clear()
    two = kept_pool(path, Wanted("still", 7, 2, (CLEAN,)), processes=1)
    assert player.played == []
    assert two == four.restricted(2)
    assert read_pool(path) == four
    assert kept_pool(None, Wanted("still", 7, 2, (CLEAN,)), processes=1) == two


def test_a_pool_of_another_seed_is_refused_and_stays(player: Counting, tmp_path: Path) -> None:
    path = tmp_path / "pool.json.gz"
    kept_pool(path, Wanted("still", 7, 1, (CLEAN,)), processes=1)
    before = path.read_bytes()
    with pytest.raises(InputError, match="another one"):
        kept_pool(path, Wanted("still", 8, 1, (CLEAN,)), processes=1)
    assert path.read_bytes() == before
    assert player.played == [0]


def test_a_source_that_is_none_and_a_folder_that_is_not_there() -> None:
    with pytest.raises(UnknownNameError, match="generator"):
        Wanted("dreams", 0, 3, (CLEAN,))
    with pytest.raises(InputError, match="no such folder"):
        kept_pool(Path("nowhere") / "pool.json.gz", Wanted("study", 0, 3, (CLEAN,)))


def test_a_negative_seed_is_refused() -> None:
    with pytest.raises(InputError, match=r"--seed: negative"):
        Wanted("study", -1, 3, (CLEAN,))


def test_a_pool_without_any_demonstration_tells_why(player: Counting, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuses(*_: object, **__: object) -> None:
        raise SceneError("no such thing")

    monkeypatch.setattr(making, "explain_recording", refuses)
    with pytest.raises(InputError, match="no demonstration could be played") as error:
        kept_pool(None, Wanted("still", 7, 2, (CLEAN,)), processes=1)
    assert "no such thing" in str(error.value)
    assert player.played == [0, 1]


def test_means_come_from_the_demonstrators_note() -> None:
    assert means_of(still()) == "standing still"
    assert means_of(replace(still(), provenance=type(still().provenance)())) == "still"
