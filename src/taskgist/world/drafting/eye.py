"""The eye of a drafted profile: which camera or frame it is, how it looks, how wide, and what is around its lens."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Collection, Sequence
from typing import Any

import mujoco
import numpy as np

from taskgist.common.arrays import Array
from taskgist.world.bodies.eyes import NO_RESOLUTION, OPTICAL_WXYZ
from taskgist.world.drafting.anatomy import Anatomy, FoundEye, Tree
from taskgist.world.drafting.lines import Lines, listed, rpy_of
from taskgist.world.geometry.transforms import matrix_from_wxyz

Sensor = tuple[str, float, tuple[int, int]]
"""A camera that a URDF describes for Gazebo: its link, its width of view in radians, its pixels."""
USUAL_PX = (320, 240)
"""The image that the built-in bodies have."""
ROUGHLY = 0.5
"""Cosine of 60°: a frame looks ahead, for heads that rest bent."""
DEVICES = (
    (re.compile(r"xtion"), (58, 45), "Asus Xtion's data sheet"),
    (re.compile(r"kinect"), (57, 43), "Microsoft Kinect's data sheet"),
    (re.compile(r"astra|orbbec"), (60, 49.5), "Orbbec Astra's data sheet"),
    (re.compile(r"d435"), (69, 42), "Intel RealSense D435's data sheet"),
)
"""Fields of view of cameras that links are called after, degrees."""
HOUSING_M, HOUSING_SHARE = 0.15, 0.10
"""How near a body hides the view that is the eye's own housing, and from which share of it on (ours)."""
RAYS = (24, 18)
"""Rays across and down with which that is looked at."""


def eye_lines(lines: Lines, found: Anatomy, sensors: Sequence[Sensor]) -> None:
    """The ``[eye]`` table, or why there is none.

    Args:
        lines: The profile.
        found: What the model consists of.
        sensors: Cameras that a URDF describes for Gazebo: link, width of view in radians, pixels.
    """
    tree = found.tree
    others = [f"{eye.name} (camera)" if eye.camera else eye.name for eye in found.eyes[1:]]
    if not found.eyes:
        aside = f"; none of its own: {listed([f'{name} ({why})' for name, why in found.aside])}" if found.aside else ""
        lines.text.append("")
        lines.note(f"no [eye]: no camera, optical frame, eye or head in the model{aside}.")
        lines.note('What it sees is unknown then. For an eye: [eye] frame = "...", exclude = "...", fov_deg, image_px')
        return
    eye = found.eyes[0]
    lines.table("[eye]", f"others that may be it: {listed(others)}" if others else "")
    if eye.camera:
        _camera_lines(lines, tree, eye)
        return
    frame, looks = _frame_of(tree, eye)
    for key, (value, why) in frame.items():
        lines.say(key, value, why)
    exclude = [_nearest_with_shape(tree, eye.body)]
    fov, pixels, why = _view(found, eye, sensors)
    exclude += _housing(tree, tree.data.xpos[eye.body], looks, exclude, fov or (60.0, 47.0))
    lines.say("exclude", exclude if len(exclude) > 1 else exclude[0], "what the eye sits in hides nothing from it")
    if fov is None:
        lines.ask(
            "eye.fov_deg", [60, 47], "the model does not say how wide it sees: width and height, from its data sheet"
        )
    else:
        lines.say("fov_deg", fov, why)
    lines.say("image_px", pixels, why if fov is not None and pixels != USUAL_PX else "as the built-in bodies have")


def _camera_lines(lines: Lines, tree: Tree, eye: FoundEye) -> None:
    model = tree.model
    camera = int(model.camera(eye.name).id)
    lines.say("camera", eye.name, f"a camera of the model, in the body {tree.name(eye.body)!r}")
    pixels = (int(model.cam_resolution[camera][0]), int(model.cam_resolution[camera][1]))
    if pixels == NO_RESOLUTION:
        pixels = USUAL_PX
        fovy = float(model.cam_fovy[camera])
        why = f"the camera gives no resolution: the built-in bodies' image; its fovy is {fovy:g} degrees"
        lines.say("image_px", pixels, why)
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.cam_quat[camera])
    body = tree.data.xmat[eye.body].reshape(3, 3)
    turned = body @ turn.reshape(3, 3)
    looks = np.stack((-turned[:, 2], -turned[:, 0], turned[:, 1]), axis=1)
    place = tree.data.xpos[eye.body] + body @ model.cam_pos[camera]
    up = float(model.cam_fovy[camera])
    across = 2 * math.degrees(math.atan(math.tan(math.radians(up) / 2) * pixels[0] / pixels[1]))
    housing = _housing(tree, place, looks, [tree.name(eye.body)], (across, up))
    if housing:
        lines.say("exclude", [tree.name(eye.body), *housing], "its own body and what is close around the lens")


