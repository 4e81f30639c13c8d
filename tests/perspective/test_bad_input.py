"""Bad input: clear errors or right answers, never a hang."""

import math
from dataclasses import replace

import pytest

from taskgist.errors import SceneError, TaskgistError
from taskgist.facts import UNKNOWN
from taskgist.observe import ability_observations
from taskgist.perspective import ABILITIES, Ability, Viewpoint, effort_from, least_effort, view_of, visibility
from taskgist.perspective.scene_efforts import SceneEfforts
from taskgist.world import Scene, Stage, holding_of
from tools.rooms import COARSE, Person, Room, Thing, table, wall

CUP = Thing("cup", (0.03, 0.05), (0.5, 0.2, 0.77), "cylinder")
P1 = Person("P1", (0.0, 0.0))


def edited(room: Room, file: str, old: str, new: str) -> dict[str, bytes]:
    """The room's files, with some text of one replaced."""
    files = dict(room.scene().bundle)
    text = files[file].decode()
    assert old in text
    files[file] = text.replace(old, new).encode()
    return files


def test_an_agent_inside_a_table_is_answered() -> None:
    """Where it stands it may stay, and leave; the table blocks what would go deeper."""
    stage = Room((table(0.0, height=0.9), replace(CUP, place=(0.35, 0.2, 0.95))), (P1,)).stage()
    levels = {ability: least_effort(stage, "P1", "cup", ability, COARSE).level for ability in ABILITIES}
    assert levels["reach"] == 1
    assert levels["see"] in (0, 1, 2)
    far = Room((table(0.0, height=0.9), replace(CUP, place=(1.4, 0.2, 0.95))), (P1,)).stage()
    assert least_effort(far, "P1", "cup", "reach", COARSE).level in (2, 4, 5)


def test_an_eye_inside_a_wall_sees_the_wall() -> None:
    block = wall("block", 0.0, half=(0.4, 0.4, 1.2))
    stage = Room((block, replace(CUP, place=(1.0, 0.0, 1.6))), (P1,)).stage()
    assert set(view_of(stage, "P1").pixels()) == {"block"}
    seen = visibility(stage, "P1", "cup")
    assert seen is not None
    assert seen.visible_px == 0 < seen.unoccluded_px
    assert seen.occluders == (("block", seen.unoccluded_px),)
    assert least_effort(stage, "P1", "cup", "see", COARSE).level in (2, 3, 4, 5)


def test_an_eye_inside_the_object_sees_it() -> None:
    stage = Room((Thing("box", (0.5, 0.5, 0.5), (0.0, 0.0, 1.6)),), (P1,)).stage()
    seen = visibility(stage, "P1", "box")
    assert seen is not None
    assert seen.visible_px == view_of(stage, "P1").pixels()["box"] > 0.5 * seen.image_px
    assert least_effort(stage, "P1", "box", "see", COARSE).level == 0


@pytest.mark.parametrize("size", [(0.0, 0.05), (-0.03, 0.05)])
def test_objects_without_size_are_refused(size: tuple[float, float]) -> None:
    with pytest.raises(SceneError, match=r"scene.toml.*size"):
        Room((replace(CUP, size=size),), (P1,)).scene()


def test_the_tiniest_object_is_answered() -> None:
    stage = Room((replace(CUP, size=(1e-3, 1e-3)),), (P1,)).stage()
    seen = visibility(stage, "P1", "cup")
    assert seen is not None
    assert seen.visible_px <= 1
    assert least_effort(stage, "P1", "cup", "reach", COARSE).level in (1, 2)


CYLINDER = '<geom type="cylinder" size="0.03 0.05" pos="0.0 0.0 0.0" />'
MASS = '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'


def test_objects_of_which_nothing_can_be_seen_are_refused() -> None:
    hull = '<geom type="box" size="0.1 0.1 0.1" group="3"/>'
    with pytest.raises(SceneError, match=r"without a shape that can be seen.*cup"):
        Scene.from_bundle(edited(Room((CUP,), (P1,)), "room.xml", CYLINDER, MASS + hull))


