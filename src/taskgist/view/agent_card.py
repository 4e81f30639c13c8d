"""A picture of a body: from the side and from above, with its eye, shoulders, hands, reach and field of view."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Wedge

from taskgist.common.arrays import Array
from taskgist.view.rendering import pinhole, render, save_figure
from taskgist.world.bodies.agent import Agent, ArmIndices
from taskgist.world.geometry.transforms import Pose
from taskgist.world.stage import Stage

FAR_M = 60.0
"""From so far away, a pinhole's picture is as good as a parallel one."""
PIXELS_PER_M = 160
MARGIN_M = 0.15
SIGHT_M = 1.6
"""Length at which the field of view is drawn."""
COLOURS = {"left": "#1f6fb4", "right": "#d2601a"}
VIEW, GAZE = "#3a9a4f", "#1d5c2c"


@dataclass(frozen=True)
class Drawing:
    """One of the two views: the axes of the world that run along the picture's own.

    Attributes:
        title: For people.
        right: World axis to the right.
        up: World axis upwards.
        forward: Where the camera looks, a unit vector.
    """

    title: str
    right: int
    up: int
    forward: tuple[float, float, float]

    def flat(self, point: Array) -> tuple[float, float]:
        """Where a point of the world lies in the picture, metres."""
        return float(point[self.right]), float(point[self.up])

    def angle_deg(self, direction: Array) -> float:
        """Direction of a vector in the picture, counted to the left from its right."""
        return math.degrees(math.atan2(direction[self.up], direction[self.right]))


SIDE = Drawing("from its right", right=0, up=2, forward=(0.0, 1.0, 0.0))
TOP = Drawing("from above", right=0, up=1, forward=(0.0, 0.0, -1.0))


def agent_card(stage: Stage, agent: str, path: Path, *, title: str) -> Path:
    """Save a picture of a body: side and top view, in metres.

    Args:
        stage: The scene in a state.
        agent: The agent; it looks along +x.
        path: The PNG file to write.
        title: Title of the picture.
    """
    body = stage.scene.agent(agent)
    low, high = _extent(stage, body)
    size = high - low
    figure = Figure(figsize=(2.4 + 3.2 * size[0], 2.2 + 1.6 * max(size[1], size[2])), layout="constrained")
    figure.suptitle(title, fontsize=13)
    for axes, drawing in zip(figure.subplots(1, 2), (SIDE, TOP), strict=True):
        _draw_body(axes, stage, body, drawing, low, high)
        _draw_sight(axes, stage, body, drawing)
        for arm in body.arms:
            _draw_arm(axes, stage, arm, drawing)
        axes.set_title(drawing.title, fontsize=11)
        axes.set_xlabel("metres")
    figure.legend(handles=list(_legend(body)), loc="outside lower center", ncols=4, fontsize=9, frameon=False)
    return save_figure(figure, path)


def _extent(stage: Stage, body: Agent) -> tuple[Array, Array]:
    """Opposite corners, metres, of what is drawn: the body, and as far as it reaches."""
    centers, radii = stage.geom_centers(body.geoms), stage.scene.model.geom_rbound[body.geoms]
    corners = [centers - radii[:, None], centers + radii[:, None]]
    for arm in body.arms:
        shoulder = stage.shoulder(arm).position
        corners += [(shoulder - arm.profile.length_m)[None], (shoulder + arm.profile.length_m)[None]]
    eye = stage.eye(body)
    if body.profile.eye.sees:
        corners.append((eye.position + SIGHT_M * eye.matrix[:, 0])[None])
    points = np.concatenate(corners)
    low, high = points.min(axis=0) - MARGIN_M, points.max(axis=0) + MARGIN_M
    low[2] = -MARGIN_M
    return low, high


