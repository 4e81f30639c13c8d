"""The [objects.NAME], [supports.NAME] and [robots.NAME] tables."""

from __future__ import annotations

import math
from collections.abc import Collection
from pathlib import Path

import numpy as np

from taskgist.common.files import is_file
from taskgist.common.toml import TomlTable
from taskgist.errors import UnknownNameError
from taskgist.importing.mapping import FixedPose, JointColumns, Markers, PointRef, Robot, Shape, Support, Thing
from taskgist.importing.mapping_fields import UNITS_M, is_column
from taskgist.importing.mapping_people import read_point_ref
from taskgist.world.bodies.profile import builtin_profiles
from taskgist.world.geometry.transforms import matrix_from_euler, wxyz_from_matrix

_SMALLEST_M = 1e-4


def read_thing(name: str, section: TomlTable, sources: Collection[str], data_dir: Path) -> Thing:
    """One object.

    Raises:
        MappingError: A field is missing, unknown or out of range.
        UnknownNameError: A source that does not exist.
    """
    thing = Thing(
        name=name,
        pose=_thing_pose(name, section, sources),
        shapes=_shapes(section, data_dir),
        estimated=section.flag("estimated", False),
        note=section.text("note", ""),
        stays=section.choice("outside", {"unknown", "stays"}, "unknown") == "stays",
    )
    section.done()
    return thing


ANGLE_UNITS_RAD = {"deg": math.pi / 180.0, "rad": 1.0}


def read_robot(name: str, section: TomlTable, sources: Collection[str], folder: Path) -> Robot:
    """One robot.

    Args:
        name: What it is called.
        section: Its table.
        sources: Names of the sources.
        folder: To which the file of a profile of one's own is relative.

    Raises:
        MappingError: A field is missing, unknown or out of range.
        UnknownNameError: A source, or a built-in profile, that does not exist.
    """
    profile = section.text("profile")
    if profile.endswith(".toml"):
        if not is_file(folder / profile):
            raise section.error("the profile does not exist", "profile", str(folder / profile), "check the path")
        profile = str((folder / profile).resolve())
    elif profile not in builtin_profiles():
        raise UnknownNameError("profile", profile, builtin_profiles(), where=f"{section.place}.profile")
    pose = _pose(name, section, sources, "robot")
    joints = _joints(section, sources, pose)
    section.done()
    return Robot(name, profile, pose, joints)


def _joints(section: TomlTable, sources: Collection[str], pose: PointRef | FixedPose) -> JointColumns | None:
    if "joints" not in section:
        return None
    table = section.table("joints")
    source = table.text("source", None if isinstance(pose, FixedPose) else pose.source)
    if source is None:
        raise table.error("the joints have no source", "source", hint='give source = "NAME"')
    if source not in sources:
        raise UnknownNameError("source", str(source), sources, where=f"{table.place}.source")
    column = table.text("column", "{joint}")
    if "{joint}" not in column:
        raise table.error("must hold {joint}", "column", column, 'write it as "position.{joint}"')
    joints = JointColumns(source, column, ANGLE_UNITS_RAD[table.choice("unit", ANGLE_UNITS_RAD, "rad")])
    table.done()
    return joints


def read_support(name: str, section: TomlTable) -> Support:
    """One support.

    Raises:
        MappingError: A field is missing, unknown or out of range.
    """
    support = Support(
        name=name,
        size_m=section.triple("size_m", least=_SMALLEST_M),
        position_m=section.triple("position_m"),
        yaw_rad=math.radians(section.number("yaw_deg", 0.0)),
        estimated=section.flag("estimated", False),
        note=section.text("note", ""),
    )
    section.done()
    return support


