"""Who asks for the level only spares what would change nothing: the full search finds the same."""

import pytest

from taskgist.perspective import ABILITIES, Viewpoint, effort_from
from taskgist.perspective.grasp import Grasp
from taskgist.perspective.target import Target
from taskgist.world import Stage
from tests.perspective.random_rooms import random_case
from tools.rooms import COARSE, Person, Room, Thing, chair


def levels(stage: Stage, agent: str, name: str, *, explained: bool) -> list[tuple[object, ...]]:
    """What is told of each ability."""
    here = Viewpoint(stage, agent, COARSE)
    efforts = [effort_from(here, name, ability, explained=explained) for ability in ABILITIES]
    return [(each.level, each.actions, each.amount, each.joints_rad, each.turns_rad) for each in efforts]


@pytest.mark.parametrize("seed", range(520, 523))
def test_the_level_alone_is_that_of_the_full_search(seed: int) -> None:
    case = random_case(seed, image_px=(48, 36))
    stage = Stage(case.scene, case.state)
    for agent in case.scene.agents:
        for name in case.scene.objects:
            assert levels(stage, agent, name, explained=False) == levels(stage, agent, name, explained=True)


@pytest.mark.parametrize("gap_m", [0.001, 0.04, 0.3])
def test_what_others_leave_no_room_to_grasp_is_level_5_both_ways(gap_m: float) -> None:
    """A cup between four posts and beneath a board: whether hands get in decides."""
    x, y, z = 0.5, 0.0, 1.0
    half = 0.03 + gap_m
    posts = [
        Thing(f"post {n}", (0.02, half, 0.2), place, free=False, yaw=yaw)
        for n, (place, yaw) in enumerate(
            [((x + half + 0.02, y, z), 0.0), ((x - half - 0.02, y, z), 0.0)]
            + [((x, y + half + 0.02, z), 1.5708), ((x, y - half - 0.02, z), 1.5708)]
        )
    ]
    board = Thing("board", (0.3, 0.3, 0.01), (x, y, z - 0.06), free=False)
    cup = Thing("cup", (0.03, 0.05), (x, y, z), "cylinder")
    stage = Room((cup, board, *posts, chair(3.0, 3.0)), (Person("P1", (0.0, 0.0)),), (48, 36)).stage()
    told = levels(stage, "P1", "cup", explained=False)
    assert told == levels(stage, "P1", "cup", explained=True)
    assert (told[ABILITIES.index("grasp")][0] == 5) == (gap_m < 0.02)


@pytest.mark.parametrize("off_m", [0.0, 0.02, 0.05, 0.08])
def test_what_is_buried_in_another_thing_is_level_5_both_ways(off_m: float) -> None:
    """A ball in a box: where its middle is within, no hand closes on it, but palms reach what of it is outside."""
    ball = Thing("ball", (0.045,), (0.45 + off_m, 0.0, 1.0), "sphere")
    block = Thing("block", (0.035, 0.035, 0.035), (0.45, 0.0, 1.0), free=False)
    stage = Room((ball, block, chair(3.0, 3.0)), (Person("P1", (0.0, 0.0)),), (48, 36)).stage()
    judge = Grasp(Viewpoint(stage, "P1", COARSE), Target(stage, "ball", COARSE))
    told = levels(stage, "P1", "ball", explained=False)
    assert told == levels(stage, "P1", "ball", explained=True)
    assert judge.buried(judge.plain.cloud) == (off_m < 0.04)
    assert (told[ABILITIES.index("grasp")][0] == 5) or off_m >= 0.04
    assert told[ABILITIES.index("reach")][0] != 5
