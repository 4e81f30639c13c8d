"""Small and far things: measured without bias, seen from a least size on, and told alike whatever the noise."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from taskgist.facts.standard import compare_scores
from taskgist.facts.values import NEGLIGIBLE, score_bin
from taskgist.facts.vocabulary import ALMOST_SAME
from taskgist.language.efforts import why
from taskgist.perspective import Viewpoint, Visibility, effort_from, least_effort, visibility
from taskgist.perspective.effort import Reason
from taskgist.settings import DEFAULT, Settings, Vision
from taskgist.world import Scene, Stage, State
from tools.rooms import Person, Room, Thing

Array = NDArray[np.float64]
Generator = np.random.Generator
P1 = Person("P1", (0.0, 0.0))
FOCAL_PX = (160 / math.tan(math.radians(60)), 120 / math.tan(math.radians(52.5)))
ARCMIN_RAD = math.radians(1 / 60)
NOISE_M, NOISE_RAD = 0.002, math.radians(0.3)
HEAD_ONLY = ("Pan_Head", "Tilt_Head")


def seen(stage: Stage, name: str = "thing", settings: Settings = DEFAULT) -> Visibility:
    found = visibility(stage, "P1", name, settings)
    assert found is not None
    return found


def put(scene: Scene, name: str, place: Array) -> State:
    """A thing elsewhere, upright."""
    return scene.initial.replace(at=scene.object_slice(name), to=(*place, 1.0, 0.0, 0.0, 0.0))


def ball_px(radius_m: float, center: Array) -> float:
    """Area of a ball's image, an ellipse: exact. The centre is in the eye's frame."""
    distance = float(np.linalg.norm(center))
    sine, cosine = radius_m / distance, center[0] / distance
    half_minor = sine / math.sqrt(cosine**2 - sine**2)
    half_major = sine * math.sqrt(1 - sine**2) / (cosine**2 - sine**2)
    return float(math.pi * half_minor * half_major * FOCAL_PX[0] * FOCAL_PX[1])


# area ---------------------------------------------------------------------------------------------------------


def test_the_area_of_small_balls_is_right() -> None:
    """Against the ellipse that a ball's image is: each one nearly, all together without bias."""
    stage, rng = Room((Thing("thing", (0.02,), (1, 0, 1), "sphere"),), (P1,)).stage(), np.random.default_rng(1)
    eye, shares = stage.eye(stage.scene.agent("P1")), list[float]()
    for _ in range(400):
        center = rng.uniform(0.8, 8.0) * np.array((1.0, rng.uniform(-1, 1), rng.uniform(-0.8, 0.8)))
        exact = ball_px(0.02, center)
        shares.append(seen(stage.show(put(stage.scene, "thing", eye.to_world(center)))).unoccluded_px / exact)
    assert np.abs(np.array(shares) - 1).max() < 0.08
    assert np.std(shares) < 0.02
    assert abs(np.mean(shares) - 1) < 0.003


@pytest.mark.parametrize("size", [(0.0005, 0.004, 0.08), (0.0005, 0.08, 0.004), (0.0005, 0.05, 0.05)])
def test_the_area_of_thin_things_along_the_rows_is_right(size: tuple[float, float, float]) -> None:
    """A pencil upright, one that lies, and a plate, all facing the eye: no row of pixels is met or missed at once."""
    stage, rng = Room((Thing("thing", size, (1, 0, 1)),), (P1,)).stage(), np.random.default_rng(2)
    eye, shares = stage.eye(stage.scene.agent("P1")), list[float]()
    for _ in range(150):
        ahead = rng.uniform(1.5, 6.0)
        place = eye.position + (ahead, ahead * rng.uniform(-0.02, 0.02), ahead * rng.uniform(-0.02, 0.02))
        exact = 4 * size[1] * size[2] / (ahead - size[0]) ** 2 * FOCAL_PX[0] * FOCAL_PX[1]
        shares.append(seen(stage.show(put(stage.scene, "thing", place))).visible_px / exact)
    assert np.abs(np.array(shares) - 1).max() < 0.1
    assert abs(np.mean(shares) - 1) < 0.01