def test_all_about_an_object_without_geometry_is_unknown() -> None:
    box = Thing("box", (0.04, 0.04, 0.04), (0.6, 0.3, 1.1))
    scene = Scene.from_bundle(edited(Room((CUP, box), (P1,)), "room.xml", CYLINDER, MASS))
    stage = Stage(scene)
    assert scene.shapeless == {"cup"}
    assert visibility(stage, "P1", "cup") is None
    for ability in ABILITIES:
        effort = least_effort(stage, "P1", "cup", ability, COARSE)
        assert (effort.level, effort.reason) == (None, "cup has no shape")
        assert least_effort(stage, "P1", "box", ability, COARSE).level is not None
    assert SceneEfforts(Stage(scene), COARSE).all() == SceneEfforts(stage, COARSE).all()
    observations = ability_observations(stage, "P1", "cup", COARSE)
    assert {observation.value for observation in observations.values()} == {UNKNOWN}
    assert holding_of(stage, "cup", COARSE.contact) is None


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("image_px = [320, 240]", "image_px = [0, 240]", "image_px"),
        ("image_px = [320, 240]", "image_px = [320, -1]", "image_px"),
        ("image_px = [320, 240]", "image_px = [32.5, 24]", "image_px"),
        ("fov_deg = [120, 105]", "fov_deg = [0, 105]", "fov_deg"),
        ("fov_deg = [120, 105]", "fov_deg = [120, 180]", "fov_deg"),
        ('joint = "head_pan"', 'joint = "neck_pan"', "neck_pan"),
        ('site = "eye"', 'site = "third_eye"', "third_eye"),
        ('palm = "left_palm"', 'palm = "left_paw"', "left_paw"),
    ],
)
def test_profiles_that_cannot_be_are_refused_by_name(old: str, new: str, says: str) -> None:
    with pytest.raises(TaskgistError, match=says):
        Scene.from_bundle(edited(Room((CUP,), (P1,)), "P1.profile.toml", old, new))


def test_an_image_of_one_pixel_is_an_image() -> None:
    stage = Room((replace(CUP, size=(0.3, 0.3), place=(1.0, 0.0, 1.6)),), (P1,), (1, 1)).stage()
    seen = visibility(stage, "P1", "cup")
    assert seen is not None
    assert seen.image_px == 1
    assert 0 < seen.visible_px == seen.gaze_px == seen.unoccluded_px < 1
    assert view_of(stage, "P1").geoms.shape == (1, 1)


@pytest.fixture(scope="module")
def crowded() -> Stage:
    """Two thousand balls on a floor, and one at hand."""
    floor = [
        Thing(f"ball {n}", (0.02,), (0.5 + 0.05 * (n % 50), 0.05 * (n // 50) - 1.0, 0.02), "sphere")
        for n in range(2000)
    ]
    return Room((*floor, Thing("near", (0.03,), (0.5, 0.1, 1.1), "sphere")), (P1,), (80, 60)).stage()


@pytest.mark.parametrize(("ability", "level"), [("see", {0, 1}), ("reach", {1}), ("grasp", {1})])
def test_two_thousand_objects_are_answered(crowded: Stage, ability: Ability, level: set[int]) -> None:
    here = Viewpoint(crowded, "P1", COARSE)
    assert effort_from(here, "near", ability).level in level
    assert effort_from(here, "ball 777", ability).level in {0, 1, 2, 4, 5}


def test_far_away_is_out_of_reach_and_not_forever() -> None:
    stage = Room((replace(CUP, place=(1e6, 0.0, 1.0)),), (P1,)).stage()
    for ability in ABILITIES:
        assert least_effort(stage, "P1", "cup", ability, COARSE).level == 5


def test_a_place_that_is_no_number_is_refused() -> None:
    with pytest.raises(TaskgistError):
        Room((CUP,), (replace(P1, place=(math.nan, 0.0)),)).scene()
