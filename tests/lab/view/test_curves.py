"""Pictures of evaluations."""

from __future__ import annotations

from pathlib import Path

import matplotlib.image
import numpy as np
import pytest

from taskgist.errors import InputError
from taskgist_lab.evaluation.experiments import CLAUSE, demonstrations_needed, transfer
from taskgist_lab.evaluation.learner import RULES, Coded
from taskgist_lab.evaluation.recognition import OURS, RecognitionScore, RecognitionScores, Reliable
from taskgist_lab.evaluation.robustness import compared, robustness
from taskgist_lab.evaluation.values import Result, Spread
from taskgist_lab.view import TABLES_AFTER, draw_needs, draw_robustness, draw_transfer, picture_of
from tests.lab.evaluation.pools import study_pool

CODED = Coded.of(study_pool(18))
NEEDS = demonstrations_needed(CODED, runs=5, seed=0)
TRANSFER = transfer(CODED, runs=5, seed=0)
ROBUSTNESS = robustness(CODED, runs=3, seed=0, rules=(RULES["paper"], RULES["wide-asked"]))
COMPARISON = compared(CODED, runs=3, seed=0, peers={})
RECOGNISED = RecognitionScores(
    tuple(
        RecognitionScore(OURS, after, *(Spread.of([share]) for _ in range(8))) for after, share in ((1, 0.5), (10, 0.9))
    ),
    tuple(Reliable(OURS, 10, low, low + 0.05, low, 0.1) for low in (0.0, 0.5, 0.9)),
    {},
    1,
)


@pytest.mark.parametrize(
    "result", [NEEDS, TRANSFER, ROBUSTNESS, COMPARISON, RECOGNISED], ids=lambda each: type(each).__name__
)
def test_pictures_are_saved_with_something_on_them(result: Result, tmp_path: Path) -> None:
    path = picture_of(result, tmp_path / "picture.png")
    pixels = matplotlib.image.imread(path)[:, :, :3]
    assert pixels.shape[1] <= 1300
    assert 0.005 < np.mean(pixels.min(axis=2) < 0.5) < 0.5
    assert path.read_bytes() == picture_of(result, tmp_path / "again.png").read_bytes()


def test_curves_are_the_rows() -> None:
    figure = draw_needs(NEEDS)
    panel = next(axes for axes in figure.axes if axes.get_title() == "hide away")
    by_label = {str(line.get_label()): line for line in panel.lines}
    assert list(by_label["all three"].get_ydata()) == list(NEEDS.row("hide away").curve)  # type: ignore[arg-type]
    assert list(by_label["see"].get_ydata()) == list(NEEDS.row("hide away", "see").curve)  # type: ignore[arg-type]


def test_tables_have_a_number_in_each_cell() -> None:
    figure = draw_transfer(TRANSFER)
    for panel, after in zip(figure.axes, TABLES_AFTER, strict=True):
        true = TRANSFER.table(after, CLAUSE).true
        assert [text.get_text() for text in panel.texts] == [f"{share:.0%}" for row in true for share in row]


def test_each_rule_has_a_dot_in_each_setting() -> None:
    figure = draw_robustness(ROBUSTNESS)
    lines = [line for line in figure.axes[0].lines if line.get_marker() == "o"]
    assert [line.get_label() for line in lines] == ["paper", "wide-asked"]
    assert {len(np.asarray(line.get_xdata())) for line in lines} == {len({o.setting for o in ROBUSTNESS.outcomes})}


def test_a_folder_that_is_not_there_is_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be written"):
        picture_of(NEEDS, tmp_path / "none" / "picture.png")
