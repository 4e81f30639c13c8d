"""Knowledge that lasts: saved, loaded, and added to, so that a failure loses nothing.

Knowledge lies in a SQLite file, which a path means, or in a shared database (PostgreSQL), which a URL means. A file
comes into being complete, under its name, or not at all. Whatever is added later, by one process or several, is added
in one transaction, as a union.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from sqlalchemy import Engine, create_engine, event
from sqlalchemy.engine import URL, Connection, make_url
from sqlalchemy.engine.interfaces import DBAPIConnection
from sqlalchemy.exc import ArgumentError, DBAPIError, NoSuchModuleError, SQLAlchemyError
from sqlalchemy.pool import NullPool

from taskgist.errors import KnowledgeError
from taskgist.learning.explanation import Context, Explanation
from taskgist.learning.knowledge import Knowledge
from taskgist.learning.understanding import Answer
from taskgist.store import tables

Address = str | Path
"""Path of a file, or a URL such as ``postgresql://user@host/name``."""


def load(address: Address, *, expected: Context | None = None) -> Knowledge:
    """Knowledge as it was saved.

    Args:
        address: Path of a knowledge file, or URL of a database.
        expected: Settings and tree that its explanations must have been made with; None takes any.

    Raises:
        KnowledgeError: There is none, it is damaged, foreign, of another version, or made with other settings or
            another tree than expected.
    """
    path = file_of(address)
    if path is not None and not path.is_file():
        hint = "learn something first: it is made by learning"
        raise KnowledgeError("no such knowledge file", where=shown(address), hint=hint)
    with transaction(address, writing=False) as connection:
        tables.check(connection, shown(address))
        knowledge = tables.read(connection, shown(address))
    _check_context(knowledge, expected, shown(address))
    return knowledge


def save(knowledge: Knowledge, address: Address) -> None:
    """Let a file or database hold this knowledge, in place of what it held.

    Args:
        knowledge: What is to be kept.
        address: Path of a knowledge file, new or to be replaced, or URL of a database.

    Raises:
        KnowledgeError: What lies there is not taskgist's, or cannot be written.
    """
    path = file_of(address)
    if path is not None and not path.exists() and _created(path, knowledge):
        return
    with transaction(address) as connection:
        _prepare(connection, address)
        tables.write(connection, knowledge)


def update(
    address: Address,
    explanations: Iterable[Explanation] = (),
    answers: Iterable[Answer] = (),
    *,
    forget: Iterable[str] = (),
    allow_mixed: bool = False,
) -> Knowledge:
    """Add to the knowledge at an address, which is made if it does not exist; all is added, or nothing.

    Args:
        address: Path of a knowledge file, or URL of a database.
        explanations: Demonstrations to add; those that are known already change nothing.
        answers: Answers to add.
        forget: Digests of explanations to remove in the same step.
        allow_mixed: Add explanations that were made with other settings or another tree.

    Returns:
        The knowledge as it is now.

    Raises:
        KnowledgeError: As ``load`` and ``Knowledge.add``. Nothing has been written then.
    """
    added = Knowledge().add(*explanations, allow_mixed=allow_mixed).answer(*answers)
    path = file_of(address)
    if path is not None and not path.exists() and _created(path, added):
        return added
    with transaction(address) as connection:
        _prepare(connection, address)
        tables.forget(connection, forget)
        known = tables.read(connection, shown(address))
        wanted = known.merge(added, allow_mixed=allow_mixed)
        tables.append(connection, known=known, wanted=wanted)
    return wanted


def _prepare(connection: Connection, address: Address) -> None:
    """A server's database may be empty and gets the tables; a file must have them, lest a foreign one be changed."""
    if file_of(address) is None:
        tables.create(connection)
    tables.check(connection, shown(address))


def _created(path: Path, knowledge: Knowledge) -> bool:
    """Make a new file, whole or not at all; false if somebody else made one of this name meanwhile."""
    try:
        with tempfile.TemporaryDirectory(dir=path.parent, prefix=f".{path.name}.") as folder:
            draft = Path(folder) / "draft"
            with transaction(draft) as connection:
                tables.create(connection)
                tables.write(connection, knowledge)
            return _named(draft, path)
    except OSError as error:
        hint = "choose a folder that exists and that you may write to"
        raise KnowledgeError(f"cannot be written: {error.strerror}", where=path, hint=hint) from error


def _named(draft: Path, path: Path) -> bool:
    try:
        path.hardlink_to(draft)  # unlike a renaming, this never replaces what another process has just made
    except FileExistsError:
        return False
    except OSError:  # a file system without links
        draft.replace(path)
    return True


def _check_context(knowledge: Knowledge, expected: Context | None, where: str) -> None:
    others = knowledge.contexts - {expected}
    if expected is not None and others:
        hint = "use the settings and the tree that made it, or learn anew from the recordings into another file"
        made = "; ".join(sorted(map(str, others)))
        raise KnowledgeError(f"made with {made}, while {expected} is in use", where=where, hint=hint)


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
