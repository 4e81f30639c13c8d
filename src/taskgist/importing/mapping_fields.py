"""Fields that several tables of a mapping have: names of columns, units, axes and frames."""

from __future__ import annotations

import math

import numpy as np

from taskgist.common.toml import TomlTable, is_finite_number
from taskgist.importing.mapping import Columns, Frame, Name, Vector
from taskgist.world.geometry.transforms import about_z, matrix_from_wxyz

# --- Names of columns, as a mapping gives them: a list, a template over the axes, or a block per point.


def read_columns(section: TomlTable, key: str, letters: str, default: object = None) -> Columns:
    """As many columns as there are letters; ``{axis}`` in a template stands for each letter in turn."""
    value = section.any(key) if default is None else section.any(key, default)
    if isinstance(value, dict):
        return _block(section.table(key), len(letters))
    if isinstance(value, str):
        if "{axis}" not in value and "{AXIS}" not in value:
            hint = f'write it as "{{point}}_{{axis}}", or list the {len(letters)} columns'
            raise section.error("one text must hold {axis}", key, value, hint)
        value = [value.replace("{axis}", letter).replace("{AXIS}", letter.upper()) for letter in letters]
    good = isinstance(value, list) and len(value) == len(letters) and all(map(is_column, value))
    if not good:
        hint = "names, or indices from 0"
        raise section.error(f"must list {len(letters)} columns", key, value, hint)
    return Columns(tuple(value))


def _block(section: TomlTable, count: int) -> Columns:
    first = section.integer("first")
    step = section.integer("step", 0)
    section.done()
    return Columns(tuple(range(first, first + count)), step)


def read_column(section: TomlTable, key: str) -> Name:
    """One column, by name or index."""
    value = section.any(key)
    if not is_column(value):
        raise section.error("must be a column's name, or its index from 0", key, value)
    name: Name = value
    return name


def is_column(value: object) -> bool:
    """Whether a TOML value can name a column."""
    return (isinstance(value, str) and value != "") or (
        isinstance(value, int) and not isinstance(value, bool) and value >= 0
    )


# --- Axes and frames: from the source's axes and units to those of the room.

UNITS_M = {"m": 1.0, "cm": 0.01, "mm": 0.001, "inch": 0.0254}

_AXES = {f"{sign}{axis}": (axis, -1.0 if sign == "-" else 1.0) for sign in ("", "+", "-") for axis in "xyz"}


def local_axis(section: TomlTable, key: str) -> Vector:
    """A local axis such as "-y", or any direction as three numbers, as a unit vector."""
    value = section.any(key)
    if isinstance(value, str):
        if value not in _AXES:
            raise section.error("is no axis", key, value, 'give one of "x", "-x", "y", "-y", "z", "-z"')
        return _axis(value)
    vector = np.array(section.triple(key))
    if not vector.any():
        raise section.error("has no direction", key, value, 'give an axis such as "-y", or three numbers')
    return _vector(vector / np.linalg.norm(vector))


def read_frame(section: TomlTable) -> Frame:
    """Units, axes and transform of a source."""
    scale_m = _scale_m(section)
    axes = section.table("axes")
    chosen = [axes.choice(ours, _AXES, ours) for ours in "xyz"]
    axes.done()
    if len({_AXES[axis][0] for axis in chosen}) < 3:
        hint = 'each of the source\'s axes once, as { x = "-z", y = "-x", z = "y" }'
        raise section.error("uses one of the source's axes twice", "axes", axes.values, hint)
    place = section.table("transform")
    position_m = place.triple("position_m", (0.0, 0.0, 0.0))
    turn = _turn(place)
    place.done()
    return Frame(scale_m, (_axis(chosen[0]), _axis(chosen[1]), _axis(chosen[2])), turn, position_m)


def _scale_m(section: TomlTable) -> float:
    """Metres per unit: of a unit by name, or as a number, for files whose unit has none."""
    if is_finite_number(section.any("units")):
        return float(section.number("units", least=1e-6, most=1e3))
    return UNITS_M[section.choice("units", UNITS_M)]


def _turn(section: TomlTable) -> tuple[Vector, Vector, Vector]:
    if "wxyz" in section:
        wxyz = np.array(section.quadruple("wxyz"))
        if abs(np.linalg.norm(wxyz) - 1.0) > 0.01:
            raise section.error("is no unit quaternion", "wxyz", section.values["wxyz"])
        if "yaw_deg" in section:
            raise section.error("wxyz and yaw_deg exclude each other", "yaw_deg", section.values["yaw_deg"])
        wxyz = wxyz / np.linalg.norm(wxyz)
    else:
        wxyz = about_z(math.radians(section.number("yaw_deg", 0.0)))
    rows = matrix_from_wxyz(wxyz)
    return _vector(rows[0]), _vector(rows[1]), _vector(rows[2])


def _axis(name: str) -> Vector:
    axis, sign = _AXES[name]
    return _vector(sign * np.eye(3)["xyz".index(axis)])


def _vector(array: np.ndarray) -> Vector:
    x, y, z = (float(value) for value in array)
    return x, y, z
