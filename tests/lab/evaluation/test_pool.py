"""Pools: what they hold, their files, and what is refused."""

from __future__ import annotations

import gzip
from dataclasses import replace
from pathlib import Path

import pytest

from taskgist.errors import InputError
from taskgist.learning import Context
from taskgist_lab.evaluation.pool import HELD_OUT_EVERY, Pool, read_pool, write_pool
from taskgist_lab.evaluation.values import CLEAN, Failure
from taskgist_lab.paper.published import INTUITION
from tests.lab.evaluation.pools import NODES, sample, study_pool
from tests.learning.learning_samples import STUDY, explained, study

POOL = study_pool(6)


def test_learning_and_held_out_demonstrations_are_all_and_share_none() -> None:
    for task in STUDY:
        learn, judge = (POOL.of(task, held_out=held_out) for held_out in (False, True))
        assert {each.number for each in learn} | {each.number for each in judge} == set(range(6))
        assert len(judge) == 6 // HELD_OUT_EVERY
        assert not set(learn) & set(judge)


def test_tasks_are_in_the_order_of_the_table() -> None:
    assert POOL.tasks == tuple(INTUITION)
    other = replace(POOL.samples[0], task="balance")
    assert POOL.with_more([other]).tasks == (*INTUITION, "balance")


def test_what_is_held_out_stays_so_in_a_larger_pool() -> None:
    larger = study_pool(24)
    for task in STUDY:
        assert set(POOL.of(task, held_out=True)) <= set(larger.of(task, held_out=True))
    assert larger.restricted(6) == POOL


def test_order_does_not_matter_and_nothing_is_replaced() -> None:
    empty = replace(POOL, samples=())
    assert empty.with_more(reversed(POOL.samples)) == POOL
    changed = replace(POOL.samples[0], values=(None,) * len(NODES))
    assert POOL.with_more([changed]) == POOL


def test_an_explanation_comes_back_without_its_evidence() -> None:
    given = explained("show", 1, STUDY["show"][0])
    again = sample(given, 7).explanation(NODES, Context.of())
    assert again.values == given.values
    assert (again.task, again.context) == (given.task, given.context)


ENTAILING = tuple(replace(each, fulfilled=("hide", each.task)) for each in POOL.samples)


@pytest.mark.parametrize(
    "pool",
    [POOL, replace(POOL, samples=()), replace(POOL, samples=ENTAILING), study_pool(3, (CLEAN, "gap"))],
)
def test_a_pool_comes_back_from_its_file(pool: Pool, tmp_path: Path) -> None:
    pool = pool.with_more((), [Failure("hide", 9, "", "no way"), Failure("show", 2, "gap", "no label")])
    write_pool(pool, tmp_path / "pool.json.gz")
    assert read_pool(tmp_path / "pool.json.gz") == pool


def test_the_same_pool_gives_the_same_bytes(tmp_path: Path) -> None:
    first, second = tmp_path / "a.gz", tmp_path / "b.gz"
    write_pool(POOL, first)
    write_pool(POOL, second)
    assert first.read_bytes() == second.read_bytes()


def test_a_changed_file_is_noticed(tmp_path: Path) -> None:
    path = tmp_path / "pool.json.gz"
    write_pool(POOL, path)
    text = gzip.decompress(path.read_bytes())
    assert b"Becomes_Easier" in text
    path.write_bytes(gzip.compress(text.replace(b"Becomes_Easier", b"Becomes_Easy")))
    with pytest.raises(InputError, match="damaged"):
        read_pool(path)


def test_a_flipped_byte_is_noticed_wherever_it_is(tmp_path: Path) -> None:
    path = tmp_path / "pool.json.gz"
    write_pool(POOL, path)
    whole = path.read_bytes()
    for place in range(10, len(whole), 97):  # behind the header, whose time stamp nobody reads
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 0xFF]) + whole[place + 1 :])
        with pytest.raises(InputError, match="not a pool") as error:
            read_pool(path)
        assert str(path) in str(error.value)
        assert "another file" in str(error.value)


@pytest.mark.parametrize(
    "content",
    [b"", b"nothing", gzip.compress(b"[]"), gzip.compress(b'{"format": "x"}')],
    ids=["empty", "no gzip", "a list", "another format"],
)
def test_what_is_no_pool_is_refused(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "pool.json.gz"
    path.write_bytes(content)
    with pytest.raises(InputError, match="not a pool") as error:
        read_pool(path)
    assert str(path) in str(error.value)


def test_a_pool_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be written"):
        write_pool(POOL, tmp_path / "none" / "pool.json.gz")


@pytest.mark.parametrize(
    ("field", "changed"),
    [
        ("context", {"context": Context("other", "1-x")}),
        ("source", {"source": "generator"}),
        ("seed", {"seed": 3}),
    ],
)
def test_another_pool_is_refused(field: str, changed: dict[str, object]) -> None:
    with pytest.raises(InputError, match="another") as error:
        replace(POOL, **changed).check(Context.of(), source="study", seed=1000, where="pool.json.gz")  # type: ignore[arg-type]
    assert error.value.field == field
    assert "--pool" in str(error.value)
    POOL.check(Context.of(), source="study", seed=1000, where="pool.json.gz")


def test_the_pool_is_of_the_study() -> None:
    shown = [each.values for each in POOL.of("show", held_out=False)]
    told = [tuple(each.values.values()) for each in study("show").explanations.values()]
    kept = [NODES.index(name) for name in ("see.class", "reach.class", "posture.value.1")]
    assert {tuple(row[i] for i in kept) for row in shown} <= {tuple(row[i] for i in kept) for row in told}
