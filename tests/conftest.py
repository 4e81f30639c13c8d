"""What tests of several rooms share.

Property tests draw the same examples in every run, and are never judged by the clock of a busy machine.
"""

import gc

import pytest
from hypothesis import HealthCheck, settings

slow = [HealthCheck.too_slow]
settings.register_profile("seeded", derandomize=True, deadline=None, database=None, suppress_health_check=slow)
settings.load_profile("seeded")


gc.set_threshold(20_000, 20, 50)


def pytest_collection_finish() -> None:
    """Eight thousand tests and all modules stay: the garbage collector need not look through them again and again."""
    gc.collect()
    gc.freeze()


@pytest.fixture
def coarse_maps(monkeypatch: pytest.MonkeyPatch) -> None:
    """Cells three times as long as usual: what a command does with its map is the same."""
    from taskgist.maps.grid import Grid
    from taskgist.settings import Maps
    from taskgist.world import Stage

    around = Grid.around

    def coarse(stage: Stage, *agents: str, **_: object) -> Grid:
        return around(stage, *agents, settings=Maps(cell_m=0.15))

    monkeypatch.setattr(Grid, "around", staticmethod(coarse))


@pytest.fixture
def coarse_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """An eighth of the rays: a picture is as large as ever, and shows the same where it is the same."""
    from taskgist.view import scene

    monkeypatch.setattr(scene, "SMOOTHING", 1)
    monkeypatch.setattr(scene, "EYE_WIDTH_PX", scene.EYE_WIDTH_PX // 2)
    monkeypatch.setattr(scene, "OUTSIDE_WIDTH_PX", scene.OUTSIDE_WIDTH_PX // 2)
