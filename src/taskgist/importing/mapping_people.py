"""The [people.NAME] tables: which tracked points are which landmarks, and which way its parts point."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import Any

from taskgist.common.toml import TomlTable
from taskgist.errors import UnknownNameError
from taskgist.importing.mapping import Between, LocalAxis, Name, Person, Point, PointRef, Source
from taskgist.importing.mapping_fields import local_axis
from taskgist.importing.skeletons import Skeleton, skeleton_named

# --- The names that an import mapping gives to tracked points of a person, and the parts of the body they belong to.

SIDES = ("left", "right")
HEAD_POINTS = frozenset({"head", "head_base", "head_top", "nose", "left_eye", "right_eye", "left_ear", "right_ear"})
TORSO_POINTS = frozenset(
    {"neck", "chest", "abdomen", "pelvis", "left_shoulder", "right_shoulder", "left_hip", "right_hip"}
)
LEG_POINTS = frozenset(f"{side}_{name}" for side in SIDES for name in ("knee", "ankle", "heel", "toe"))


def _hand_points(side: str) -> frozenset[str]:
    return frozenset(f"{side}_{name}" for name in ("wrist", "hand", "fingertip", "thumb"))


PARTS: dict[str, frozenset[str]] = {
    "head": HEAD_POINTS,
    "torso": TORSO_POINTS,
    "left_arm": _hand_points("left") | {"left_elbow"},
    "right_arm": _hand_points("right") | {"right_elbow"},
    "left_hand": _hand_points("left"),
    "right_hand": _hand_points("right"),
    "legs": LEG_POINTS,
}
"""Parts that a mapping may declare unknown, with the points that fall with them."""

LANDMARKS: frozenset[str] = frozenset().union(*PARTS.values())
"""Every name of a point; ``docs/howto/import.md`` says where on the body each lies."""

DIRECTIONS: dict[str, dict[str, str]] = {
    "head": {"forward": "face", "up": "head_up"},
    "left_hand": {"forward": "left_hand", "palm": "left_palm", "thumb": "left_thumb"},
    "right_hand": {"forward": "right_hand", "palm": "right_palm", "thumb": "right_thumb"},
    "chest": {"forward": "chest"},
    "pelvis": {"forward": "pelvis", "up": "pelvis_up"},
}
"""What a mapping may say about the axes of parts, and the name under which the fit of a body asks for it."""

Directions = dict[str, LocalAxis | Between]


def read_person(name: str, section: TomlTable, sources: Mapping[str, Source]) -> Person:
    """One person.

    Args:
        name: The person's name.
        section: The [people.NAME] table.
        sources: The mapping's sources, by name.

    Raises:
        MappingError: A field is missing, unknown or out of range.
        UnknownNameError: A landmark, part, source or skeleton that does not exist.
    """
    default_source = section.text("source", None)
    given = {
        landmark: _refs(section.table("points"), landmark, default_source, sources)
        for landmark in _known_keys(section, "points", LANDMARKS, "landmark")
    }
    preset: dict[str, tuple[PointRef, ...]] = {}
    axes: Mapping[str, Mapping[str, str]] = {}
    skeleton = section.text("skeleton", None)
    if skeleton is not None:
        source = sources[_source(section, default_source, sources)]
        known = skeleton_named(skeleton, f"{section.place}.skeleton")
        preset = {key: refs for key, refs in _preset(section, known, source).items() if key not in given}
        axes = known.axes_by_up.get(_up(source), {}) if source.rotation else {}
    points = tuple(Point(landmark, refs) for landmark, refs in {**preset, **given}.items() if refs)
    if not points:
        hint = 'as points = { head = "Head", ... }, or skeleton = "zed_body_34"'
        raise section.error("names no points", "points", hint=hint)
    person = Person(
        name=name,
        token=_token(section, name),
        points=points,
        directions=tuple(_directions(section, {point.landmark for point in points}, axes).items()),
        unknown=_unknown(section),
        stature_m=section.number("stature_m", None, least=0.5, most=2.5),
        skeleton=skeleton or "",
        preset=tuple(preset),
    )
    section.done()
    return person


def _preset(section: TomlTable, skeleton: Skeleton, source: Source) -> dict[str, tuple[PointRef, ...]]:
    """The points of a skeleton as the source calls them, by landmark; those that it does not list are left out.

    Names are alike whatever their case and what stands between their words: LEFT_EYE is "Left eye", too. A source that
    lists no names is taken to have the skeleton's own, in the skeleton's order.
    """
    listed = source.names or skeleton.names
    spelled = {folded(name): name for name in listed}
    found = {
        landmark: tuple(PointRef(source.name, spelled.get(folded(point), point)) for point in at.points)
        for landmark, at in skeleton.points().items()
        if not listed or all(folded(point) in spelled for point in at.points)
    }
    if not found:
        theirs = ", ".join(point for at in list(skeleton.points().values())[:6] for point in at.points)
        raise section.error(
            "the source's names are not those of this skeleton",
            "skeleton",
            section.values["skeleton"],
            f"its points are called {theirs}, ...: name them so in the source, or map them by points = {{ ... }}",
        )
    return found


def folded(name: str) -> str:
    """A name without what differs between spellings: case, and what stands between its words."""
    return "".join(letter for letter in name.casefold() if letter.isalnum())


def _up(source: Source) -> str:
    """The source's axis that points up, "y" or "z"; empty for another one."""
    return {(0.0, 1.0, 0.0): "y", (0.0, 0.0, 1.0): "z"}.get(source.frame.axes[2], "")


