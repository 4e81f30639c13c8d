"""Pictures of a performance: a strip of its moments, and a short film, from outside and through the target's eyes.

A film is drawn fast because most of it stands still: what never moves is rendered once, and of each frame only the
pixels around what does. It shows as many frames as a small file holds, faster than life where that takes longer.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from textwrap import fill

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.common.files import writing
from taskgist.common.workers import Progress, silent
from taskgist.errors import InputError
from taskgist.language.performing import chosen, doing
from taskgist.language.phrases import listed
from taskgist.performing.execution import Execution, phase_frames
from taskgist.planning.plan import RATE_HZ, Phase, Plan
from taskgist.recording.recording import Label, Recording
from taskgist.settings import DEFAULT, Settings
from taskgist.view.rendering import pinhole, render, save_figure
from taskgist.view.scene import FOV_RAD, Camera, camera_outside, draw_eye, draw_names, draw_outside
from taskgist.world.stage import Stage

CHOOSING_WIDTH_PX, PICTURE_WIDTH_PX, FILM_WIDTH_PX, EYE_WIDTH_PX = 200, 600, 480, 300
"""Widths of pictures: by which a camera is chosen, in a strip, in a film, and there through an eye."""
TITLE_LETTERS = 120
"""Letters of a line above a strip, which has room for no more."""


# --- A strip of moments.


def performance_picture(plan: Plan, execution: Execution, path: Path, *, settings: Settings = DEFAULT) -> Path:
    """Save the moments of a performance from outside, and what each target agent sees before and after.

    Args:
        plan: What was done.
        execution: How it was carried out.
        path: The PNG file to write.
        settings: For the visibility scores in the titles.

    Raises:
        InputError: The file cannot be written.
    """
    recording, label = execution.recording, _label(execution)
    stage, shown = Stage(recording.scene), moments(plan, execution)
    camera = _camera(stage, plan, execution, PICTURE_WIDTH_PX)
    rows = -(-len(shown) // 3)
    eyes = len(plan.targets)
    figure = Figure(figsize=(13, 3.15 * rows + 5.0 * eyes), layout="constrained")
    figure.suptitle("\n".join(fill(line, TITLE_LETTERS) for line in (_title(plan), chosen(plan))), fontsize=13)
    grid = figure.add_gridspec(rows + eyes, 6, height_ratios=[1.0] * rows + [1.5] * eyes)
    for number, (frame, text) in enumerate(shown):
        row, column = divmod(number, 3)
        stage.show(recording.state(frame))
        axes = figure.add_subplot(grid[row, 2 * column : 2 * column + 2])
        draw_outside(axes, stage, camera, label, f"{recording.times_s[frame]:.1f} s: {text}")
    for column, (frame, when) in enumerate(((0, "at the start"), (-1, "at the end"))):
        stage.show(recording.state(frame))
        for row, target in enumerate(plan.targets, start=rows):
            axes = figure.add_subplot(grid[row, 3 * column : 3 * column + 3])
            draw_eye(axes, stage, target, plan.things, settings, f"what {target} sees {when}")
    return save_figure(figure, path)


def moments(plan: Plan, execution: Execution) -> list[tuple[int, str]]:
    """Frames that tell a performance, six in order of time, and what happens in each."""
    last = len(execution.recording.times_s) - 1
    found, texts = {0: "at the start"}, ["at the start"] * (last + 1)
    for (phase, text), frames in zip(_told(plan), phase_frames(plan), strict=True):
        texts[frames.start : frames.stop] = [text] * len(frames)
        share = TELLING.get(phase.name)
        if share is not None:
            found[frames.start + round(share * (len(frames) - 1))] = text
    found[last] = "at the end"
    while True:
        one, other = min(pairwise(sorted(found)), key=lambda pair: pair[1] - pair[0] if pair[1] < last else last)
        if len(found) <= MOMENTS and other - one > NEAR_S * RATE_HZ:
            break
        del found[other]  # of two that are near each other the later one tells little
    while len(found) < MOMENTS:
        one, other = max(pairwise(sorted(found)), key=lambda pair: pair[1] - pair[0])
        middle = (one + other) // 2
        found[middle] = texts[middle]
    return sorted(found.items())


MOMENTS, NEAR_S = 6, 0.4
"""So many are shown, none of them so near to another."""
TELLING = {"approach": 1.0, "transport": 0.5, "transfer": 1.0, "lower": 1.0, "take": 1.0}
"""Phases of robots that are shown, and how far each has come; where there are fewer, the longest gaps are filled."""


def _told(plan: Plan) -> Iterator[tuple[Phase, str]]:
    """Each phase and what happens in it; where several act, who does it."""
    for action in plan.actions:
        who = f"{action.performer} " if len(plan.performers) > 1 else ""
        for phase in action.phases:
            yield phase, f"{who}{doing(action, phase.name)}"


def _label(execution: Execution) -> Label:
    label = execution.recording.label
    assert label is not None  # what is carried out is labelled
    return label


def _title(plan: Plan) -> str:
    return (
        f"{plan.performer} performs “{plan.task}” for {listed(plan.targets)} with the {listed(plan.things, 'and the')}"
    )


def _camera(stage: Stage, plan: Plan, execution: Execution, width_px: int) -> Camera:
    """The camera that has all that happens in its picture, and shows most of the thing."""
    recording = execution.recording
    frames = {frame for frame, _ in moments(plan, execution)} | {frames[-1] for frames in phase_frames(plan)}
    states = [recording.state(frame) for frame in sorted(frames)]
    camera = camera_outside(stage, states, plan.things, width_px=CHOOSING_WIDTH_PX)
    return replace(camera, width_px=width_px, height_px=round(width_px * camera.height_px / camera.width_px))


# --- A film.

FPS, MOST_FRAMES, LAST_S = 8, 64, 1.5
"""Frames in a second, at most so many of them, and how long the last one stays."""
MOST_BYTES = 2_000_000
"""A film is not larger, where a lower quality makes it so."""
WEBP_QUALITIES, GIF_COLOURS = (80, 60, 40, 20), (256, 128, 64, 32)
"""Tried one after the other until a film is small enough."""
FILMS = (".webp", ".gif")
"""How the names of films end."""
SMOOTHING = 2
"""Rays in each direction for one pixel."""
SAME = 1e-6
"""Metres, and parts of a rotation, by which nothing is seen to move."""
AROUND_PX = 3
"""Pixels around what moves that are drawn anew."""


def performance_film(plan: Plan, execution: Execution, path: Path, *, progress: Progress = silent) -> Path:
    """Save a short film of a performance: the room from outside, and what the target agent sees.

    Args:
        plan: What was done.
        execution: How it was carried out.
        path: The file to write, ``.webp`` or ``.gif``.
        progress: Told how far it is.

    Raises:
        InputError: The name ends otherwise, or the file cannot be written.
    """
    if path.suffix.lower() not in FILMS:
        raise InputError("films are WEBP or GIF", where=path, hint="name it .webp or .gif")
    drawn = list(_drawn(plan, execution, progress))
    with writing(path, replace=True) as stream:
        stream.write(encoded(drawn, path.suffix.lower()))
    return path


def _drawn(plan: Plan, execution: Execution, progress: Progress) -> Iterator[Image.Image]:
    recording, label = execution.recording, _label(execution)
    frames = film_frames(len(recording.times_s))
    faster = len(recording.times_s) / RATE_HZ * FPS / len(frames)
    stage, texts = Stage(recording.scene), _texts(plan, len(recording.times_s))
    camera = _camera(stage, plan, execution, FILM_WIDTH_PX)
    outside = Outside(stage, recording, frames, camera)
    figure = Figure(figsize=(8.2, 3.8))
    canvas = FigureCanvasAgg(figure)
    for number, frame in enumerate(frames.tolist()):
        progress("drawing the film", number / len(frames))
        stage.show(recording.state(frame))
        figure.clear()
        figure.text(0.012, 0.955, _title(plan), fontsize=12, va="center")
        speed = f"{faster:.1f} times as fast" if faster > 1.05 else ""
        figure.text(0.988, 0.955, speed, fontsize=9, ha="right", va="center")
        axes = figure.add_axes((0.01, 0.085, 0.586, 0.82))
        _draw_frame(axes, stage, camera, label, outside.picture())
        axes.text(0, 1.02 * camera.height_px, f"{recording.times_s[frame]:5.1f} s  {texts[frame]}", va="top")
        axes = figure.add_axes((0.612, 0.085, 0.378, 0.715))
        draw_eye(axes, stage, plan.target, plan.things, DEFAULT, f"what {plan.target} sees", width_px=EYE_WIDTH_PX)
        canvas.draw()  # type: ignore[no-untyped-call]
        rgba = np.asarray(canvas.buffer_rgba())  # type: ignore[no-untyped-call]
        yield Image.fromarray(rgba[..., :3].copy())


def _draw_frame(axes: Axes, stage: Stage, camera: Camera, label: Label, rgb: Array) -> None:
    axes.imshow(rgb)
    axes.set_axis_off()
    draw_names(axes, stage, camera, label)


def film_frames(count: int) -> Indices:
    """Which of so many frames of a recording a film shows, the first and the last among them, (n,)."""
    wanted = min(MOST_FRAMES, max(2, round(count / RATE_HZ * FPS)))
    return np.round(np.linspace(0, count - 1, wanted)).astype(np.intp)


def _texts(plan: Plan, count: int) -> list[str]:
    """What happens in each frame of the recording."""
    texts = [""] * count
    who = "" if len(plan.performers) > 1 else f"{plan.performers[0]} "
    for (_, text), frames in zip(_told(plan), phase_frames(plan), strict=True):
        texts[frames.start : frames.stop] = [f"{who}{text}"] * len(frames)
    return texts


class Outside:
    """Pictures of some frames of a recording from one camera: what stands still in all of them is rendered once.

    Args:
        stage: The scene; its state is pictured.
        recording: Of which the frames are; its target objects have the colour of attention.
        frames: Which.
        camera: From where.
    """

    def __init__(self, stage: Stage, recording: Recording, frames: Indices, camera: Camera) -> None:
        self._stage, self._camera = stage, camera
        things = recording.label.target_objects if recording.label else ()
        self._marked = [int(geom) for thing in things for geom in recording.scene.object_geoms(thing)]
        self._moving = moving_geoms(stage, recording, frames)
        self._rays = pinhole(FOV_RAD, SMOOTHING * camera.width_px, SMOOTHING * camera.height_px)
        still = stage.seen.copy()
        still[self._moving] = False
        self._still = render(stage, camera.pose, self._rays, only=np.flatnonzero(still), highlight=self._marked).rgb

    def picture(self) -> Array:
        """Colours from 0 to 1, (height, width, 3)."""
        rgb, near = self._still.copy(), self._near()
        if near.any():
            rays = self._rays[near][None]
            rgb[near] = render(self._stage, self._camera.pose, rays, highlight=self._marked).rgb[0]
        width, height = self._camera.width_px, self._camera.height_px
        smooth = np.clip(rgb, 0, 1).reshape(height, SMOOTHING, width, SMOOTHING, 3).mean(axis=(1, 3))
        return np.asarray(smooth)

    def _near(self) -> Mask:
        """Rays that may meet what moves: squares around the balls around its shapes."""
        height, width = self._rays.shape[:2]
        near = np.zeros((height, width), dtype=np.bool_)
        pose, model = self._camera.pose, self._stage.scene.model
        focal_px = width / 2 / np.tan(FOV_RAD[0] / 2)
        for center, radius_m in zip(
            self._stage.geom_centers(self._moving), model.geom_rbound[self._moving].tolist(), strict=True
        ):
            ahead_m = float(pose.to_local(center)[0])
            if ahead_m <= radius_m:  # around the camera itself
                near[:] = True
                continue
            column, row = (SMOOTHING * value for value in self._camera.pixel(center))
            # A ball at the edge of a flat picture is an ellipse, longer by the cosine there than in its middle.
            tilt = float(np.linalg.norm(pose.to_local(center))) / ahead_m
            around = focal_px * radius_m / (ahead_m - radius_m) * tilt + SMOOTHING * AROUND_PX
            rows, columns = (slice(max(0, int(at - around)), max(0, int(at + around) + 1)) for at in (row, column))
            near[rows, columns] = True
        return near


def moving_geoms(stage: Stage, recording: Recording, frames: Indices) -> Indices:
    """Shapes that are not in the same place in all of some frames of a recording, (n,).

    Args:
        stage: Its scene; shows the last of the frames afterwards.
        recording: The recording.
        frames: Which of its frames.
    """
    bodies = np.array([stage.show(recording.state(frame)).bodies() for frame in frames.tolist()])
    moves = np.any(np.ptp(bodies, axis=0) > SAME, axis=1)
    return np.flatnonzero(moves[stage.scene.model.geom_bodyid])


def encoded(frames: Sequence[Image.Image], suffix: str) -> bytes:
    """A film as the bytes of a file, of the highest quality with which it is small enough.

    Args:
        frames: Its pictures, of one size.
        suffix: ``.webp`` or ``.gif``.
    """
    durations_ms = [round(1000 / FPS)] * (len(frames) - 1) + [round(1000 * LAST_S)]
    for quality in WEBP_QUALITIES if suffix == ".webp" else GIF_COLOURS:
        stream = io.BytesIO()
        first, *others = frames if suffix == ".webp" else _with_one_palette(frames, quality)
        options = {"format": "WEBP", "quality": quality, "method": 4} if suffix == ".webp" else {"format": "GIF"}
        first.save(stream, save_all=True, append_images=others, duration=durations_ms, loop=0, **options)
        if stream.tell() <= MOST_BYTES:
            break
    return stream.getvalue()


def _with_one_palette(frames: Sequence[Image.Image], colours: int) -> list[Image.Image]:
    """The same frames in few colours, the same for all: what stands still does not flicker."""
    shown = [frames[0], frames[len(frames) // 2], frames[-1]]
    together = Image.fromarray(np.concatenate([np.asarray(frame) for frame in shown]))
    palette = together.quantize(colours, method=Image.Quantize.FASTOCTREE)
    return [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
