"""Ability maps: what each cell means, and that fast and slow agree on it."""

from __future__ import annotations

import itertools
import math
import pickle
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from taskgist.errors import InputError, UnknownNameError
from taskgist.maps import grid
from taskgist.maps.ability_map import AbilityMap, ability_map
from taskgist.maps.configurations import configurations
from taskgist.maps.grid import Grid, Zone, solid_cells
from taskgist.maps.see import shapes_of_head
from taskgist.perspective import Ability, Viewpoint, effort_from
from taskgist.settings import DEFAULT, Maps
from taskgist.world import Stage, State
from tests.maps.maps_twin import MapTwin
from tests.perspective.random_rooms import random_case
from tools.rooms import ROUGH, Person, Room, Shape, Thing, chair, random_room, table, wall

SMALL = replace(ROUGH, maps=Maps(cell_m=0.1))
ABILITIES: tuple[Ability, ...] = ("see", "reach")
SEATED = Room((chair(0.0), table(1.05)), (Person("P1", (0, 0), 0.0, "sitting"), Person("P2", (1.9, 0.3), 3.0)))


def twin_disagreements(stage: Stage, agent: str, ability: Ability, rng: np.random.Generator) -> list[object]:
    """Cells in which map and twin differ."""
    found = ability_map(stage, agent, ability, settings=SMALL)
    twin = MapTwin(stage, agent, SMALL)
    cells = rng.choice(found.levels.size, size=25, replace=False)
    fast = found.levels.ravel()[cells].tolist()
    slow = [twin.level(ability, point) for point in found.grid.centers()[cells]]
    return [row for row in zip(cells.tolist(), fast, slow, strict=True) if row[1] != row[2]]


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("ability", ABILITIES)
def test_fast_and_slow_agree_in_simple_rooms(seed: int, ability: Ability) -> None:
    stage = random_room(seed).stage()
    assert twin_disagreements(stage, "P1", ability, np.random.default_rng(seed)) == []


@pytest.mark.parametrize("seed", [19, 23, 31])
@pytest.mark.parametrize("ability", ABILITIES)
def test_fast_and_slow_agree_in_furnished_rooms(seed: int, ability: Ability) -> None:
    """With robots, meshes, held and untracked things, people and parts."""
    stage = random_case(seed).stage()
    for agent in stage.scene.agents[:2]:
        assert twin_disagreements(stage, agent, ability, np.random.default_rng(seed)) == []


def test_fast_and_slow_agree_where_an_agent_has_very_many_ways_to_stand() -> None:
    """Its own shapes, once for each way, make a table with more rows than 16 bits can tell apart."""
    fine = replace(ROUGH.efforts, turn_step_rad=math.radians(2.0), lean_step_rad=0.05, move_radius_m=0.0)
    stage, settings = Room((table(0.9),), (Person("P1", (0, 0)),)).stage(), replace(ROUGH, efforts=fine)
    twin, here = MapTwin(stage, "P1", settings), Viewpoint(stage, "P1", settings)
    beside_the_legs = Grid((0.0, 0.1, 0.35), 0.0, 0.05, (1, 1, 2))
    found = ability_map(here, ability="see", grid=beside_the_legs)
    assert found.levels.ravel().tolist() == [twin.level("see", point) for point in beside_the_legs.centers()]
    own = set(here.agent.geoms.tolist()) - set(shapes_of_head(here).tolist())
    assert len(list(configurations(here, 2))) * len(own) > 2**15


@cache
def seated(ability: Ability) -> AbilityMap:
    return ability_map(SEATED.stage(), "P1", ability, settings=SMALL)


@pytest.mark.parametrize("ability", ABILITIES)
def test_a_map_says_what_the_search_says_of_a_small_ball(ability: Ability) -> None:
    """Up to the ball's size: it is seen and reached a little sooner than its middle."""
    dot = Thing("dot", (0.012,), (9.0, 0.0, 1.0), "sphere")
    stage = replace(SEATED, things=(*SEATED.things, dot)).stage()
    found, rng, same = seated(ability), np.random.default_rng(7), 0
    free = np.flatnonzero(~found.solid.ravel() & ~solid_cells(stage, found.grid).ravel())
    cells = rng.choice(free, size=60, replace=False)
    for cell in cells:
        point = found.grid.centers()[cell]
        state = stage.state.replace(at=stage.scene.object_slice("dot"), to=(*point, 1.0, 0.0, 0.0, 0.0))
        here = Viewpoint(Stage(stage.scene, state), "P1", SMALL)
        same += effort_from(here, "dot", ability).level == found.levels.ravel()[cell]
    assert same >= 56


