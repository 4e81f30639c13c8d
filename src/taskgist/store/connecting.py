"""Transactions: all of it is kept, or nothing; one writer at a time, and those who wait are told for how long.

**One writer at a time.** What is added depends on what is there (another label, other settings), so a writer looks
and writes while no other does. In a file that is SQLite's own lock, taken at the beginning (``BEGIN IMMEDIATE``);
waiting for it backs off. In PostgreSQL it is an advisory lock of the transaction, which also keeps two from making or
migrating the tables at once. Either is held for milliseconds. Readers are not kept out.

**One file.** A file keeps SQLite's rollback journal instead of a write-ahead log: between additions the knowledge is
one file, which can be copied, mailed, and kept on a network disk. Commits are synced, the folder too (``EXTRA``): what
was acknowledged outlasts a kill and a power failure.

**Once more.** A transaction that failed for a passing reason (a lost connection, a server that restarts) is done again
as a whole, with pauses that double. That is safe: what is added is added as a set.
"""

from __future__ import annotations

import random
import sqlite3
import time
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar
from urllib.parse import quote

from sqlalchemy import Engine, create_engine, event, text
from sqlalchemy.engine import URL, Connection
from sqlalchemy.engine.interfaces import DBAPIConnection
from sqlalchemy.exc import DBAPIError, NoSuchModuleError, SQLAlchemyError
from sqlalchemy.pool import NullPool

from taskgist.errors import KnowledgeError
from taskgist.settings import DEFAULT, Limits
from taskgist.store.address import Address, file_of, shown, url_of, without_secrets
from taskgist.store.faults import Fault, fault_of

T = TypeVar("T")

FIRST_PAUSE_S, LONGEST_PAUSE_S = 0.02, 1.0
"""Pauses between attempts double from the first to the longest; each is shortened at random, so that many spread."""
LONGEST_TURN_S = 0.03
"""The longest pause until a writer looks again whether it is its turn: a few times what another takes."""
LOCK = 0x7A5C6157
"""The advisory lock of PostgreSQL that writers hold: any number that others hardly use."""
DRIVERS = {"postgresql": 'pip install "taskgist[postgres]"', "mysql": "pip install mysqlclient"}
SERVER_LIMITS = {
    "connect_timeout": 10,  # seconds until another attempt, or a refusal
    "keepalives_idle": 10,  # seconds of silence after which a server is asked whether it is still there
    "keepalives_interval": 5,
    "keepalives_count": 3,
    "tcp_user_timeout": 30_000,  # milliseconds until what was sent must have been received
}
"""Bounds of libpq, so that a network that fails is noticed; a URL may say otherwise."""


def transact(
    address: Address, work: Callable[[Connection], T], *, writing: bool = True, limits: Limits = DEFAULT.limits
) -> T:
    """The result of some work inside a transaction.

    Args:
        address: Path of a file that exists, or URL.
        work: Reads and writes; may be done more than once, of which only the last counts.
        writing: Whether to keep other writers out from the start; a file to be read may be read-only.
        limits: How long to wait for others.

    Raises:
        KnowledgeError: The database cannot be reached, is none, or refuses; or others wrote all the time.
    """
    deadline, pause_s, before = time.monotonic() + limits.knowledge_wait_s, FIRST_PAUSE_S, False
    while True:
        left_s = max(0.0, deadline - time.monotonic())
        engine = _engine(address, writing=writing, wait_s=left_s)
        try:
            with _connected(engine, address) as connection:
                before = True
                with connection.begin():
                    return work(connection)
        except SQLAlchemyError as error:
            fault = fault_of(error)
            again = fault.passing or (fault.reconnecting and before)
            if not again or time.monotonic() + pause_s > deadline:
                raise _refusal(error, fault, address, limits.knowledge_wait_s if again else None) from error
        finally:
            engine.dispose()
        time.sleep(pause_s * random.uniform(0.5, 1.0))
        pause_s = min(2 * pause_s, LONGEST_PAUSE_S)


def _connected(engine: Engine, address: Address) -> Connection:
    try:
        return engine.connect()
    except SQLAlchemyError:
        raise
    except Exception as error:  # each driver reads hosts and options in its own way, and fails in its own way
        reason = without_secrets(str(error), address)
        hint = "check it: postgresql://USER@HOST/NAME"
        raise KnowledgeError(
            f"the driver cannot use this address: {reason}", where=shown(address), hint=hint
        ) from error