def test_left_and_right_are_mirrored() -> None:
    for y in (0.1, 0.37, 1.03):
        things = tuple(
            Thing(side, (0.02, 0.01, 0.03), (2.0, sign * y, 1.3), yaw=sign * 0.4)
            for side, sign in (("left", 1), ("right", -1))
        )
        stage = Room(things, (P1,)).stage()
        assert seen(stage, "left").visible_px == seen(stage, "right").visible_px > 0


# seen or not --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("radius_m", "ahead_m"), [(0.01, 3.0), (0.04, 6.0), (0.002, 0.7), (0.01, 9.0)])
def test_small_things_in_plain_view_are_seen(radius_m: float, ahead_m: float) -> None:
    """A key three metres away, a ball at six; not by luck, so wherever they are by a little."""
    for y in np.linspace(-0.1, 0.1, 7):
        stage = Room((Thing("thing", (radius_m,), (ahead_m, float(y), 1.6), "sphere"),), (P1,)).stage()
        assert least_effort(stage, "P1", "thing", "see").level == 0
        score = seen(stage).score
        assert score > 0
        assert score_bin(score, DEFAULT.vision) != NEGLIGIBLE


def of_area(arcmin2: float, ahead_m: float) -> Room:
    """A ball that has this solid angle, seen from P1."""
    radius_m = ahead_m * math.sqrt(arcmin2 / math.pi) * ARCMIN_RAD
    return Room((Thing("thing", (radius_m,), (ahead_m, 0.05, 1.62), "sphere"),), (P1,))


@pytest.mark.parametrize("ahead_m", [1.0, 4.0])
def test_what_is_too_small_is_not_seen(ahead_m: float) -> None:
    least = DEFAULT.vision.least_visible_arcmin2
    assert seen(of_area(1.25 * least, ahead_m).stage()).visible_px > 0
    stage = of_area(0.8 * least, ahead_m).stage()
    found = seen(stage)
    assert (found.visible_px, found.gaze_px, found.nearest_m, found.score) == (0, 0, None, 0)
    assert found.unoccluded_px > 0
    effort = effort_from(Viewpoint(stage, "P1", actions=HEAD_ONLY), "thing", "see")
    assert effort.level == 5
    assert effort.evidence.told is not None
    assert effort.evidence.told.reason is Reason.TOO_SMALL
    assert "too small to be made out" in why(effort)


def test_how_small_is_a_setting() -> None:
    stage = of_area(300.0, 2.0).stage()
    dull = replace(DEFAULT, vision=replace(DEFAULT.vision, least_visible_arcmin2=900.0))
    assert seen(stage).visible_px > 0 == seen(stage, settings=dull).visible_px
    assert least_effort(stage, "P1", "thing", "see").level == 0
    assert least_effort(stage, "P1", "thing", "see", dull).level == 4
    assert dull.digest != DEFAULT.digest


def test_nothing_that_is_seen_is_negligible() -> None:
    """The least that a person makes out lies at the first bin, in the middle of the image and at its margin."""
    vision = Vision()
    pixel_sr = 1 / (FOCAL_PX[0] * FOCAL_PX[1])
    least_score = vision.least_visible_arcmin2 * ARCMIN_RAD**2 / pixel_sr / (320 * 240)
    assert vision.negligible_score == pytest.approx(least_score, rel=0.05)


def test_most_of_a_thing_hidden_leaves_too_little() -> None:
    """A sliver that is smaller than what is made out: the board is named."""
    ball, board = (
        Thing("thing", (0.01,), (3.0, 0.0, 1.62), "sphere"),
        Thing("board", (0.005, 0.3, 0.3), (2.9, 0.0, 1.6)),
    )
    scene = Room((ball, board), (P1,)).scene()
    eye = Stage(scene).eye(scene.agent("P1"))
    edge = (2.895 - eye.position[0]) / (3.0 - eye.position[0]) * 0.0098
    stage = Stage(scene, put(scene, "board", np.array((2.9, edge - 0.3, 1.6))))
    found = seen(stage)
    assert found.visible_px == 0 < found.unoccluded_px
    assert [owner for owner, _ in found.occluders] == ["board"]
    effort = effort_from(Viewpoint(stage, "P1", actions=HEAD_ONLY), "thing", "see")
    assert effort.evidence.told is not None
    assert effort.evidence.told.reason is Reason.OCCLUDED


