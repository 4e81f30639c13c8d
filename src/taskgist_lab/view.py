"""Pictures of the lab: contact sheets, learning curves, the hypothesis tree, demonstrations from all sides."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, FancyBboxPatch, Rectangle
from matplotlib.transforms import Affine2D

from taskgist.common.workers import Progress, cores, in_order, silent
from taskgist.facts.tree import HypothesisTree, Node
from taskgist.language.phrases import listed
from taskgist.learning.understanding import Understanding
from taskgist.perspective.effort import Ability
from taskgist.pipeline.explain import label_of
from taskgist.recording.mcap import read
from taskgist.recording.recording import Label, Recording
from taskgist.settings import DEFAULT
from taskgist.view.rendering import save_figure
from taskgist.view.scene import camera_outside, draw_eye, draw_outside
from taskgist.world.stage import Stage
from taskgist.world.state import State
from taskgist_lab.evaluation.asking import Asked
from taskgist_lab.evaluation.clause_learning import ONE_WRONG, ClauseScores, learner_text
from taskgist_lab.evaluation.experiments import CLAUSE, SETTINGS, Needs, Table, Transfer
from taskgist_lab.evaluation.ordinary_rooms import Pair
from taskgist_lab.evaluation.recognition import SHOWN_AFTER, RecognitionScores
from taskgist_lab.evaluation.robustness import Comparison, Robustness
from taskgist_lab.evaluation.values import CLEAN, Result
from taskgist_lab.ordinary.rooms import LENGTH_M, SECOND_M, WIDTH_M, FurnishedRoom
from taskgist_lab.ordinary.truth import Truth
from taskgist_lab.paper.judging import Judged, understanding_of
from taskgist_lab.paper.published import COLUMNS
from taskgist_lab.simulator.room import Person

# --- Contact sheets: many demonstrations at a glance, the end of each one seen from outside.

MOST, SHEET_COLUMNS = 12, 4
"""Pictures on a sheet, at most, and in a row."""
PICTURE_PX = 400


def contact_sheet(recordings: Sequence[Recording], titles: Sequence[str], path: Path, *, title: str = "") -> Path:
    """Save a picture of the end of each of some labelled demonstrations, the first ``MOST`` of them.

    Args:
        recordings: The demonstrations, one or more.
        titles: Title of each.
        path: The PNG file to write.
        title: Title of the whole sheet.
    """
    shown = recordings[:MOST]
    columns = min(SHEET_COLUMNS, len(shown))
    rows = math.ceil(len(shown) / columns)
    figure = Figure(figsize=(4.0 * columns, 3.0 * rows + 0.4), layout="constrained")
    figure.suptitle(title, fontsize=12)
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes in panels:
        axes.set_axis_off()
    for axes, recording, name in zip(panels, shown, titles, strict=False):
        assert recording.label is not None
        state = recording.at(recording.label.end_s)
        stage = Stage(recording.scene, state)
        camera = camera_outside(stage, (state,), recording.label.target_objects, width_px=PICTURE_PX)
        draw_outside(axes, stage, camera, recording.label, name)
    return save_figure(figure, path)


# --- Evaluations: learning curves, tables of truth, robustness, peers.

INK, SOFT = "#222222", "#9a9a9a"
COLOURS = ("#1f5fa8", "#b5651d", "#3a7d44", "#7a4a9e", "#c23b50", "#4f9da6")
LINES = ("-", "--", "-.")
"""Of the columns of Table 4; curves often lie on each other."""
TABLES_AFTER = (1, 3, 10)
"""Demonstrations after which tables are drawn."""
RULES_DRAWN = ("paper", "wide-asked", "paper-asked", "sharp", "sharp-m1")
AFTER = 10
"""Demonstrations after which rules are compared."""


def picture_of(result: Result, path: Path) -> Path:
    """Draw a result of an evaluation.

    Raises:
        InputError: The file cannot be written.
    """
    return save_figure(DRAWN[type(result)](result), path)


def draw_needs(needs: Needs) -> Figure:
    """A panel for each task: share of runs that have each cell of Table 4, by demonstrations."""
    tasks = tuple(dict.fromkeys(row.task for row in needs.rows))
    figure = Figure(figsize=(10.5, 5.8), layout="constrained")
    panels = figure.subplots(2, -(-len(tasks) // 2), sharex=True, sharey=True, squeeze=False).ravel()
    for panel, task in zip(panels, tasks, strict=False):
        _curves(panel, needs, task)
    for panel in panels[len(tasks) :]:
        panel.set_axis_off()
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=5, frameon=False)
    figure.supxlabel("demonstrations")
    figure.supylabel("share of runs")
    return figure


def draw_transfer(found: Transfer) -> Figure:
    """Tables of the whole clause after few and many demonstrations."""
    figure = Figure(figsize=(11.5, 4.6), layout="constrained")
    shown = [after for after in TABLES_AFTER if after in found.sizes]
    panels = figure.subplots(1, len(shown), sharey=True, squeeze=False)[0]
    for panel, after in zip(panels, shown, strict=True):
        _table(panel, found.table(after, CLAUSE))
    panels[0].set_ylabel("clause of")
    figure.supxlabel("demonstrations of")
    return figure


def draw_robustness(found: Robustness) -> Figure:
    """F1 of some rules in every setting."""
    named = {each.setting for each in found.outcomes}
    settings = [each for each in SETTINGS if each.name in named]
    rules = [rule for rule in RULES_DRAWN if any(each.rule == rule for each in found.outcomes)]
    figure = Figure(figsize=(9.0, 0.42 * len(settings) + 1.4), layout="constrained")
    axes = figure.subplots()
    lines = np.arange(len(settings))[::-1]
    for number, rule in enumerate(rules):
        f1 = [_f1(found, setting.name, rule) for setting in settings]
        aside = 0.11 * (number - (len(rules) - 1) / 2)
        axes.plot(f1, lines - aside, "o", color=COLOURS[number], label=rule, markersize=6)
    axes.set_yticks(lines, [setting.text for setting in settings])
    axes.set_xlim(-0.02, 1.0)
    axes.set_xlabel(f"F1 of the clause after {AFTER} demonstrations (or all, if fewer), mean over tasks")
    axes.grid(axis="x", alpha=0.3)
    for line in lines[:-1]:
        axes.axhline(line - 0.5, color=SOFT, alpha=0.3, linewidth=0.6)
    figure.legend(loc="outside upper center", ncols=len(rules), frameon=False, fontsize=9)
    return figure


def draw_comparison(found: Comparison) -> Figure:
    """F1 of every learner by demonstrations; what needs negatives is dashed."""
    figure = Figure(figsize=(8.2, 4.4), layout="constrained")
    axes = figure.subplots()
    names = list(dict.fromkeys(each.name for each in found.learners))
    widths = np.linspace(5.5, 1.2, len(found.learners))  # thick below thin: some lie on each other
    for each, width in zip(found.learners, widths, strict=True):
        label = each.name if not each.negatives else f"{each.name}, with negatives"
        axes.plot(
            range(len(each.tables)),
            [table.overall.f1.mean or 0.0 for table in each.tables],
            "--s" if each.negatives else "-o",
            color=COLOURS[names.index(each.name)],
            label=label,
            linewidth=width,
            markersize=width + 3,
            alpha=0.8,
        )
    sizes = [table.after for table in found.learners[0].tables]
    axes.set_xticks(range(len(sizes)), [str(size) for size in sizes])
    axes.set_ylim(0.0, 1.0)
    axes.set_xlabel("demonstrations of the task")
    axes.set_ylabel("F1 on held-out demonstrations")
    axes.grid(alpha=0.3)
    figure.legend(loc="outside right upper", frameon=False, fontsize=9)
    return figure


def draw_clauses(found: ClauseScores) -> Figure:
    """F1 of both learners by demonstrations, a panel for each setting, judged by all tasks that are fulfilled."""
    figure = Figure(figsize=(9.0, 3.8), layout="constrained")
    shown = (CLEAN, ONE_WRONG)
    panels = figure.subplots(1, len(shown), sharey=True)
    for panel, setting in zip(panels, shown, strict=True):
        sizes = found.sizes(setting)
        for number, (learner, others) in enumerate(found.learners(setting)):
            f1 = [found.row(learner, others, setting, after).as_fulfilled.mean or 0.0 for after in sizes]
            panel.plot(range(len(f1)), f1, "-o", color=COLOURS[number], label=learner_text(learner, others))
        panel.set_xticks(range(len(sizes)), [str(size) for size in sizes])
        panel.set_ylim(0.0, 1.0)
        panel.set_title(setting, fontsize=10)
        panel.grid(alpha=0.3)
    figure.supxlabel("demonstrations of the task")
    figure.supylabel("F1 on held-out demonstrations")
    figure.legend(
        *panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=3, frameon=False, fontsize=9
    )
    return figure


def draw_recognition(found: RecognitionScores) -> Figure:
    """How reliable probabilities are, what is recognised by demonstrations, and what is called none of the tasks."""
    figure = Figure(figsize=(11.0, 4.0), layout="constrained")
    reliable, right, none = figure.subplots(1, 3)
    reliable.plot((0.0, 1.0), (0.0, 1.0), color=SOFT, linewidth=0.8)
    after = SHOWN_AFTER if SHOWN_AFTER in found.sizes else found.sizes[-1]
    places = range(len(found.sizes))
    for name, colour in zip(found.recognisers, COLOURS, strict=False):
        curve = found.curve(name, after)
        reliable.plot([each.predicted for each in curve], [each.observed for each in curve], "-o", color=colour, ms=4)
        rows = [found.row(name, size) for size in found.sizes]
        right.plot(places, [each.right.mean for each in rows], "-o", color=colour, ms=4, label=name)
        if all(each.unknown_none.mean is not None for each in rows):
            none.plot(places, [each.unknown_none.mean for each in rows], "-o", color=colour, ms=4)
        none.plot(places, [each.own_none.mean for each in rows], "--o", color=colour, ms=4)
    reliable.set_xlabel(f"probability, after {after} demonstrations")
    reliable.set_ylabel("how often it was so")
    right.set_title("the most probable task is right", fontsize=10)
    none.set_title("called none: unknown kinds, own dashed", fontsize=10)
    for panel in (right, none):
        panel.set_xticks(places, [str(size) for size in found.sizes])
        panel.set_xlabel("demonstrations of each task")
    for panel in (reliable, right, none):
        panel.set_ylim(-0.03, 1.03)
        panel.grid(alpha=0.3)
    figure.legend(*right.get_legend_handles_labels(), loc="outside upper center", ncols=4, frameon=False, fontsize=9)
    return figure


def draw_asking(found: Asked) -> Figure:
    """F1 by demonstrations, and how it rises with each answer, a panel for each number of other tasks."""
    figure = Figure(figsize=(9.0, 3.8), layout="constrained")
    numbers = tuple(dict.fromkeys(each.others for each in found.rows))
    panels = figure.subplots(1, len(numbers), sharey=True, squeeze=False)[0]
    for panel, others in zip(panels, numbers, strict=True):
        rows = [each for each in found.rows if each.others == others]
        plain = [each for each in rows if not each.questions]
        panel.plot(
            [each.demonstrations for each in plain],
            [each.as_fulfilled.mean or 0.0 for each in plain],
            "-o",
            color=COLOURS[0],
            label="demonstrations alone",
        )
        for number, first in enumerate(dict.fromkeys(each.demonstrations for each in rows if each.questions), start=1):
            asked = [each for each in rows if each.demonstrations == first]
            panel.plot(
                [first + each.questions for each in asked],
                [each.as_fulfilled.mean or 0.0 for each in asked],
                "--s",
                color=COLOURS[number],
                label=f"{first} demonstration{'s' * (first > 1)}, then answers",
            )
        panel.set_ylim(0.0, 1.0)
        panel.set_title(f"{others or 'no'} other task{'s' * (others != 1)}", fontsize=10)
        panel.grid(alpha=0.3)
    figure.supxlabel("demonstrations and answers")
    figure.supylabel("F1 on held-out demonstrations")
    figure.legend(
        *panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=3, frameon=False, fontsize=9
    )
    return figure


def _curves(axes: Axes, needs: Needs, task: str) -> None:
    whole = needs.row(task)
    counts = np.arange(1, len(whole.curve) + 1)
    axes.plot(counts, whole.curve, color=SOFT, linewidth=6.0, alpha=0.6, label="all three", solid_capstyle="butt")
    for column, colour, line in zip(COLUMNS, COLOURS, LINES, strict=False):
        axes.plot(counts, needs.row(task, column).curve, color=colour, linestyle=line, linewidth=1.6, label=column)
    if whole.paper is not None:
        axes.axvline(whole.paper, color=INK, linestyle=":", linewidth=1.0, label="the paper's number")
    axes.set_title(task, fontsize=10)
    axes.set_xlim(0.5, len(counts) + 0.5)
    axes.set_ylim(-0.03, 1.03)
    axes.set_xticks([1, *range(5, len(counts) + 1, 5)])
    axes.grid(alpha=0.25)


def _table(axes: Axes, table: Table) -> None:
    shares = np.array(table.true)
    axes.imshow(shares, cmap="Blues", vmin=0.0, vmax=1.15)
    for row, column in np.ndindex(shares.shape):
        colour = "white" if shares[row, column] > 0.6 else INK
        axes.text(column, row, f"{shares[row, column]:.0%}", ha="center", va="center", color=colour, fontsize=9)
    axes.set_xticks(range(len(table.tasks)), table.tasks, rotation=40, ha="right")
    axes.set_yticks(range(len(table.tasks)), table.tasks)
    one = "demonstration" if table.after == 1 else "demonstrations"
    axes.set_title(f"after {table.after} {one}", fontsize=10)


def _f1(found: Robustness, setting: str, rule: str) -> float:
    after = found.outcome(setting, rule).after
    return next(each.f1.mean or 0.0 for each in reversed(after) if each.demonstrations <= AFTER)


DRAWN: Mapping[type[Result], Callable[..., Figure]] = {
    Needs: draw_needs,
    Transfer: draw_transfer,
    Robustness: draw_robustness,
    Comparison: draw_comparison,
    ClauseScores: draw_clauses,
    RecognitionScores: draw_recognition,
    Asked: draw_asking,
}
"""What pictures each kind of result."""


# --- A picture of the hypothesis tree: what is kept, what was pruned, and after how many demonstrations.

KEPT, ONCE, NEVER = "#2b7a3d", "#b7791f", "#a8a8a8"
"""Colours of nodes that are kept in the end, that were kept once, and that never were."""
COLUMN_IN, ROW_IN = 2.6, 0.33
BOX = (2.38, 0.28)
MARK_IN = 0.13
LINE_IN = 0.065
"""How far title and value lie from the middle of a box."""
LONGEST = 40
"""Letters of a value that fit into a box."""


def tree_picture(stages: Mapping[str, Understanding], path: Path, *, title: str = "") -> Path:
    """Save the tree of one task, from its roots on the left to its leaves on the right.

    Args:
        stages: Understandings while they grow, by what marks them: ``{"2": ..., "3": ..., "4": ...}``. A node bears a
            mark for each stage, filled where it is kept; its value is that of the last stage in which it was.
        path: The PNG file to write.
        title: Title of the picture.

    Raises:
        InputError: The file cannot be written.
    """
    tree = next(iter(stages.values())).tree
    places = layout(tree)
    columns = 1 + max(column for column, _ in places.values())
    rows = 1 + max(row for _, row in places.values())
    figure = Figure(figsize=(COLUMN_IN * columns, ROW_IN * (rows + 2.4)))
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_xlim(0, COLUMN_IN * columns)
    axes.set_ylim(ROW_IN * (rows + 0.7), -1.7 * ROW_IN)
    axes.set_axis_off()
    axes.text(0.1, -1.1 * ROW_IN, title, fontsize=11, va="center")
    _draw_key(axes, list(stages), ROW_IN * (rows + 0.15))
    for node in tree.nodes:
        if node.parent is not None:
            _draw_line(axes, places[node.parent], places[node.name])
    for node in tree.nodes:
        _draw_node(axes, node, places[node.name], stages)
    return save_figure(figure, path)


def layout(tree: HypothesisTree) -> dict[str, tuple[int, float]]:
    """Column and row of each node: leaves one below the other, a parent in the middle of its children."""
    places: dict[str, tuple[int, float]] = {}
    leaves = 0.0
    for root in (node for node in tree.nodes if node.parent is None):
        leaves = _place(tree, root, 0 if root.level == 1 else 1, leaves, places) + 0.35
    return places


def _place(tree: HypothesisTree, node: Node, column: int, leaves: float, places: dict[str, tuple[int, float]]) -> float:
    """Place a node and all below it from this row on; return the next free row."""
    children = tree.children(node.name)
    if not children:
        places[node.name] = (column, leaves)
        return leaves + 1.0
    for child in children:
        leaves = _place(tree, child, column + 1, leaves, places)
    rows = [places[child.name][1] for child in children]
    places[node.name] = (column, (rows[0] + rows[-1]) / 2)
    return leaves


def _draw_node(axes: Axes, node: Node, place: tuple[int, float], stages: Mapping[str, Understanding]) -> None:
    x, y = _corner(place)
    judgements = [understanding.judgements[node.name] for understanding in stages.values()]
    values = [judgement.value for judgement in judgements if judgement.kept]
    colour = KEPT if judgements[-1].kept else ONCE if values else NEVER
    width, height = BOX
    box = FancyBboxPatch((x, y - height / 2), width, height, boxstyle="round,pad=0,rounding_size=0.04")
    box.set(facecolor="white" if not values else _pale(colour), edgecolor=colour, linewidth=0.8)
    axes.add_patch(box)
    axes.text(x + 0.05, y - LINE_IN * bool(values), node.title, fontsize=6.6, va="center", color="#505050")
    if values:
        size = 7.2 * min(1.0, LONGEST / len(str(values[-1])))
        axes.text(x + 0.05, y + LINE_IN, str(values[-1]), fontsize=size, va="center", weight="bold")
    for number, judgement in enumerate(judgements):
        right = x + width - 0.03 - (len(judgements) - number) * MARK_IN
        _draw_mark(axes, right, y - LINE_IN, filled=judgement.kept)


def _draw_mark(axes: Axes, x: float, y: float, *, filled: bool) -> None:
    face = KEPT if filled else "white"
    axes.plot(x + MARK_IN / 2, y, marker="s", markersize=4.2, markerfacecolor=face, markeredgecolor="#707070", mew=0.5)


def _draw_line(axes: Axes, parent: tuple[int, float], child: tuple[int, float]) -> None:
    (x, y), (right, below) = _corner(parent), _corner(child)
    start = x + BOX[0]
    middle = (start + right) / 2
    axes.plot([start, middle, middle, right], [y, y, below, below], color=NEVER, linewidth=0.7, zorder=0)


def _draw_key(axes: Axes, names: Sequence[str], y: float) -> None:
    x = 0.1
    for colour, text in (
        (KEPT, "kept in the end"),
        (ONCE, "kept at first, pruned later"),
        (NEVER, "never kept"),
    ):
        axes.plot(x + 0.06, y, marker="s", markersize=7, color=colour)
        axes.text(x + 0.2, y, text, fontsize=7.5, va="center")
        x += 0.55 + 0.062 * len(text)
    if len(names) > 1:
        told = ", ".join(names[:-1]) + f" and {names[-1]}"
        axes.text(x + 0.1, y, f"squares: kept after {told} demonstrations", fontsize=7.5, va="center")


def _corner(place: tuple[int, float]) -> tuple[float, float]:
    """Left edge and middle of a node's box, inches from the top left."""
    column, row = place
    return 0.08 + column * COLUMN_IN, row * ROW_IN


