"""The fast search agrees exactly with the slow one, and the window with the whole image."""

from dataclasses import replace

import pytest

from taskgist.perspective import ABILITIES, Standpoint, effort_from, view_of, visibility
from tests.perspective.rooms import COARSE, Person, Room, Thing, chair, random_room, table, wall
from tests.perspective.twin import Twin

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
    here = Standpoint(stage, "P1", COARSE)
    for name in stage.scene.objects:
        twin = Twin(stage, "P1", name, COARSE)
        for ability in ABILITIES:
            fast, slow = effort_from(here, name, ability), twin.answer(ability)
            assert fast.level == slow.level, (name, ability)
            assert (fast.amount and fast.amount.key) == slow.amount, (name, ability)
            assert fast.actions in slow.actions, (name, ability)


def test_the_rooms_above_reach_every_level_but_held() -> None:
    stages = [room.stage() for room in ROOMS.values()]
    levels = {
        (ability, effort_from(Standpoint(stage, "P1", COARSE), name, ability).level)
        for stage in stages
        for name in stage.scene.objects
        for ability in ABILITIES
    }
    wanted = {(ability, level) for ability in ABILITIES for level in range(6)}
    assert levels == wanted - {("reach", 0), ("grasp", 0)}


@pytest.mark.parametrize("seed", range(20, 32))
def test_window_counts_the_pixels_of_the_whole_image(seed: int) -> None:
    stage = random_room(seed, image_px=(320, 240)).stage()
    for agent in stage.scene.agents:
        counts = view_of(stage, agent).pixels()
        for name in stage.scene.objects:
            seen = visibility(stage, agent, name)
            assert seen is not None
            assert seen.visible_px == counts.get(name, 0)
            assert seen.visible_px + sum(count for _, count in seen.occluders) == seen.unoccluded_px


def test_unoccluded_pixels_are_those_of_the_object_alone() -> None:
    screen, brick = Thing("screen", (0.02, 0.3, 0.3), (0.7, 0, 1.5)), Thing("brick", (0.1, 0.1, 0.1), (1.2, 0.1, 1.6))
    person = Person("P1", (0, 0))
    hidden = visibility(Room((screen, brick), (person,)).stage(), "P1", "brick")
    alone = visibility(Room((brick,), (person,)).stage(), "P1", "brick")
    assert hidden is not None
    assert alone is not None
    assert alone.unoccluded_px == alone.visible_px == hidden.unoccluded_px
    assert (hidden.visible_px, hidden.occluders) == (0, (("screen", hidden.unoccluded_px),))
