"""Many write the same knowledge at once: none is refused, nothing is lost, and who is cut off comes again."""

from __future__ import annotations

import dataclasses
import multiprocessing
import sqlite3
import tempfile
import threading
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import psycopg
import pytest
from sqlalchemy import Connection

from taskgist.errors import KnowledgeError
from taskgist.learning import Explanation, Knowledge
from taskgist.settings import DEFAULT
from taskgist.store import load, save, tables, update
from tests.store import postgres
from tests.store.test_store import KNOWLEDGE, explanation

WRITERS, ADDITIONS, SHARED = 4, 6, 3


def _adding(address: str, writer: int) -> None:
    """What one writer adds, one after the other: some that all of them add, and its own."""
    for index in range(SHARED):
        update(address, [explanation(index)], relabelled="refuse")
    for index in range(ADDITIONS):
        update(address, [explanation(100 * (writer + 1) + index)], relabelled="refuse")


def in_processes(work: Callable[..., None], *each: tuple[Any, ...]) -> None:
    """Run in a process for each arguments, all at once; what one raises is raised."""
    with multiprocessing.get_context("spawn").Pool(len(each)) as pool:
        pool.starmap(work, each, chunksize=1)


def test_many_may_add_at_once_from_the_first_on(address: str) -> None:
    """The file is made, or the tables, by whoever comes first; the others wait."""
    in_processes(_adding, *((address, writer) for writer in range(WRITERS)))
    own = (100 * (writer + 1) + index for writer in range(WRITERS) for index in range(ADDITIONS))
    assert load(address) == Knowledge().add(*map(explanation, (*range(SHARED), *own)))


