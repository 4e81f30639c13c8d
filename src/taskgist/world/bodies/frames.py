"""Frames of a body that a profile names: eye, shoulders, palms.

A frame is a site of the model, or one of its bodies, maybe moved and turned: URDF knows links only, and cameras' links
look along z. A frame on a body becomes a site when the agent is assembled.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import mujoco
import numpy as np

from taskgist.common.toml import UNREADABLE, Attempts, TomlTable
from taskgist.world.geometry.transforms import IDENTITY_WXYZ, multiply

OPTICAL_WXYZ = (0.5, 0.5, -0.5, 0.5)
"""The frame that looks along x with z up, in a camera's optical frame: z forward, x to the right, y down (REP 103)."""
SITE_GROUP, SITE_M = 4, 0.01
"""Group and radius of the sites that are added: never seen."""
FIELDS = ("offset_m", "rpy_deg", "optical")


@dataclass(frozen=True)
class Frame:
    """A frame fixed to a body.

    Attributes:
        name: Site or body of the model.
        offset_m: Where the frame is, in that body, metres.
        wxyz: How it is turned there.
    """

    name: str
    offset_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    wxyz: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)

    @property
    def is_plain(self) -> bool:
        """Whether the frame is the named one, neither moved nor turned."""
        return self == Frame(self.name)


def read_frame(table: TomlTable, key: str, attempt: Attempts) -> Frame:
    """A frame that a field of a profile gives.

    The field is the name of a site or body, or a table ``{ frame = "camera_link", offset_m = [0, 0, 0.1],
    rpy_deg = [0, 0, 90], optical = true }``: roll, pitch and yaw as in URDF.
    """
    if not isinstance(table.values.get(key), dict):
        return Frame(attempt(lambda: table.text(key), UNREADABLE))
    inner = table.table(key)
    attempt(lambda: inner.only({"frame", *FIELDS}), inner)
    return frame_from(inner, "frame", attempt)


def frame_from(table: TomlTable, key: str, attempt: Attempts) -> Frame:
    """A frame whose name stands under ``key``, with its offset and turn beside it in the same table."""
    zero = (0.0, 0.0, 0.0)
    name = attempt(lambda: table.text(key), UNREADABLE)
    offset_m = attempt(lambda: table.triple("offset_m", zero), zero)
    wxyz = _wxyz_from_rpy(attempt(lambda: table.triple("rpy_deg", zero), zero))
    if attempt(lambda: table.flag("optical", False), False):
        wxyz = multiply(wxyz, OPTICAL_WXYZ)
    w, x, y, z = (float(value) for value in wxyz)
    return Frame(name, offset_m, (w, x, y, z))


def _wxyz_from_rpy(rpy_deg: tuple[float, float, float]) -> np.ndarray:
    """URDF's fixed-axis roll, pitch, yaw: about x first, z last."""
    wxyz: np.ndarray = IDENTITY_WXYZ
    for axis, angle in enumerate(rpy_deg):
        half = math.radians(angle) / 2
        turn = np.array([math.cos(half), 0.0, 0.0, 0.0])
        turn[1 + axis] = math.sin(half)
        wxyz = multiply(turn, wxyz)
    return wxyz


def add_frame(spec: mujoco.MjSpec, frame: Frame, label: str) -> None:
    """Make a frame a site of the model, called ``label``; nothing to do where the frame is a site itself."""
    if spec.site(frame.name) is not None:
        return
    size = [SITE_M] * 3
    spec.body(frame.name).add_site(name=label, pos=frame.offset_m, quat=frame.wxyz, group=SITE_GROUP, size=size)
