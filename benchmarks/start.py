"""The first answers of a new process: right after installation, when inner loops are compiled, and from then on."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator

from benchmarks.figure import Figure
from benchmarks.timing import REPEATS, once

ANSWERS = """
from benchmarks.rooms import furnished
from benchmarks.scenes import everything
scene = furnished(2, 6)
everything(scene, scene.initial)
"""


COMMAND = "from taskgist.cli import main; main()"


def figures() -> Iterator[Figure]:
    """A command that only says something; and all efforts of two agents towards six things, from an empty process."""
    numpy_s = min(once(lambda: _python("import numpy")) for _ in range(REPEATS))
    for option in ("--version", "--help"):
        told_s = min(once(lambda option=option: _python(COMMAND, option)) for _ in range(REPEATS))  # type: ignore[misc]
        goal = {"goal": "at most twice as long as importing numpy", "met": told_s <= 2.0 * numpy_s}
        yield Figure("start", f"taskgist {option}", told_s, {"importing numpy": numpy_s}, **goal)  # type: ignore[arg-type]
    with tempfile.TemporaryDirectory() as folder:
        environment = os.environ | {"NUMBA_CACHE_DIR": folder}
        first, second = (once(lambda: _answers(environment)) for _ in range(2))
    bare = once(lambda: subprocess.run([sys.executable, "-c", "import mujoco, numpy"], check=True))
    beside = {"importing mujoco and numpy alone": bare}
    yield Figure("start", "a new process, 2 agents × 6 objects: after installation, once", first, beside)
    yield Figure("start", "a new process, 2 agents × 6 objects: from then on", second, beside)


def _answers(environment: dict[str, str]) -> None:
    subprocess.run([sys.executable, "-c", ANSWERS], check=True, env=environment)


def _python(code: str, *words: str) -> None:
    subprocess.run([sys.executable, "-c", code, *words], check=True, stdout=subprocess.DEVNULL)
