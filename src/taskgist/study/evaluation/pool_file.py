"""Pools on disk: compressed JSON in which each value stands once.

Values repeat: a table lists them, and a demonstration is a row of indices into it, with -1 for unknown. The digest
over the content tells a damaged file.
"""

from __future__ import annotations

import gzip
import hashlib
import json
import zlib
from pathlib import Path
from typing import Any

from taskgist.errors import InputError
from taskgist.files import replacing
from taskgist.learning import Context
from taskgist.study.evaluation.pool import Pool
from taskgist.study.evaluation.sample import Failure, Sample

FORMAT = "taskgist pool 1"


def write_pool(pool: Pool, path: Path) -> None:
    """Write a pool, whole or not at all; the same pool gives the same bytes.

    Raises:
        InputError: The file cannot be written.
    """
    text = json.dumps(_document(pool), ensure_ascii=False, separators=(",", ":"))
    try:
        with replacing(path) as stream:
            stream.write(gzip.compress(text.encode(), mtime=0))
    except OSError as error:
        hint = "name a file in a folder that exists and may be written to"
        raise InputError(f"cannot be written: {error.strerror}", where=path, field="pool", hint=hint) from error


def read_pool(path: Path) -> Pool:
    """Read a pool.

    Raises:
        InputError: The file cannot be read, or is no pool.
    """
    try:
        document = json.loads(gzip.decompress(path.read_bytes()))
        pool = _pool(document)
    except (OSError, EOFError, zlib.error, ValueError, KeyError, TypeError, IndexError, AttributeError) as error:
        hint = "name a pool that taskgist evaluate made, or another file to make one"
        raise InputError(f"not a pool: {error!r}", where=path, field="pool", hint=hint) from error
    return pool


def _document(pool: Pool) -> dict[str, Any]:
    table = sorted({value for sample in pool.samples for value in sample.values if value is not None})
    index: dict[str | None, int] = {value: number for number, value in enumerate(table)}
    index[None] = -1
    content = {
        "format": FORMAT,
        "settings": pool.context.settings_digest,
        "tree": pool.context.tree_version,
        "source": pool.source,
        "seed": pool.seed,
        "nodes": pool.nodes,
        "values": table,
        "samples": [
            [each.task, each.number, each.condition, each.means, [index[value] for value in each.values]]
            for each in pool.samples
        ],
        "failures": [[each.task, each.number, each.condition, each.problem] for each in pool.failures],
    }
    return {**content, "digest": _digest(content)}


def _pool(document: dict[str, Any]) -> Pool:
    if document.pop("format") != FORMAT:
        raise ValueError("another format")
    stored = document.pop("digest")
    if stored != _digest({"format": FORMAT, **document}):
        raise ValueError("damaged: the digest does not fit")
    table = [*document["values"], None]  # the last is what -1 means
    return Pool(
        context=Context(document["settings"], document["tree"]),
        source=document["source"],
        seed=document["seed"],
        nodes=tuple(document["nodes"]),
        samples=tuple(
            Sample(task, number, condition, means, tuple(table[code] for code in codes))
            for task, number, condition, means, codes in document["samples"]
        ),
        failures=tuple(Failure(*fields) for fields in document["failures"]),
    )


def _digest(content: dict[str, Any]) -> str:
    return hashlib.sha256(json.dumps(content, ensure_ascii=False, sort_keys=True).encode()).hexdigest()[:16]
