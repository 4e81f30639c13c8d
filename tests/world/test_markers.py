"""Markers beside landmarks: where they are, how they move, and a fit that meets them."""

from __future__ import annotations

import mink
import numpy as np
import pytest

from taskgist.errors import UnknownNameError
from taskgist.world import Fitter, Stage
from taskgist.world.fit import FixedPoints, Marker, PointsTask
from tests.scenes import agent, scene

OFFSETS_M = np.array([[0.05, -0.03, -0.10], [0.0, 0.07, 0.0], [0.0, 0.0, 0.0]])


def test_jacobians_are_what_a_small_step_does() -> None:
    room = scene(agents=agent("P1", 0.0, 0.0))
    sites = [room.model.site(f"P1/{name}").id for name in ("left_wrist", "right_elbow", "nose")]
    frames = [sites[0], room.model.site("P1/right_shoulder").id, sites[2]]
    points = FixedPoints(tuple(sites), tuple(frames), OFFSETS_M)
    task = PointsTask(points, np.zeros((3, 3)), np.ones(3))
    configuration = mink.Configuration(room.model)
    rng = np.random.default_rng(2)
    configuration.update(room.initial.qpos)
    configuration.integrate_inplace(rng.normal(0.0, 0.3, room.model.nv), 1.0)
    before, jacobian = task.compute_error(configuration), task.compute_jacobian(configuration)
    step = rng.normal(0.0, 1e-5, room.model.nv)
    configuration.integrate_inplace(step, 1.0)
    np.testing.assert_allclose(task.compute_error(configuration) - before, jacobian @ step, atol=1e-8)


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
