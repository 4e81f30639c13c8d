"""Pixels against projections worked out by hand."""

import math
from itertools import product

import numpy as np
import pytest

from taskgist.perspective import view_of, visibility
from taskgist.world import Scene, Stage
from tools.rooms import Person, Room, Thing, table, wall

WIDTH, HEIGHT = 320, 240
EYE = Person("P1", (0.0, 0.0))


def focal_px() -> tuple[float, float]:
    return WIDTH / 2 / math.tan(math.radians(60)), HEIGHT / 2 / math.tan(math.radians(52.5))


def in_eye(stage: Stage, points: np.ndarray) -> np.ndarray:
    return stage.eye(stage.scene.agent("P1")).to_local(points)


def box_pixels(corners_in_eye: np.ndarray) -> int:
    """Pixel centres inside the convex outline of a box's projected corners."""
    fx, fy = focal_px()
    points = [(-y / x * fx, -z / x * fy) for x, y, z in corners_in_eye]
    hull = convex_hull(points)
    columns = np.arange(WIDTH) + 0.5 - WIDTH / 2
    rows = np.arange(HEIGHT) + 0.5 - HEIGHT / 2
    u, v = np.meshgrid(columns, rows)
    inside = np.ones_like(u, dtype=bool)
    for (ax, ay), (bx, by) in zip(hull, hull[1:] + hull[:1], strict=True):
        inside &= (bx - ax) * (v - ay) - (by - ay) * (u - ax) >= 0
    return int(inside.sum())


def convex_hull(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Andrew's monotone chain, counter-clockwise."""

    def half(ordered: list[tuple[float, float]]) -> list[tuple[float, float]]:
        chain: list[tuple[float, float]] = []
        for p in ordered:
            while len(chain) > 1 and cross(chain[-2], chain[-1], p) <= 0:
                chain.pop()
            chain.append(p)
        return chain[:-1]

    ordered = sorted(points)
    return half(ordered) + half(ordered[::-1])


def cross(o: tuple[float, float], a: tuple[float, float], b: tuple[float, float]) -> float:
    return (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])


@pytest.mark.parametrize("seed", range(8))
def test_a_box_covers_the_pixels_of_its_projected_outline(seed: int) -> None:
    rng = np.random.default_rng(seed)
    size = tuple(rng.uniform(0.1, 0.3, 3))
    brick = Thing(
        "brick", size, (rng.uniform(0.8, 3), rng.uniform(-1, 1), rng.uniform(1.2, 2.2)), yaw=rng.uniform(-3, 3)
    )
    stage = Room((brick,), (EYE,)).stage()
    pose = stage.geom(int(stage.scene.object_geoms("brick")[0]))
    corners = pose.to_world(np.array(list(product((-1, 1), repeat=3))) * size)
    seen = visibility(stage, "P1", "brick")
    assert seen is not None
    assert seen.visible_px > 0
    assert seen.visible_px == box_pixels(in_eye(stage, corners))


@pytest.mark.parametrize("seed", range(4))
def test_a_ball_covers_the_pixels_of_its_cone(seed: int) -> None:
    rng = np.random.default_rng(100 + seed)
    radius, place = rng.uniform(0.2, 0.4), (rng.uniform(0.7, 3), rng.uniform(-1, 1), rng.uniform(1.2, 2.2))
    stage = Room((Thing("ball", (radius,), place, "sphere"),), (EYE,)).stage()
    center = in_eye(stage, np.array(place))
    fx, fy = focal_px()
    u, v = np.meshgrid((np.arange(WIDTH) + 0.5 - WIDTH / 2) / fx, (np.arange(HEIGHT) + 0.5 - HEIGHT / 2) / fy)
    along = (center[0] - u * center[1] - v * center[2]) / np.sqrt(1 + u * u + v * v)
    expected = int((along >= math.sqrt(center @ center - radius**2)).sum())
    seen = visibility(stage, "P1", "ball")
    assert seen is not None
    assert seen.visible_px == expected > 0


def test_visible_pixels_of_all_owners_and_nothing_sum_to_the_image() -> None:
    room = Room((table(0.9), wall("wall", 3.0), Thing("cup", (0.1,), (0.8, 0, 1.0), "sphere")), (EYE,))
    counts = view_of(room.stage(), "P1").pixels()
    assert set(counts) >= {None, "floor", "table", "wall", "cup"}
    assert sum(counts.values()) == WIDTH * HEIGHT


def test_the_body_around_the_eye_is_looked_through() -> None:
    """An eye that sits inside of the head sees what an eye on its surface sees, from a little farther back."""
    files = dict(Room((Thing("brick", (0.2, 0.2, 0.2), (1.5, 0, 1.6)),), (EYE,)).scene().bundle)
    model = files["P1.model.xml"].decode()
    start = model.index('<site name="eye" pos="') + len('<site name="eye" pos="')
    files["P1.model.xml"] = (model[:start] + "0 0 0.1" + model[model.index('"', start) :]).encode()
    stage = Stage(Scene.from_bundle(files))
    assert stage.cast(stage.eye(stage.scene.agent("P1")).position, [(1.0, 0.0, 0.0)])[1][0] < 0.2
    seen = visibility(stage, "P1", "brick")
    assert seen is not None
    assert seen.visible_px == view_of(stage, "P1").pixels()["brick"] > 0
    assert "P1" not in view_of(stage, "P1").pixels()


@pytest.mark.parametrize("seed", range(6))
def test_a_board_before_the_nose_fills_the_image_as_it_should(seed: int) -> None:
    """The eye is inside of the board's bounding sphere, so its window is all that is ahead."""
    rng = np.random.default_rng(seed)
    place = (rng.uniform(0.2, 0.4), rng.uniform(-0.6, 0.6), rng.uniform(1.3, 1.9))
    stage = Room((Thing("board", (0.01, 0.7, 0.4), place, yaw=rng.uniform(-2, 2)),), (EYE,)).stage()
    seen = visibility(stage, "P1", "board")
    assert seen is not None
    assert seen.visible_px == view_of(stage, "P1").pixels().get("board", 0)


def test_left_is_left_and_up_is_up() -> None:
    things = (Thing("left", (0.1,), (1.5, 0.5, 1.64), "sphere"), Thing("above", (0.1,), (1.5, 0.0, 2.1), "sphere"))
    stage = Room(things, (EYE,)).stage()
    view = view_of(stage, "P1")
    left = np.argwhere(np.isin(view.geoms, stage.scene.object_geoms("left")))
    above = np.argwhere(np.isin(view.geoms, stage.scene.object_geoms("above")))
    assert left[:, 1].max() < WIDTH / 2
    assert above[:, 0].max() < HEIGHT / 2


def test_own_hands_occlude() -> None:
    cup = Thing("cup", (0.04, 0.05), (0.75, 0.0, 1.45), "cylinder")
    raised = Person("P1", (0, 0), joints_deg=(("right_shoulder_flexion", 100), ("right_girdle_protraction", 20)))
    free = visibility(Room((cup,), (EYE,)).stage(), "P1", "cup")
    behind = [visibility(Room((cup,), (raise_to(raised, turn),)).stage(), "P1", "cup") for turn in range(-50, 1, 5)]
    assert free is not None
    assert free.occluders == ()
    assert any(seen is not None and "P1" in dict(seen.occluders) for seen in behind)


def raise_to(person: Person, abduction_deg: float) -> Person:
    joints = (*person.joints_deg, ("right_shoulder_abduction", abduction_deg))
    return Person(person.name, person.place, joints_deg=joints)
