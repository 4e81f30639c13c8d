"""A picture of the hypothesis tree: what is kept, what was pruned, and after how many demonstrations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch

from taskgist.facts import HypothesisTree, Node
from taskgist.learning import Understanding
from taskgist.view.saving import save_figure

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
