"""The fast search agrees exactly with the slow one, and the window with the whole image.

In a few random rooms, which together have every level; ``make twins`` compares levels and pixels in hundreds,
``python -m tools.twins --fine`` in the steps of the default settings.
"""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from taskgist.perspective import ABILITIES, Viewpoint, effort_from, visibility
from taskgist.settings import DEFAULT
from tests.perspective.comparing import Comparison, compare_levels, compare_pixels
from tests.perspective.random_rooms import random_case
from tests.perspective.twin import Twin, disagreement
from tests.perspective.twin_world import SEEN_MASK, World, pixel_rays
from tools.rooms import ROUGH, Person, Room, Thing, chair, random_room, table, wall

SHORT = replace(DEFAULT.efforts, move_radius_m=0.75, bends=DEFAULT.efforts.bends[::5])
FINE = replace(DEFAULT, reach=ROUGH.reach, efforts=SHORT)
"""The steps of the default settings, over fewer places and bends: all of them would take the twin an hour."""
CUP = Thing("cup", (0.03, 0.05), (0.5, 0.2, 1.75), "cylinder")
ROOMS = {
    **{f"random {seed}": random_room(seed) for seed in range(4)},
    "high": Room((chair(0.0), CUP), (Person("P1", (0, 0), 0.0, "sitting"),), (64, 48)),
    "behind a low wall": Room(
        (chair(0.0), wall("wall", 0.9, half=(0.02, 0.8, 0.7)), replace(CUP, place=(2.2, 0.1, 0.9))),
        (Person("P1", (0, 0), 0.0, "sitting"),),
        (64, 48),
    ),
    "behind a high wall": Room(
        (wall("wall", 0.6, half=(0.02, 0.35, 1.2)), replace(CUP, place=(1.3, 0.1, 1.1))),
        (Person("P1", (0, 0)),),
        (64, 48),
    ),
    "far": Room((replace(CUP, place=(1.7, 0.3, 1.1)),), (Person("P1", (0, 0)),), (64, 48)),
    "low, with a seat": Room(
        (chair(-0.45), wall("wall", 0.8, half=(0.02, 0.9, 0.6)), replace(CUP, place=(0.5, 0.1, 0.2))),
        (Person("P1", (0, 0)),),
        (64, 48),
    ),
    "in a block": Room(
        (wall("wall", 0.5, half=(0.3, 0.3, 0.7)), replace(CUP, place=(0.5, 0.0, 1.0))),
        (Person("P1", (0, 0)),),
        (64, 48),
    ),
    "at a table": Room(
        (chair(0.0), table(0.95), replace(CUP, place=(0.85, 0.2, 0.77))),
        (Person("P1", (0, 0), 0.0, "sitting"),),
        (64, 48),
    ),
}


@pytest.mark.parametrize("room", ROOMS)
def test_fast_search_agrees_with_trying_every_state(room: str) -> None:
    stage = ROOMS[room].stage()
    here, twin = Viewpoint(stage, "P1", ROUGH), Twin(stage, "P1", ROUGH)
    for name in stage.scene.objects:
        for ability in ABILITIES:
            difference = disagreement(effort_from(here, name, ability), twin.answer(name, ability))
            assert difference is None, (name, ability, difference)


def test_the_rooms_above_reach_every_level_but_held() -> None:
    stages = [room.stage() for room in ROOMS.values()]
    levels = {
        (ability, effort_from(Viewpoint(stage, "P1", ROUGH), name, ability).level)
        for stage in stages
        for name in stage.scene.objects
        for ability in ABILITIES
    }
    wanted = {(ability, level) for ability in ABILITIES for level in range(6)}
    assert levels == wanted - {("reach", 0), ("grasp", 0)}


@pytest.mark.parametrize("seed", range(5))
def test_fast_search_agrees_with_trying_every_state_in_furnished_rooms(seed: int) -> None:
    case = random_case(seed)
    found = compare_levels(case, case.scene.agents[seed % len(case.scene.agents)])
    assert found.count >= 9
    assert not found.differences


def test_fast_search_agrees_with_trying_every_state_in_the_steps_of_the_default_settings() -> None:
    seed = 705
    case = random_case(seed, image_px=(32, 24))
    found = compare_levels(case, case.scene.agents[seed % len(case.scene.agents)], FINE)
    assert found.count >= 9
    assert not found.differences


@pytest.mark.parametrize("seed", range(100, 120, 10))
def test_windows_count_the_pixels_of_the_whole_image(seed: int) -> None:
    found = Comparison()
    for number in range(seed, seed + 10):
        found += compare_pixels(random_case(number))
    assert found.count > 100
    assert not found.differences


def test_windows_count_the_pixels_of_a_fine_image() -> None:
    assert not compare_pixels(random_case(1, image_px=(320, 240))).differences


@pytest.mark.parametrize("seed", range(3))
def test_rays_cast_together_are_rays_cast_one_by_one(seed: int) -> None:
    """The twin's images come from MuJoCo's many rays at once; each of them is also right on its own."""
    case = random_case(seed, image_px=(32, 24))
    world, agent = World(case.scene, case.state), case.scene.agent("P1")
    rays = pixel_rays(agent) @ world.data.site_xmat[agent.eye_site].reshape(3, 3).T
    eye, hit = world.data.site_xpos[agent.eye_site], np.zeros(1, dtype=np.int32)
    for ray, geom in zip(rays, world.image(agent), strict=True):
        mujoco.mj_ray(world.model, world.data, eye, ray, SEEN_MASK, True, agent.eye_exclude_body, hit)
        assert hit[0] == geom


def test_unoccluded_pixels_are_those_of_the_object_alone() -> None:
    screen, brick = Thing("screen", (0.02, 0.3, 0.3), (0.7, 0, 1.5)), Thing("brick", (0.1, 0.1, 0.1), (1.2, 0.1, 1.6))
    person = Person("P1", (0, 0))
    hidden = visibility(Room((screen, brick), (person,)).stage(), "P1", "brick")
    alone = visibility(Room((brick,), (person,)).stage(), "P1", "brick")
    assert hidden is not None
    assert alone is not None
    assert alone.unoccluded_px == alone.visible_px == hidden.unoccluded_px
    assert (hidden.visible_px, hidden.occluders) == (0, (("screen", hidden.unoccluded_px),))
