"""Knowledge of earlier releases: read as it is, brought up to date once by whoever first adds to it."""

from __future__ import annotations

import multiprocessing
import shutil
import sqlite3
from dataclasses import replace
from pathlib import Path

import pytest
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from sqlalchemy import Connection, create_engine, insert, text
from sqlalchemy.pool import NullPool

from taskgist.errors import KnowledgeError
from taskgist.facts import Episode, Observation
from taskgist.learning import Answer, Context, Explanation, Knowledge, Verdict, explain
from taskgist.store import check, load, save, tables, update
from taskgist.store.connecting import transact

DATA = Path(__file__).parent / "data"
FILES = {"1": DATA / "knowledge_0_1_0.db", "2": DATA / "knowledge_0_3_0.db"}
"""Made by these releases from what ``taught`` gives, and the answer below; by the version of their tables."""
OLD = FILES["1"]


OLD_CONTEXT = Context("191e32c110a0", "1-29b9297d")
"""Settings and tree of that release."""


def taught(index: int, task: str = "show", end_s: float | None = None) -> Explanation:
    start = {"posture": Observation("Sitting", {"thigh_rad": 1.5}), "motion": Observation("Static")}
    end = {"posture": Observation("Sitting")}
    source = f"recording{index} 0.0000-{end_s or index:.4f} s"
    found = explain(Episode(task, f"Vorführung {index}", "P1", "P2", "cup", start, end, source=source))
    return replace(found, context=OLD_CONTEXT)


ANSWER = Answer("show", "see.class", Verdict.RELEVANT, author="ann", time="2024-05-01T12:00:00+00:00", value="x")
TAUGHT = Knowledge().add(taught(1), taught(2), taught(3, "hide")).answer(ANSWER)


@pytest.fixture(params=FILES)
def version_of_old(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def old(address: str, version_of_old: str) -> str:
    """Knowledge of an earlier release: its file, or the same tables and rows on a server."""
    file = FILES[version_of_old]
    if "://" not in address:
        shutil.copy(file, address)
        return address
    with sqlite3.connect(file) as source:
        made = [statement for (statement,) in source.execute("SELECT sql FROM sqlite_master WHERE sql IS NOT NULL")]
        rows = {name: source.execute(f"SELECT * FROM {name}").fetchall() for name in tables.METADATA.tables}
    source.close()

    def fill(connection: Connection) -> None:
        for statement in made:
            connection.execute(text(statement))
        for name, listed in rows.items():
            table = tables.METADATA.tables[name]
            columns = [column.name for column in table.columns][: len(listed[0])]
            connection.execute(insert(table), [dict(zip(columns, row, strict=True)) for row in listed])

    transact(address, fill)
    return address


def version(address: str) -> str:
    return transact(address, lambda connection: tables.version(connection, address), writing=False)


def test_reading_changes_nothing(old: str, version_of_old: str) -> None:
    before = Path(old).read_bytes() if Path(old).exists() else b""
    assert load(old) == TAUGHT
    assert load(old, tasks=["hide"]).tasks == ("hide",)
    check(old)
    assert version(old) == version_of_old
    assert (Path(old).read_bytes() if Path(old).exists() else b"") == before


def test_adding_brings_it_up_to_date(old: str, version_of_old: str) -> None:
    with pytest.raises(KnowledgeError, match="with another label"):
        update(old, [taught(1, end_s=9.0)], relabelled="refuse")
    assert version(old) == version_of_old, "a refusal leaves it as it was"
    update(old, [taught(2), taught(4)], relabelled="refuse")
    assert version(old) == tables.SCHEMA_VERSION
    assert load(old) == TAUGHT.add(taught(4))
    save(TAUGHT, old)
    assert load(old) == TAUGHT


def test_migrated_tables_are_those_that_are_made_anew(old: str) -> None:
    update(old, [taught(4)])

    def differences(connection: Connection) -> list[object]:
        return list(compare_metadata(MigrationContext.configure(connection), tables.METADATA))

    assert transact(old, differences) == []


def test_migrated_tables_are_found_different_where_they_are(tmp_path: Path) -> None:
    """The witness of the test above sees what it should."""
    engine = create_engine(f"sqlite:///{shutil.copy(OLD, tmp_path / 'k.db')}", poolclass=NullPool)
    with engine.connect() as connection:
        assert len(compare_metadata(MigrationContext.configure(connection), tables.METADATA)) == 5


def test_damaged_knowledge_is_not_brought_up_to_date(tmp_path: Path) -> None:
    path = tmp_path / "knowledge.db"
    shutil.copy(OLD, path)
    with sqlite3.connect(path) as connection:
        connection.execute("UPDATE taskgist_explanations SET document = '[]' WHERE task = 'hide'")
    connection.close()
    before = path.read_bytes()
    with pytest.raises(KnowledgeError, match=r"row '.*': not an explanation"):
        update(path, [taught(4)])
    assert path.read_bytes() == before


def _add(address: str, index: int) -> None:
    update(address, [taught(index)])


def test_many_may_bring_it_up_to_date_at_once(old: str) -> None:
    with multiprocessing.get_context("spawn").Pool(4) as pool:
        pool.starmap(_add, [(old, index) for index in range(4, 12)], chunksize=1)
    assert load(old) == TAUGHT.add(*(taught(index) for index in range(4, 12)))
