"""Pictures of demonstrations: from outside, and through the eyes of both people, at the start and at the end."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from taskgist.recording import Label, Progress, Recording, read, silent
from taskgist.settings import DEFAULT
from taskgist.study import label_of
from taskgist.study.paper import Judged, understanding_of
from taskgist.view.eyes import draw_eye
from taskgist.view.outside import camera_outside, draw_outside
from taskgist.view.saving import save_figure
from taskgist.view.trees import tree_picture
from taskgist.workers import cores, in_order
from taskgist.world import Stage, State

INSTANTS = ("start", "end")


def study_pictures(
    paths: Mapping[str, Sequence[Path]],
    judged: Mapping[str, Sequence[Judged]],
    folder: Path,
    progress: Progress = silent,
) -> Iterator[Path]:
    """Save a picture of every demonstration, and the tree of every task.

    Args:
        paths: Recordings by task.
        judged: The same, judged.
        folder: Where the pictures go.
        progress: Told how far it is.

    Raises:
        InputError: A file cannot be written.
    """
    jobs = [(path, folder / f"{path.stem}.png") for of_task in paths.values() for path in of_task]
    for number, picture in enumerate(in_order(lambda number: _draw(*jobs[number]), len(jobs), cores()), start=1):
        progress(f"drew {picture.stem}", number / len(jobs))
        yield picture
    for task, demonstrations in judged.items():
        grown = range(1, len(demonstrations) + 1)
        stages = {str(count): understanding_of(task, demonstrations[:count]) for count in grown}
        title = f"{task}: what is understood after {', '.join(stages)} demonstrations"
        yield tree_picture(stages, folder / f"tree_{task.replace(' ', '_')}.png", title=title)


def _draw(recording: Path, picture: Path) -> Path:
    return demonstration_picture(read(recording), picture)


def demonstration_picture(recording: Recording, path: Path) -> Path:
    """Save one demonstration: rows for the scene, the target agent's and the performer's eyes; columns start and end.

    Args:
        recording: A labelled recording.
        path: The PNG file to write.

    Raises:
        LabelError: It has no label.
        InputError: The file cannot be written.
    """
    label, states = _ends(recording)
    stage = Stage(recording.scene)
    figure = Figure(figsize=(9, 10.6), layout="constrained")
    figure.suptitle(
        f"{label.task}: {label.performing_agent} → {label.target_agent}, {label.target_object} ({recording.name})",
        fontsize=11,
    )
    grid = figure.subplots(3, 2, gridspec_kw={"height_ratios": [1, 1.2, 1.2]})
    camera = camera_outside(stage, states, label.target_object)
    for column, (instant, state) in enumerate(zip(INSTANTS, states, strict=True)):
        stage.show(state)
        draw_outside(grid[0, column], stage, camera, label, f"{instant}, {state.time_s:.1f} s")
        for row, agent in ((1, label.target_agent), (2, label.performing_agent)):
            title = f"what {agent} sees at the {instant}"
            draw_eye(grid[row, column], stage, agent, label.target_object, DEFAULT, title)
    return save_figure(figure, path)


def task_picture(recordings: Sequence[Recording], path: Path) -> Path:
    """Save all demonstrations of a task: start and end of each, two demonstrations in a row.

    Args:
        recordings: Labelled recordings.
        path: The PNG file to write.

    Raises:
        LabelError: One has no label.
        InputError: The file cannot be written.
    """
    rows = (len(recordings) + 1) // 2
    figure = Figure(figsize=(10.4, 2.05 * rows), layout="constrained")
    grid = figure.subplots(rows, 4, squeeze=False)
    for axes in grid.flat:
        axes.set_axis_off()
    for number, recording in enumerate(recordings):
        column = 2 * (number % 2)
        _draw_ends((grid[number // 2, column], grid[number // 2, column + 1]), recording)
    return save_figure(figure, path)


def _draw_ends(axes: Sequence[Axes], recording: Recording) -> None:
    label, states = _ends(recording)
    stage = Stage(recording.scene)
    camera = camera_outside(stage, states, label.target_object, width_px=300)
    for each, instant, state in zip(axes, INSTANTS, states, strict=True):
        stage.show(state)
        draw_outside(each, stage, camera, label, f"{recording.name}: {instant}")


def _ends(recording: Recording) -> tuple[Label, tuple[State, State]]:
    label = label_of(recording)
    return label, (recording.at(label.start_s), recording.at(label.end_s))