def _thing_pose(name: str, section: TomlTable, sources: Collection[str]) -> PointRef | FixedPose | Markers:
    if "points" not in section:
        return _pose(name, section, sources, "object")
    source, points = section.text("source"), section.any("points")
    if source not in sources:
        raise UnknownNameError("source", str(source), sources, where=f"{section.place}.source")
    if not isinstance(points, list) or len(points) < LEAST_MARKERS or not all(map(is_column, points)):
        hint = 'as points = ["cup1", "cup2", "cup3"]; one alone is its point'
        raise section.error(f"must list {LEAST_MARKERS} markers, or more", "points", points, hint)
    if len(set(points)) < len(points):
        raise section.error("names a marker twice", "points", points)
    return Markers(tuple(PointRef(str(source), point) for point in points))


LEAST_MARKERS = 3
"""Fewer points do not fix a pose."""


def _pose(name: str, section: TomlTable, sources: Collection[str], kind: str) -> PointRef | FixedPose:
    if "fixed" in section:
        fixed = section.table("fixed")
        pose = FixedPose(fixed.triple("position_m"), math.radians(fixed.number("yaw_deg", 0.0)))
        fixed.done()
        return pose
    named = {"point": name} | {key: section.any(key) for key in ("source", "point", "offset_m") if key in section}
    if "source" not in named:
        hint = 'give source = "NAME" (tracked), or fixed = { position_m = [x, y, z] } (it never moves)'
        raise section.error(f"the {kind} has no pose", "source", hint=hint)
    return read_point_ref(TomlTable(named, section.document, section.path), None, sources)


def _shapes(section: TomlTable, data_dir: Path) -> tuple[Shape, ...]:
    value = section.any("shape")
    tables = value if isinstance(value, list) else [value]
    if not tables or not all(isinstance(table, dict) for table in tables):
        hint = 'as shape = { type = "box", size_m = [0.3, 0.2, 0.1] }, or a list of such tables'
        raise section.error("must be a table, or a list of tables", "shape", value, hint)
    return tuple(_shape(section.inner(table, "shape"), data_dir) for table in tables)


def _shape(section: TomlTable, data_dir: Path) -> Shape:
    kind = section.choice("type", {"box", "cylinder", "sphere", "mesh"})
    shape = Shape(
        kind=kind,
        size_m=_size(section, kind),
        position_m=section.triple("position_m", (0.0, 0.0, 0.0)),
        wxyz=_orientation(section, kind),
        mesh=_mesh_file(section, data_dir) if kind == "mesh" else None,
        scale_m=UNITS_M[section.choice("units", UNITS_M)] if kind == "mesh" else 1.0,
    )
    section.done()
    return shape


def _size(section: TomlTable, kind: str) -> tuple[float, ...]:
    if kind == "box":
        size: tuple[float, ...] = section.triple("size_m", least=_SMALLEST_M)
        return size
    keys = {"cylinder": ("radius_m", "length_m"), "sphere": ("radius_m",), "mesh": ()}[kind]
    return tuple(section.number(key, least=_SMALLEST_M, most=100.0) for key in keys)


def _orientation(section: TomlTable, kind: str) -> tuple[float, float, float, float]:
    """Of the shape in its object: a cylinder's axis by name, anything else by turns about x, then y, then z."""
    if kind == "cylinder":
        axis = section.choice("axis", {"x", "y", "z"}, "z")
        turn_rad = {"x": (0.0, math.pi / 2, 0.0), "y": (-math.pi / 2, 0.0, 0.0), "z": (0.0, 0.0, 0.0)}[axis]
    else:
        x_deg, y_deg, z_deg = section.triple("turn_deg", (0.0, 0.0, 0.0))
        turn_rad = (math.radians(x_deg), math.radians(y_deg), math.radians(z_deg))
    w, x, y, z = wxyz_from_matrix(matrix_from_euler(np.array(turn_rad), "xyz", intrinsic=False))
    return float(w), float(x), float(y), float(z)


def _mesh_file(section: TomlTable, data_dir: Path) -> Path:
    path: Path = data_dir / section.text("file")
    if not is_file(path):
        raise section.error("the mesh file does not exist", "file", str(path), "check the path")
    return path
