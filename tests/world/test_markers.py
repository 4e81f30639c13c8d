"""Markers beside landmarks: a fit that meets them. How they move is held to a witness in ``test_fit_steps``."""

from __future__ import annotations

import numpy as np
import pytest

from taskgist.errors import UnknownNameError
from taskgist.world import Fitter, Stage
from taskgist.world.fit import Marker
from tests.scenes import agent, scene


def test_a_fit_brings_the_marker_to_its_target() -> None:
    """A marker on the back of the wrist: the wrist itself ends beside the target, by the offset."""
    room = scene(agents=agent("P1", 0.0, 0.0))
    marker = Marker("right_wrist", (0.0, -0.04, -0.02))
    start = Stage(room, room.initial).site(room.model.site("P1/right_wrist").id).position
    target = start + (0.25, 0.05, 0.2)
    fitter = Fitter(room, "P1", moving="arms", markers={"band": marker})
    fit = fitter.fit(room.initial, points={"band": target}, iterations=60)
    assert fit.errors_m["band"] < 0.002
    wrist = Stage(room, fit.state).site(room.model.site("P1/right_wrist").id).position
    assert np.linalg.norm(wrist - target) == pytest.approx(np.linalg.norm(marker.offset_m), abs=0.002)


def test_a_marker_needs_a_landmark() -> None:
    room = scene(agents=agent("P1", 0.0, 0.0))
    fitter = Fitter(room, "P1", markers={"band": Marker("right_rist", (0.0, 0.0, 0.0))})
    with pytest.raises(UnknownNameError, match="did you mean 'right_wrist'"):
        fitter.fit(room.initial, points={"band": (0.0, 0.0, 1.0)})