def test_levels_are_nested() -> None:
    for ability in ABILITIES:
        found = seated(ability)
        zones = [found.at_most(level) for level in range(6)]
        assert all((less - more).count == 0 for less, more in itertools.pairwise(zones))
        assert sum(found.counts.values()) == found.levels.size == zones[5].count
        assert len(found.counts) >= 4


def test_the_workspace_is_anchored_to_the_agent() -> None:
    moved = SEATED.moved(0.7, 2.0, -1.0)
    for ability in ABILITIES:
        there = ability_map(moved.stage(), "P1", ability, settings=SMALL)
        assert there.grid.yaw_rad == pytest.approx(0.7)
        assert np.mean(there.levels == seated(ability).levels) > 0.999  # but for rounding at the brink


def test_a_mirrored_room_has_a_mirrored_map() -> None:
    for ability in ABILITIES:
        mirrored = ability_map(SEATED.mirrored().stage(), "P1", ability, settings=SMALL)
        assert np.mean(mirrored.levels[:, ::-1] == seated(ability).levels) > 0.999


def test_fewer_actions_win_fewer_cells() -> None:
    stage = SEATED.stage()
    for ability, actions in (("see", ["Pan_Head", "Tilt_Head"]), ("reach", ["Lean_Torso", "Stretch_Out_Arm(left)"])):
        some = ability_map(Viewpoint(stage, "P1", SMALL, actions=actions), ability=ability)  # type: ignore[arg-type]
        every = seated(ability)
        assert 0 < some.at_most(4).count < every.at_most(4).count
        assert (some.at_most(4) - every.at_most(4)).count == 0
    none = ability_map(Viewpoint(stage, "P1", SMALL, actions=[]), ability="reach")
    assert none.at_most(4).count == 0


def test_nobody_sees_through_a_wall_or_into_things() -> None:
    room = Room((wall("wall", 0.8, half=(0.02, 9.0, 3.0)),), (Person("P1", (0, 0)),))
    found = ability_map(room.stage(), "P1", "see", settings=SMALL)
    beyond = found.grid.centers()[:, 0].reshape(found.grid.shape) > 0.83
    assert (found.levels[beyond] == 5).all()
    assert (found.levels[~beyond & ~found.solid] < 5).mean() > 0.8


@pytest.mark.parametrize(
    ("lost", "ability", "known"),
    [("P1", "see", set()), ("P1/head", "see", set()), ("P1/torso", "see", {0, 1}), ("P1/legs", "reach", {1, 2})],
)
def test_what_is_not_tracked_leaves_cells_unknown(lost: str, ability: Ability, known: set[int]) -> None:
    stage = SEATED.stage()
    state = State(stage.state.qpos, untracked=frozenset({lost}))
    found = ability_map(Stage(stage.scene, state), "P1", ability, settings=SMALL)
    assert set(found.counts) - {5} == {*known, -1}
    assert found.unknown.count == found.counts[-1]
    assert (found.solid | (found.levels != 5)).all()
    assert not (found.unknown & found.at_most(5)).count


def test_making_a_map_leaves_the_stage_as_it_was() -> None:
    stage = SEATED.stage()
    shown, eye = stage.state, stage.eye(stage.scene.agent("P1")).position
    ability_map(stage, "P1", "see", settings=SMALL)
    assert stage.state is shown
    assert np.array_equal(stage.eye(stage.scene.agent("P1")).position, eye)


def test_grids() -> None:
    grid = Grid((1.0, -2.0, 0.5), 0.6, 0.25, (4, 3, 2))
    cells = grid.cells_at(grid.centers())
    assert np.array_equal(np.ravel_multi_index(tuple(cells.T), grid.shape), np.arange(24))
    assert grid.holds(cells).all()
    assert not grid.holds(grid.cells_at([(1.0, -2.1, 0.6)])).any()
    assert grid.center((1, 2, 0)) == pytest.approx(grid.centers().reshape(4, 3, 2, 3)[1, 2, 0])
    assert Grid.around(SEATED.stage(), "P1").shape == (60, 60, 40)
    both = Grid.around(SEATED.stage(), "P1", "P2")
    for name in ("P1", "P2"):
        assert both.holds(both.cells_at(Grid.around(SEATED.stage(), name).centers())).mean() > 0.9
    assert both.cells_at([(0.0, 0.0, 0.01)]).tolist() == [[30, 30, 0]]


@pytest.mark.parametrize(("cell_m", "shape"), [(0.0, (1, 1, 1)), (0.1, (0, 4, 4)), (1e-4, (9000, 9000, 9000))])
def test_grids_that_cannot_be_made(cell_m: float, shape: tuple[int, int, int]) -> None:
    with pytest.raises(InputError, match="no such grid can be made"):
        Grid((0.0, 0.0, 0.0), 0.0, cell_m, shape)


