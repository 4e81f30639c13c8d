"""Capability maps: where the palm of an arm gets to, and with which configurations of its joints.

An arm is sampled: its joints are put anywhere in their ranges, a million times, and where its palm comes is noted in a
grid of cells that is fixed to what carries the arm, with its shoulder as origin [Zacharias 2007; Reuleaux, Makhal
2018]. Elbows, telescopes and arms that bend one way only come out as they are. The map tells

- which eighths of each cell lie within half a cell of a place that the palm took (what is reached),
- for each cell, one configuration for each of 26 directions in which the hand may point, where there is any: that which
  brings the palm nearest to the cell's middle (how it is reached).

The shoulder girdle stays at rest: joints that move the shoulder itself are a body's thrust, no part of its arm. What a
configuration pushes into the carrier itself, an upper body mostly, is no configuration; nor is one that a
ball-and-socket joint does not take, though each of the hinges that stand for it does.

Maps are made once, in seconds, and kept in the user's cache by a digest of the arm; that of people comes with the
package (``tools/arm_maps.py``). Left and right arms that mirror
each other have one map, and all people of the same proportions: lengths scale with the stature.
"""

from __future__ import annotations

import hashlib
import logging
import math
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from taskgist.common.array_files import ArrayFile
from taskgist.common.arrays import Array, Indices
from taskgist.common.compiled import compiled, compiled_part
from taskgist.common.files import writing
from taskgist.errors import InputError
from taskgist.world.bodies.arm_chain import (
    ALONG,
    CARRIED,
    END,
    LOW,
    SLIDES,
    SPAN,
    STEPS,
    THICK,
    ArmChain,
    chain_of,
    put,
    put_frames,
    within_limits,
)
from taskgist.world.bodies.human import HumanSize, human_mjcf, shoulder_limits
from taskgist.world.geometry.convex import cache_folder
from taskgist.world.geometry.solids import AT, TURNED, outside_m

log = logging.getLogger("taskgist.world")
SAMPLES = 1_500_000
"""Configurations tried for a map: a cell of an arm of 0.7 m is met about a hundred times."""
EDGE_SHARE = 0.15
"""How often a joint is put to an end of its range, so that the border of the map is met as well."""
CELL_M = 0.05
"""Edge of a cell; arms of many joints, or of more than 1.6 m, have larger ones, for want of memory."""
MOST_SAMPLED_BYTES = 2**27
"""Memory for configurations while an arm is sampled."""
SHIFT_M = 0.0037
"""How far the grid is shifted, so that no round coordinate lies on the border of a cell or of its eighths."""
DIRECTIONS = 27
"""Directions in which a hand may point: −1, 0 or 1 along each axis."""
SPREAD = 0.4
"""Least part of a direction along an axis that counts as pointing that way: about the sine of 22.5°."""
SUNK_M = 0.01
"""How deep an arm may push into what carries it: shapes of bodies are rough."""
VERSION = "8"


# --- Sampling. Compiled.


class Samples(NamedTuple):
    """What sampling found, over a grid of cells that holds all that the arm may reach.

    Attributes:
        eighths: Of each cell, a bit for each eighth that is reached, (cells,).
        chosen: One configuration for each cell and direction, (cells, 27, j).
        off: How far its palm is from the cell's middle; infinite for none, (cells, 27).
    """

    eighths: NDArray[np.uint8]
    chosen: NDArray[np.uint16]
    off: NDArray[np.float32]


@compiled
def _sampled(
    joints: Array,
    capsules: Array,
    palm: Array,
    wrist: Array,
    carrier: Array,
    limits: Array,
    count: int,
    cells: int,
    cell_m: float,
) -> Samples:
    """Put the joints anywhere, so many times; the grid has so many cells along each axis, about the shoulder."""
    np.random.seed(0)
    size, half_m, total = len(joints), cells * cell_m / 2 + SHIFT_M, cells**3
    eighths = np.zeros(total, dtype=np.uint8)
    chosen = np.zeros((total, DIRECTIONS, size), dtype=np.uint16)
    off = np.full((total, DIRECTIONS), np.inf, dtype=np.float32)
    frames, steps = np.empty((size + 1, 12)), np.empty(size, dtype=np.uint16)
    for _ in range(count):
        for joint in range(size):
            drawn = np.random.random()
            if drawn < EDGE_SHARE:
                steps[joint] = 0 if drawn < EDGE_SHARE / 2 else STEPS
            else:
                steps[joint] = int((drawn - EDGE_SHARE) / (1.0 - EDGE_SHARE) * STEPS)
        put_frames(joints, steps, frames)
        x, y, z = put(frames[size], palm[0], palm[1], palm[2])
        i, j, k = int((x + half_m) / cell_m), int((y + half_m) / cell_m), int((z + half_m) / cell_m)
        if min(i, j, k) < 1 or max(i, j, k) >= cells - 1 or not within_limits(frames, limits):
            continue
        if _pushes(frames, capsules, carrier):
            continue
        wx, wy, wz = put(frames[size], wrist[0], wrist[1], wrist[2])
        direction = pointing(x - wx, y - wy, z - wz)
        cell = (i * cells + j) * cells + k
        mx, my, mz = x + half_m - (i + 0.5) * cell_m, y + half_m - (j + 0.5) * cell_m, z + half_m - (k + 0.5) * cell_m
        away = mx * mx + my * my + mz * mz
        if away < off[cell, direction]:
            off[cell, direction] = away
            for joint in range(size):
                chosen[cell, direction, joint] = steps[joint]
        _mark(eighths, cells, cell_m / 2, x + half_m, y + half_m, z + half_m)
    return Samples(eighths, chosen, off)


