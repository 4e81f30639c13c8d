"""Grasps of an object by a hand that closes between a thumb and fingers (5.1.3).

The two points of a pair can be grasped if the hand opens that wide; it may come from several directions around the
line between them. Before it closes it is open by little more than the width, or, where the object itself is then in
its way (as the curved wall of a bowl in that of straight fingers), as wide as it goes.

Grasps are sampled in the object's own frame, once for each form of object, hand and settings (and, of an object with
joints of its own, each position of these): wherever the object goes, they go with it, into other scenes, too.
"""

from __future__ import annotations

import math
from collections.abc import Hashable
from dataclasses import replace
from weakref import WeakKeyDictionary

import numpy as np

from taskgist.perspective.grasping.forms import form_of, shapes_of
from taskgist.perspective.grasping.grasps import Array, Grasps
from taskgist.perspective.grasping.pairs import Pairs, opposite_points
from taskgist.perspective.grasping.touch import in_itself, met_by_all_fingers, touching
from taskgist.settings import Grasp
from taskgist.world import Hand, Scene, Stage

ROUNDING = 1e-9
REMEMBERED = 256
"""Sampled objects kept for each scene, and forms kept for all of them."""
IDENTITY = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)


def sample_grasps(stage: Stage, name: str, hand: Hand, settings: Grasp) -> Grasps:
    """Grasps of an object where it is now, in the world.

    Args:
        stage: The scene in a state.
        name: The object.
        hand: What is to grasp it.
        settings: How densely to sample.
    """
    return grasps_in_object(stage, name, hand, settings).placed(stage.body(stage.scene.object_body(name)))


def grasps_in_object(stage: Stage, name: str, hand: Hand, settings: Grasp) -> Grasps:
    """Grasps of an object in its own frame, sampled once; only the object's own joints are read off the stage."""
    scene = stage.scene
    joints = {int(index): round(float(stage.state.qpos[index]), 6) for index in scene.inner_joints(name)}
    known = _SAMPLED.setdefault(scene, {})
    key = (name, hand, settings, tuple(joints.values()))
    if key not in known:
        if len(known) >= REMEMBERED:
            known.pop(next(iter(known)))
        at_origin = scene.initial.replace(joints, at=scene.object_slice(name), to=IDENTITY)
        known[key] = _of_its_form(Stage(scene, at_origin), name, hand, settings)
    return known[key]


_SAMPLED: WeakKeyDictionary[Scene, dict[Hashable, Grasps]] = WeakKeyDictionary()
_BY_FORM: dict[Hashable, Grasps] = {}
"""Grasps whose shapes are counted among those of their object."""


def _of_its_form(bench: Stage, name: str, hand: Hand, settings: Grasp) -> Grasps:
    """Grasps of an object; one of the same form may have been sampled in another scene."""
    shapes = shapes_of(bench, name)
    key = (form_of(bench, name), hand, settings)
    if key not in _BY_FORM:
        if len(_BY_FORM) >= REMEMBERED:
            _BY_FORM.pop(next(iter(_BY_FORM)))
        grasps = _sampled(bench, name, hand, settings)
        counted = {field: np.searchsorted(shapes, getattr(grasps, field)) for field in ("shapes", "solids")}
        _BY_FORM[key] = replace(grasps, **counted)
    known = _BY_FORM[key]
    return _frozen(replace(known, shapes=shapes[known.shapes], solids=shapes[known.solids]))


def _sampled(bench: Stage, name: str, hand: Hand, settings: Grasp) -> Grasps:
    pairs = opposite_points(bench, name, settings, hand.opening_m + ROUNDING)
    narrowest_m = float(pairs.widths_m.min()) if len(pairs.widths_m) else None
    pairs = pairs.take(pairs.widths_m <= hand.opening_m + ROUNDING)
    grasps = _around(bench, name, _both_ways(pairs) if hand.one_sided else pairs, narrowest_m, settings)
    if hand.one_sided:
        grasps = grasps.only(met_by_all_fingers(bench, name, grasps, hand))
    return _frozen(_opened(bench, grasps, hand))


def _around(bench: Stage, name: str, pairs: Pairs, narrowest_m: float | None, settings: Grasp) -> Grasps:
    """Grasps of each pair from all directions, the hand opened little more than wide enough."""
    rows = np.repeat(np.arange(len(pairs.centers)), settings.approaches)
    return Grasps(
        centers=pairs.centers[rows],
        closings=pairs.closings[rows],
        approaches=around(pairs.closings, settings.approaches).reshape(-1, 3),
        widths_m=pairs.widths_m[rows],
        gaps_m=np.full(len(rows), settings.clearance_m),
        in_itself=np.zeros(len(rows), dtype=bool),
        shapes=pairs.shapes[rows],
        solids=bench.scene.solid_geoms_of(name),
        touching=touching(bench, name, pairs)[rows],
        narrowest_m=narrowest_m,
    )


def _opened(bench: Stage, grasps: Grasps, hand: Hand) -> Grasps:
    """Grasps opened as wide as the hand goes where they would be in the object otherwise."""
    tight = in_itself(bench, grasps, hand)
    widest = np.maximum((hand.opening_m - grasps.widths_m) / 2, grasps.gaps_m)
    wide = replace(grasps, gaps_m=np.where(tight, widest, grasps.gaps_m))
    blocked = np.zeros(len(grasps), dtype=bool)
    blocked[tight] = in_itself(bench, wide.only(tight), hand)
    return replace(wide, gaps_m=np.where(blocked, grasps.gaps_m, wide.gaps_m), in_itself=blocked)


def around(closings: Array, count: int) -> Array:
    """Directions square to closing directions, evenly around each, beginning near an axis of the frame.

    Args:
        closings: Unit directions, (n, 3).
        count: How many around each.

    Returns:
        Unit directions, (n, count, 3).
    """
    reference = np.eye(3)[np.argmin(np.round(np.abs(closings), 6), axis=1)]
    first = reference - closings * np.sum(closings * reference, axis=1, keepdims=True)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(closings, first)
    angles = 2 * math.pi * np.arange(count)[:, None] / count
    return np.asarray(np.cos(angles) * first[:, None] + np.sin(angles) * second[:, None])


def _both_ways(pairs: Pairs) -> Pairs:
    """Each pair, and with thumb and fingers changed over."""
    return Pairs(
        np.concatenate((pairs.centers, pairs.centers)),
        np.concatenate((pairs.closings, -pairs.closings)),
        np.concatenate((pairs.widths_m, pairs.widths_m)),
        np.concatenate((pairs.shapes, pairs.shapes[:, ::-1])),
    )


def _frozen(grasps: Grasps) -> Grasps:
    for value in vars(grasps).values():
        if isinstance(value, np.ndarray):
            value.flags.writeable = False
    return grasps
