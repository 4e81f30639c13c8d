"""Settling: what physics makes of a thing that is let go where a plan puts it.

A plan says where a thing shall be; whether it stays there is for MuJoCo to say (``world/dynamics.py``). The thing, and
whatever it touches directly or through others, may move; all else keeps still. Example::

    end = settled(scene, state, "cup")
    end.stays  # within 10 mm and 5° of where it was put, at rest, and nothing else was pushed
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from taskgist.common.arrays import Array
from taskgist.common.frozen import FrozenMap, Json
from taskgist.world import FreeMotion, Scene, Stage, State
from taskgist.world.dynamics import free_motions
from taskgist.world.geometry.transforms import rotate

LONGEST_S = 2.0
"""How long a thing is watched."""
TOUCHING_M = 0.01
"""Things no farther apart than this may come to touch as they settle."""
STAYS_M, STAYS_RAD = 0.010, np.deg2rad(5.0)
"""How far a thing may move and turn, and still be where it was put."""


@dataclass(frozen=True)
class Shift:
    """By how much a thing has moved: its middle in metres, and its turn in radians."""

    moved_m: float
    turned_rad: float

    @property
    def is_small(self) -> bool:
        """Whether it counts as having stayed."""
        return self.moved_m <= STAYS_M and self.turned_rad <= STAYS_RAD

    @property
    def text(self) -> str:
        """The shift as people write it."""
        return f"{1000 * self.moved_m:.1f} mm and {np.degrees(self.turned_rad):.1f}°"


@dataclass(frozen=True, eq=False)
class Settled:
    """How a thing settled.

    Attributes:
        thing: The thing that was let go.
        shift: By how much it moved.
        rests: Whether it, and all that it touches, came to rest.
        pushed: The other things that did not stay where they were, and by how much they moved.
        motions: How the thing, and each that might have moved with it, moved.
        state: Where everything is afterwards.
    """

    thing: str
    shift: Shift
    rests: bool
    pushed: Mapping[str, Shift]
    motions: Mapping[str, FreeMotion]
    state: State

    @property
    def stays(self) -> bool:
        """Whether it is where it was put, at rest, and all else is in place."""
        return self.shift.is_small and self.rests and not self.pushed

    @property
    def text(self) -> str:
        """What happened, as a sentence."""
        if self.stays:
            return f"{self.thing} stays where it is put"
        parts = [] if self.shift.is_small else [f"{self.thing} moves by {self.shift.text} when it is let go"]
        parts += [f"it pushes {name} by {shift.text}" for name, shift in self.pushed.items()]
        parts += [] if self.rests else [f"{self.thing} does not come to rest within {LONGEST_S:.0f} s"]
        return ", and ".join(parts)

    def to_json(self) -> dict[str, Json]:
        """As JSON values."""
        return {
            "thing": self.thing,
            "stays": self.stays,
            "moved_m": self.shift.moved_m,
            "turned_rad": self.shift.turned_rad,
            "rests": self.rests,
            "pushed": {name: [shift.moved_m, shift.turned_rad] for name, shift in self.pushed.items()},
            "text": self.text,
        }


def settled(
    scene: Scene, state: State, thing: str, *, passing: Iterable[str] = (), longest_s: float = LONGEST_S
) -> Settled:
    """Let a thing go where it is, and watch it and what it touches.

    Args:
        scene: The scene.
        state: Where everything is, the thing where a plan puts it.
        thing: The thing, an object of the scene.
        passing: What it passes through: the hand that lets it go, such as "P1/right_arm".
        longest_s: How long to watch at most, seconds.

    Raises:
        SceneError: A thing has no shape, or one without inside, so that nothing can be said of its motion.
        UnknownNameError: There is no such object.
    """
    passing = tuple(passing)
    loose = _touching(scene, state.without(passing), thing)
    motions = free_motions(scene, state, loose, passing=passing, longest_s=longest_s)
    stage, shifts, end = Stage(scene, state), {}, state
    for name in loose:
        shifts[name] = _shift(stage, name, motions[name])
        end = end.replace(at=scene.object_slice(name), to=motions[name].end)
    pushed = {name: shifts[name] for name in loose[1:] if not shifts[name].is_small}
    return Settled(thing, shifts[thing], motions[thing].rests, FrozenMap(pushed), FrozenMap(motions), end)


def _touching(scene: Scene, state: State, thing: str) -> tuple[str, ...]:
    """A thing, and all other objects that it touches, directly or through others."""
    scene.object_body(thing)
    stage, found = Stage(scene, state), [thing]
    others = [name for name in scene.objects if name != thing and stage.state.known([name])]
    for name in found:  # it grows meanwhile
        mine = scene.solid_geoms_of(name)
        for other in others:
            theirs = scene.solid_geoms_of(other)
            if other not in found and stage.closest(mine, theirs, limit_m=TOUCHING_M)[1] >= 0:
                found.append(other)
    return tuple(found)


def _shift(stage: Stage, name: str, motion: FreeMotion) -> Shift:
    """How far a thing has moved at the end of a motion."""
    middle = stage.bounds(stage.scene.solid_geoms_of(name)).mean(axis=0)
    inside = stage.body(stage.scene.object_body(name)).to_local(middle)
    start, end = motion.poses[0], motion.poses[-1]
    moved = _placed(end, inside) - _placed(start, inside)
    turned_rad = 2 * np.arccos(np.clip(abs(float(start[3:] @ end[3:])), 0.0, 1.0))
    return Shift(float(np.linalg.norm(moved)), float(turned_rad))


def _placed(pose: Array, point: Array) -> Array:
    return np.asarray(pose[:3] + rotate(pose[3:], point))
