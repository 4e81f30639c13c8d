"""Who holds by geometry agrees in time with who grips by force, on the real handovers (docs/research/holding.md)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from taskgist.errors import RecordingError
from taskgist_lab.paper import GripCheck, check_grips
from tests.shipped import names_of, observer, recording

LARGEST_MS, MOST_MS = 250.0, 120.0
TRACKED = ("handover_1", "handover_2", "handover_3", "handover_4")
"""In the fifth, the right hands were not tracked."""


@dataclass(frozen=True)
class Figures:
    """How far geometry and force differ: events in the air, mean and largest absolute difference, milliseconds."""

    events: int
    mean_ms: float
    largest_ms: float


def in_air() -> dict[str, tuple[GripCheck, ...]]:
    """By recording: the events at which the baton rested on nothing."""
    checks = {name: check_grips(recording(name), observer(name), "baton") for name in names_of("give")}
    return {name: tuple(each for each in found if not each.supported) for name, found in checks.items()}


def grip_figures() -> Figures:
    """The figures that docs/research/holding.md states."""
    differences = [abs(each.difference_ms) for checks in in_air().values() for each in checks]
    return Figures(len(differences), float(np.mean(differences)), max(differences))


def test_geometry_and_force_agree_in_the_air() -> None:
    figures = grip_figures()
    assert figures.events >= 2 * len(TRACKED), "in each, P2 takes and P1 lets go"
    assert figures.largest_ms < LARGEST_MS
    assert figures.mean_ms <= MOST_MS


@pytest.mark.parametrize("name", TRACKED)
def test_in_each_handover_the_passing_itself_was_measured(name: str) -> None:
    assert {("P2", "takes"), ("P1", "lets go")} <= {(each.agent, each.event) for each in in_air()[name]}


@pytest.mark.parametrize("name", TRACKED)
def test_events_come_in_order(name: str) -> None:
    for agent in ("P1", "P2"):
        taken, left = (each for each in check_grips(recording(name), observer(name), "baton") if each.agent == agent)
        assert (taken.event, left.event) == ("takes", "lets go")
        assert taken.by_force_s < left.by_force_s
        assert taken.by_geometry_s < left.by_geometry_s
        assert taken.difference_ms == pytest.approx(1000 * (taken.by_geometry_s - taken.by_force_s))


def test_without_forces_there_is_nothing_to_compare() -> None:
    with pytest.raises(RecordingError, match="signals: no grip forces; name them AGENT_grip"):
        check_grips(recording("hide_a"), observer("hide_a"), "cup")
