"""Ability maps (Mightability): which places of its workspace an agent sees or reaches, and with what effort.

A map asks of every cell of a grid what the search asks of an object, as if there were only the point at the cell's
centre: from all candidates of an effort level (``Viewpoint.candidates``), with the head aimed or an arm stretched out,
where joint limits and collisions allow it. Where a point differs from an object, and where steps are taken:

- *See*: the point lies in the gaze cone and in the field of view, and the straight line from the eye to it meets
  nothing; pixels do not matter. A candidate counts if it is free of collisions with the head as it is now.
- *Reach*: the point lies in the sector of an arm. Nothing is held at a place, so level 1 is the least.
- At level 4 the chest turns to each point by itself, as it does in the search; what is in the way then is tested with
  the chest in steps of ``efforts.turn_step_rad``.
- Nothing can be put into what is solid: cells there have level 5. The agent's own body does not count.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Protocol
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from taskgist.common.array_files import ArrayFile
from taskgist.common.arrays import Indices, Mask
from taskgist.common.documents import parse_json
from taskgist.errors import InputError, UnknownNameError
from taskgist.maps.configurations import Configuration, configurations
from taskgist.maps.grid import Cells, Grid, Undecided, Zone, solid_cells
from taskgist.maps.reach import CellsToReach
from taskgist.maps.see import CellsToSee
from taskgist.perspective.effort import NO_KNOWN_LEVEL, Ability
from taskgist.perspective.occlusion import BOXED, CLEAR, HIDDEN
from taskgist.perspective.reach import PARTS as HAND_PARTS
from taskgist.perspective.see import PARTS as EYE_PARTS
from taskgist.perspective.viewpoint import Viewpoint
from taskgist.settings import DEFAULT, Limits, Settings
from taskgist.world.stage import Stage

UNKNOWN_LEVEL = -1
"""Level of cells of which nothing is known: what would decide was not tracked."""
Levels = NDArray[np.int8]


@dataclass(frozen=True, eq=False)
class AbilityMap:
    """The least effort of an agent for every cell of a grid.

    Attributes:
        agent: Whose.
        ability: ``see`` or ``reach``.
        grid: The grid.
        levels: Least effort levels, 0 to 5, or −1 where that is unknown, the grid's shape, read-only.
        solid: Whether each cell lies in something solid, the grid's shape, read-only.
        settings_digest: Of the settings with which it was made.
    """

    agent: str
    ability: Ability
    grid: Grid
    levels: Levels
    solid: Mask
    settings_digest: str

    def __post_init__(self) -> None:
        for name, kind in (("levels", np.int8), ("solid", np.bool_)):
            array = np.array(getattr(self, name), dtype=kind).reshape(self.grid.shape)
            array.flags.writeable = False
            object.__setattr__(self, name, array)

    def at_most(self, level: int) -> Zone:
        """Where the agent is able to with no more than an effort level; where that is unknown it does not count."""
        return Zone(self.grid, (self.levels >= 0) & (self.levels <= level))

    @property
    def unknown(self) -> Zone:
        """Where it is unknown."""
        return Zone(self.grid, self.levels == UNKNOWN_LEVEL)

    @property
    def free(self) -> Zone:
        """Where nothing solid is."""
        return Zone(self.grid, ~self.solid)

    @property
    def counts(self) -> dict[int, int]:
        """Number of cells by level."""
        levels, counts = np.unique(self.levels, return_counts=True)
        return {int(level): int(count) for level, count in zip(levels, counts, strict=True)}


class CellJudge(Protocol):
    """Judges one ability of an agent towards the cells of a workspace.

    Attributes:
        first_level: The least level that may give the ability.
        found: Of all cells, what was found of those asked for: ``CLEAR``, ``BOXED`` or ``HIDDEN``, (cells,).
    """

    first_level: int
    found: NDArray[np.uint8]

    def find(self, configuration: Configuration, places: Indices, cells: Undecided) -> None:
        """Note what a configuration gives at some of its places."""

    def past_meshes(self, configuration: Configuration, rows: Indices) -> Mask:
        """Whether cells are not hidden by meshes from where they were just looked at, (n,)."""


JUDGES: Mapping[str, tuple[Callable[[Viewpoint, Cells], CellJudge], tuple[tuple[str, ...], ...]]] = {
    "see": (CellsToSee, EYE_PARTS),
    "reach": (CellsToReach, HAND_PARTS),
}
"""Judges by ability, and the parts of an agent that must be tracked to judge each level."""


def ability_map(
    stage: Stage | Viewpoint,
    agent: str | None = None,
    ability: Ability = "reach",
    *,
    grid: Grid | None = None,
    settings: Settings = DEFAULT,
) -> AbilityMap:
    """Map where an agent sees or reaches what, and with what effort.

    Args:
        stage: The scene in a state, or the agent's viewpoint, for whoever asks more than one thing.
        agent: Whose; left out with a viewpoint.
        ability: ``see`` or ``reach``.
        grid: Where; the agent's own workspace if left out. Maps are combined only if they have one grid.
        settings: All settings; a viewpoint has its own.

    Raises:
        UnknownNameError: There is no such agent, or no such map.
    """
    if ability not in JUDGES:
        raise UnknownNameError("ability to map", ability, JUDGES)
    here = stage if isinstance(stage, Viewpoint) else Viewpoint(stage, agent or "", settings)
    with here.stage.showing(here.state):
        where = grid or Grid.around(here.stage, here.agent.name, settings=here.settings.maps)
        space = _workspace_of(here, where)
        levels = _levels(here, space, ability)
        return AbilityMap(here.agent.name, ability, where, levels, space.solid, here.settings.digest)


class Workspace:
    """The cells of a grid around an agent, and how it may get at them. All maps of a viewpoint share it.

    Args:
        here: The agent's viewpoint, whose stage shows its state.
        grid: The grid.

    Attributes:
        cells: The grid's cells, block by block.
        solid: Whether each lies in something solid that is not the agent's own, the grid's shape.
    """

    def __init__(self, here: Viewpoint, grid: Grid) -> None:
        self.grid, self.cells = grid, Cells.of(grid)
        self.solid = solid_cells(here.stage, grid, but=here.agent.name)
        self._configurations: dict[int, tuple[Configuration, ...]] = {}

    def configurations(self, here: Viewpoint, level: int) -> tuple[Configuration, ...]:
        """Those of an effort level, 0 to 4."""
        if level not in self._configurations:
            self._configurations[level] = tuple(configurations(here, level))
        return self._configurations[level]


_LAST: WeakKeyDictionary[Viewpoint, Workspace] = WeakKeyDictionary()


def _workspace_of(here: Viewpoint, grid: Grid) -> Workspace:
    """The workspace of a viewpoint; the last one is kept."""
    last = _LAST.get(here)
    if last is None or last.grid != grid:
        last = _LAST[here] = Workspace(here, grid)
    return last


def _levels(here: Viewpoint, space: Workspace, ability: Ability) -> Levels:
    """Level by level, only the cells that no lower level won; (cells,)."""
    make, parts = JUDGES[ability]
    index, levels = space.cells.index, np.full(space.solid.size, NO_KNOWN_LEVEL, dtype=np.int8)
    left = np.flatnonzero(~space.solid.ravel()[index])
    judge = make(here, space.cells)
    for level in range(NO_KNOWN_LEVEL):
        if here.untracked(parts[level]):
            levels[index[left]] = UNKNOWN_LEVEL
            break
        if level >= judge.first_level and len(left):
            able = _able(here, judge, space.configurations(here, level), space.cells, left)
            levels[index[left[able]]] = level
            left = left[~able]
    return levels


def _able(
    here: Viewpoint, judge: CellJudge, configurations: Sequence[Configuration], cells: Cells, rows: Indices
) -> Mask:
    """Whether any of some configurations is able to, of each of some cells, (n,)."""
    judge.found[rows] = HIDDEN
    undecided = cells.undecided(rows)
    for configuration in configurations:  # first all that needs no test
        judge.find(configuration, configuration.clear, undecided)
    able = np.asarray(judge.found == CLEAR)
    left, boxed = rows[~able[rows]], rows[judge.found[rows] == BOXED]
    for configuration in configurations:
        for places, asked in ((configuration.clear, boxed), (configuration.doubtful, left)):
            asked = _perhaps(judge, configuration, places, cells, asked[~able[asked]])
            for place in places:
                asked = asked[~able[asked]]
                if not len(asked):
                    break
                there = _perhaps(judge, configuration, np.array([place]), cells, asked)
                there = there[judge.past_meshes(configuration, there)]
                able[there[configuration.free(here, int(place), cells.points[there])]] = True
    return np.asarray(able[rows])


def _perhaps(judge: CellJudge, configuration: Configuration, places: Indices, cells: Cells, rows: Indices) -> Indices:
    """Those of some cells that a configuration may see or reach at some places, but for meshes and collisions."""
    if not len(rows) or not len(places):
        return rows[:0]
    judge.found[rows] = HIDDEN
    judge.find(configuration, places, cells.undecided(rows))
    return np.asarray(rows[judge.found[rows] != HIDDEN])


# --- Ability maps on disk: one ``.npz`` file that numpy opens, with arrays, grid and names.

VERSION = 1
ARRAYS = ("about", "agents", "abilities", "levels", "solid")
"""Those that are read again."""
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


def read_maps(path: str | Path, *, limits: Limits = DEFAULT.limits) -> tuple[AbilityMap, ...]:
    """The maps in a file.

    Args:
        path: The file.
        limits: How much is read of it.

    Raises:
        InputError: It cannot be read, or holds no maps of this version.
    """
    file = ArrayFile(Path(path), most_bytes=limits.table_bytes)
    if not set(ARRAYS) <= set(file.names):
        raise InputError("holds no ability maps", where=path, hint=HINT)
    arrays = {name: file.array(name) for name in ARRAYS}
    try:
        return _maps(arrays, path)
    except (ValueError, KeyError, TypeError, AttributeError, OverflowError) as error:
        raise InputError("holds no ability maps", where=path, hint=HINT) from error


def _maps(arrays: dict[str, np.ndarray], path: str | Path) -> tuple[AbilityMap, ...]:
    about = parse_json(str(arrays["about"]))
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
