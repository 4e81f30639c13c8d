"""Convex parts of a concave mesh: found by CoACD [Wei 2022], kept in the user's cache, written as OBJ.

The pieces of a mesh are looked at one by one: what is convex is a part already, only what has hollows is cut.
"""

from __future__ import annotations

import hashlib
import logging
import os
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from taskgist.files import replacing
from taskgist.world.geometry.mesh_pieces import Array, Piece, hollow_m, is_flat, pieces

log = logging.getLogger("taskgist.world")
HOLLOW_M = 0.005
"""Hollows up to this depth are filled (ours: half of what a contact may be deeper than usual)."""
HOLLOW_SHARE = 0.01
"""And up to this share of the mesh's extent (ours: a cupboard's mouldings need no parts of their own)."""
MOST_PIECES = 64
"""Meshes of more pieces are cut as a whole."""
SEARCH = {"mcts_iterations": 20, "mcts_nodes": 10, "mcts_max_depth": 2, "resolution": 500, "seed": 1}
"""CoACD's search: seconds instead of the default's minutes, with parts as tight."""
SHEET_M = 0.001
"""Thickness given to what has none."""


def tolerance_m(mesh: Piece) -> float:
    """Depth of the hollows of a mesh that its solid shape may fill, metres."""
    return max(HOLLOW_M, HOLLOW_SHARE * float(np.ptp(mesh.vertices, axis=0).max()))


def parts_name(mesh: Piece) -> str:
    """Name of the file with a mesh's parts, by a digest of what they depend on."""
    content = (np.round(mesh.vertices * 1e6).astype("<i8").tobytes(), mesh.faces.astype("<i8").tobytes())
    search = repr((HOLLOW_M, HOLLOW_SHARE, MOST_PIECES, SHEET_M, sorted(SEARCH.items())))
    return f"parts-{hashlib.sha256(b''.join((*content, search.encode()))).hexdigest()[:16]}.obj"


def parts_text(mesh: Piece, name: str) -> bytes | None:
    """The convex parts of a mesh as an OBJ document; None if they cannot be found, which is logged.

    Args:
        mesh: A mesh with hollows.
        name: Its name, for messages.
    """
    kept = cache_folder() / parts_name(mesh)
    if kept.is_file():
        return kept.read_bytes()
    log.info("mesh %r is concave: cutting it into convex parts, once", name)
    found = _cut(mesh, name)
    if found is None:
        return None
    text = _as_obj(found)
    try:
        kept.parent.mkdir(parents=True, exist_ok=True)
        with replacing(kept) as stream:
            stream.write(text)
    except OSError as error:
        log.info("convex parts are not kept for the next time: %s", error)
    return text


def read_parts(text: bytes) -> list[Array]:
    """Vertices of the parts in an OBJ document, metres, (n, 3) each.

    Raises:
        ValueError: It is no such document.
    """
    parts: list[list[list[float]]] = []
    for line in text.decode("utf-8").splitlines():
        kind, _, rest = line.partition(" ")
        if kind == "o":
            parts.append([])
        elif kind == "v":
            parts[-1].append([float(number) for number in rest.split()])
    arrays = [np.array(part) for part in parts]
    if not arrays or any(array.shape != (len(array), 3) or not np.isfinite(array).all() for array in arrays):
        raise ValueError("an OBJ document with three finite numbers per vertex was expected")
    return arrays


def cache_folder() -> Path:
    """Where parts are kept for the next time, by the platform's convention."""
    if sys.platform == "darwin":
        root = Path.home() / "Library" / "Caches"
    else:
        variable, otherwise = ("LOCALAPPDATA", "AppData/Local") if os.name == "nt" else ("XDG_CACHE_HOME", ".cache")
        root = Path(os.environ.get(variable) or Path.home() / otherwise)
    return root / "taskgist" / "parts"


def _cut(mesh: Piece, name: str) -> list[Piece] | None:
    limit_m = tolerance_m(mesh)
    apart = pieces(mesh)
    parts: list[Piece] = []
    for piece in apart if len(apart) <= MOST_PIECES else [mesh]:
        if is_flat(piece):
            parts.append(_thickened(piece))
        elif hollow_m(piece) <= limit_m:
            parts.append(piece)
        else:
            cut = _coacd(piece, limit_m, name)
            if cut is None:
                return None
            parts += cut
    return parts


def _thickened(piece: Piece) -> Piece:
    normal = np.linalg.svd(piece.vertices - piece.vertices.mean(axis=0))[2][-1]
    both = [piece.vertices + sign * SHEET_M / 2 * normal for sign in (-1, 1)]
    return Piece(np.concatenate(both), np.concatenate((piece.faces, piece.faces[:, ::-1] + len(piece.vertices))))


def _coacd(piece: Piece, limit_m: float, name: str) -> list[Piece] | None:
    try:
        import coacd
    except ImportError:
        log.warning(
            "mesh %r is concave, but taken for its convex hull: nothing fits into it (to mend: pip install coacd)", name
        )
        return None
    coacd.set_log_level("off")
    found = coacd.run_coacd(coacd.Mesh(piece.vertices, piece.faces), threshold=limit_m, real_metric=True, **SEARCH)
    if not found:
        log.warning("mesh %r is concave, but cannot be cut into convex parts: taken for its convex hull", name)
        return None
    return [Piece(np.asarray(vertices), np.asarray(faces)) for vertices, faces in found]


def _as_obj(parts: Sequence[Piece]) -> bytes:
    """Rounded to micrometres; any program that opens OBJ shows them."""
    lines, start = ["# convex parts of a mesh, metres"], 1
    for number, part in enumerate(parts):
        lines.append(f"o part{number}")
        lines += [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in part.vertices]
        lines += [f"f {a + start} {b + start} {c + start}" for a, b, c in part.faces]
        start += len(part.vertices)
    return ("\n".join(lines) + "\n").encode()
