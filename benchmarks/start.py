"""The first answers of a new process: right after installation, when inner loops are compiled, and from then on."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator

from benchmarks.figure import Figure
from benchmarks.timing import once

ANSWERS = """
from benchmarks.rooms import furnished
from benchmarks.scenes import everything
scene = furnished(2, 6)
everything(scene, scene.initial)
"""


def figures() -> Iterator[Figure]:
    """All efforts of two agents towards six things, libraries loaded and scene compiled."""
    with tempfile.TemporaryDirectory() as folder:
        environment = os.environ | {"NUMBA_CACHE_DIR": folder}
        first, second = (once(lambda: _answers(environment)) for _ in range(2))
    bare = once(lambda: subprocess.run([sys.executable, "-c", "import mujoco, numpy"], check=True))
    beside = {"importing mujoco and numpy alone": bare}
    yield Figure("start", "a new process, 2 agents × 6 objects: after installation, once", first, beside)
    yield Figure("start", "a new process, 2 agents × 6 objects: from then on", second, beside)


def _answers(environment: dict[str, str]) -> None:
    subprocess.run([sys.executable, "-c", ANSWERS], check=True, env=environment)
