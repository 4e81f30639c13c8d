"""What is no knowledge, or cannot be reached or written: each has its own message and its own way out."""

from __future__ import annotations

import os
import pwd
import re
import shutil
import socket
import sqlite3
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import psycopg
import pytest

from taskgist.errors import KnowledgeError
from taskgist.settings import DEFAULT
from taskgist.store import check, load, save, shown, update
from tests.store.test_store import KNOWLEDGE, explanation

IMPATIENT = replace(DEFAULT.limits, knowledge_wait_s=0.2)


def foreign(path: Path) -> None:
    with sqlite3.connect(path) as connection:
        connection.execute("CREATE TABLE birds (name TEXT)")
    connection.close()


def changed(path: Path, statement: str) -> None:
    save(KNOWLEDGE, path)
    with sqlite3.connect(path) as connection:
        connection.execute(statement)
    connection.close()


def truncated(path: Path) -> None:
    save(KNOWLEDGE, path)
    path.write_bytes(path.read_bytes()[:5000])


DAMAGE: dict[str, tuple[Callable[[Path], object], str]] = {
    "missing": (lambda path: path.unlink(missing_ok=True), "no such knowledge file; learn something first"),
    "no database": (
        lambda path: path.write_text("give me the mug\n" * 99),
        "cannot be used as knowledge: file is not a database; give a knowledge file that taskgist wrote",
    ),
    "empty": (lambda path: path.write_bytes(b""), "a database, but not of taskgist"),
    "foreign": (foreign, "a database, but not of taskgist"),
    "truncated": (truncated, "is damaged knowledge: database disk image is malformed; restore it from a copy"),
    "newer": (
        lambda path: changed(path, "UPDATE taskgist_properties SET value = '99'"),
        "schema: another version of the tables (got '99'); this release reads version 3 and older: use",
    ),
    "bad text": (lambda path: changed(path, "UPDATE taskgist_explanations SET document = '{'"), "damaged document"),
    "bad digest": (
        lambda path: changed(path, "UPDATE taskgist_explanations SET document = replace(document, 'P2', 'P3')"),
        "digest: damaged explanation",
    ),
    "bad answer": (lambda path: changed(path, "UPDATE taskgist_answers SET document = '{}'"), "not an answer"),
    "lost table": (
        lambda path: changed(path, "DROP TABLE taskgist_answers"),
        "is damaged knowledge: no table taskgist_answers",
    ),
    "lost column": (lambda path: changed(path, "ALTER TABLE taskgist_answers DROP task"), "is damaged knowledge: "),
    "exchanged": (
        lambda path: changed(path, "UPDATE taskgist_explanations SET task = 'give'"),
        "task: does not fit its document (got 'give')",
    ),
    "misfiled": (
        lambda path: changed(path, "UPDATE taskgist_explanations SET recording_key = 'x'"),
        "recording_key: does not fit its document",
    ),
    "view": (lambda path: changed(path, "CREATE VIEW birds AS SELECT 1"), "a view or trigger, which taskgist never"),
    "no version": (lambda path: changed(path, "DELETE FROM taskgist_properties"), "another version of the tables"),
}


NOT_LOOKED_AT = ("bad answer", "lost column")
"""What an addition has nothing to do with."""


