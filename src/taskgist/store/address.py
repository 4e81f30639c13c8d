"""Where knowledge lies: a file (SQLite) or the URL of a shared database (PostgreSQL)."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from sqlalchemy import Engine, create_engine, event
from sqlalchemy.engine import URL, Connection, make_url
from sqlalchemy.engine.interfaces import DBAPIConnection
from sqlalchemy.exc import ArgumentError, DBAPIError, NoSuchModuleError, SQLAlchemyError
from sqlalchemy.pool import NullPool

from taskgist.errors import KnowledgeError

Address = str | Path
"""Path of a file, or a URL such as ``postgresql://user@host/name``."""


def file_of(address: Address) -> Path | None:
    """The file that an address means, or None for a database server."""
    if isinstance(address, Path) or "://" not in address:
        return Path(address)
    url = _url(address)
    if url.get_backend_name() != "sqlite":
        return None
    if url.database in (None, "", ":memory:"):
        raise KnowledgeError("would not last", where=address, hint="give the path of a file: sqlite:///knowledge.db")
    return Path(str(url.database))


def shown(address: Address) -> str:
    """The address as text, without its password."""
    if isinstance(address, Path) or "://" not in address:
        return str(address)
    return _url(address).render_as_string(hide_password=True)


@contextmanager
def transaction(address: Address, *, writing: bool = True) -> Iterator[Connection]:
    """A connection inside a transaction: all of it is kept, or nothing.

    Args:
        address: Path or URL.
        writing: Whether to keep other writers of a file out from the start; a file to be read may be read-only.

    Raises:
        KnowledgeError: The database cannot be reached, is none, or refuses.
    """
    engine = _engine(address, writing=writing)
    try:
        with engine.begin() as connection:
            yield connection
    except SQLAlchemyError as error:
        reason = error.orig if isinstance(error, DBAPIError) else error
        hint = "give a knowledge file that taskgist wrote, or the URL of a database that you may use"
        raise KnowledgeError(f"cannot be used as knowledge: {reason}", where=shown(address), hint=hint) from error
    finally:
        engine.dispose()


def _engine(address: Address, *, writing: bool) -> Engine:
    path = file_of(address)
    url = _url(str(address)) if path is None else URL.create("sqlite", database=str(path))
    try:
        engine = create_engine(url, poolclass=NullPool)
    except (ImportError, NoSuchModuleError) as error:
        drivers = {"postgresql": 'pip install "psycopg[binary]"', "mysql": "pip install mysqlclient"}
        hint = f"install its driver: {drivers.get(url.get_backend_name(), 'see the documentation of SQLAlchemy')}"
        raise KnowledgeError(f"no driver: {error}", where=shown(address), hint=hint) from error
    if path is not None:
        _begin_explicitly(engine, "BEGIN IMMEDIATE" if writing else "BEGIN")
    return engine


def _begin_explicitly(engine: Engine, statement: str) -> None:
    """Begin transactions ourselves; as writers at once, so that two who add wait for each other instead of failing."""

    @event.listens_for(engine, "connect")
    def _(connection: DBAPIConnection, _record: object) -> None:
        connection.isolation_level = None  # the driver must not begin on its own

    @event.listens_for(engine, "begin")
    def _(connection: Connection) -> None:
        connection.exec_driver_sql(statement)


def _url(address: str) -> URL:
    try:
        return make_url(address)
    except ArgumentError as error:
        raise KnowledgeError("not a URL", where=address, hint="give a path, or postgresql://user@host/name") from error