@compiled_part
def _mark(eighths: NDArray[np.uint8], cells: int, fine_m: float, x: float, y: float, z: float) -> None:
    """Note which eighths of cells have their middles within half a cell of a place, from the grid's corner."""
    i, j, k = int(x / fine_m), int(y / fine_m), int(z / fine_m)
    for a in range(i - 1, i + 2):
        dx = x - (a + 0.5) * fine_m
        for b in range(j - 1, j + 2):
            dy = y - (b + 0.5) * fine_m
            for c in range(k - 1, k + 2):
                dz = z - (c + 0.5) * fine_m
                if dx * dx + dy * dy + dz * dz <= fine_m * fine_m:
                    bit = 4 * (a % 2) + 2 * (b % 2) + c % 2
                    eighths[((a // 2) * cells + b // 2) * cells + c // 2] |= np.uint8(1 << bit)


@compiled_part
def pointing(x: float, y: float, z: float) -> int:
    """Which of the 27 directions a vector points in."""
    least = SPREAD * math.sqrt(x * x + y * y + z * z)
    found = 0
    for part in (x, y, z):
        found = 3 * found + (2 if part > least else 0 if part < -least else 1)
    return found


@compiled_part
def _pushes(frames: Array, capsules: Array, carrier: Array) -> bool:
    """Whether the outer links push into what carries the arm: the innermost one is joined to it."""
    inner = 0.0
    for c in range(len(capsules)):
        carried = capsules[c, CARRIED]
        if carried == 0.0:
            continue
        inner = carried if inner == 0.0 else inner
        if carried == inner:
            continue
        frame = frames[int(carried)]
        for share in (0.0, 0.33, 0.67, 1.0):
            x = capsules[c, 0] + share * (capsules[c, END] - capsules[c, 0])
            y = capsules[c, 1] + share * (capsules[c, END + 1] - capsules[c, 1])
            z = capsules[c, 2] + share * (capsules[c, END + 2] - capsules[c, 2])
            x, y, z = put(frame, x, y, z)
            for s in range(len(carrier)):
                dx, dy, dz = x - carrier[s, AT], y - carrier[s, AT + 1], z - carrier[s, AT + 2]
                lx = dx * carrier[s, TURNED] + dy * carrier[s, TURNED + 3] + dz * carrier[s, TURNED + 6]
                ly = dx * carrier[s, TURNED + 1] + dy * carrier[s, TURNED + 4] + dz * carrier[s, TURNED + 7]
                lz = dx * carrier[s, TURNED + 2] + dy * carrier[s, TURNED + 5] + dz * carrier[s, TURNED + 8]
                if outside_m(carrier, s, lx, ly, lz) < capsules[c, THICK] - SUNK_M:
                    return True
    return False


# --- The map.


@dataclass(frozen=True, eq=False)
class CapabilityMap:
    """Where the palm of an arm gets to, in the frame of its chain.

    Attributes:
        chain: The arm.
        corner: Lowest corner of the grid, metres, (3,).
        cell_m: Edge of a cell.
        shape: Cells along x, y and z.
        eighths: Of each cell, a bit for each eighth that is reached, (cells,); the bit is 4 x + 2 y + z of the halves.
        starts: Where the configurations of each cell begin, one more at the end, (cells + 1,).
        configurations: Steps of the joints' spans, 0 to 65,535, (n, j).
        palms: Where the palm is then, metres, (n, 3).
    """

    chain: ArmChain
    corner: Array
    cell_m: float
    shape: tuple[int, int, int]
    eighths: NDArray[np.uint8]
    starts: Indices
    configurations: NDArray[np.uint16]
    palms: NDArray[np.float32]

    @cached_property
    def radius_m(self) -> float:
        """How far from the shoulder the palm gets, and half a cell: nothing farther is reached."""
        if not len(self._reached):
            return 0.0
        return float(np.linalg.norm(self._reached, axis=1).max()) + self._half_m

    def along(self, axis: Array) -> tuple[float, float]:
        """The least and the most that the palm gets along a unit axis, (3,), metres: nothing beyond is reached."""
        if not len(self._reached):
            return 0.0, 0.0
        far_m = self._reached @ axis
        return float(far_m.min()) - self._half_m, float(far_m.max()) + self._half_m

    @property
    def _half_m(self) -> float:
        """How far from its middle an eighth of a cell gets, metres."""
        return math.sqrt(3) * self.cell_m / 4

    @cached_property
    def _reached(self) -> Array:
        """The middles of all eighths that are reached, metres, (n, 3)."""
        cells = np.flatnonzero(self.eighths)
        low = self.corner + np.stack(np.unravel_index(cells, self.shape), axis=1) * self.cell_m
        found = []
        for bit in range(8):
            half = np.array((bit >> 2 & 1, bit >> 1 & 1, bit & 1))
            found.append((low + (half + 0.5) * self.cell_m / 2)[self.eighths[cells] >> bit & 1 == 1])
        return np.concatenate(found)

    @classmethod
    def of(cls, chain: ArmChain, count: int) -> CapabilityMap:
        """Sample an arm so many times."""
        stretched_m = _longest_m(chain)
        most = int((MOST_SAMPLED_BYTES / (2 * DIRECTIONS * max(len(chain.joints), 1))) ** (1 / 3))
        cell_m = max(CELL_M, 2 * stretched_m / (most - 6))
        cells = 2 * math.ceil(stretched_m / cell_m) + 4
        arrays = (chain.joints, chain.capsules, chain.palm, chain.wrist, chain.carrier, chain.limits)
        found = _sampled(*arrays, count, cells, cell_m)
        kept = np.isfinite(found.off)
        grid = (found.eighths > 0) | kept.any(axis=1)
        index = np.stack(np.unravel_index(np.flatnonzero(grid), (cells,) * 3), axis=1)
        if not len(index):
            index = np.zeros((1, 3), dtype=np.intp)
        low, high = index.min(axis=0), index.max(axis=0) + 1
        cut = tuple(slice(int(a), int(b)) for a, b in zip(low, high, strict=True))
        kept = kept.reshape(cells, cells, cells, DIRECTIONS)[cut]
        eighths = found.eighths.reshape(cells, cells, cells)[cut].ravel()
        flat = kept.reshape(-1, DIRECTIONS)
        chosen = found.chosen.reshape(cells, cells, cells, DIRECTIONS, len(chain.joints))[cut][kept]
        return cls(
            chain=chain,
            corner=low * cell_m - cells * cell_m / 2 - SHIFT_M,
            cell_m=cell_m,
            shape=(int(high[0] - low[0]), int(high[1] - low[1]), int(high[2] - low[2])),
            eighths=eighths,
            starts=np.concatenate(((0,), np.cumsum(flat.sum(axis=1)))).astype(np.intp),
            configurations=chosen,
            palms=_palms(chain, chosen),
        )


def _palms(chain: ArmChain, configurations: NDArray[np.uint16]) -> NDArray[np.float32]:
    """Where configurations, (n, j), bring the palm, metres, (n, 3): the outermost joint moves it first."""
    found = np.tile(chain.palm, (len(configurations), 1))
    for row, steps in zip(chain.joints[::-1], configurations.T[::-1], strict=True):
        anchor, axis, by = row[:3], row[ALONG : ALONG + 3], (row[LOW] + row[SPAN] * steps / STEPS)[:, None]
        if row[SLIDES] == 1:
            found += by * axis
        else:
            arm = found - anchor
            along = (arm @ axis)[:, None] * axis  # Rodrigues' formula
            found = anchor + along + np.cos(by) * (arm - along) + np.sin(by) * np.cross(axis, arm)
    return found.astype(np.float32)


def _longest_m(chain: ArmChain) -> float:
    """What the palm is never farther away than: the lengths from joint to joint, and what slides."""
    points = np.concatenate((np.zeros((1, 3)), chain.joints[:, :3], chain.palm[None]))
    slides = chain.joints[chain.joints[:, SLIDES] == 1]
    farthest = np.maximum(np.abs(slides[:, LOW]), np.abs(slides[:, LOW] + slides[:, SPAN])).sum()
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum() + farthest) + CELL_M


# --- Maps on request: one for all arms that are alike, kept for the next time.


@dataclass(frozen=True)
class ArmReach:
    """The map of an arm, which may be that of another one that is alike.

    Attributes:
        map: The map.
        mirrored: Whether the arm is that of the other side.
        scale: How many times as large the arm is.
    """

    map: CapabilityMap
    mirrored: bool
    scale: float


USUAL_M = 1.75
"""Stature of the body whose map serves all people of its proportions, metres."""
ALIKE_M = 0.01
"""How far links of people may differ from those of that body, scaled: widths of hands do not scale (ours)."""


def reach_of(chain: ArmChain, side: str, human_stature_m: float | None = None) -> ArmReach:
    """What an arm reaches.

    Args:
        chain: The arm.
        side: ``left`` or ``right``.
        human_stature_m: Stature of a body that may have the usual human proportions; None for other bodies.
    """
    mirrored = side == "right"
    left = chain.mirrored() if mirrored else chain
    if human_stature_m is not None:
        scale = human_stature_m / USUAL_M
        if left.scaled(1.0 / scale).is_about(usual_arm(), ALIKE_M):
            return ArmReach(capability(usual_arm()), mirrored, scale)
    return ArmReach(capability(left), mirrored, 1.0)


@lru_cache(maxsize=1)
def usual_arm() -> ArmChain:
    """The left arm of the usual human body."""
    model = mujoco.MjModel.from_xml_string(human_mjcf(HumanSize.from_stature(USUAL_M)))
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    bodies = {"root": "left_clavicle", "hand": "left_hand", "carrier": "torso"}
    indices = {name: int(model.body(body).id) for name, body in bodies.items()}
    sites = {"shoulder": int(model.site("left_shoulder").id), "palm": int(model.site("left_palm").id)}
    arm = ("left_clavicle", "left_upper_arm", "left_forearm", "left_hand")
    geoms = np.flatnonzero(np.isin(model.geom_bodyid, [model.body(name).id for name in arm]))
    return chain_of(model, data, indices | sites, geoms, shoulder_limits("left"))


@lru_cache(maxsize=32)
def capability(chain: ArmChain) -> CapabilityMap:
    """The map of an arm: known, shipped, kept from an earlier run, or made now and kept."""
    return _kept(chain, SHIPPED / _file(chain).name) or _kept(chain, _file(chain)) or _made(chain)


SHIPPED = Path(__file__).parent.parent / "arms"
"""Folder of the maps that come with the package."""
NAMES = ("grid", "shape", "eighths", "starts", "configurations")
MOST_BYTES = 2**28


def _file(chain: ArmChain) -> Path:
    settings = repr((VERSION, SAMPLES, EDGE_SHARE, CELL_M, MOST_SAMPLED_BYTES, SHIFT_M, SPREAD, SUNK_M, chain.digest))
    return cache_folder().parent / "arms" / f"arm-{hashlib.sha256(settings.encode()).hexdigest()[:16]}.npz"


def _made(chain: ArmChain) -> CapabilityMap:
    log.info("an arm is met for the first time: finding out where it gets to, once")
    found = CapabilityMap.of(chain, SAMPLES)
    try:
        keep(found, _file(chain).parent)
    except (OSError, InputError) as error:
        log.info("where an arm gets to is not kept for the next time: %s", error)
    return found


def keep(found: CapabilityMap, folder: Path) -> Path:
    """Write a map into a folder, under the name by which it is found again."""
    file = folder / _file(found.chain).name
    file.parent.mkdir(parents=True, exist_ok=True)
    with writing(file, replace=True) as stream:
        np.savez_compressed(
            stream,
            grid=np.array((*found.corner, found.cell_m)),
            shape=np.array(found.shape),
            eighths=found.eighths,
            starts=found.starts.astype(np.int32),
            configurations=found.configurations,
        )
    return file


def _kept(chain: ArmChain, file: Path) -> CapabilityMap | None:
    """The map in a file; None where there is none, or none of use."""
    if not file.is_file():
        return None
    with suppress(InputError, OSError, ValueError, KeyError):
        arrays = ArrayFile(file, most_bytes=MOST_BYTES)
        grid, shape, eighths, starts, configurations = (arrays.array(name) for name in NAMES)
        size = (int(shape[0]), int(shape[1]), int(shape[2]))
        whole = (
            grid.shape == (4,)
            and eighths.shape == (math.prod(size),)
            and starts.shape == (len(eighths) + 1,)
            and starts[0] == 0
            and bool((np.diff(starts) >= 0).all())
            and configurations.shape == (starts[-1], len(chain.joints))
        )
        if whole and min(size) > 0:
            return CapabilityMap(
                chain,
                grid[:3].astype(np.float64),
                float(grid[3]),
                size,
                eighths.astype(np.uint8),
                starts.astype(np.intp),
                configurations.astype(np.uint16),
                _palms(chain, configurations),
            )
    return None
