"""Knowledge of earlier releases is brought up to date: one step for each version of the tables.

A step runs inside the transaction of whoever first adds to the knowledge, while nobody else writes: it is done once
and as a whole. Who only reads changes nothing and reads the older tables as they are. A step names the tables as they
were then, so that a later change of ``tables`` changes no step.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from alembic.migration import MigrationContext
from alembic.operations import Operations
from sqlalchemy import Column, String, bindparam, column, select, table, update
from sqlalchemy.engine import Connection

from taskgist.store import tables


def upgrade(connection: Connection, where: str) -> None:
    """Bring the tables up to this release's version; nothing happens if they are.

    Raises:
        KnowledgeError: A document is damaged, or the tables are not ours or of a newer release.
    """
    while (version := tables.version(connection, where)) != tables.SCHEMA_VERSION:
        STEPS[version](Operations(MigrationContext.configure(connection)), connection, where)
        properties = tables.PROPERTIES
        after = update(properties).where(properties.c.name == "schema").values(value=str(int(version) + 1))
        connection.execute(after)


def _from_1(operations: Operations, connection: Connection, where: str) -> None:
    """Explanations get the keys that they are found by."""
    name, keys = "taskgist_explanations", ("task_key", "context_key", "recording_key")
    for key in keys:
        operations.add_column(name, Column(key, String(16)))
    _fill(connection, where, keys)
    with operations.batch_alter_table(name) as batch:
        for key in keys:
            batch.alter_column(key, existing_type=String(16), nullable=False)
    operations.create_index("taskgist_by_task", name, ["task_key", "context_key"])
    operations.create_index("taskgist_by_recording", name, ["recording_key"])


def _from_2(_operations: Operations, connection: Connection, where: str) -> None:
    """The key of a recording no longer holds agent and object: labels with several of them overlap with others."""
    _fill(connection, where, ("recording_key",))


def _fill(connection: Connection, where: str, keys: Sequence[str]) -> None:
    """Write keys of all explanations as they follow from their documents."""
    rows = table("taskgist_explanations", column("digest"), column("document"), *map(column, keys))
    fill = update(rows).where(rows.c.digest == bindparam("row")).values({key: bindparam(key) for key in keys})
    digests = connection.scalars(select(rows.c.digest)).all()
    for some in tables.batches(digests):
        found = connection.execute(select(rows.c.digest, rows.c.document).where(rows.c.digest.in_(some))).all()
        documents = {row.digest: tables.explanation_of(row._mapping, where) for row in found}
        filled = [
            {"row": digest, **{key: tables.found_by(each)[key] for key in keys}} for digest, each in documents.items()
        ]
        connection.execute(fill, filled)


STEPS: Mapping[str, Callable[[Operations, Connection, str], None]] = {"1": _from_1, "2": _from_2}
"""What makes the next version of each."""
