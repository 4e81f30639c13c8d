"""Facts over time of recordings, kept for the next time that the same is asked of the same file.

Watching a long recording takes seconds, and whoever works with one asks for its facts again and again. So what was
found is kept in the user's cache folder, as JSON, under a digest of all that it hangs on: the file, byte by byte, what
was asked, and the sources of taskgist and the packages that it calculates with. If any of them changes, another name
is looked for, and nothing that is kept can be out of date. What cannot be read is found anew, what cannot be written is
not kept, and the files that were not asked for longest make room for new ones.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import logging
import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from importlib import metadata
from pathlib import Path
from typing import Any

from taskgist.common.files import reading, writing
from taskgist.common.frozen import Json, canonical_text
from taskgist.errors import InputError, RecordingError
from taskgist.learning.explanation import Explanation, explanation_from_json
from taskgist.observe.frames import Interval
from taskgist.pipeline.timelines import AssumedGaze, Timeline
from taskgist.world.geometry.convex import cache_folder

log = logging.getLogger(__name__)

MOST_FILES, MOST_BYTES = 256, 64 * 2**20
"""As much is kept, of all recordings together."""
LARGEST_BYTES = 8 * 2**20
"""Larger facts, of days, are not kept."""
PACKAGE = Path(__file__).parents[1]
SOURCES = (".py", ".toml", ".xml")
CALCULATING = ("numpy", "mujoco", "numba", "scipy", "example-robot-data")
"""Packages whose versions facts may hang on; some need not be installed."""
CHUNK_BYTES = 2**20


@dataclass(frozen=True)
class FactsOverTime:
    """What ``taskgist facts`` tells of a recording.

    Attributes:
        timelines: Of each target agent and object.
        effect: What changed between the label's ends; None without a label.
    """

    timelines: tuple[Timeline, ...]
    effect: Explanation | None

    def to_json(self) -> dict[str, Any]:
        """Plain data; ``facts_from_json`` reads it back."""
        effect = self.effect.to_json() if self.effect else None
        return {"timelines": [dataclasses.asdict(line) for line in self.timelines], "effect": effect}


def facts_from_json(document: Any) -> FactsOverTime:
    """Read back what ``FactsOverTime.to_json`` gave.

    Raises:
        KeyError: Something is missing,
        TypeError: or of another kind.
        KnowledgeError: The effect is damaged.
    """
    effect = document["effect"]
    timelines = tuple(map(_timeline, document["timelines"]))
    return FactsOverTime(timelines, explanation_from_json(effect) if effect is not None else None)


def _timeline(fields: Mapping[str, Any]) -> Timeline:
    rows = {name: tuple(Interval(**interval) for interval in row) for name, row in fields["rows"].items()}
    gaze = tuple(AssumedGaze(**{**each, "turned_rad": tuple(each["turned_rad"])}) for each in fields["gaze"])
    return Timeline(**{**fields, "rows": rows, "gaze": gaze})


def remembered(recording: Path, asked: Mapping[str, Json], watch: Callable[[], FactsOverTime]) -> FactsOverTime:
    """The facts of a recording: those that are kept, else those that are found now, which are kept.

    Args:
        recording: The file.
        asked: All that the facts hang on but the file and the sources: agent, object, seconds between samples, ...
        watch: Finds them.

    Raises:
        RecordingError: The file cannot be read.
        TaskgistError: As ``watch``.
    """
    file = _file(recording, asked)
    known = _read(file)
    if known is None:
        known = watch()
        if _file(recording, asked) == file:  # nobody has changed the recording meanwhile
            _keep(file, known)
    return known


def _file(recording: Path, asked: Mapping[str, Json]) -> Path:
    digest = hashlib.sha256(canonical_text({**asked, "sources": _sources()}).encode())
    with reading(recording, error=RecordingError) as stream:
        while chunk := stream.read(CHUNK_BYTES):
            digest.update(chunk)
    return cache_folder().parent / "facts" / f"facts-{digest.hexdigest()[:32]}.json"


@lru_cache(maxsize=1)
def _sources() -> str:
    """Digest of all sources of the package, and of the versions of those that it calculates with."""
    digest = hashlib.sha256()
    for path in sorted(each for each in PACKAGE.rglob("*") if each.suffix in SOURCES):
        digest.update(f"\n{path.relative_to(PACKAGE)}\n".encode() + path.read_bytes())
    for package in CALCULATING:
        with suppress(metadata.PackageNotFoundError):
            digest.update(f"\n{package} {metadata.version(package)}".encode())
    return digest.hexdigest()


def _read(file: Path) -> FactsOverTime | None:
    """What is kept; None if nothing is, or nothing that can be read."""
    try:
        found = facts_from_json(json.loads(file.read_bytes()))
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError, InputError):
        return None
    with suppress(OSError):
        os.utime(file)  # asked for now: others make room before it
    return found


def _keep(file: Path, facts: FactsOverTime) -> None:
    text = json.dumps(facts.to_json(), separators=(",", ":")).encode()
    if len(text) > LARGEST_BYTES:
        return
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        with writing(file, replace=True) as stream:
            stream.write(text)
        _make_room(file.parent)
    except (OSError, InputError) as error:
        log.info("facts are not kept for the next time: %s", error)


def _make_room(folder: Path) -> None:
    """Remove the files that were not asked for longest, until what is left is little enough."""
    found = sorted(((each, each.stat()) for each in folder.glob("facts-*.json")), key=lambda pair: -pair[1].st_mtime_ns)
    kept_bytes = 0
    for number, (file, stat) in enumerate(found):
        kept_bytes += stat.st_size
        if number >= MOST_FILES or kept_bytes > MOST_BYTES:
            file.unlink(missing_ok=True)
