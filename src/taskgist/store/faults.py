"""What goes wrong with databases, each kind with its own way out."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

from sqlalchemy.exc import DBAPIError, IntegrityError, SQLAlchemyError


@dataclass(frozen=True)
class Fault:
    """A kind of failure."""

    problem: str
    """In one clause; the reason of the driver follows."""
    hint: str
    """The way out."""
    passing: bool = False
    """Whether it may be over in a moment: the whole transaction is tried again."""
    reconnecting: bool = False
    """The same, but only for those who were connected before."""


FOREIGN = Fault("cannot be used as knowledge", "give a knowledge file that taskgist wrote")
DAMAGED = Fault(
    "is damaged knowledge", "restore it from a copy, or learn anew from the recordings into another file or database"
)
WAITING = Fault("another writes this knowledge", "do it again when that is done", passing=True)
LOST = Fault("the connection to the database was lost", "do it again when the server is back", passing=True)
OTHER = Fault("the database refuses", "what it says names the reason; the address may be wrong")

SQLITE: Mapping[str, Fault] = {
    "SQLITE_BUSY": WAITING,
    "SQLITE_LOCKED": WAITING,
    "SQLITE_FULL": Fault("the disk is full", "free some space, or name a file on another disk; nothing has changed"),
    "SQLITE_IOERR": Fault("the disk fails", "look after the disk, then do it again; nothing has changed"),
    "SQLITE_READONLY_ROLLBACK": Fault(
        "a writer was killed, and what it left must be undone", "open it once as somebody who may write the file"
    ),
    "SQLITE_READONLY": Fault("is read-only", "allow writing the file and its folder, or name another file"),
    "SQLITE_CANTOPEN": Fault("cannot be opened", "allow reading the file, and writing its folder if it is added to"),
    "SQLITE_PERM": Fault("may not be used", "ask its owner for the permission, or name another file"),
    "SQLITE_NOTADB": FOREIGN,
    "SQLITE_CORRUPT": DAMAGED,
    "SQLITE_ERROR": DAMAGED,  # our statements are sound: a table or column is not what it was
}
"""By the beginning of SQLite's name of the error; the first that fits."""

POSTGRESQL: tuple[tuple[str, str, Fault], ...] = (
    ("55P03", "", WAITING),
    ("40001|40P01", "", LOST),
    (
        "57P0[123]|53300",
        "starting up|shutting down|recovery mode|too many clients|remaining connection slots",
        Fault("the server takes no connections now", "do it again later, or allow it more connections", passing=True),
    ),
    (
        "28...",
        "password authentication failed|no password supplied|authentication failed|no pg_hba.conf entry|role .* exist",
        Fault(
            "the server does not let this user in",
            "check user and password: postgresql://USER@HOST/NAME with the password in PGPASSWORD or ~/.pgpass",
        ),
    ),
    (
        "3D000",
        "database .* does not exist",
        Fault("the server has no such database", "check the name, or make it: createdb NAME"),
    ),
    ("42501", "", Fault("this user may not do that", "ask for the right to create and change tables there")),
    ("25006", "", Fault("is read-only", "give the address of the server that takes changes")),
    ("53100", "", Fault("the server's disk is full", "free some space there; nothing has changed")),
    ("42P01|42703|42P07", "", DAMAGED),
    (
        "08...",
        "connection (to server .*)?(failed|refused)|could not connect|failed to resolve|could not translate host"
        "|timeout expired|timed out|unreachable|No such file or directory",
        Fault("the server cannot be reached", "check host, port and network, and whether it runs", reconnecting=True),
    ),
)
"""Patterns of SQLSTATE and of text (connecting fails without a SQLSTATE); the first that fits."""


def fault_of(error: SQLAlchemyError) -> Fault:
    """The kind of a database's error."""
    if not isinstance(error, DBAPIError):
        return OTHER
    if error.connection_invalidated:
        return LOST
    if isinstance(error, IntegrityError):  # another wrote the same meanwhile, where no lock keeps others out
        return WAITING
    name = getattr(error.orig, "sqlite_errorname", None)
    if name or type(error.orig).__module__ == "sqlite3":
        return next((fault for start, fault in SQLITE.items() if str(name).startswith(start)), DAMAGED)
    state = getattr(error.orig, "sqlstate", None) or getattr(error.orig, "pgcode", None)
    for states, words, fault in POSTGRESQL:
        if re.fullmatch(states, state or "") or (not state and words and re.search(words, str(error.orig))):
            return fault
    return OTHER
