"""Who takes a mug from whom, and when, however the hands tremble; live as well (docs/research/holding.md has more)."""

from __future__ import annotations

import pytest

from taskgist.observe import Observer
from taskgist.recognition import grips_of, propose_label
from taskgist.recording import Recording
from tests.importing.noisy_takes import CHANGES_S, take
from tools.holding_page import carriers

KINDS = [(hands_m, lasts_s, seed) for hands_m in (0.02, 0.05) for lasts_s in (0.0, 0.15) for seed in (100, 101)]


@pytest.fixture(scope="module")
def takes(tmp_path_factory: pytest.TempPathFactory) -> dict[tuple[float, float, int], Recording]:
    return {
        (hands_m, lasts_s, seed): take(
            tmp_path_factory.mktemp("take"), hands_m=hands_m, correlated_s=lasts_s, seed=seed
        )
        for hands_m, lasts_s, seed in KINDS
    }


@pytest.mark.parametrize("kind", KINDS)
def test_the_roles_are_right_and_the_change_of_hands_is_close(
    takes: dict[tuple[float, float, int], Recording], kind: tuple[float, float, int]
) -> None:
    recording = takes[kind]
    observer = Observer(recording.scene, recording)
    label = propose_label(recording, observer)
    assert (label.task, label.performing_agent, label.target_agent) == ("give", "P1", "P2")
    first, *_, last = grips_of(observer, "mug")
    assert (first.agent, first.side, last.agent, last.side) == ("P1", "right", "P2", "right")
    assert (first.end_s + last.start_s) / 2 == pytest.approx(CHANGES_S, abs=0.3)


def test_live_nearly_the_same_is_said(takes: dict[tuple[float, float, int], Recording]) -> None:
    same = [
        one == other
        for recording in takes.values()
        for one, other in zip(carriers(recording, whole=True), carriers(recording, whole=False), strict=True)
    ]
    assert sum(same) >= 0.98 * len(same)
