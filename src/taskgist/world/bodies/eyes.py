"""Frames of a body that a profile names, and the eye that looks from one of them.

An eye is a frame of the model, or a camera of an MJCF: then the model says where it looks, and how far to the sides.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from taskgist.common.toml import UNREADABLE, Attempts, TomlTable
from taskgist.errors import SceneError
from taskgist.settings import DEFAULT, Limits
from taskgist.world.geometry.transforms import IDENTITY_WXYZ, multiply

# --- Frames of a body that a profile names: eye, shoulders, palms.
#
# A frame is a site of the model, or one of its bodies, maybe moved and turned: URDF knows links only, and cameras'
# links look along z. A frame on a body becomes a site when the agent is assembled.

OPTICAL_WXYZ = (0.5, 0.5, -0.5, 0.5)
"""The frame that looks along x with z up, in a camera's optical frame: z forward, x to the right, y down (REP 103)."""
CAMERA_WXYZ = (0.5, -0.5, 0.5, 0.5)
"""The same in the frame of a camera of MJCF, which looks along −z with y up and x to the right."""
SITE_GROUP, SITE_M = 4, 0.01
"""Group and radius of the sites that are added: never seen."""
FRAME_FIELDS = ("offset_m", "rpy_deg", "optical")


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
    attempt(lambda: inner.only({"frame", *FRAME_FIELDS}), inner)
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


@dataclass(frozen=True)
class Eye:
    """A pinhole eye: a frame that looks along its x axis, z up.

    Attributes:
        exclude: The body that the eye sits in, which hides nothing from it.
        housing: More bodies around the eye, such as a camera's case; nobody sees them.
        turn_rad: How far the eye turns in the head; None: as people's eyes do (setting ``gaze.range_rad``).
        camera: The camera of the model that the eye is; what it leaves to the camera is ``UNREADABLE`` or zero until
            ``from_camera`` fills it in. None for a frame.
        sees: False for a body that has no eye: what it sees is unknown. The frame is then only where it is.
    """

    frame: Frame
    exclude: str
    housing: tuple[str, ...]
    fov_rad: tuple[float, float]
    image_px: tuple[int, int]
    gaze_cone_rad: float
    turn_rad: float | None = 0.0
    camera: str | None = None
    sees: bool = True


# --- Reading the ``[eye]`` table.


UNREAD_EYE = Eye(Frame(UNREADABLE), UNREADABLE, (), (1.0, 1.0), (1, 1), 1.0)
"""Stands in for an eye that could not be read."""
NO_EYE = replace(UNREAD_EYE, sees=False)
"""The eye of a body that has none."""
OPEN_RAD, OPEN_PX = (0.0, 0.0), (0, 0)
"""Field of view and image that are left to the camera."""
VIEW_FIELDS = ("exclude", "fov_deg", "image_px", "gaze_cone_deg", "turn_deg")


def read_eye(table: TomlTable, attempt: Attempts, limits: Limits = DEFAULT.limits) -> Eye:
    """The ``[eye]`` table; the limits are those of its image."""
    camera = attempt(lambda: table.text("camera"), UNREADABLE) if "camera" in table else None
    if camera is not None:
        attempt(lambda: _only_camera(table), table)
        frame = Frame(UNREADABLE)
    else:
        name = "site" if "site" in table else "frame"
        attempt(lambda: table.only({name, "camera", *FRAME_FIELDS, *VIEW_FIELDS}), table)
        frame = frame_from(table, name, attempt)
    left = {field for field in ("fov_deg", "image_px", "exclude") if camera is not None and field not in table}
    fov_rad = OPEN_RAD if "fov_deg" in left else attempt(lambda: _fov_rad(table), (1.0, 1.0))
    unread: tuple[str, ...] = (UNREADABLE,)
    exclude = unread if "exclude" in left else attempt(lambda: _excluded(table), unread)
    return Eye(
        frame=frame,
        exclude=exclude[0],
        housing=exclude[1:],
        fov_rad=fov_rad,
        image_px=OPEN_PX if "image_px" in left else attempt(lambda: _image_px(table, limits), (1, 1)),
        gaze_cone_rad=attempt(lambda: _gaze_cone_rad(table, fov_rad), 1.0),
        turn_rad=attempt(lambda: _turn_rad(table), None),
        camera=camera,
    )


def _only_camera(table: TomlTable) -> TomlTable:
    """Refuse a frame beside a camera."""
    for field in ("frame", "site", *FRAME_FIELDS):
        if field in table:
            hint = "a camera is taken as it stands in the model: name it alone, or the frame alone"
            raise table.error("an eye is a camera, or a frame", field, table.values[field], hint)
    return table.only({"camera", *VIEW_FIELDS})


def _fov_rad(table: TomlTable) -> tuple[float, float]:
    fov = table.pair("fov_deg")
    if not all(0 < angle < 180 for angle in fov):
        raise table.error("a pinhole sees between 0 and 180 degrees", "fov_deg", fov, "as [120, 105]")
    return math.radians(fov[0]), math.radians(fov[1])