def _frame_of(tree: Tree, eye: FoundEye) -> tuple[dict[str, tuple[Any, str]], Array]:
    """The fields that name the eye's frame, and how it looks: x ahead, z up, as columns (3, 3)."""
    turn = tree.data.xmat[eye.body].reshape(3, 3)
    optical = turn @ matrix_from_wxyz(OPTICAL_WXYZ)
    kind = WHAT.get(eye.rank, "a link that is called as a camera")
    if _ahead(turn):
        return {"frame": (eye.name, f"{kind}; it looks ahead along its x")}, turn
    if _ahead(optical):
        return {
            "frame": (eye.name, kind),
            "optical": (True, "its z looks ahead and its y down, as cameras' frames do"),
        }, optical
    rpy = [round(math.degrees(angle), 1) for angle in rpy_of(turn.T)]
    return {
        "frame": (eye.name, kind),
        "rpy_deg": (rpy, "its axes do not look ahead: turned so that it does, as the body rests; look at the picture"),
    }, np.eye(3)


WHAT = {
    1: "a colour camera's optical frame",
    2: "the left camera's optical frame",
    3: "an optical frame",
    5: "a link that is called an eye",
    6: "no camera is there: the head, by its name",
}


def _ahead(turn: Array) -> bool:
    return bool(turn[0, 0] >= ROUGHLY and turn[2, 2] >= ROUGHLY)


def _nearest_with_shape(tree: Tree, body: int) -> str:
    """The body itself, or what carries it without a joint and has a shape."""
    at = body
    while not tree.model.body_geomnum[at] and at not in tree.links:
        at = int(tree.model.body_parentid[at])
    return tree.name(at if tree.model.body_geomnum[at] else body)


def _view(
    found: Anatomy, eye: FoundEye, sensors: Sequence[Sensor]
) -> tuple[tuple[float, float] | None, tuple[int, int], str]:
    """Field of view in degrees, None if nothing tells it; pixels; and why."""
    tree = found.tree
    named = {tree.name(body): body for body in range(1, tree.model.nbody)}
    link = tree.link_of(eye.body)
    near = [
        (float(np.linalg.norm(tree.data.xpos[named[name]] - tree.data.xpos[eye.body])), name, across, pixels)
        for name, across, pixels in sensors
        if name in named and tree.link_of(named[name]) == link
    ]
    if near:
        _, name, across, (width, height) = min(near)
        up = 2 * math.atan(math.tan(across / 2) * height / width)
        shown = (USUAL_PX[0], max(1, round(USUAL_PX[0] * height / width)))
        fov = (round(math.degrees(across), 1), round(math.degrees(up), 1))
        return fov, shown, f"URDF: the sensor of {name!r}, {fov[0]:g} across {width} x {height} pixels"
    names = tree.names_to(eye.body)
    for pattern, device, why in DEVICES:
        if pattern.search(names):
            return device, USUAL_PX, f"{why}; hold it against your own"
    return None, USUAL_PX, ""


def _housing(tree: Tree, place: Array, looks: Array, exclude: Sequence[str], fov_deg: tuple[float, float]) -> list[str]:
    """Names of bodies of the eye's own link that are so close before it that they must be around the lens."""
    link = tree.link_of(int(tree.model.body(exclude[0]).id))
    found: list[str] = []
    for _ in range(3):
        hits = _close_hits(tree, place, looks, {*exclude, *found}, fov_deg)
        more = [body for body, share in hits.items() if share > HOUSING_SHARE and tree.link_of(body) == link]
        if not more:
            break
        found += [tree.name(body) for body in more]
    return found


def _close_hits(
    tree: Tree, place: Array, looks: Array, but: Collection[str], fov_deg: tuple[float, float]
) -> dict[int, float]:
    """Bodies that hide a share of a view from close by."""
    model = tree.model
    hidden = [geom for geom in range(model.ngeom) if tree.name(int(model.geom_bodyid[geom])) not in but]
    groups = np.array([1, 1, 1, 0, 0, 0], dtype=np.uint8)
    across, up = (math.tan(math.radians(angle) / 2) for angle in fov_deg)
    counts: dict[int, int] = {}
    shown = model.geom_group.copy()
    model.geom_group[np.setdiff1d(np.arange(model.ngeom), hidden)] = 5
    for column, row in itertools.product(range(RAYS[0]), range(RAYS[1])):
        y = across * (1 - 2 * (column + 0.5) / RAYS[0])
        z = up * (1 - 2 * (row + 0.5) / RAYS[1])
        geom = np.zeros(1, np.int32)
        away = mujoco.mj_ray(model, tree.data, place, looks @ (1.0, y, z), groups, True, -1, geom)
        if 0.0 <= away * math.sqrt(1 + y * y + z * z) < HOUSING_M:
            body = int(model.geom_bodyid[int(geom[0])])
            counts[body] = counts.get(body, 0) + 1
    model.geom_group[:] = shown
    return {body: count / (RAYS[0] * RAYS[1]) for body, count in counts.items()}
