"""Contact sheets: many demonstrations at a glance, the end of each one seen from outside."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from matplotlib.figure import Figure

from taskgist.recording import Recording
from taskgist.view.outside import camera_outside, draw_outside
from taskgist.view.saving import save_figure
from taskgist.world import Stage

MOST, COLUMNS = 12, 4
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
    columns = min(COLUMNS, len(shown))
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
        camera = camera_outside(stage, (state,), recording.label.target_object, width_px=PICTURE_PX)
        draw_outside(axes, stage, camera, recording.label, name)
    return save_figure(figure, path)