def test_zones_are_sets() -> None:
    grid, rng = Grid((0.0, 0.0, 0.0), 0.3, 0.1, (3, 4, 5)), np.random.default_rng(1)
    a, b = (Zone(grid, rng.random(grid.shape) < 0.5) for _ in range(2))
    assert np.array_equal((a & b).cells, a.cells & b.cells)
    assert np.array_equal((a | b).cells, a.cells | b.cells)
    assert np.array_equal((a - b).cells, (a & ~b).cells)
    assert (a & ~a).count == 0
    assert (a | ~a).volume_m3 == pytest.approx(60 * 0.001)
    assert a.contains(a.points_m).all()
    assert not a.contains((~a).points_m).any()
    assert not a.contains([(99.0, 0.0, 0.0)]).any()
    assert (~a & a).nearest((0, 0, 0)) is None
    away = np.linalg.norm(a.points_m - (0.1, 0.2, 0.3), axis=1)
    cell = a.nearest((0.1, 0.2, 0.3))
    assert cell is not None
    assert np.linalg.norm(grid.center(cell) - (0.1, 0.2, 0.3)) == pytest.approx(away.min())
    copy = pickle.loads(pickle.dumps(a))
    assert np.array_equal(copy.cells, a.cells)
    with pytest.raises(ValueError, match="read-only"):
        copy.cells[0, 0, 0] = True


def test_zones_of_different_grids_are_not_combined() -> None:
    grids = [Grid((0.0, 0.0, z), 0.0, 0.1, (2, 2, 2)) for z in (0.0, 1.0)]
    first, second = (Zone(grid, np.ones(grid.shape, dtype=bool)) for grid in grids)
    with pytest.raises(InputError, match=r"different grids.*make both maps with one grid"):
        first & second
    with pytest.raises(InputError, match="do not fit"):
        Zone(grids[0], np.ones((3, 2, 2), dtype=bool))


def test_solid_cells() -> None:
    stage = Room((Thing("block", (0.3, 0.2, 0.25), (1.0, 0.0, 0.5), yaw=math.pi / 2),), (Person("P1", (0, 0)),)).stage()
    grid = Grid((0.0, -1.0, 0.0), 0.0, 0.05, (40, 40, 40))
    solid = solid_cells(stage, grid, but="P1")
    assert solid.sum() == 8 * 12 * 10
    assert solid_cells(stage, grid, but="block").sum() > 0  # the agent is solid, too
    assert not solid_cells(
        Stage(stage.scene, State(stage.state.qpos, untracked=frozenset({"block"}))), grid, but="P1"
    ).any()


def test_names_that_do_not_exist() -> None:
    with pytest.raises(UnknownNameError, match="no agent 'P3'"):
        ability_map(SEATED.stage(), "P3", "see")
    with pytest.raises(UnknownNameError, match="no ability to map 'grasp'"):
        ability_map(SEATED.stage(), "P1", "grasp")


def test_settings_of_maps_shape_no_facts() -> None:
    assert replace(DEFAULT, maps=Maps(cell_m=0.2)).digest == DEFAULT.digest


@pytest.mark.parametrize("ability", ABILITIES)
def test_a_map_does_not_depend_on_how_its_blocks_are_dealt_out(
    ability: Ability, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(grid, "FEW", 1)
    for parts in (1, 7):
        monkeypatch.setattr(grid, "PARTS", parts)
        again = ability_map(SEATED.stage(), "P1", ability, settings=SMALL)
        assert np.array_equal(again.levels, seated(ability).levels)


CUPBOARD = (0.6, 0.1, 1.15), (0.2, 0.35, 0.3)


@pytest.mark.parametrize("door", [True, False])
def test_what_is_closed_up_is_reached_nowhere(door: bool) -> None:
    """The cells well inside of a cupboard, with and without its door."""
    (x, y, z), (deep, wide, high) = CUPBOARD
    shapes = [Shape("box", (0.01, wide, high), (side * deep, 0.0, 0.0)) for side in ((-1, 1) if door else (1,))]
    shapes += [Shape("box", (deep, 0.01, high), (0.0, side * wide, 0.0)) for side in (-1, 1)]
    shapes += [Shape("box", (deep, wide, 0.01), (0.0, 0.0, side * high)) for side in (-1, 1)]
    stage = Room((Thing("cupboard", (), (x, y, z), free=False, shapes=tuple(shapes)),), (Person("P1", (0, 0)),)).stage()
    found = ability_map(stage, "P1", "reach", grid=Grid((0.3, -0.35, 0.75), 0.0, 0.05, (12, 18, 16)))
    inside = (np.abs(found.grid.centers() - (x, y, z)) < np.array((deep, wide, high)) - 0.05).all(axis=1)
    levels = found.levels.ravel()[inside]
    assert len(levels) > 300
    assert (levels == 5).all() == door
    assert door or (levels <= 2).all()
