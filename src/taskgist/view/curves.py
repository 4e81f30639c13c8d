"""Pictures of evaluations: learning curves, tables of truth, robustness, peers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from taskgist.study.evaluation.comparison import Comparison
from taskgist.study.evaluation.holding import Table
from taskgist.study.evaluation.needed import Needs
from taskgist.study.evaluation.result import Result
from taskgist.study.evaluation.robustness import Robustness
from taskgist.study.evaluation.setting import SETTINGS
from taskgist.study.evaluation.transfer import CLAUSE, Transfer
from taskgist.study.intuition import COLUMNS
from taskgist.view.saving import save_figure

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
    """A panel for each task: share of draws that have each cell of Table 4, by demonstrations."""
    tasks = tuple(dict.fromkeys(row.task for row in needs.rows))
    figure = Figure(figsize=(10.5, 5.8), layout="constrained")
    panels = figure.subplots(2, -(-len(tasks) // 2), sharex=True, sharey=True, squeeze=False).ravel()
    for panel, task in zip(panels, tasks, strict=False):
        _curves(panel, needs, task)
    for panel in panels[len(tasks) :]:
        panel.set_axis_off()
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=5, frameon=False)
    figure.supxlabel("demonstrations")
    figure.supylabel("share of draws")
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
}
"""What draws each kind of result."""
