"""Scenes from outside: a camera that shows all people and things of a demonstration, with everybody's name."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from taskgist.recording import Label
from taskgist.view.rendering import looking, pinhole, render
from taskgist.world import Pose, Stage, State

Array = NDArray[np.float64]
FOV_RAD = (math.radians(40), math.radians(28))
STEEPNESS = 0.42
"""How far the camera looks down: the tangent of the angle."""
ASIDE = 0.30
"""How far it looks along the line from one person to the other, relative to across it."""
MARGIN = 1.08
SMOOTHING = 2
"""Rays in each direction for one pixel."""
ABOVE_EYE_M = 0.17
"""Height of names above the eyes."""
SOLID = 0.6
"""How much of the ball around a part of a body the part fills, about."""
NAME_M = np.array([0.0, 0.0, 0.32])
"""What the picture must hold above the eyes: head and name."""


@dataclass(frozen=True, eq=False)
class Camera:
    """A camera outside.

    Attributes:
        pose: Looks along its x axis.
        width_px: Width of its pictures.
        height_px: Their height.
    """

    pose: Pose
    width_px: int
    height_px: int

    def pixel(self, point: Array) -> tuple[float, float]:
        """Column and row of a point of the world, metres, (3,)."""
        ahead, left, up = self.pose.matrix.T @ (point - self.pose.position)
        across = (1 - left / ahead / math.tan(FOV_RAD[0] / 2)) / 2
        down = (1 - up / ahead / math.tan(FOV_RAD[1] / 2)) / 2
        return float(across * self.width_px), float(down * self.height_px)


def camera_outside(stage: Stage, states: Sequence[State], target: str, *, width_px: int = 480) -> Camera:
    """The camera that shows most of the target object, of the four that look across the people's line.

    Args:
        stage: The scene; shows the last state afterwards.
        states: What the picture must hold.
        target: The target object.
        width_px: Width of the pictures.
    """
    height_px = round(width_px * math.tan(FOV_RAD[1] / 2) / math.tan(FOV_RAD[0] / 2))
    cameras = [Camera(pose, width_px, height_px) for pose in _poses(stage, states)]
    return max(cameras, key=lambda camera: _least_seen(stage, states, target, camera))


def draw_outside(axes: Axes, stage: Stage, camera: Camera, label: Label, title: str) -> None:
    """Draw the state that the stage shows, the target object in the colour of attention.

    Args:
        axes: Where to draw.
        stage: The scene in a state.
        camera: From where.
        label: Who performs, for whom, with what.
        title: Title of the picture.
    """
    axes.imshow(_smooth_picture(stage, camera, label.target_object))
    axes.set_title(title, fontsize=9)
    axes.set_axis_off()
    roles = {label.performing_agent: "performer", label.target_agent: "target agent"}
    for name in stage.scene.agents:
        head = stage.eye(stage.scene.agent(name)).position + (0.0, 0.0, ABOVE_EYE_M)
        column, row = camera.pixel(head)
        text = f"{name}, {roles[name]}" if name in roles else name
        axes.text(column, row, text, fontsize=7.5, ha="center", va="bottom")


def _poses(stage: Stage, states: Sequence[State]) -> list[Pose]:
    """From both sides of the line between the people, each from a bit to the left and to the right."""
    points, middle, along = _surroundings(stage, states)
    poses = []
    for side in (1.0, -1.0):
        for aside in (ASIDE, -ASIDE):
            away = np.array([along[1] * side, -along[0] * side, 0.0]) + aside * along
            away = away / np.linalg.norm(away) + (0.0, 0.0, STEEPNESS)
            away /= np.linalg.norm(away)
            poses.append(looking(middle + _distance_m(points - middle, away) * away, middle))
    return poses


def _surroundings(stage: Stage, states: Sequence[State]) -> tuple[Array, Array, Array]:
    """Points that the picture must hold, (n, 3); their middle; and the direction from the first person to the last."""
    clouds, people = [], []
    for state in states:
        stage.show(state)
        for name in stage.scene.agents:
            geoms = stage.scene.agent(name).geoms
            centers, radii = stage.geom_centers(geoms), SOLID * stage.scene.model.geom_rbound[geoms][:, None]
            clouds += [centers - radii, centers + radii]
            people.append(stage.eye(stage.scene.agent(name)).position)
            clouds.append((people[-1] + NAME_M)[None])
        clouds.append(np.array([state.qpos[stage.scene.object_slice(name)][:3] for name in stage.scene.objects]))
    points = np.concatenate(clouds)
    line = people[len(stage.scene.agents) - 1] - people[0]
    line[2] = 0.0
    length = float(np.linalg.norm(line))
    along = line / length if length > 0.0 else np.array([1.0, 0.0, 0.0])
    return points, (points.min(axis=0) + points.max(axis=0)) / 2, along


def _distance_m(offsets: Array, away: Array) -> float:
    """How far away the camera must be for all points around the middle to be in its picture."""
    matrix = looking(away, np.zeros(3)).matrix
    ahead, left, up = (offsets @ matrix).T
    needed = [
        MARGIN * np.abs(offset) / math.tan(fov / 2) - ahead for offset, fov in zip((left, up), FOV_RAD, strict=True)
    ]
    return float(np.max(needed))


def _least_seen(stage: Stage, states: Sequence[State], target: str, camera: Camera) -> int:
    """Pixels of the target object in the state in which fewest are seen, in a small picture."""
    rays = pinhole(FOV_RAD, camera.width_px // 2, camera.height_px // 2)
    marked = stage.scene.object_geoms(target)
    counts = []
    for state in states:
        stage.show(state)
        counts.append(int(np.isin(render(stage, camera.pose, rays).geoms, marked).sum()))
    return min(counts)


def _smooth_picture(stage: Stage, camera: Camera, target: str) -> Array:
    width, height = camera.width_px, camera.height_px
    rays = pinhole(FOV_RAD, SMOOTHING * width, SMOOTHING * height)
    marked = [int(geom) for geom in stage.scene.object_geoms(target)]
    rgb = np.clip(render(stage, camera.pose, rays, highlight=marked).rgb, 0, 1)
    return np.asarray(rgb.reshape(height, SMOOTHING, width, SMOOTHING, 3).mean(axis=(1, 3)))
