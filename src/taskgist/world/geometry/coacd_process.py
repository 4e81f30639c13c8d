"""CoACD in a process of its own, which strange meshes may end, or keep busy, without harm to this one.

This file is also the program of that process: it reads a mesh from its input and writes parts to its output, as NPZ.
"""

from __future__ import annotations

import importlib.util
import io
import subprocess
import sys
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

PROCESSOR_S = 10
"""Processor time that it is given (ours: mugs, bins and shelves take one to five seconds)."""
CLOCK_S = 120
"""And time, where the machine is busy, or does not count the other."""
SEARCH = {"mcts_iterations": 20, "mcts_nodes": 10, "mcts_max_depth": 2, "resolution": 500, "seed": 1}
"""CoACD's search: seconds instead of the default's minutes, with parts as tight."""
Part = tuple[NDArray[np.float64], NDArray[np.intp]]
"""Vertices, metres, (n, 3), and triangles, (m, 3)."""


def is_there() -> bool:
    """Whether CoACD is installed."""
    return importlib.util.find_spec("coacd") is not None


def searched(
    vertices: NDArray[np.float64], faces: NDArray[np.intp], limit_m: float, *, clock_s: float = CLOCK_S
) -> list[Part] | None:
    """The convex parts of a mesh.

    Args:
        vertices: Metres, (n, 3).
        faces: Triangles, (m, 3).
        limit_m: Depth of the hollows that parts may fill.
        clock_s: How long it may take by the clock; never longer than ``CLOCK_S``.

    Returns:
        At least one part; None where CoACD finds none, does not come to an end, or breaks down.
    """
    most_s = min(CLOCK_S, clock_s)
    if most_s <= 0:
        return None
    mesh = io.BytesIO()
    np.savez(mesh, vertices=vertices, faces=faces, limit_m=limit_m)
    program = [sys.executable, "-P", __file__]  # without this file's folder among those that modules are looked for in
    try:
        done = subprocess.run(program, input=mesh.getvalue(), capture_output=True, timeout=most_s, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return None
    if done.returncode:
        return None
    with np.load(io.BytesIO(done.stdout), allow_pickle=False) as found:
        count = len(found.files) // 2
        return [(found[f"vertices{part}"], found[f"faces{part}"]) for part in range(count)] or None


def main(source: BinaryIO, target: BinaryIO) -> None:
    """Read a mesh, and write its parts."""
    import coacd

    _limit_time()
    coacd.set_log_level("off")
    with np.load(io.BytesIO(source.read()), allow_pickle=False) as mesh:
        given, limit_m = coacd.Mesh(mesh["vertices"], mesh["faces"]), float(mesh["limit_m"])
    parts = coacd.run_coacd(given, threshold=limit_m, real_metric=True, **SEARCH)
    arrays: dict[str, NDArray[np.generic]] = {}
    for part, (vertices, faces) in enumerate(parts):
        arrays |= {f"vertices{part}": np.asarray(vertices), f"faces{part}": np.asarray(faces)}
    found = io.BytesIO()
    np.savez(found, allow_pickle=False, **arrays)
    target.write(found.getvalue())


def _limit_time() -> None:
    try:
        import resource
    except ImportError:  # a system without it, where only the clock counts
        return
    resource.setrlimit(resource.RLIMIT_CPU, (PROCESSOR_S, PROCESSOR_S))


if __name__ == "__main__":
    main(sys.stdin.buffer, sys.stdout.buffer)