def test_many_threads_may_add_at_once(address: str) -> None:
    """Locks of files belong to processes: what one thread closes must not open the door to others."""
    wrong: list[Exception] = []

    def work(index: int) -> None:
        try:
            update(address, [explanation(index)], relabelled="refuse")
            load(address)
        except Exception as error:
            wrong.append(error)

    threads = [threading.Thread(target=work, args=(index,)) for index in range(12)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert wrong == []
    assert load(address) == Knowledge().add(*map(explanation, range(12)))


def relabelled(end_s: float) -> Explanation:
    return dataclasses.replace(explanation(1), source=f"recording 0.0000-{end_s:.4f} s")


def _labelled(address: str, end_s: float) -> None:
    update(address, [relabelled(end_s)], relabelled="refuse")


def test_of_two_labels_at_once_one_is_refused(address: str) -> None:
    with pytest.raises(KnowledgeError, match="with another label"):
        in_processes(_labelled, (address, 1.0), (address, 2.0), (address, 3.0))
    assert len(load(address).explanations) == 1


def test_readers_see_all_of_an_addition_or_nothing(address: str) -> None:
    save(KNOWLEDGE, address)
    pair = [explanation(20), explanation(21)]
    done = threading.Event()
    seen: set[int] = set()

    def read() -> None:
        while not done.is_set():
            seen.add(len({each.digest for each in load(address).explanations} & {each.digest for each in pair}))

    reader = threading.Thread(target=read)
    reader.start()
    for _ in range(10):
        update(address, pair)
        update(address, forget=[each.digest for each in pair])
    done.set()
    reader.join()
    assert seen <= {0, 2}


# --- Cut off.


def cutting(server: str, times: int, when: str) -> Callable[..., None]:
    """``tables.add``, whose connection is cut off by the server, before or after the rows are written."""
    adding, left = tables.add, [times]

    def add(connection: Connection, *args: Any, **options: Any) -> None:
        if when == "after":
            adding(connection, *args, **options)
        if left[0]:
            left[0] -= 1
            process = connection.exec_driver_sql("SELECT pg_backend_pid()").scalar()
            with psycopg.connect(server) as other:
                other.execute("SELECT pg_terminate_backend(%s)", [process])
        if when == "before":
            adding(connection, *args, **options)

    return add


@pytest.mark.parametrize("when", ["before", "after"])
def test_a_lost_connection_is_taken_up_again(
    server: str, database: str, when: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    save(KNOWLEDGE, database)
    monkeypatch.setattr(tables, "add", cutting(server, 2, when))
    update(database, [explanation(8)])
    assert load(database) == KNOWLEDGE.add(explanation(8))


def test_a_connection_that_is_lost_again_and_again_is_told(
    server: str, database: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    save(KNOWLEDGE, database)
    monkeypatch.setattr(tables, "add", cutting(server, 1000, "after"))
    with pytest.raises(KnowledgeError) as caught:
        update(database, [explanation(8)], limits=replace(DEFAULT.limits, knowledge_wait_s=0.3))
    assert "waited 0.3 s in vain: the connection to the database was lost: " in str(caught.value)
    assert "; do it again when the server is back, or wait longer (" in str(caught.value)
    assert load(database) == KNOWLEDGE


@pytest.mark.skipif(postgres.missing() is not None, reason=str(postgres.missing()))
def test_a_server_that_restarts_refuses_nobody_who_was_connected() -> None:
    with tempfile.TemporaryDirectory() as folder:
        Path(folder).chmod(0o711)
        server = postgres.Server(Path(folder) / "server")
        server.start()
        try:
            adding, restarts = tables.add, [1]

            def add(connection: Connection, *args: Any, **options: Any) -> None:
                if restarts:
                    restarts.pop()
                    server.stop()
                    threading.Timer(0.3, server.start).start()
                adding(connection, *args, **options)

            with pytest.MonkeyPatch.context() as patch:
                patch.setattr(tables, "add", add)
                update(server.url, [explanation(8)])
            assert load(server.url) == Knowledge().add(explanation(8))
        finally:
            server.stop()


@pytest.mark.parametrize("state", ["40001", "40P01", "57P03", "53300"])
def test_what_is_over_in_a_moment_is_tried_again(database: str, state: str, monkeypatch: pytest.MonkeyPatch) -> None:
    adding, left = tables.add, [2]

    def add(connection: Connection, *args: Any, **options: Any) -> None:
        adding(connection, *args, **options)
        if left[0]:
            left[0] -= 1
            raised = f"DO $$ BEGIN RAISE EXCEPTION 'later' USING ERRCODE = '{state}'; END $$"
            connection.exec_driver_sql(raised)

    monkeypatch.setattr(tables, "add", add)
    update(database, [explanation(8)])
    assert left == [0]
    assert load(database) == Knowledge().add(explanation(8))


def test_a_write_that_another_release_makes_meanwhile_is_no_conflict(database: str) -> None:
    """Rows that are there already, whoever wrote them and without our lock, are no error."""
    save(KNOWLEDGE, database)
    with psycopg.connect(database) as other:
        row = tables.explanation_row(explanation(8))
        columns = ", ".join(row)
        other.execute(
            f"INSERT INTO taskgist_explanations ({columns}) VALUES ({', '.join(['%s'] * len(row))})".encode(),
            list(row.values()),
        )
        thread = threading.Thread(target=update, args=(database, [explanation(8)]))
        thread.start()  # waits for the other's commit
        thread.join(0.1)
        assert thread.is_alive()
    thread.join()
    assert load(database) == KNOWLEDGE.add(explanation(8))


def test_a_writer_waits_for_the_one_before(tmp_path: Any) -> None:
    path = str(tmp_path / "knowledge.db")
    save(KNOWLEDGE, path)
    holding = sqlite3.connect(path, isolation_level=None, check_same_thread=False)
    holding.execute("BEGIN IMMEDIATE")
    thread = threading.Thread(target=update, args=(path, [explanation(8)]))
    thread.start()
    thread.join(0.1)
    assert thread.is_alive()
    assert load(path) == KNOWLEDGE, "readers need not wait"
    holding.execute("COMMIT")
    holding.close()
    thread.join()
    assert load(path) == KNOWLEDGE.add(explanation(8))
