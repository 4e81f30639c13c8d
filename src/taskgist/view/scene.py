"""Pictures of a scene: what an agent sees, and the room from outside with everybody's name; the target is marked."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.language.phrases import listed
from taskgist.perspective.image import no_eye, visibility
from taskgist.recording.recording import Label
from taskgist.settings import DEFAULT, Settings
from taskgist.view.rendering import HIGHLIGHT, looking, pinhole, render, save_figure
from taskgist.world.geometry.transforms import Pose
from taskgist.world.stage import Stage
from taskgist.world.state import State

EYE_WIDTH_PX = 640
OUTSIDE_WIDTH_PX = 640
"""Width of the picture from outside beside one through an eye."""


def see_picture(
    stage: Stage,
    agent: str,
    path: Path,
    *,
    target: str | Sequence[str] | None = None,
    settings: Settings = DEFAULT,
    title: str | None = None,
) -> Path:
    """Save what an agent sees in the state that the stage shows.

    Args:
        stage: The scene in a state.
        agent: Whose eyes.
        path: The PNG file to write.
        target: An object to mark, or several.
        settings: For the visibility score in the title.
        title: Instead of the default title.

    Raises:
        SceneError: The agent has no eye.
    """
    if not stage.scene.agent(agent).profile.eye.sees:
        raise no_eye(agent)
    figure = Figure(figsize=(7, 6.2), layout="constrained")
    axes = figure.subplots()
    draw_eye(axes, stage, agent, target, settings, title or f"{agent} at {stage.state.time_s:.2f} s")
    return save_figure(figure, path)


def before_after_picture(
    stage: Stage,
    states: tuple[State, State],
    label: Label,
    path: Path,
    *,
    settings: Settings = DEFAULT,
    title: str = "",
) -> Path:
    """Save a demonstration's start and end: the room from outside, and what each target agent sees.

    Args:
        stage: The scene; shows the last state afterwards.
        states: Start and end.
        label: Who performs, for whom, with what.
        path: The PNG file to write.
        settings: For the visibility scores in the titles.
        title: Title of the whole picture.
    """
    agents, things = label.watched, label.target_objects
    figure = Figure(figsize=(12, 3.8 + 4.8 * len(agents)), layout="constrained")
    figure.suptitle(title, fontsize=13)
    grid = figure.subplots(1 + len(agents), 2, gridspec_kw={"height_ratios": [1] + [1.25] * len(agents)})
    camera = camera_outside(stage, states, things, width_px=OUTSIDE_WIDTH_PX)
    for column, (name, state) in enumerate(zip(("start", "end"), states, strict=True)):
        stage.show(state)
        draw_outside(grid[0, column], stage, camera, label, f"{name}, {state.time_s:.2f} s")
        for row, agent in enumerate(agents, start=1):
            draw_eye(grid[row, column], stage, agent, things, settings, f"what {agent} sees at the {name}")
    return save_figure(figure, path)


def draw_eye(
    axes: Axes,
    stage: Stage,
    agent: str,
    target: str | Sequence[str] | None,
    settings: Settings,
    title: str,
    *,
    width_px: int | None = None,
) -> None:
    """Draw what an agent sees, with one target object or several marked; the dashed circle is its gaze cone."""
    width_px = width_px or EYE_WIDTH_PX
    body = stage.scene.agent(agent)
    eye = body.profile.eye
    if not eye.sees:
        axes.set_title(f"{title}: unknown, it has no eye", fontsize=10)
        axes.set_axis_off()
        return
    height = round(width_px * eye.image_px[1] / eye.image_px[0])
    things = _names(target)
    marked = _geoms(stage, things)
    there = stage.seen & stage.scene.hiding(settings.vision.transparent_alpha)
    there[marked] = stage.seen[marked]
    image = render(
        stage,
        stage.eye(body),
        pinhole(eye.fov_rad, width_px, height),
        exclude_body=body.eye_exclude_body,
        only=np.flatnonzero(there),
        highlight=[int(geom) for geom in marked],
    )
    axes.imshow(np.clip(image.rgb, 0, 1))
    scores = "".join(_score_text(stage, agent, thing, settings) for thing in things)
    axes.set_title(f"{title}{scores}", fontsize=10)
    axes.set_xticks([])
    axes.set_yticks([])
    _draw_gaze(axes, eye.fov_rad, eye.gaze_cone_rad, width_px, height)
    shown = {thing: np.isin(image.geoms, stage.scene.object_geoms(thing)) for thing in things}
    unseen = [thing for thing, mask in shown.items() if not _mark(axes, mask, thing)]
    if unseen:
        text = f"{listed(unseen)} {'is' if len(unseen) == 1 else 'are'} not visible"
        axes.text(0.02, 0.03, text, transform=axes.transAxes, fontsize=10, backgroundcolor="white")


def _names(target: str | Sequence[str] | None) -> tuple[str, ...]:
    """Names of none, one or several target objects."""
    if target is None:
        return ()
    return (target,) if isinstance(target, str) else tuple(target)


def _geoms(stage: Stage, things: Sequence[str]) -> Indices:
    """Shapes of target objects."""
    return np.array([geom for thing in things for geom in stage.scene.object_geoms(thing)], dtype=np.intp)


def _score_text(stage: Stage, agent: str, target: str, settings: Settings) -> str:
    seen = visibility(stage, agent, target, settings)
    if seen is None:
        return f"\n{target}: unknown"
    hidden = f", {100 * (1 - seen.visible_share):.0f} % occluded" if seen.unoccluded_px else ""
    return f"\n{target}: visibility score {100 * seen.score:.2f} %{hidden}"


def _draw_gaze(axes: Axes, fov_rad: tuple[float, float], cone_rad: float, width: int, height: int) -> None:
    if cone_rad >= max(fov_rad) / 2:
        return
    across = width * math.tan(cone_rad) / math.tan(fov_rad[0] / 2)
    down = height * math.tan(cone_rad) / math.tan(fov_rad[1] / 2)
    middle = (width / 2 - 0.5, height / 2 - 0.5)
    axes.add_patch(Ellipse(middle, across, down, fill=False, linestyle="--", linewidth=1, edgecolor="black", alpha=0.6))


def _mark(axes: Axes, mask: Mask, name: str) -> bool:
    """Outline the visible pixels of a target and name it; whether there are any."""
    if not mask.any():
        return False
    axes.contour(mask, levels=[0.5], colors=["black"], linewidths=1.0)
    rows, columns = np.nonzero(mask)
    axes.annotate(
        name,
        (float(columns.mean()), float(rows.min())),
        xytext=(0, 28),
        textcoords="offset points",
        ha="center",
        fontsize=10,
        color="black",
        bbox={"boxstyle": "round,pad=0.2", "facecolor": "white", "edgecolor": tuple(HIGHLIGHT)},
        arrowprops={"arrowstyle": "->", "color": "black"},
    )
    return True


# --- From outside: a camera that shows all people and things of a demonstration, with everybody's name.

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
LETTER, LINE = 0.0125, 0.03
"""Width of a letter of a name, and height of its line, as shares of a picture's width."""
BEHIND_NAMES = {"facecolor": "white", "alpha": 0.6, "edgecolor": "none", "pad": 1.0}
"""Names are read before dark things, too."""
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


