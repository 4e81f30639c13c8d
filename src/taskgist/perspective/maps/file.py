"""Ability maps on disk: one ``.npz`` file that numpy opens, with arrays, grid and names."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import IO

import numpy as np

from taskgist.errors import InputError
from taskgist.perspective.maps.ability_map import AbilityMap
from taskgist.perspective.maps.grid import Grid

VERSION = 1
HINT = "write it with taskgist map --npz"


def write_maps(stream: IO[bytes], maps: Sequence[AbilityMap]) -> None:
    """Write maps of one grid.

    ``levels`` and ``solid`` are (maps, *grid.shape), ``agents`` and ``abilities`` (maps,); ``centers_m`` is
    (*grid.shape, 3), for whoever reads them without taskgist; ``about`` is JSON: grid, settings digest, version.

    Args:
        stream: Where to; open for writing bytes.
        maps: One or more.

    Raises:
        InputError: There are none, or their grids or settings differ.
    """
    grids = {(each.grid, each.settings_digest) for each in maps}
    if len(grids) != 1:
        hint = "make them with one grid, as Grid.around(stage, *agents)"
        raise InputError(
            "a file holds one or more maps of one grid and one digest of settings", field="maps", hint=hint
        )
    ((grid, digest),) = grids
    about = {
        "version": VERSION,
        "settings": digest,
        "origin_m": grid.origin_m,
        "yaw_rad": grid.yaw_rad,
        "cell_m": grid.cell_m,
        "shape": grid.shape,
    }
    np.savez_compressed(
        stream,
        levels=np.stack([each.levels for each in maps]),
        solid=np.stack([each.solid for each in maps]),
        agents=np.array([each.agent for each in maps]),
        abilities=np.array([each.ability for each in maps]),
        centers_m=grid.centers().reshape(*grid.shape, 3).astype(np.float32),
        about=np.array(json.dumps(about)),
    )


def read_maps(path: str | Path) -> tuple[AbilityMap, ...]:
    """The maps in a file.

    Raises:
        InputError: It cannot be read, or holds no maps of this version.
    """
    try:
        with Path(path).open("rb") as stream, np.load(stream, allow_pickle=False) as arrays:
            return _maps(dict(arrays), path)
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror or error}", where=path, hint="check the path") from error
    except (ValueError, KeyError, TypeError, AttributeError, EOFError, zipfile.BadZipFile) as error:
        raise InputError("holds no ability maps", where=path, hint=HINT) from error


def _maps(arrays: dict[str, np.ndarray], path: str | Path) -> tuple[AbilityMap, ...]:
    about = json.loads(str(arrays["about"]))
    if about["version"] != VERSION:
        problem = "holds ability maps of another version"
        raise InputError(problem, where=path, field="version", value=about["version"], hint=HINT)
    x, y, z = (float(value) for value in about["origin_m"])
    first, second, third = (int(value) for value in about["shape"])
    grid = Grid((x, y, z), float(about["yaw_rad"]), float(about["cell_m"]), (first, second, third))
    rows = zip(arrays["agents"], arrays["abilities"], arrays["levels"], arrays["solid"], strict=True)
    return tuple(
        AbilityMap(str(agent), "see" if ability == "see" else "reach", grid, levels, solid, str(about["settings"]))
        for agent, ability, levels, solid in rows
    )
