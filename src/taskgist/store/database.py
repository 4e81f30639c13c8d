"""Knowledge that lasts: saved, loaded, and added to, so that a failure loses nothing.

Knowledge lies in a SQLite file, which a path means, or in a shared database (PostgreSQL), which a URL means. A file
comes into being complete, under its name, or not at all. Whatever is added later, by one process or many, is added in
one transaction, as a union.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable, Mapping
from pathlib import Path

from sqlalchemy import create_engine
from sqlalchemy.engine import Connection
from sqlalchemy.pool import NullPool

from taskgist.common.files import check_replaceable, writing
from taskgist.errors import KnowledgeError
from taskgist.learning.answers import Answer
from taskgist.learning.explanation import Context, Explanation
from taskgist.learning.knowledge import Knowledge
from taskgist.settings import DEFAULT, Limits
from taskgist.store import tables
from taskgist.store.address import Address, file_of, is_there, shown
from taskgist.store.connecting import transact


def load(
    address: Address,
    *,
    expected: Context | None = None,
    tasks: Iterable[str] | None = None,
    evidence: bool = True,
    limits: Limits = DEFAULT.limits,
) -> Knowledge:
    """Knowledge as it was saved, by this release or an earlier one; nothing is changed by reading.

    Args:
        address: Path of a knowledge file, or URL of a database.
        expected: Settings and tree that its explanations must have been made with; None takes any.
        tasks: Only what was learned of these; None takes all.
        evidence: Whether explanations keep the evidence of their facts. Without it they take a tenth of the memory, are
            read faster, and serve to learn, to recognise and to plan; they cannot be saved.
        limits: How long to wait for writers.

    Raises:
        KnowledgeError: There is none, it is damaged, foreign, of a newer version, or made with other settings or
            another tree than expected.
    """
    where, path = shown(address), file_of(address)
    if path is not None and not is_there(path):
        hint = "learn something first: it is made by learning"
        raise KnowledgeError("no such knowledge file", where=where, hint=hint)
    wanted = None if tasks is None else list(tasks)
    # What was fetched is looked into when the transaction is over, so that nobody waits for it.
    fetched = transact(address, lambda held: tables.rows(held, where, tasks=wanted), writing=False, limits=limits)
    knowledge = tables.knowledge(*fetched, where, evidence=evidence)
    _check_contexts(knowledge.contexts, expected, where)
    return knowledge


def save(knowledge: Knowledge, address: Address, *, limits: Limits = DEFAULT.limits) -> None:
    """Let a file or database hold this knowledge, in place of what it held.

    Args:
        knowledge: What is to be kept.
        address: Path of a knowledge file, new or to be replaced, or URL of a database.
        limits: How long to wait for other writers.

    Raises:
        KnowledgeError: What lies there is not taskgist's, or cannot be written.
    """

    def write(connection: Connection) -> None:
        _prepare(connection, address)
        tables.write(connection, knowledge)

    if not _is_new(address, knowledge):
        transact(address, write, limits=limits)


def update(
    address: Address,
    explanations: Iterable[Explanation] = (),
    answers: Iterable[Answer] = (),
    *,
    forget: Iterable[str] = (),
    relabelled: tables.Relabelled = "add",
    allow_mixed: bool = False,
    limits: Limits = DEFAULT.limits,
) -> None:
    """Add to the knowledge at an address, which is made if it does not exist; all is added, or nothing.

    It costs what is added, whatever the knowledge holds. When it returns, what was added is on the disk.

    Args:
        address: Path of a knowledge file, or URL of a database.
        explanations: Demonstrations to add; those that are known already change nothing.
        answers: Answers to add.
        forget: Digests of explanations to remove in the same step.
        relabelled: What becomes of a recording that was learned from already, for the same agent and object, with
            another label or other times: "add" counts both, "refuse" raises, "replace" forgets the older one.
        allow_mixed: Add explanations that were made with other settings or another tree.
        limits: How long to wait for other writers.

    Raises:
        KnowledgeError: As ``load`` and ``Knowledge.add``. Nothing has been written then.
    """
    added = Knowledge().add(*explanations, allow_mixed=allow_mixed).answer(*answers)
    tables.check_rivals(added.explanations, relabelled)
    gone = list(forget)

    def add(connection: Connection) -> None:
        _prepare(connection, address)
        tables.forget(connection, gone)
        tables.add(connection, added, shown(address), relabelled=relabelled, allow_mixed=allow_mixed)

    if not _is_new(address, added):
        transact(address, add, limits=limits)


def check(
    address: Address,
    *,
    expected: Context | None = None,
    tasks: Iterable[str] | None = None,
    added: Iterable[Explanation] = (),
    relabelled: tables.Relabelled = "add",
    names: Mapping[str, str] = tables.NO_NAMES,
    limits: Limits = DEFAULT.limits,
) -> None:
    """Refuse an address at which ``update`` would fail, before any long work. Nothing is changed.

    Args:
        address: Path of a knowledge file, which need not exist, or URL of a database.
        expected: Settings and tree that its explanations must have been made with; None takes any.
        tasks: Of which ``load`` must be able to read afterwards what was learned; it need not if left out.
        added: Explanations that are to be added, as far as they are known: of their facts none need be.
        relabelled: As ``update``.
        names: What they are called in errors, by digest, such as their files; else by their demonstrations.
        limits: How long to wait for other writers.

    Raises:
        KnowledgeError: As ``load``; it cannot be written; or a recording has another label, and that is refused.
    """
    path, where = file_of(address), shown(address)
    wanted = tuple(added)
    tables.check_rivals(wanted, relabelled, names)
    if path is not None and not is_there(path):
        check_replaceable(path, replace=True, error=KnowledgeError)
        return

    def rehearse(connection: Connection) -> frozenset[Context]:
        _prepare(connection, address)
        tables.touch(connection)
        found = frozenset(each.context for each in tables.contexts(connection, where))
        if relabelled == "refuse":
            tables.check_learned(connection, wanted, where, names)
        connection.rollback()
        return found

    found = transact(address, rehearse, limits=limits)
    _check_contexts(found, expected, where)
    if found and tasks is not None:
        load(address, tasks=tasks, limits=limits)


def create(path: Path, knowledge: Knowledge) -> bool:
    """Make a new knowledge file, whole or not at all; false if the name is taken.

    Raises:
        KnowledgeError: It cannot be written.
    """
    if is_there(path):
        return False
    with create_engine("sqlite://", poolclass=NullPool).connect() as connection:
        tables.create(connection)
        tables.write(connection, knowledge)
        connection.commit()
        made = connection.connection.driver_connection
        assert isinstance(made, sqlite3.Connection), made
        content = made.serialize()
    try:
        with writing(path, replace=False, error=KnowledgeError) as stream:
            stream.write(content)
    except KnowledgeError:
        if is_there(path):  # another was faster
            return False
        raise
    return True


def _is_new(address: Address, knowledge: Knowledge) -> bool:
    """Whether the address is a file that was not there, and now is."""
    path = file_of(address)
    return path is not None and create(path, knowledge)


def _prepare(connection: Connection, address: Address) -> None:
    """A server's database may be empty and gets the tables; a file must have them, lest a foreign one be changed."""
    if file_of(address) is None and not tables.exist(connection):
        tables.create(connection)
    if tables.version(connection, shown(address)) != tables.SCHEMA_VERSION:
        from taskgist.store.migrations import upgrade  # with alembic, which hardly anybody needs twice

        upgrade(connection, shown(address))


def _check_contexts(contexts: frozenset[Context], expected: Context | None, where: str) -> None:
    others = contexts - {expected}
    if expected is not None and others:
        hint = "use the settings and the tree that made it, or learn anew from the recordings into another file"
        made = "; ".join(sorted(map(str, others)))
        raise KnowledgeError(f"made with {made}, while {expected} is in use", where=where, hint=hint)