def camera_outside(
    stage: Stage, states: Sequence[State], target: str | Sequence[str], *, width_px: int = 480
) -> Camera:
    """The camera that shows most of the target objects, of the four that look across the people's line.

    Args:
        stage: The scene; shows the last state afterwards.
        states: What the picture must hold.
        target: The target object, or several.
        width_px: Width of the pictures.
    """
    height_px = round(width_px * math.tan(FOV_RAD[1] / 2) / math.tan(FOV_RAD[0] / 2))
    cameras = [Camera(pose, width_px, height_px) for pose in _poses(stage, states)]
    return max(cameras, key=lambda camera: _seen(stage, states, _names(target), camera))


def draw_outside(axes: Axes, stage: Stage, camera: Camera, label: Label, title: str) -> None:
    """Draw the state that the stage shows, the target objects in the colour of attention.

    Args:
        axes: Where to draw.
        stage: The scene in a state.
        camera: From where.
        label: Who performs, for whom, with what.
        title: Title of the picture.
    """
    axes.imshow(_smooth_picture(stage, camera, label.target_objects))
    axes.set_title(title, fontsize=9)
    axes.set_axis_off()
    draw_names(axes, stage, camera, label)


def draw_names(axes: Axes, stage: Stage, camera: Camera, label: Label) -> None:
    """Write above everybody's head who it is, and which part in the task it has."""
    roles = {label.performing_agent: "performer"} | dict.fromkeys(label.target_agents, "target agent")
    heads = [stage.eye(stage.scene.agent(name)).position + (0.0, 0.0, ABOVE_EYE_M) for name in stage.scene.agents]
    placed: list[tuple[float, float, float]] = []
    lowest_first = sorted(zip(map(camera.pixel, heads), stage.scene.agents, strict=True), key=lambda each: -each[0][1])
    for (column, row), name in lowest_first:
        text = f"{name}, {roles[name]}" if name in roles else name
        half, high = len(text) * LETTER * camera.width_px / 2, LINE * camera.width_px
        for at, other_half, other_row in placed:  # from the lowest up, so that one pass is enough
            if abs(at - column) < half + other_half and abs(other_row - row) < high:
                row = other_row - high
        placed.append((column, half, row))
        axes.text(column, row, text, fontsize=7.5, ha="center", va="bottom", bbox=BEHIND_NAMES)


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


def _seen(stage: Stage, states: Sequence[State], things: Sequence[str], camera: Camera) -> list[int]:
    """Pixels of each target object in each state, fewest first, in a small picture."""
    rays = pinhole(FOV_RAD, camera.width_px // 2, camera.height_px // 2)
    counts = []
    for state in states:
        stage.show(state)
        geoms = render(stage, camera.pose, rays).geoms
        counts += [int(np.isin(geoms, stage.scene.object_geoms(thing)).sum()) for thing in things]
    return sorted(counts)


def _smooth_picture(stage: Stage, camera: Camera, things: Sequence[str]) -> Array:
    width, height = camera.width_px, camera.height_px
    rays = pinhole(FOV_RAD, SMOOTHING * width, SMOOTHING * height)
    marked = [int(geom) for geom in _geoms(stage, things)]
    rgb = np.clip(render(stage, camera.pose, rays, highlight=marked).rgb, 0, 1)
    return np.asarray(rgb.reshape(height, SMOOTHING, width, SMOOTHING, 3).mean(axis=(1, 3)))
