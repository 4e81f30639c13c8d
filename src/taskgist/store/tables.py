"""Tables of the knowledge database, of types that every database has.

An explanation's row holds its document and three *keys*, short digests that are indexed: of its task, of its context
(settings, tree, and whether it is the performing agent's own), and of its recording. By these an addition finds what it
has to do with, whatever else the knowledge holds: the same demonstration, the same recording under another label, and
one explanation of each context of its tasks.
"""

from __future__ import annotations

import hashlib
import json
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from itertools import combinations, islice
from operator import itemgetter
from types import MappingProxyType
from typing import Any, Literal, TypeVar

from sqlalchemy import (
    Column,
    ColumnElement,
    Index,
    MetaData,
    Row,
    String,
    Table,
    Text,
    delete,
    insert,
    inspect,
    select,
    text,
    update,
)
from sqlalchemy.dialects import postgresql, sqlite
from sqlalchemy.engine import Connection

from taskgist.common.frozen import canonical_text
from taskgist.errors import KnowledgeError
from taskgist.learning.answers import Answer, answer_from_json
from taskgist.learning.explanation import Context, Explanation, explanation_from_json
from taskgist.learning.knowledge import Knowledge
from taskgist.store.faults import DAMAGED

SCHEMA_VERSION = "3"
"""Version of these tables; ``migrations`` brings older ones up to it."""
READABLE = ("1", "2", SCHEMA_VERSION)

METADATA = MetaData()

PROPERTIES = Table(
    "taskgist_properties",
    METADATA,
    Column("name", String(64), primary_key=True),
    Column("value", String(64), nullable=False),
)
EXPLANATIONS = Table(
    "taskgist_explanations",
    METADATA,
    Column("digest", String(64), primary_key=True),
    Column("task", Text, nullable=False),
    Column("document", Text, nullable=False),
    Column("task_key", String(16), nullable=False),
    Column("context_key", String(16), nullable=False),
    Column("recording_key", String(16), nullable=False),
    Index("taskgist_by_task", "task_key", "context_key"),
    Index("taskgist_by_recording", "recording_key"),
)
ANSWERS = Table(
    "taskgist_answers",
    METADATA,
    Column("digest", String(64), primary_key=True),
    Column("task", Text, nullable=False),
    Column("document", Text, nullable=False),
)
KEYS = ("task_key", "context_key", "recording_key")

Relabelled = Literal["add", "refuse", "replace"]
"""What becomes of a recording that taught something under another label: both count, it is refused, the older goes."""

AT_ONCE = 500
"""Values in one statement: far below what any database takes."""

T = TypeVar("T")
AnyRow = Row[*tuple[Any, ...]]
Fetched = Mapping[Any, Any]
"""Columns of a row by name."""
FAST = 1
"""Level of packing."""
NO_NAMES: Mapping[str, str] = MappingProxyType({})


class Packed(bytes):
    """A document that was packed when it was fetched; plain bytes are what a damaged row may hold."""


# --- Making and checking.


def create(connection: Connection) -> None:
    """Make the tables."""
    METADATA.create_all(connection)
    connection.execute(insert(PROPERTIES).values(name="schema", value=SCHEMA_VERSION))


def exist(connection: Connection) -> bool:
    """Whether there are any tables of taskgist."""
    return inspect(connection).has_table(PROPERTIES.name)


def version(connection: Connection, where: str) -> str:
    """Version of the tables.

    Raises:
        KnowledgeError: The database is not ours, or of a newer release.
    """
    there, of_file = inspect(connection), connection.dialect.name == "sqlite"
    lost = [name for name in METADATA.tables if not there.has_table(name)]
    if PROPERTIES.name in lost and of_file:
        hint = "give a file that taskgist wrote, or a name that is not taken"
        raise KnowledgeError("a database, but not of taskgist", where=where, hint=hint)
    if PROPERTIES.name in lost:
        hint = "learn something first: its tables are made by learning"
        raise KnowledgeError("a database without knowledge", where=where, hint=hint)
    if lost:
        raise KnowledgeError(f"{DAMAGED.problem}: no table {', '.join(lost)}", where=where, hint=DAMAGED.hint)
    if of_file:  # what a file computes when it is read or written is not ours
        strange = connection.scalar(text("SELECT name FROM sqlite_master WHERE type IN ('view', 'trigger') LIMIT 1"))
        if strange is not None:
            hint = "give a file that nobody but taskgist wrote"
            raise KnowledgeError("a view or trigger, which taskgist never makes", where=where, value=strange, hint=hint)
    found = connection.scalar(select(PROPERTIES.c.value).where(PROPERTIES.c.name == "schema"))
    if found not in READABLE:
        hint = f"this release reads version {SCHEMA_VERSION} and older: use the release that wrote it, or a newer one"
        raise KnowledgeError("another version of the tables", where=where, field="schema", value=found, hint=hint)
    return str(found)