def _image_px(table: TomlTable, limits: Limits) -> tuple[int, int]:
    pixels = table.pair("image_px")
    if not all(value >= 1 and value == int(value) for value in pixels):
        raise table.error("an image needs at least one pixel each way", "image_px", pixels, "as [320, 240]")
    if pixels[0] * pixels[1] > limits.image_pixels:
        hint = f"at most {limits.image_pixels:,} pixels are cast (setting limits.image_pixels): give fewer each way"
        raise table.error("an image too large", "image_px", pixels, hint)
    return int(pixels[0]), int(pixels[1])


def _excluded(table: TomlTable) -> tuple[str, ...]:
    """The body that the eye sits in, and more of them around it."""
    names = table.texts("exclude") if isinstance(table.values.get("exclude"), list) else (table.text("exclude"),)
    if not names:
        raise table.error("an eye sits in a body", "exclude", [], 'as "head"')
    return names


def _gaze_cone_rad(table: TomlTable, fov_rad: tuple[float, float]) -> float:
    """Half-angle of the gaze cone; where none is given, the one that holds the whole image."""
    if "gaze_cone_deg" not in table:
        return whole_image_rad(fov_rad)
    cone = table.number("gaze_cone_deg")
    if not 0 < cone <= 180:
        raise table.error("a gaze cone is a half-angle between 0 and 180 degrees", "gaze_cone_deg", cone, "as 30")
    return math.radians(cone)


def _turn_rad(table: TomlTable) -> float | None:
    """How far the eye turns in the head; unless it is said, who attends to a cone has eyes, and others have cameras."""
    if "turn_deg" not in table:
        return None if "gaze_cone_deg" in table else 0.0
    turn = table.number("turn_deg")
    if not 0 <= turn < 90:
        raise table.error("eyes turn by less than 90 degrees", "turn_deg", turn, "as 35, or 0 for a camera")
    return math.radians(turn)


def whole_image_rad(fov_rad: tuple[float, float]) -> float:
    """Half-angle of the cone that holds a whole image."""
    return math.atan(math.hypot(*(math.tan(angle / 2) for angle in fov_rad)))


# --- What the model says of a camera.


def from_camera(eye: Eye, model: mujoco.MjModel, where: str) -> Eye:
    """The eye with all that its profile leaves to the camera.

    A camera is named with the body that carries it. Its height of view is its ``fovy``; the width follows from that
    and from the shape of its image: ``tan(width / 2) = aspect * tan(height / 2)``.

    Args:
        eye: As the profile has it.
        model: The body alone, compiled.
        where: The profile's file, for messages.

    Raises:
        SceneError: The camera is not fixed to the body, is no pinhole, or has no resolution and the profile gives none.
    """
    camera = model.camera(eye.camera)
    index, body = int(camera.id), str(model.body(int(camera.bodyid[0])).name)
    if int(model.cam_mode[index]) != int(mujoco.mjtCamLight.mjCAMLIGHT_FIXED) or not int(camera.bodyid[0]):
        hint = 'name one with mode="fixed" in a body of the robot, or a frame'
        raise SceneError("a camera that is not fixed to the body", **_at(eye, where), hint=hint)
    if int(model.cam_projection[index]) != int(mujoco.mjtProjection.mjPROJ_PERSPECTIVE):
        raise SceneError("an eye is a pinhole, this camera is not", **_at(eye, where), hint="name another, or a frame")
    image_px = eye.image_px
    if image_px == OPEN_PX:
        image_px = (int(model.cam_resolution[index][0]), int(model.cam_resolution[index][1]))
        if image_px == NO_RESOLUTION:
            hint = "give [eye] image_px = [320, 240], or resolution in the model"
            raise SceneError("the camera says nothing of its image", **_at(eye, where), hint=hint)
    fov_rad = eye.fov_rad if eye.fov_rad != OPEN_RAD else _camera_fov_rad(model, index, image_px)
    w, x, y, z = (float(value) for value in multiply(model.cam_quat[index], CAMERA_WXYZ))
    at_x, at_y, at_z = (float(value) for value in model.cam_pos[index])
    return replace(
        eye,
        frame=Frame(body, (at_x, at_y, at_z), (w, x, y, z)),
        exclude=eye.exclude or body,
        image_px=image_px,
        fov_rad=fov_rad,
        gaze_cone_rad=eye.gaze_cone_rad or whole_image_rad(fov_rad),
    )


NO_RESOLUTION = (1, 1)
"""MuJoCo's own where a camera gives none."""


def _at(eye: Eye, where: str) -> dict[str, str | None]:
    return {"where": where, "field": "eye.camera", "value": eye.camera}


def _camera_fov_rad(model: mujoco.MjModel, camera: int, image_px: tuple[int, int]) -> tuple[float, float]:
    """Width and height of what a camera sees."""
    sensor_m = model.cam_sensorsize[camera]
    if sensor_m.all():  # with a sensor, MuJoCo draws by the focal lengths
        across, up = (sensor_m / (2 * model.cam_intrinsic[camera][:2])).tolist()
    else:
        up = math.tan(math.radians(float(model.cam_fovy[camera])) / 2)
        across = up * image_px[0] / image_px[1]
    return 2 * math.atan(across), 2 * math.atan(up)