def _refusal(error: SQLAlchemyError, fault: Fault, address: Address, waited_s: float | None) -> KnowledgeError:
    reason = str(error.orig if isinstance(error, DBAPIError) else error).strip()
    lines = " ".join(without_secrets(reason, address).split())
    waited = "" if waited_s is None else f"waited {waited_s:g} s in vain: "
    hint = fault.hint if waited_s is None else f"{fault.hint}, or wait longer (setting limits.knowledge_wait_s)"
    return KnowledgeError(f"{waited}{fault.problem}: {lines}", where=shown(address), hint=hint)


def _engine(address: Address, *, writing: bool, wait_s: float) -> Engine:
    path = file_of(address)
    if path is not None:
        return _of_file(path, writing=writing, wait_s=wait_s)
    url = url_of(str(address))
    try:
        return _of_server(url, writing=writing, wait_s=wait_s)
    except (ImportError, NoSuchModuleError) as error:
        hint = f"install its driver: {DRIVERS.get(url.get_backend_name(), 'see the documentation of SQLAlchemy')}"
        raise KnowledgeError(f"no driver: {error}", where=shown(address), hint=hint) from error


def _of_file(path: Path, *, writing: bool, wait_s: float) -> Engine:
    def connect() -> sqlite3.Connection:
        address = f"file:{quote(bytes(path.absolute()))}?mode=rw"  # a file that vanished is not made anew
        return sqlite3.connect(address, uri=True, timeout=wait_s, isolation_level=None)

    engine = create_engine("sqlite://", creator=connect, poolclass=NullPool)

    @event.listens_for(engine, "connect")
    def _(connection: DBAPIConnection, _record: object) -> None:
        cursor = connection.cursor()
        cursor.execute("PRAGMA synchronous = EXTRA")
        cursor.execute("PRAGMA trusted_schema = OFF")
        cursor.close()

    @event.listens_for(engine, "begin")
    def _(connection: Connection) -> None:
        if writing:
            _begin_in_turn(connection, wait_s)
        else:
            connection.exec_driver_sql("BEGIN")

    return engine


def _begin_in_turn(connection: Connection, wait_s: float) -> None:
    """Begin as the one writer of a file.

    SQLite's own waiting comes to look but every 100 ms, so that whoever has just written is first again and others
    wait for seconds. Pauses that are short and at random let all of them have their turn.
    """
    driver, deadline, pause_s = connection.connection.driver_connection, time.monotonic() + wait_s, 0.001
    assert isinstance(driver, sqlite3.Connection), driver
    driver.execute("PRAGMA busy_timeout = 0")
    while time.monotonic() < deadline:
        try:
            driver.execute("BEGIN IMMEDIATE")
        except sqlite3.OperationalError as error:
            if not error.sqlite_errorname.startswith("SQLITE_BUSY"):
                break
            time.sleep(random.uniform(0.0, pause_s))
            pause_s = min(2 * pause_s, LONGEST_TURN_S)
        else:
            driver.execute(f"PRAGMA busy_timeout = {round(1000 * wait_s)}")  # for readers, who are soon done
            return
    connection.exec_driver_sql("BEGIN IMMEDIATE")  # once more: what is wrong is told as all other faults are


def _of_server(url: URL, *, writing: bool, wait_s: float) -> Engine:
    if url.get_backend_name() != "postgresql":
        return create_engine(url, poolclass=NullPool)
    if url.drivername == "postgresql":
        url = url.set(drivername="postgresql+psycopg")
    bounds = {name: value for name, value in SERVER_LIMITS.items() if name not in url.query}
    engine = create_engine(
        url,
        poolclass=NullPool,
        # Each look of a writer sees what was kept before it got the lock; all looks of a reader see the same.
        isolation_level="READ COMMITTED" if writing else "REPEATABLE READ",
        connect_args=bounds if url.get_driver_name() in ("psycopg", "psycopg2") else {},
    )

    @event.listens_for(engine, "begin")
    def _(connection: Connection) -> None:
        wait = text("SELECT set_config('lock_timeout', :wait, true)")
        connection.execute(wait, {"wait": f"{max(1, round(1000 * wait_s))}ms"})
        if writing:
            connection.execute(text("SELECT pg_advisory_xact_lock(:lock)"), {"lock": LOCK})

    return engine
