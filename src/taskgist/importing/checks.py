"""What cannot be right in tracked motion: units, axes, a floor elsewhere, copied points, left and right mixed up."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping, Set
from pathlib import Path

import numpy as np

from taskgist.common.arrays import Array
from taskgist.errors import MappingError
from taskgist.importing.mapping import PointRef
from taskgist.importing.mapping_fields import UNITS_M
from taskgist.importing.mapping_people import HEAD_POINTS, LEG_POINTS, PARTS
from taskgist.importing.table_values import Track
from taskgist.importing.tables import Samples

PERSON_EXTENT_M = (0.1, 3.0)
"""Across all points of a person in one frame: few points of a child, to outstretched arms over head."""
USUAL_EXTENT_M = (0.4, 2.6)
"""The same, for suggesting a unit."""
HEAD_HEIGHT_M = (0.4, 2.4)
"""Over the floor, sitting child to tall adult."""
FARTHEST_OBJECT_M = 20.0
"""From the middle of all people."""

FARTHEST_CLOCKS_S = 60.0
"""Between the end of one source and the beginning of another (ours)."""

_KNEES = frozenset({"left_knee", "right_knee"})
_BELOW_HEAD = frozenset({"pelvis", "abdomen", "left_hip", "right_hip", "chest"})


def check_duplicates(file: Path, people: Mapping[str, Samples]) -> None:
    """Refuse two points whose samples are the same in every frame: one of them was recorded twice.

    Raises:
        MappingError: There are such points.
    """
    seen: dict[bytes, tuple[str, str, PointRef]] = {}
    for person, landmarks in people.items():
        for landmark, pairs in landmarks.items():
            for ref, track in pairs:
                if not np.isfinite(track.position_m).any():
                    continue
                first = seen.setdefault(track.position_m.tobytes(), (person, landmark, ref))
                if first[:2] != (person, landmark) and (first[0] != person or first[2] != ref):
                    raise _duplicate(file, first[:2], (person, landmark), track)


def check_clocks(file: Path, tracks: Iterable[Track]) -> None:
    """Refuse sources whose times lie far apart: their clocks have different origins.

    Things that are tracked one after the other are let pass where another source spans the time between them.

    Raises:
        MappingError: For a long time nothing is tracked, and there are sources before it and after it.
    """
    known = sorted(tracks, key=lambda track: float(track.times_s[0]))
    if not known:
        return
    first = known[0]
    for track in known[1:]:
        if float(track.times_s[0] - first.times_s[-1]) > FARTHEST_CLOCKS_S:
            spans = [f"{each.where}: {each.times_s[0]:.3f} to {each.times_s[-1]:.3f} s" for each in (first, track)]
            raise MappingError(
                "two sources were never recorded together: their clocks differ",
                where=file,
                field="time",
                value="; ".join(spans),
                hint="give one of the sources offset_s, which is added to its times",
            )
        first = max(first, track, key=lambda each: float(each.times_s[-1]))


def check_person(file: Path, name: str, points: Mapping[str, Array], units_m: Set[float]) -> None:
    """Refuse a person of impossible size, upside down, or away from the floor.

    Args:
        file: The mapping, for messages.
        name: The person.
        points: Positions by landmark, (N, 3) each.
        units_m: Units of the sources that they come from.

    Raises:
        MappingError: The person is never seen; units, axes or the height of the floor must be wrong.
    """
    field = f"people.{name}"
    if not any(np.isfinite(values).any() for values in points.values()):
        hint = "check missing, confidence, time and the mapping's start_s and end_s"
        raise MappingError("the person is never seen", where=file, field=field, hint=hint)
    if len(points) >= 3:
        _check_extent(file, field, _median_extent_m(points), units_m)
    head_z = _median_z(points, HEAD_POINTS)
    below_z = _median_z(points, _BELOW_HEAD)
    if is_low(points) or _bends(points):
        return
    if head_z - below_z < LEAST_RISE_M:
        hint = 'check axes: our x is forward, y left, z up, as axes = { x = "-z", y = "-x", z = "y" } for y up'
        value = f"{head_z - below_z:+.2f} m along our z axis"
        raise MappingError("the head is not above the trunk", where=file, field=field, value=value, hint=hint)
    if not np.isnan(head_z) and not HEAD_HEIGHT_M[0] <= head_z <= HEAD_HEIGHT_M[1]:
        hint = "the floor must be z = 0: shift the source, as transform = { position_m = [0, 0, 1.1] }"
        raise MappingError("the head is not at a person's height", where=file, field=field, value=head_z, hint=hint)


LEAST_RISE_M = 0.05
"""Between trunk and head of who neither lies nor bends far."""
LYING_M = (-0.15, 1.2)
"""Heights between which all of somebody lies, from the floor to a high bed (ours)."""
LYING_EXTENT_M, LYING_RISE_M = 0.7, 0.3
"""Vertical extent of somebody who lies, and of the head over the trunk, or below it (ours)."""
BENT_RISE_M, STANDING_RISE_M = -0.7, 0.3
"""Least height of the head over the trunk in who bends down, and of the hips over the feet (ours)."""


def is_low(points: Mapping[str, Array]) -> bool:
    """Whether somebody lies for most of the time, or bends far where no legs are known: the body is level and low."""
    rise_m = _median_z(points, HEAD_POINTS) - _median_z(points, _BELOW_HEAD)
    if not abs(rise_m) < LYING_RISE_M:
        return False
    heights = np.concatenate([values[:, 2] for values in points.values()])
    low, high = np.nanpercentile(heights, (5.0, 95.0))
    return bool(low >= LYING_M[0] and high <= LYING_M[1] and high - low < LYING_EXTENT_M)


def _bends(points: Mapping[str, Array]) -> bool:
    """Whether the head is down while the hips are over the feet, for most of the time."""
    rise_m = _median_z(points, HEAD_POINTS) - _median_z(points, _BELOW_HEAD)
    legs_m = _median_z(points, {"pelvis", "left_hip", "right_hip"}) - _median_z(points, LEG_POINTS - _KNEES)
    return bool(BENT_RISE_M < rise_m < LEAST_RISE_M and legs_m > STANDING_RISE_M)


def check_objects(file: Path, positions: Mapping[str, Array], people: list[Array]) -> None:
    """Refuse objects far away from everybody.

    Args:
        file: The mapping, for messages.
        positions: Positions by object, (N, 3) each.
        people: Tracked points of each person, (n, 3) each.

    Raises:
        MappingError: Units or frames must be wrong.
    """
    if not people:
        return
    somebody = np.nanmedian(np.concatenate(people), axis=0)
    for name, position_m in positions.items():
        distance_m = float(np.nanmin(np.linalg.norm(position_m - somebody, axis=1)))
        if distance_m > FARTHEST_OBJECT_M:
            raise MappingError(
                "the object is far away from all people",
                where=file,
                field=f"objects.{name}",
                value=f"{distance_m:.3g} m",
                hint="check units, axes and transform of its source",
            )


def _check_extent(file: Path, field: str, extent_m: float, units_m: Set[float]) -> None:
    if np.isnan(extent_m) or PERSON_EXTENT_M[0] <= extent_m <= PERSON_EXTENT_M[1]:
        return
    fitting = [
        unit
        for unit, metres in UNITS_M.items()
        if len(units_m) == 1 and USUAL_EXTENT_M[0] <= extent_m / min(units_m) * metres <= USUAL_EXTENT_M[1]
    ]
    hint = f'change units to "{fitting[0]}"' if fitting else "check units"
    raise MappingError(
        "no person has this size",
        where=file,
        field=field,
        value=f"{extent_m:.4g} m across all points",
        hint=f"{hint} in the source",
    )


def _median_extent_m(points: Mapping[str, Array]) -> float:
    stacked = np.stack(list(points.values()))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # frames in which nothing is known are NaN, as they should
        spans = np.nanmax(stacked, axis=0) - np.nanmin(stacked, axis=0)
        return float(np.nanmedian(np.linalg.norm(spans, axis=1)))


def _median_z(points: Mapping[str, Array], names: Set[str]) -> float:
    heights = [values[:, 2] for landmark, values in points.items() if landmark in names]
    known = np.concatenate(heights) if heights else np.array([])
    known = known[np.isfinite(known)]
    return float(np.median(known)) if len(known) else float("nan")


def _duplicate(file: Path, first: tuple[str, str], second: tuple[str, str], track: Track) -> MappingError:
    person, landmark = second
    return MappingError(
        "two points have the same positions in every frame",
        where=file,
        field=f"people.{person}.points.{landmark}",
        value=f"{'.'.join(first)} and {'.'.join(second)}",
        hint=_way_out_of_duplicate(first, second, track),
    )


def _way_out_of_duplicate(first: tuple[str, str], second: tuple[str, str], track: Track) -> str:
    person, landmark = second
    known = np.isfinite(track.position_m).all(axis=1)
    if not np.ptp(track.position_m[known], axis=0).any():
        return "they never move: if that value stands for not tracked, declare it with missing = 0"
    if first[0] != person:
        return f"check what person = ... stands for in {first[0]} and {person}"
    part = next(part for part in ("left_hand", "right_hand", *PARTS) if landmark in PARTS[part])
    return f'say which one not to believe, as [people.{person}] unknown = {{ {part} = "copy of the other" }}'


# --- People whose left is on their right: axes that mirror, or sides that were mixed up.
#
# Bodies are nearly symmetric, so a mirrored one would be fitted well enough to be believed, with every hand the wrong
# one and the face looking backwards. What betrays it is that faces, toes, and knees as they bend, point forward.

SIDES = (("left_shoulder", "right_shoulder"), ("left_hip", "right_hip"))
FORWARD = (("left_heel", "left_toe"), ("right_heel", "right_toe"))
MOST_TURNED = -0.5
"""Cosine between where face and feet point and what the sides say is forward; people turn their heads, not round."""
ALWAYS = 90.0
"""Percentage of the frames in which a mirrored person faces backwards: all, but for noise. Who looks back does so for a
while, and trackers of images exchange the sides of somebody who turns round until they see the face again (ours)."""


def check_not_mirrored(file: Path, name: str, points: Mapping[str, Array], face: Array | None) -> None:
    """Refuse a person that faces backwards all the time.

    Args:
        file: The mapping, for messages.
        name: The person.
        points: Positions by landmark, metres, (N, 3) each.
        face: Where the face looks, (N, 3), if that is known.

    Raises:
        MappingError: Face and feet point against what left and right say.
    """
    across = [points[left] - points[right] for left, right in SIDES if left in points and right in points]
    ahead = [points[toe] - points[heel] for heel, toe in FORWARD if heel in points and toe in points]
    ahead += [] if face is None else [face]
    cosines = [_level_cosine(np.cross(sideways, (0.0, 0.0, 1.0)), forward) for sideways in across for forward in ahead]
    known = [cosine for cosine in cosines if np.isfinite(cosine)]
    if known and max(known) < MOST_TURNED:
        raise MappingError(
            "the person faces backwards: left and right are exchanged",
            where=file,
            field=f"people.{name}",
            hint="give axes that mirror if the source is left-handed (see Units, axes, frames), or exchange the points",
        )


def _level_cosine(a: Array, b: Array) -> float:
    """Cosine between horizontal directions that they seldom exceed (``ALWAYS``); NaN if never known together."""
    level_a, level_b = a[:, :2], b[:, :2]
    lengths = np.linalg.norm(level_a, axis=1) * np.linalg.norm(level_b, axis=1)
    known = np.isfinite(lengths) & (lengths > 0.0)
    if not known.any():
        return float("nan")
    return float(np.percentile(np.sum(level_a[known] * level_b[known], axis=1) / lengths[known], ALWAYS))
