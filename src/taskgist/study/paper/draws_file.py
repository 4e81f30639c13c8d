"""Draws on disk: one compact file, written whole or not at all, that says under what it was measured."""

from __future__ import annotations

import gzip
import json
import zlib
from importlib import resources
from pathlib import Path
from typing import Any

from taskgist.errors import InputError, KnowledgeError
from taskgist.facts import STANDARD_TREE, UNKNOWN, Unknown, Value
from taskgist.files import replacing
from taskgist.learning import Context
from taskgist.study.paper.draws import ANGLE_RAD, DISTANCE_M, Draw, Draws, Outcome

FORMAT = "taskgist draws 1"
AGAIN = "measure anew: taskgist paper --draws 200 --save FILE"


def shipped_draws() -> Draws | None:
    """The measurement that comes with taskgist, if there is one."""
    path = Path(str(resources.files("taskgist") / "data" / "study" / "draws.json.gz"))
    return read_draws(path) if path.is_file() else None


def write_draws(draws: Draws, path: Path) -> None:
    """Write draws to a file, compressed.

    Raises:
        InputError: It cannot be written.
    """
    values: dict[str | None, int] = {}
    tasks = {
        task: [[_packed(each, values) for each in draw] for draw in drawn] for task, drawn in draws.by_task.items()
    }
    document = {
        "format": FORMAT,
        "study": draws.study,
        "settings": draws.context.settings_digest,
        "tree": draws.context.tree_version,
        "distance_m": DISTANCE_M,
        "angle_rad": ANGLE_RAD,
        "nodes": [node.name for node in STANDARD_TREE.nodes],
        "values": list(values),
        "draws": tasks,
    }
    text = json.dumps(document, ensure_ascii=False, separators=(",", ":"))
    try:
        with replacing(path) as stream:
            stream.write(gzip.compress(text.encode(), mtime=0))  # the same draws give the same bytes
    except OSError as error:
        hint = "name a file in a folder that exists and may be written to"
        raise InputError(f"cannot be written: {error.strerror}", where=path, hint=hint) from error


def read_draws(path: Path) -> Draws:
    """Read draws that ``write_draws`` wrote.

    Raises:
        KnowledgeError: The file cannot be read, or holds something else.
    """
    try:
        document: dict[str, Any] = json.loads(gzip.decompress(path.read_bytes()))
        if document["format"] != FORMAT:
            raise ValueError(f"its format is {document['format']!r}, not {FORMAT!r}")
        if (document["distance_m"], document["angle_rad"]) != (DISTANCE_M, ANGLE_RAD):
            raise ValueError("people and things were moved by other amounts")
        values = [UNKNOWN if value is None else str(value) for value in document["values"]]
        tasks = {str(task): tuple(_draw(draw, values) for draw in drawn) for task, drawn in document["draws"].items()}
        context = Context(str(document["settings"]), str(document["tree"]))
        return Draws(str(document["study"]), context, tasks)
    except (OSError, EOFError, zlib.error, KeyError, TypeError, ValueError, AttributeError, IndexError) as error:
        raise KnowledgeError(f"no draws: {error}", where=path, hint=AGAIN) from error


def outdated(draws: Draws, study: str) -> str:
    """What these draws were measured with that is different now; nothing if all is the same.

    Args:
        draws: Draws from a file.
        study: Digest of the present recordings; see ``digest_of``.
    """
    now = Context.of()
    differences = {
        "settings": draws.context.settings_digest != now.settings_digest,
        "hypothesis tree": draws.context.tree_version != now.tree_version,
        "recordings": draws.study != study,
    }
    return ", ".join(f"other {what}" for what, different in differences.items() if different)


def _packed(outcome: Outcome, values: dict[str | None, int]) -> list[int] | str:
    """Each value as its number among those met so far; unknown is null."""
    if isinstance(outcome, str):
        return outcome
    plain = (None if isinstance(value, Unknown) else value for value in outcome)
    return [values.setdefault(value, len(values)) for value in plain]


def _draw(packed: list[Any], values: list[Value]) -> Draw:
    return tuple(each if isinstance(each, str) else tuple(values[int(number)] for number in each) for each in packed)