def touch(connection: Connection) -> None:
    """A change that changes nothing: it fails where changes are not possible, or a column is gone."""
    for table in METADATA.sorted_tables:
        connection.execute(select(table).limit(0))
    connection.execute(update(PROPERTIES).where(PROPERTIES.c.name == "schema").values(name="schema"))


# --- Reading.


def rows(
    connection: Connection, where: str, *, tasks: Iterable[str] | None = None
) -> tuple[Sequence[Fetched], Sequence[Fetched]]:
    """What the tables hold, not looked into yet: rows of explanations and of answers; of any version.

    Documents are packed as they come, to a sixth of their size: they are held all at once, because nobody is to wait
    until they are understood.

    Args:
        connection: Inside a transaction.
        where: For errors.
        tasks: Only explanations of these; None takes all.
    """
    old = version(connection, where) != SCHEMA_VERSION
    columns = EXPLANATIONS.c
    wanted = select(*(column for column in columns if not old or column.name not in KEYS))
    if tasks is not None:
        listed = list(tasks)
        wanted = wanted.where(columns.task.in_(listed) if old else columns.task_key.in_(map(_key, listed)))
    found = connection.execution_options(yield_per=AT_ONCE).execute(wanted)
    return [_packed(row) for row in found], [row._mapping for row in connection.execute(select(ANSWERS))]


def _packed(row: AnyRow) -> Fetched:
    """A row whose document is packed; one that is no text stays as it is, and is refused when it is read."""
    columns = dict(row._mapping)
    if isinstance(columns["document"], str):
        columns["document"] = Packed(zlib.compress(columns["document"].encode(errors="surrogatepass"), FAST))
    return columns


def knowledge(
    explanations: Iterable[Fetched], answers: Iterable[Fetched], where: str, *, evidence: bool = True
) -> Knowledge:
    """What rows hold.

    Args:
        explanations: Their rows.
        answers: Their rows.
        where: For errors.
        evidence: Whether explanations keep their evidence.

    Raises:
        KnowledgeError: One is damaged; names it.
    """
    read = [explanation_of(row, where, evidence=evidence) for row in explanations]
    given = [_read(row, answer_from_json, answer_row, where) for row in answers]
    # What was stored together was allowed to be mixed then; who loads is asked anew.
    return Knowledge().add(*read, allow_mixed=True).answer(*given)


def explanation_of(row: Fetched, where: str, *, evidence: bool = True) -> Explanation:
    """The explanation that a row holds, of any version of the tables.

    Raises:
        KnowledgeError: It is damaged; names the row.
    """
    return _read(row, partial(explanation_from_json, evidence=evidence), found_by, where)


def _read(row: Fetched, parse: Callable[..., T], as_row: Callable[[T], dict[str, str]], where: str) -> T:
    """What the document of a row says; the row's other columns follow from it."""
    place = f"{where}: row {repr(row['digest'])[:80]}"
    hint = "restore the file from a copy, or learn anew from the recordings"
    text = row["document"]
    try:
        document = json.loads(zlib.decompress(text) if isinstance(text, Packed) else text)
    except (TypeError, ValueError, RecursionError) as error:
        raise KnowledgeError(f"damaged document: {error}", where=place, hint=hint) from error
    found = parse(document, where=place)
    expected = as_row(found)
    for name, value in row.items():
        if name != "document" and value != expected[name]:
            raise KnowledgeError("does not fit its document", where=place, field=name, value=value, hint=hint)
    return found


# --- Adding.