def read_point_ref(section: TomlTable, default_source: str | None, sources: Collection[str]) -> PointRef:
    """A point given as a table: source, point, offset_m (and nothing else)."""
    ref = PointRef(
        source=_source(section, section.text("source", default_source), sources),
        point=_point_name(section, "point", section.any("point")),
        offset_m=section.triple("offset_m", None),
    )
    section.done()
    return ref


def _refs(
    points: TomlTable, landmark: str, default_source: str | None, sources: Collection[str]
) -> tuple[PointRef, ...]:
    value = points.any(landmark)
    if value is False:
        return ()
    if isinstance(value, dict) and "mean" in value:
        section = points.table(landmark)
        items = section.any("mean")
        section.done()
        if not isinstance(items, list) or not items:
            raise section.error("must be a list of points", "mean", items)
        return tuple(_ref(points, landmark, item, default_source, sources) for item in items)
    return (_ref(points, landmark, value, default_source, sources),)


def _ref(
    points: TomlTable, landmark: str, value: Any, default_source: str | None, sources: Collection[str]
) -> PointRef:
    if isinstance(value, dict):
        return read_point_ref(points.inner(value, landmark), default_source, sources)
    source = _source(points, default_source, sources)
    return PointRef(source, _point_name(points, landmark, value))


def _source(section: TomlTable, source: str | None, sources: Collection[str]) -> str:
    if source is None:
        hint = 'add source = "NAME", which names one of [sources.NAME]'
        raise section.error("no source is given", "source", hint=hint)
    if source not in sources:
        raise UnknownNameError("source", source, sources, where=f"{section.place}")
    return source


def _point_name(section: TomlTable, key: str, value: Any) -> Name:
    good = (isinstance(value, str) and value) or (isinstance(value, int) and not isinstance(value, bool))
    if not good or (isinstance(value, int) and value < 0):
        raise section.error("must be the point's name in the source, or its index from 0", key, value)
    name: Name = value
    return name


def _token(section: TomlTable, name: str) -> Name:
    return _point_name(section, "person", section.any("person", name))


