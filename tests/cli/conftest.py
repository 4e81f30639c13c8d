"""What tests of commands share."""

from __future__ import annotations

import pytest

from taskgist.maps.grid import Grid
from taskgist.settings import Maps
from taskgist.world import Stage

COARSE = Maps(cell_m=0.15)


@pytest.fixture
def coarse_maps(monkeypatch: pytest.MonkeyPatch) -> None:
    """Cells three times as long as usual: what a command does with its map is the same."""
    around = Grid.around

    def coarse(stage: Stage, *agents: str, **_: object) -> Grid:
        return around(stage, *agents, settings=COARSE)

    monkeypatch.setattr(Grid, "around", staticmethod(coarse))