def check_rivals(added: Iterable[Explanation], relabelled: Relabelled, names: Mapping[str, str] = NO_NAMES) -> None:
    """Refuse one recording under two labels at once, unless both are to be counted.

    Args:
        added: Explanations that are to be added; no values are looked at.
        relabelled: What becomes of a recording with another label.
        names: What explanations are called in errors, by digest; by their demonstrations where left out.

    Raises:
        KnowledgeError: There is one.
    """
    by_recording = _by_recording(added) if relabelled != "add" else {}
    for each, other in (pair for rivals in by_recording.values() for pair in combinations(rivals, 2)):
        if each.is_rival_of(other):
            raise KnowledgeError(
                f"the same recording as {names.get(other.digest, other.demonstration)!r}, "
                + ("done right and done wrong" if each.wrong != other.wrong else "with another label"),
                where=names.get(each.digest, each.demonstration),
                hint="learn from one of them",
            )


def check_learned(
    connection: Connection, added: Iterable[Explanation], where: str, names: Mapping[str, str] = NO_NAMES
) -> None:
    """Refuse recordings that were learned from already with another label; arguments as ``check_rivals``.

    Raises:
        KnowledgeError: There is one.
    """
    for older, fresh in _rivals(connection, added, where):
        raise _learned_already(older, fresh, where, names)


def add(
    connection: Connection, added: Knowledge, where: str, *, relabelled: Relabelled = "add", allow_mixed: bool = False
) -> None:
    """Let the tables hold this knowledge, too. Reads only what it has to do with.

    Raises:
        KnowledgeError: As ``Knowledge.merge``, or a recording was learned from already with another label and that is
            to be refused. Nothing has been written then.
    """
    if relabelled == "refuse":
        check_learned(connection, added.explanations, where)
    if relabelled == "replace":
        forget(connection, {stored.digest for stored, _ in list(_rivals(connection, added.explanations, where))})
    known = _concerned(connection, added, where)
    wanted = known.merge(added, allow_mixed=allow_mixed)
    before = {each.digest: each for each in known.explanations}
    for each in (one for one in wanted.explanations if before.get(one.digest, one) != one):
        changed = update(EXPLANATIONS).where(EXPLANATIONS.c.digest == each.digest)
        connection.execute(changed.values(explanation_row(each)))
    fresh = (each for each in wanted.explanations if each.digest not in before)
    _insert(connection, EXPLANATIONS, map(explanation_row, fresh))
    _insert(connection, ANSWERS, sorted(map(answer_row, added.answers), key=itemgetter("digest")))


def write(connection: Connection, knowledge: Knowledge) -> None:
    """Let the tables hold this knowledge, and nothing else."""
    connection.execute(delete(EXPLANATIONS))
    connection.execute(delete(ANSWERS))
    _insert(connection, EXPLANATIONS, map(explanation_row, knowledge.explanations))
    _insert(connection, ANSWERS, sorted(map(answer_row, knowledge.answers), key=itemgetter("digest")))


def forget(connection: Connection, digests: Iterable[str]) -> None:
    """Remove explanations."""
    for some in batches(digests):
        connection.execute(delete(EXPLANATIONS).where(EXPLANATIONS.c.digest.in_(some)))


def contexts(connection: Connection, where: str, tasks: Iterable[str] | None = None) -> Iterator[Explanation]:
    """One explanation of each task, context, and whose tree it is, found without a look at the others.

    Args:
        connection: Inside a transaction.
        where: For errors.
        tasks: Only of these; None takes all.

    Raises:
        KnowledgeError: It is damaged.
    """
    columns = EXPLANATIONS.c
    for task in _distinct(connection, columns.task_key) if tasks is None else map(_key, tasks):
        of_task = columns.task_key == task
        for context in _distinct(connection, columns.context_key, of_task):
            one = select(EXPLANATIONS).where(of_task, columns.context_key == context).limit(1)
            for row in connection.execute(one):
                yield explanation_of(row._mapping, where)


def _concerned(connection: Connection, added: Knowledge, where: str) -> Knowledge:
    """The part of the knowledge that decides whether, and how, something is added."""
    same = _found(connection, EXPLANATIONS.c.digest, (each.digest for each in added.explanations), where)
    others = contexts(connection, where, {each.task for each in added.explanations})
    return Knowledge().add(*same, *others, allow_mixed=True)