# noise --------------------------------------------------------------------------------------------------------


def noisy(scene: Scene, state: State, rng: Generator) -> State:
    """As a tracker would have it: everything 2 mm and 0.3° off."""
    frames = [scene.object_slice(name) for name in scene.objects] + [scene.base_slice("P1")]
    for frame in frames:
        pose = state.qpos[frame] + (*rng.normal(0, NOISE_M, 3), 0, *rng.normal(0, NOISE_RAD / 2, 3))
        pose[3:] /= np.linalg.norm(pose[3:])
        state = state.replace(at=frame, to=pose)
    return state


def test_noise_changes_no_class_of_a_small_thing() -> None:
    """A tracker's noise is no change of visibility: at most one in a hundred. (It was two in five.)"""
    rng, wrong, count, smallest, things = np.random.default_rng(3), 0, 200, math.inf, list[Thing]()
    for number in range(8):
        kind = ("box", "cylinder", "sphere", "capsule")[number % 4]
        size = tuple(rng.uniform(0.006, 0.05, {"box": 3, "sphere": 1}.get(kind, 2)))
        things.append(Thing(f"{number}", size, (-5.0 - number, 0.0, 1.0), kind, rng.uniform(-3, 3)))
    stage = Room(tuple(things), (P1,)).stage()
    for number in range(count):
        name = f"{number % 8}"
        place = rng.uniform(1.5, 6.0) * np.array((1.0, rng.uniform(-0.5, 0.5), 0.0)) + (0.0, 0.0, rng.uniform(1.0, 1.8))
        state = put(stage.scene, name, place)
        before, after = (seen(stage.show(noisy(stage.scene, state, rng)), name) for _ in range(2))
        wrong += compare_scores(before.score, after.score, DEFAULT) != ALMOST_SAME
        smallest = min(smallest, before.visible_px)
    assert wrong <= 0.01 * count
    assert smallest < 0.3


def test_noise_changes_few_classes_of_a_small_thing_that_is_half_hidden() -> None:
    """Where less than a quarter of what is to be seen has come or gone, known from the edges, the class says so."""
    rng, wrong, count, half = np.random.default_rng(4), 0, 0, np.array((0.0005, 0.03, 0.02))
    plate, board = Thing("thing", tuple(half), (2, 0, 1.6)), Thing("board", (0.0005, 0.4, 0.4), (1, 0, 1.6))
    stage = Room((plate, board), (P1,)).stage()
    scene, eye = stage.scene, stage.eye(stage.scene.agent("P1")).position
    for _ in range(150):
        place = np.array((rng.uniform(1.5, 5.0), 0.0, 1.63))
        edge = eye + 0.95 * (place - eye)
        state = put(scene, "thing", place).replace(
            at=scene.object_slice("board"), to=(*(edge - (0.0, 0.4, 0.0)), 1.0, 0.0, 0.0, 0.0)
        )
        before, after = (free_and_seen(stage.show(noisy(scene, state, rng)), half) for _ in range(2))
        if compare_scores(before[0], after[0], DEFAULT) == ALMOST_SAME:
            count += 1
            wrong += compare_scores(before[1], after[1], DEFAULT) != ALMOST_SAME
    assert count > 90
    assert wrong <= 0.05 * count


def free_and_seen(stage: Stage, half: Array) -> tuple[float, float]:
    """Share of an upright plate beside the board's left edge, straight from where they are; and its score."""
    eye = stage.eye(stage.scene.agent("P1")).position
    plate, board = (stage.geom(int(stage.scene.object_geoms(name)[0])) for name in ("thing", "board"))
    left, right = (plate.to_world(np.array((-half[0], side * half[1], 0.0))) - eye for side in (1, -1))
    edge = board.to_world(np.array((0.0005, 0.4, 0.0))) - eye
    low, high, hidden = right[1] / right[0], left[1] / left[0], edge[1] / edge[0]
    return float((high - min(max(hidden, low), high)) / (high - low)), seen(stage).score