def _draw_body(axes: Axes, stage: Stage, body: Agent, drawing: Drawing, low: Array, high: Array) -> None:
    right, up = drawing.right, drawing.up
    width, height = high[right] - low[right], high[up] - low[up]
    middle = (low + high) / 2
    forward = np.array(drawing.forward)
    upwards = np.eye(3)[up]
    camera = Pose(middle - FAR_M * forward, np.stack((forward, np.cross(upwards, forward), upwards), axis=1))
    fov = (2 * math.atan(width / 2 / FAR_M), 2 * math.atan(height / 2 / FAR_M))
    rays = pinhole(fov, round(PIXELS_PER_M * width), round(PIXELS_PER_M * height))
    image = render(stage, camera, rays)
    shown = np.isin(image.geoms, body.geoms)
    axes.imshow(
        np.dstack((np.clip(image.rgb, 0, 1), shown)),
        extent=(low[right], high[right], low[up], high[up]),
        zorder=2,
        interpolation="bilinear",
    )
    if up == SIDE.up:
        axes.axhline(0.0, color="0.4", linewidth=1, zorder=1)
    axes.grid(color="0.9", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.set_aspect("equal")


def _draw_sight(axes: Axes, stage: Stage, body: Agent, drawing: Drawing) -> None:
    """Field of view and gaze cone about where the eye looks now; nothing for a body without one."""
    if not body.profile.eye.sees:
        return
    eye, profile = stage.eye(body), body.profile.eye
    place, ahead = drawing.flat(eye.position), drawing.angle_deg(eye.matrix[:, 0])
    half = math.degrees(profile.fov_rad[0 if drawing is TOP else 1]) / 2
    axes.add_patch(Wedge(place, SIGHT_M, ahead - half, ahead + half, color=VIEW, alpha=0.13, linewidth=0, zorder=1))
    cone = math.degrees(profile.gaze_cone_rad)
    if cone < half:
        _outline(axes, place, SIGHT_M, ahead - cone, ahead + cone, GAZE)
    axes.plot(*place, marker="o", markersize=6, color=VIEW, markeredgecolor="white", zorder=6)


def _draw_arm(axes: Axes, stage: Stage, arm: ArmIndices, drawing: Drawing) -> None:
    """The sector that the arm reaches, through the shoulder: level from above, straight ahead from the side."""
    shoulder, profile = stage.shoulder(arm), arm.profile
    colour, place = COLOURS[profile.side], drawing.flat(shoulder.position)
    ahead = drawing.angle_deg(shoulder.matrix[:, 0])
    low, high = (math.degrees(angle) for angle in (profile.azimuth_rad if drawing is TOP else profile.elevation_rad))
    if drawing is TOP and profile.side == "right":
        low, high = -high, -low
    wedge = Wedge(place, profile.length_m, ahead + low, ahead + high, color=colour, alpha=0.10, linewidth=0, zorder=1)
    axes.add_patch(wedge)
    _outline(axes, place, profile.length_m, ahead + low, ahead + high, colour, style="-")
    axes.plot(*place, marker="s", markersize=6, color=colour, markeredgecolor="white", zorder=5)
    palm = drawing.flat(stage.site(arm.palm_site).position)
    axes.plot(*palm, marker="D", markersize=6, color=colour, markeredgecolor="white", zorder=5)


def _outline(
    axes: Axes, place: tuple[float, float], radius: float, low: float, high: float, colour: str, style: str = "--"
) -> None:
    outline = Wedge(place, radius, low, high, fill=False, edgecolor=colour, linestyle=style, linewidth=1, zorder=3)
    axes.add_patch(outline)


def _legend(body: Agent) -> Iterator[Line2D | Patch]:
    eye = body.profile.eye
    fov = " × ".join(f"{math.degrees(angle):.0f}°" for angle in eye.fov_rad)
    if eye.sees:
        yield Line2D([], [], marker="o", color=VIEW, linestyle="", label="eye")
        yield Patch(color=VIEW, alpha=0.25, label=f"field of view {fov}")
    if eye.sees and eye.gaze_cone_rad < max(eye.fov_rad) / 2:
        yield Line2D([], [], color=GAZE, linestyle="--", label=f"gaze cone {math.degrees(eye.gaze_cone_rad):.0f}°")
    for arm in body.arms:
        colour, side = COLOURS[arm.profile.side], arm.profile.side
        yield Line2D([], [], marker="s", color=colour, linestyle="", label=f"{side} shoulder")
        yield Line2D([], [], marker="D", color=colour, linestyle="", label=f"{side} palm")
        yield Patch(color=colour, alpha=0.25, label=f"{side} reach {arm.profile.length_m:.2f} m")