def _rivals(
    connection: Connection, added: Iterable[Explanation], where: str
) -> Iterator[tuple[Explanation, Explanation]]:
    """Stored explanations of the recordings that are added, with other labels or times, and one that is added.

    See ``Knowledge.rivals``.
    """
    by_recording = _by_recording(added)
    for stored in _found(connection, EXPLANATIONS.c.recording_key, (_key(*each) for each in by_recording), where):
        fresh = next((each for each in by_recording[stored.recording] if each.is_rival_of(stored)), None)
        if fresh is not None:
            yield stored, fresh


def _by_recording(explanations: Iterable[Explanation]) -> Mapping[tuple[str, ...], list[Explanation]]:
    found: dict[tuple[str, ...], list[Explanation]] = {}
    for each in explanations:
        found.setdefault(each.recording, []).append(each)
    return found


def _learned_already(older: Explanation, fresh: Explanation, where: str, names: Mapping[str, str]) -> KnowledgeError:
    problem, how = "was learned from already, with another label", ("right", "wrong")
    if older.wrong != fresh.wrong:
        problem = f"was learned from already, as a {older.task!r} done {how[older.wrong]}, and not {how[fresh.wrong]}"
    if fresh.demonstration != older.demonstration:
        problem += f" (there it is called {older.demonstration!r})"
    hint = f"add --replace to forget what {where} holds of it"
    return KnowledgeError(problem, where=names.get(fresh.digest, fresh.demonstration), hint=hint)


def _found(connection: Connection, column: Column[Any], values: Iterable[str], where: str) -> Iterator[Explanation]:
    for some in batches(values):
        for row in connection.execute(select(EXPLANATIONS).where(column.in_(some))).all():
            yield explanation_of(row._mapping, where)


def _distinct(connection: Connection, column: Column[Any], *conditions: ColumnElement[bool]) -> Iterator[str]:
    """The values of an indexed column, each looked up beyond the last: the rows between are not read."""
    last = ""
    while True:
        beyond = select(column).where(column > last, *conditions).order_by(column).limit(1)
        found = connection.scalar(beyond)
        if found is None:
            return
        yield found
        last = found


def _insert(connection: Connection, table: Table, rows: Iterable[dict[str, str]]) -> None:
    """Insert rows; those that are there already stay as they are, where the database can do that in one step."""
    digest, statement = table.c.digest, insert(table)
    if connection.dialect.name == "postgresql":
        statement = postgresql.insert(table).on_conflict_do_nothing()
    elif connection.dialect.name == "sqlite":
        statement = sqlite.insert(table).on_conflict_do_nothing()
    for some in batches(rows):
        if connection.dialect.name not in ("postgresql", "sqlite"):
            known = set(connection.scalars(select(digest).where(digest.in_([row["digest"] for row in some]))))
            some = [row for row in some if row["digest"] not in known]
        if some:
            connection.execute(statement, some)


def found_by(explanation: Explanation) -> dict[str, str]:
    """The row of an explanation without its document."""
    context: Context = explanation.context
    whose = () if explanation.tree_of == "target" else (explanation.tree_of,)
    return {
        "digest": explanation.digest,
        "task": explanation.task,
        "task_key": _key(explanation.task),
        "context_key": _key(context.settings_digest, context.tree_version, *whose),
        "recording_key": _key(*explanation.recording),
    }


def explanation_row(explanation: Explanation) -> dict[str, str]:
    """The row of an explanation."""
    return {**found_by(explanation), "document": canonical_text(explanation.to_json())}


def answer_row(answer: Answer) -> dict[str, str]:
    """The row of an answer."""
    document = canonical_text(answer.to_json())
    return {"digest": hashlib.sha256(document.encode()).hexdigest(), "task": answer.task, "document": document}


def _key(*parts: str) -> str:
    return hashlib.sha256(canonical_text(parts).encode()).hexdigest()[:16]


def batches(values: Iterable[T]) -> Iterator[list[T]]:
    """Values, as many at a time as fit into one statement."""
    left = iter(values)
    while some := list(islice(left, AT_ONCE)):
        yield some