def _pale(colour: str) -> tuple[float, float, float]:
    red, green, blue = (int(colour[place : place + 2], 16) / 255 for place in (1, 3, 5))
    return (0.86 + 0.14 * red, 0.86 + 0.14 * green, 0.86 + 0.14 * blue)


# --- Pictures of demonstrations: from outside, and through the eyes of both people, at the start and at the end.

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
    watching = (*label.target_agents, label.performing_agent)
    agents, things = listed(label.watched), listed(label.target_objects)
    figure = Figure(figsize=(9, 3.4 + 3.6 * len(watching)), layout="constrained")
    figure.suptitle(f"{label.task}: {label.performing_agent} → {agents}, {things} ({recording.name})", fontsize=11)
    grid = figure.subplots(1 + len(watching), 2, gridspec_kw={"height_ratios": [1] + [1.2] * len(watching)})
    camera = camera_outside(stage, states, label.target_objects)
    for column, (instant, state) in enumerate(zip(INSTANTS, states, strict=True)):
        stage.show(state)
        draw_outside(grid[0, column], stage, camera, label, f"{instant}, {state.time_s:.1f} s")
        for row, agent in enumerate(watching, start=1):
            title = f"what {agent} sees at the {instant}"
            draw_eye(grid[row, column], stage, agent, label.target_objects, DEFAULT, title)
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
    camera = camera_outside(stage, states, label.target_objects, width_px=300)
    for each, instant, state in zip(axes, INSTANTS, states, strict=True):
        stage.show(state)
        draw_outside(each, stage, camera, label, f"{recording.name}: {instant}")


