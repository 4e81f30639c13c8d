"""Tables of the knowledge database, of types that every database has."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable

from sqlalchemy import Column, MetaData, String, Table, Text, delete, insert, inspect, select
from sqlalchemy.engine import Connection

from taskgist.common.frozen import canonical_text
from taskgist.errors import KnowledgeError
from taskgist.learning.explanation import Explanation, explanation_from_json
from taskgist.learning.knowledge import Knowledge
from taskgist.learning.understanding import Answer, answer_from_json

SCHEMA_VERSION = "1"
"""Version of these tables."""

_METADATA = MetaData()

PROPERTIES = Table(
    "taskgist_properties",
    _METADATA,
    Column("name", String(64), primary_key=True),
    Column("value", String(64), nullable=False),
)
EXPLANATIONS = Table(
    "taskgist_explanations",
    _METADATA,
    Column("digest", String(64), primary_key=True),
    Column("task", Text, nullable=False),
    Column("document", Text, nullable=False),
)
ANSWERS = Table(
    "taskgist_answers",
    _METADATA,
    Column("digest", String(64), primary_key=True),
    Column("task", Text, nullable=False),
    Column("document", Text, nullable=False),
)


def create(connection: Connection) -> None:
    """Make the tables where there are none yet."""
    if not inspect(connection).has_table(PROPERTIES.name):
        _METADATA.create_all(connection)
        connection.execute(insert(PROPERTIES).values(name="schema", value=SCHEMA_VERSION))


def check(connection: Connection, where: str) -> None:
    """Refuse a database that is not ours, or of another version.

    Raises:
        KnowledgeError: It is.
    """
    if not inspect(connection).has_table(PROPERTIES.name):
        hint = "give a file that taskgist wrote, or a name that is not taken"
        raise KnowledgeError("a database, but not of taskgist", where=where, hint=hint)
    version = connection.scalar(select(PROPERTIES.c.value).where(PROPERTIES.c.name == "schema"))
    if version != SCHEMA_VERSION:
        hint = f"this release reads version {SCHEMA_VERSION}: use the release that wrote it, or learn anew"
        raise KnowledgeError("another version of the tables", where=where, field="schema", value=version, hint=hint)


def read(connection: Connection, where: str) -> Knowledge:
    """All knowledge in the tables.

    Raises:
        KnowledgeError: A document is damaged.
    """
    explanations = [
        explanation_from_json(_decoded(text, where), where=where)
        for text in connection.scalars(select(EXPLANATIONS.c.document))
    ]
    answers = [
        answer_from_json(_decoded(text, where), where=where) for text in connection.scalars(select(ANSWERS.c.document))
    ]
    # What was stored together was allowed to be mixed then; who loads is asked anew.
    return Knowledge().add(*explanations, allow_mixed=True).answer(*answers)


def write(connection: Connection, knowledge: Knowledge) -> None:
    """Let the tables hold this knowledge, and nothing else."""
    connection.execute(delete(EXPLANATIONS))
    connection.execute(delete(ANSWERS))
    _insert(connection, EXPLANATIONS, (_explanation_row(each) for each in knowledge.explanations))
    _insert(connection, ANSWERS, (_answer_row(each) for each in knowledge.answers))


def forget(connection: Connection, digests: Iterable[str]) -> None:
    """Remove explanations."""
    for digest in digests:
        connection.execute(delete(EXPLANATIONS).where(EXPLANATIONS.c.digest == digest))


def append(connection: Connection, *, known: Knowledge, wanted: Knowledge) -> None:
    """Add the rows that ``wanted`` has beyond ``known``, which the tables hold."""
    old = {each.digest for each in known.explanations}
    fresh = (each for each in wanted.explanations if each.digest not in old)
    _insert(connection, EXPLANATIONS, (_explanation_row(each) for each in fresh))
    _insert(connection, ANSWERS, (_answer_row(each) for each in wanted.answers - known.answers))


def _insert(connection: Connection, table: Table, rows: Iterable[dict[str, str]]) -> None:
    listed = sorted(rows, key=lambda row: row["digest"])
    if listed:
        connection.execute(insert(table), listed)


def _explanation_row(explanation: Explanation) -> dict[str, str]:
    document = canonical_text(explanation.to_json())
    return {"digest": explanation.digest, "task": explanation.task, "document": document}


def _answer_row(answer: Answer) -> dict[str, str]:
    document = canonical_text(answer.to_json())
    return {"digest": hashlib.sha256(document.encode()).hexdigest(), "task": answer.task, "document": document}


def _decoded(text: str, where: str) -> object:
    try:
        return json.loads(text)
    except ValueError as error:
        hint = "restore the file from a copy, or learn anew from the recordings"
        raise KnowledgeError(f"damaged document: {error}", where=where, hint=hint) from error