@pytest.mark.parametrize("kind", DAMAGE)
def test_what_is_no_knowledge_is_refused_and_left_as_it_is(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "knowledge.db"
    damage, message = DAMAGE[kind]
    damage(path)
    before = path.read_bytes() if path.is_file() else None
    with pytest.raises(KnowledgeError) as caught:
        load(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert message in str(caught.value)
    if before is not None:
        if kind not in NOT_LOOKED_AT:
            with pytest.raises(KnowledgeError):
                update(path, [explanation(9)])
        assert path.read_bytes() == before
    else:
        assert not path.is_file()


def test_a_foreign_file_is_not_overwritten(tmp_path: Path) -> None:
    path = tmp_path / "birds.db"
    foreign(path)
    before = path.read_bytes()
    with pytest.raises(KnowledgeError, match="not of taskgist"):
        save(KNOWLEDGE, path)
    assert path.read_bytes() == before


def row_changed(path: Path, table: str, document: object) -> None:
    """As a stranger may: a database without our constraints, and a document of any type."""
    save(KNOWLEDGE, path)
    with sqlite3.connect(path) as connection:
        connection.execute("PRAGMA writable_schema = ON")
        connection.execute("UPDATE sqlite_master SET sql = replace(sql, 'document TEXT NOT NULL', 'document TEXT')")
    connection.close()
    with sqlite3.connect(path) as connection:
        connection.execute(
            f"UPDATE {table} SET document = ? WHERE digest = (SELECT min(digest) FROM {table})", [document]
        )
    connection.close()


DEEP = "[" * 100_000
DOCUMENTS: dict[str, tuple[str, object, str]] = {
    "null explanation": ("taskgist_explanations", None, "damaged document: "),
    "null answer": ("taskgist_answers", None, "damaged document: "),
    "number": ("taskgist_explanations", 7, "not an explanation"),
    "list": ("taskgist_answers", "[1, 2]", "not an answer"),
    "bytes": ("taskgist_explanations", b"\xff\xfe\x00", "damaged document: "),
    "no unicode": ("taskgist_answers", '{"task": "\ud800"}'.encode("utf-8", "surrogatepass"), "not an answer"),
    "escaped half": ("taskgist_explanations", '{"task": "\\ud800"}', "not an explanation"),
    "deep": ("taskgist_explanations", DEEP, "damaged document: "),
    "deep answer": ("taskgist_answers", DEEP, "damaged document: "),
    "less deep": ("taskgist_explanations", '{"nodes": ' + "[" * 900 + "]" * 900 + "}", "not an explanation"),
    "long number": ("taskgist_explanations", "9" * 10_000, "damaged document: "),
    "unhashable": (
        "taskgist_answers",
        '{"author": "ann", "node": "see.class", "task": "show", "time": "2024-05-01T12:00:00+00:00", '
        '"value": {"a": 1}, "verdict": "relevant"}',
        "not an answer: TypeError('value: no text')",
    ),
}


@pytest.mark.parametrize("kind", DOCUMENTS)
def test_a_damaged_document_is_refused_and_its_row_named(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "knowledge.db"
    table, document, message = DOCUMENTS[kind]
    row_changed(path, table, document)
    with pytest.raises(KnowledgeError) as caught:
        load(path)
    with pytest.raises(KnowledgeError, match=re.escape(message)):
        load(path, evidence=False)
    assert str(caught.value).startswith(f"{path}: row '")
    assert message in str(caught.value)
    assert "; restore the file from a copy" in str(caught.value)
    assert len(str(caught.value)) < 1000


def test_evidence_that_is_nested_deeper_than_can_be_read_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "knowledge.db"
    save(KNOWLEDGE, path)
    with sqlite3.connect(path) as connection:
        for depth in (200, 400, 800):
            deep = '{"a":' * depth + "1" + "}" * depth
            connection.execute(
                "UPDATE taskgist_explanations SET document = replace(document, '\"evidence\":{}', ?)",
                [f'"evidence":{deep}'],
            )
    connection.close()
    with pytest.raises(KnowledgeError, match="explanation"):
        load(path)


# --- What may not be opened, or not be written.


def test_what_is_no_file_is_refused_by_name_without_waiting(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "folder").mkdir()
    with socket.socket(socket.AF_UNIX) as end:
        end.bind(str(tmp_path / "socket"))
    (tmp_path / "loop").symlink_to("loop")
    told = {
        str(tmp_path / "pipe"): "cannot be knowledge: it is a pipe; name a file",
        str(tmp_path / "folder"): "cannot be knowledge: it is a folder; name a file",
        str(tmp_path / "socket"): "cannot be knowledge: it is a socket; name a file",
        "/dev/zero": "cannot be knowledge: it is a device; name a file",
        str(tmp_path / "loop"): "cannot be read: Too many levels of symbolic links; check the path",
        f"{tmp_path}/a\0b": "embedded null byte; check the path",
        f"{tmp_path}/{'a' * 300}": "cannot be read: File name too long; check the path",
    }
    for path, message in told.items():
        for use in (load, check, update):
            with pytest.raises(KnowledgeError) as caught:
                use(path)
            assert message in str(caught.value)
            assert "\0" not in str(caught.value)


def test_a_read_only_file_can_be_read(tmp_path: Path) -> None:
    path = tmp_path / "knowledge.db"
    save(KNOWLEDGE, path)
    path.chmod(0o400)
    assert load(path) == KNOWLEDGE


@contextmanager
def without_rights() -> Iterator[None]:
    """Whoever runs the tests is nobody for a while, if it is root."""
    if os.geteuid() != 0:
        yield
        return
    nobody = pwd.getpwnam("nobody")
    os.setresgid(nobody.pw_gid, nobody.pw_gid, 0)
    os.setresuid(nobody.pw_uid, nobody.pw_uid, 0)
    try:
        yield
    finally:
        os.setresuid(0, 0, 0)
        os.setresgid(0, 0, 0)


@contextmanager
def open_to_all() -> Iterator[Path]:
    """A folder that other users get to; pytest's own are closed to them."""
    folder = Path(tempfile.mkdtemp())
    folder.chmod(0o755)
    try:
        yield folder
    finally:
        shutil.rmtree(folder)


NOT_WRITABLE = {
    "file/k.db": "is read-only: attempt to write a readonly database; allow writing the file and its folder",
    "folder/k.db": "is read-only: attempt to write a readonly database; allow writing the file and its folder",
    "folder/new.db": "cannot be written: the folder '",
    "secret/k.db": "cannot be opened: unable to open database file; allow reading the file",
}


def test_what_may_not_be_written_is_noticed_before_the_work() -> None:
    with open_to_all() as folder:
        for name, mode in (("file", 0o444), ("folder", 0o666), ("secret", 0o000)):
            (folder / name).mkdir()
            save(KNOWLEDGE, folder / name / "k.db")
            (folder / name / "k.db").chmod(mode)
        (folder / "file").chmod(0o777)
        (folder / "folder").chmod(0o555)
        with without_rights():
            for name, message in NOT_WRITABLE.items():
                for use in (check, lambda path: update(path, [explanation(9)])):
                    with pytest.raises(KnowledgeError) as caught:
                        use(folder / name)
                    assert str(caught.value).startswith(f"{folder / name}: {message}")
            assert load(folder / "file" / "k.db") == load(folder / "folder" / "k.db") == KNOWLEDGE
        (folder / "folder").chmod(0o755)


def test_a_full_disk_is_told_and_leaves_the_knowledge_as_it_was(tmp_path: Path) -> None:
    """A limit on pages stands for the disk: SQLite says the same of both."""
    path = tmp_path / "knowledge.db"
    save(KNOWLEDGE, path)
    from taskgist.store import tables

    adding = tables.add

    def on_a_full_disk(connection, *args, **options):  # type: ignore[no-untyped-def]
        connection.exec_driver_sql("PRAGMA max_page_count = 1")
        adding(connection, *args, **options)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tables, "add", on_a_full_disk)
        with pytest.raises(KnowledgeError, match=r"the disk is full: .*; free some space, or name a file on another"):
            update(path, [explanation(index) for index in range(4, 20)])
    assert load(path) == KNOWLEDGE


def test_who_waits_in_vain_is_told_for_how_long(tmp_path: Path) -> None:
    path = tmp_path / "knowledge.db"
    save(KNOWLEDGE, path)
    holding = sqlite3.connect(path, isolation_level=None)
    holding.execute("BEGIN EXCLUSIVE")
    for use in (
        lambda: update(path, [explanation(7)], limits=IMPATIENT),
        lambda: check(path, limits=IMPATIENT),
        lambda: load(path, limits=IMPATIENT),
    ):
        with pytest.raises(KnowledgeError) as caught:
            use()
        assert str(caught.value) == (
            f"{path}: waited 0.2 s in vain: another writes this knowledge: database is locked; do it again when that "
            "is done, or wait longer (setting limits.knowledge_wait_s)"
        )
    holding.execute("COMMIT")
    holding.close()
    update(path, [explanation(7)], limits=IMPATIENT)


# --- Servers.


def test_addresses_that_mean_no_database(tmp_path: Path) -> None:
    with pytest.raises(KnowledgeError, match=r"cannot be written: there is no folder '.*'; name a file"):
        save(KNOWLEDGE, tmp_path / "nowhere" / "knowledge.db")
    with pytest.raises(KnowledgeError, match="would not last"):
        save(KNOWLEDGE, "sqlite://")


def of(server: str, *, user: str = "postgres", name: str = "postgres") -> str:
    return f"postgresql://{user}@/{name}?{server.partition('?')[2]}"


def told(address: str, use: Callable[..., object] = load) -> str:
    with pytest.raises(KnowledgeError) as caught:
        use(address, limits=IMPATIENT)
    return str(caught.value)


def test_each_fault_of_a_server_has_its_own_way_out(server: str, database: str) -> None:
    assert "the server has no such database: " in told(of(server, name="birds"))
    assert "; check the name, or make it: createdb NAME" in told(of(server, name="birds"))
    assert "the server does not let this user in: " in told(of(server, user="bob"))
    assert "; check user and password: " in told(of(server, user="bob"))
    assert "a database without knowledge; learn something first: " in told(database)
    save(KNOWLEDGE, database)
    with psycopg.connect(database, autocommit=True) as connection:
        reader = f"reader_{os.urandom(4).hex()}"
        connection.execute(f"CREATE ROLE {reader} LOGIN".encode())
        connection.execute(f"GRANT SELECT ON ALL TABLES IN SCHEMA public TO {reader}".encode())
        readable = database.replace("postgres@", f"{reader}@")
        assert load(readable) == KNOWLEDGE
        assert "this user may not do that: permission denied for table" in told(readable, check)
        standby = f"{database}&options=-cdefault_transaction_read_only%3Don"
        assert "is read-only: " in told(standby, check)
        assert "; give the address of the server that takes changes" in told(standby, check)
        connection.execute("SELECT pg_advisory_lock(%s)", [0x7A5C6157])
        assert "waited 0.2 s in vain: another writes this knowledge: " in told(database, check)
        assert load(database, limits=IMPATIENT) == KNOWLEDGE, "readers need not wait"
        connection.execute("SELECT pg_advisory_unlock(%s)", [0x7A5C6157])
        connection.execute("DROP TABLE taskgist_answers")
    assert "is damaged knowledge: no table taskgist_answers; restore it from a copy" in told(database)


SECRET = "Geheim7"
HOPELESS = {
    f"postgresql://bob:{SECRET}@localhost:1/name": "the server cannot be reached: ",
    f"postgresql://bob@localhost:1/name?password={SECRET}": "the server cannot be reached: ",
    f"postgresql://bob:{SECRET}@nowhere.invalid/name": "the server cannot be reached: ",
    f"postgresql://bob:a@{SECRET}@localhost/name": "a password that cannot be told from the host; write @ as %40",
    f"postgresql://bob:a/{SECRET}@localhost:1/name": "the server cannot be reached",
    f"postgresql://bob:{SECRET}@[::1/name": "not a URL; give a path, or postgresql://USER@HOST/NAME",
    f"postgresql://bob:{SECRET}@localhost:port/name": "not a URL",
    f"postgresql://a/bob:{SECRET}@localhost:1/name": "the server cannot be reached",
    f"postgresql:/bob:{SECRET}@localhost/name": "no such knowledge file",
    f"postgresql://bob@localhost:1/name?sslpassword={SECRET}&connect_timeout=x": "the database refuses: ",
    f"postgresql://bob:{SECRET}@{'h' * 70}.é/name": "the driver cannot use this address: ",
    f"postgresql://bob:{SECRET}@localhost:1/name?birds={SECRET}": "the database refuses: invalid connection option",
    f"mysql://bob:{SECRET}@localhost/name": "no driver: ",
    f"birds://bob:{SECRET}@localhost/name": "no driver: ",
}


@pytest.mark.parametrize("address", HOPELESS)
def test_no_message_shows_a_password(address: str) -> None:
    message = told(address)
    assert HOPELESS[address] in message
    if "birds=" not in address:
        assert SECRET not in message
    assert SECRET not in shown(address).replace(f"birds={SECRET}", "")


def test_a_missing_driver_is_named_with_its_installation(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "psycopg", None)
    message = told("postgresql://localhost/name")
    assert "no driver: " in message
    assert message.endswith('; install its driver: pip install "taskgist[postgres]"')


@pytest.mark.parametrize(
    "address",
    [
        "host=x user=u password=hunter2",
        "postgresql://u:hunter2",
        "//u:hunter2@h/x",
        "postgresql://u:hun/hunter2@h/x",
        "postgresql://u@h/x?pwd=hunter2",
        "postgresql://u@h/x?p%61ssword=hunter2",
        "mssql+pyodbc:///?odbc_connect=DRIVER%3Dx;UID%3Du;PWD%3Dhunter2",
    ],
)
def test_a_password_is_not_shown_wherever_it_stands(address: str) -> None:
    assert "hunter2" not in shown(address)


@pytest.mark.parametrize("address", ["a/b:c.db", "postgresql://u@h:5432/x?host=/tmp", "postgresql://h:5432/x"])
def test_an_address_without_a_password_is_shown_as_it_is(address: str) -> None:
    assert shown(address) == address