def _ends(recording: Recording) -> tuple[Label, tuple[State, State]]:
    label = label_of(recording)
    return label, (recording.at(label.start_s), recording.at(label.end_s))


# --- Ordinary rooms in plan view: who and what, coloured by the effort that perspective finds.

LEVEL_COLOURS = ("#1a7f4b", "#52a84f", "#9ac442", "#e3c22f", "#e8923a", "#1c1c1c")
"""By effort level, 0 to 5."""
WRONG = "#d01c1c"
PLAN_IN = (4.2, 2.9)
OVER_M = 1.3
"""Boxes above this are drawn as outlines alone: one looks beneath them."""


def ordinary_room_picture(room: FurnishedRoom, pairs: Sequence[Pair], ability: Ability, path: Path) -> Path:
    """Save a plan view of a room for each person in it: things by effort level, wrong answers ringed.

    Args:
        room: The room.
        pairs: Its pairs of person and thing.
        ability: Whose answers are shown.
        path: The PNG file to write.

    Raises:
        InputError: The file cannot be written.
    """
    columns = min(3, len(room.people))
    rows = math.ceil(len(room.people) / columns)
    figure = Figure(figsize=(PLAN_IN[0] * columns, PLAN_IN[1] * rows + 0.5), layout="constrained")
    figure.suptitle(f"{ability}, for each person (arrow) in turn", fontsize=11)
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes in panels:
        axes.set_axis_off()
    for axes, person in zip(panels, room.people, strict=False):
        _draw_plan(axes, room, person)
        for pair, placed in zip((each for each in pairs if each.person == person.name), room.placed, strict=True):
            answer, (x, y, _), size = pair.answers[ability], placed.middle_m, 6.0
            colour = SOFT if answer.level is None else LEVEL_COLOURS[answer.level]
            axes.plot(x, y, "s" if answer.truth is Truth.NOBODY else "o", color=colour, markersize=size)
            if answer.is_wrong:
                axes.plot(x, y, "o", markersize=2 * size, markerfacecolor="none", markeredgecolor=WRONG, mew=1.5)
            elif answer.truth is Truth.DEBATABLE:
                axes.plot(x, y, ".", color="white", markersize=size / 2)
    marks = [Line2D([], [], marker="o", ls="", color=colour) for colour in LEVEL_COLOURS]
    marks += [Line2D([], [], marker="o", ls="", color=SOFT, mfc="none", mec=WRONG, ms=11)]
    marks += [Line2D([], [], marker=mark, ls="", color=INK) for mark in ("s", "o")]
    marks += [Line2D([], [], marker="o", ls="", mfc="white", mec=INK, ms=4)]
    names = [*(f"level {level}" for level in range(6)), "wrong", "nobody gets at it", "an able adult does", "debatable"]
    figure.legend(marks, names, loc="outside lower center", ncols=5, frameon=False, fontsize=8)
    return save_figure(figure, path)