def _directions(section: TomlTable, mapped: Collection[str], preset: Mapping[str, Mapping[str, str]]) -> Directions:
    given = section.table("directions")
    directions: Directions = {}
    for part in DIRECTIONS:
        if part in given:
            directions |= _given(given.table(part), part, mapped)
        elif part in preset and _usual_frame(part, mapped) in mapped:
            directions |= _given(given.inner(preset[part], part), part, mapped)
        else:
            directions |= _usual(part, mapped)
    given.done()
    return directions


def _given(section: TomlTable, part: str, mapped: Collection[str]) -> Directions:
    names = DIRECTIONS[part]
    found: Directions = {}
    if "from" in section:
        start, end = _landmarks(section, "from", mapped), _landmarks(section, "to", mapped)
        raise_rad = math.radians(section.number("raise_deg", 0.0, least=-90, most=90))
        found[names["forward"]] = Between(start, end, raise_rad)
    else:
        of = section.text("of", _usual_frame(part, mapped))
        if of not in mapped:
            raise UnknownNameError("mapped landmark", str(of), mapped, where=f"{section.place}.of")
        found |= {name: LocalAxis(of, local_axis(section, key)) for key, name in names.items() if key in section}
    section.done()
    if not found:
        hint = f"give a local axis for {' or '.join(names)}, or from = [...], to = [...] (landmarks)"
        raise section.error("does not say which way", hint=hint)
    return found


def _usual_frame(part: str, mapped: Collection[str]) -> str:
    candidates = {"head": ("head", "head_base")}.get(part, (part, part.replace("hand", "wrist")))
    return next((candidate for candidate in candidates if candidate in mapped), candidates[0])


def _usual(part: str, mapped: Collection[str]) -> Directions:
    """Where the mapping is silent: from the ears to the face; from the wrist to the knuckles and the fingertip.

    The knuckles alone are near the wrist and shake; the tip alone is beside the hand's line when fingers are bent.
    """
    if part == "head":
        start: tuple[str, ...] = ("left_ear", "right_ear")
        end = _face(mapped)
    elif part.endswith("_hand"):
        start = (part.replace("hand", "wrist"),)
        end = tuple(name for name in (part, part.replace("hand", "fingertip")) if name in mapped)
    else:
        return {}
    return {DIRECTIONS[part]["forward"]: Between(start, end)} if end and set(start) <= set(mapped) else {}


def _face(mapped: Collection[str]) -> tuple[str, ...]:
    """Nose and eyes, as far as they are there; one eye alone would turn the face aside."""
    eyes = ("left_eye", "right_eye") if {"left_eye", "right_eye"} <= set(mapped) else ()
    return eyes + (("nose",) if "nose" in mapped else ())


def _landmarks(section: TomlTable, key: str, mapped: Collection[str]) -> tuple[str, ...]:
    value = section.any(key)
    names = value if isinstance(value, list) else [value]
    for name in names:
        if not isinstance(name, str) or name not in mapped:
            raise UnknownNameError("mapped landmark", str(name), mapped, where=f"{section.place}.{key}")
    if not names:
        raise section.error("names no landmark", key, value)
    return tuple(names)


def _unknown(section: TomlTable) -> tuple[tuple[str, str], ...]:
    value = section.any("unknown", {})
    if isinstance(value, list):
        value = dict.fromkeys(map(str, value), "declared unknown in the mapping")
        for part in value:
            _check_known(section, "unknown", part, PARTS, "part")
        return tuple(value.items())
    reasons = section.table("unknown")
    return tuple((part, reasons.text(part)) for part in _known_keys(section, "unknown", PARTS, "part"))


def _known_keys(section: TomlTable, key: str, known: Collection[str], kind: str) -> tuple[str, ...]:
    names = tuple(section.table(key).values)
    for name in names:
        _check_known(section, key, name, known, kind)
    return names


def _check_known(section: TomlTable, key: str, name: str, known: Collection[str], kind: str) -> None:
    if name not in known:
        raise UnknownNameError(kind, name, known, where=f"{section.place}.{key}")