def _draw_plan(axes: Axes, room: FurnishedRoom, person: Person) -> None:
    """Furniture as seen from above, everybody, and where one of them looks."""
    for piece in room.pieces:
        for box in sorted(piece.boxes, key=lambda box: box.top_m):
            x, y = box.centre_m[0] - box.size_m[0] / 2, box.centre_m[1] - box.size_m[1] / 2
            patch = Rectangle((x, y), *box.size_m[:2], linewidth=0.4, edgecolor=SOFT)
            patch.set_facecolor("none" if box.under_m > OVER_M else "#555555" if piece.kind == "wall" else "#ece3d4")
            turned = Affine2D().rotate(piece.yaw_rad).translate(*piece.centre_m)
            patch.set_transform(turned + axes.transData)
            axes.add_patch(patch)
    for each in room.people:
        x, y = each.position_m
        axes.add_patch(Circle((x, y), 0.2, facecolor="#7d9fc9" if each is person else "#dddddd", edgecolor=SOFT))
    x, y = person.position_m
    ahead = (x + 0.5 * math.cos(person.yaw_rad), y + 0.5 * math.sin(person.yaw_rad))
    axes.annotate("", ahead, (x, y), arrowprops={"arrowstyle": "->"})
    axes.set_title(person.name, fontsize=9)
    axes.set_xlim(-0.2, LENGTH_M + SECOND_M + 0.2)
    axes.set_ylim(-0.2, WIDTH_M + 0.2)
    axes.set_aspect("equal")
