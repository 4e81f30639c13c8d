"""Places on supports, set questions about places, and maps on disk."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from taskgist.errors import InputError, UnknownNameError
from taskgist.maps.ability_map import AbilityMap, ability_map, read_maps, write_maps
from taskgist.maps.grid import Grid, Zone
from taskgist.maps.places import Place, places_for, zone_where
from taskgist.perspective.queries import parse_question
from taskgist.perspective.scene_efforts import SceneEfforts
from taskgist.world import Scene, Stage, State
from taskgist_lab.ordinary.furnishing import furnished
from tests.maps.places_twin import PlacesTwin
from tests.maps.test_maps import SMALL
from tests.meshes import body, mesh_scene, shelf, shell_bin
from tools.rooms import Person, Room, Thing, chair, table

BOX = Thing("box", (0.1, 0.1, 0.1), (1.05, 0.2, 0.82))
SHELF = Thing("shelf", (0.3, 0.3, 0.01), (1.05, 0.0, 1.2), free=False)
PEOPLE = (Person("P1", (0, 0), 0.0, "sitting"), Person("P2", (2.0, 0.3), 3.0))
ROOM = Room((chair(0.0), table(1.05), BOX, SHELF), PEOPLE)
GRID = Grid((0.4, -0.7, 0.0), 0.0, 0.05, (24, 28, 30))
SIZE = (0.08, 0.06, 0.1)


def everywhere() -> Zone:
    return Zone(GRID, np.ones(GRID.shape, dtype=bool))


def on(support: str, places: tuple[Place, ...]) -> np.ndarray:
    return np.array([place.position_m for place in places if place.support == support]).reshape(-1, 3)


def test_places_are_on_level_faces_where_the_object_stands_and_fits() -> None:
    places = places_for(ROOM.stage(), SIZE, everywhere())
    assert {place.support for place in places} == {"table", "shelf", "box", "floor"}
    for support, height, (x, y), half in (
        ("table", 0.72, (1.05, 0.0), (0.4, 0.6)),
        ("shelf", 1.21, (1.05, 0.0), (0.3, 0.3)),
        ("box", 0.92, (1.05, 0.2), (0.1, 0.1)),
    ):
        spots = on(support, places)
        assert spots[:, 2] == pytest.approx(height)
        assert (np.abs(spots[:, 0] - x) <= half[0] - SIZE[0] / 2 + 1e-6).all()
        assert (np.abs(spots[:, 1] - y) <= half[1] - SIZE[1] / 2 + 1e-6).all()
    table_spots = on("table", places)
    beside = (np.abs(table_spots[:, :2] - (1.05, 0.2)) >= np.array((0.1, 0.1)) + np.array(SIZE[:2]) / 2 - 1e-6).any(
        axis=1
    )
    assert beside.all(), "nothing stands in the box"
    assert len(table_spots) > 100


def test_every_place_that_exists_is_found() -> None:
    """The grid's columns over the table's half without a box: all that keep the object's base on it."""
    spots = on("table", places_for(ROOM.stage(), SIZE, everywhere(), supports=["table"]))
    columns = GRID.centers().reshape(*GRID.shape, 3)[:, :, 0, :2].reshape(-1, 2)
    inside = (columns[:, 1] < 0.0) & (np.abs(columns - (1.05, 0.0)) <= (0.4 - 0.04, 0.6 - 0.03)).all(axis=1)
    assert len(spots[spots[:, 1] < 0.0]) == inside.sum()


def test_room_above_is_needed() -> None:
    tall = places_for(ROOM.stage(), (0.08, 0.06, 0.5), everywhere(), supports=["table"])
    under_the_shelf = (np.abs(on("table", tall)[:, :2] - (1.05, 0.0)) < 0.3).all(axis=1)
    assert len(tall) > 10
    assert not under_the_shelf.any()


def test_the_object_itself_is_not_in_its_own_way() -> None:
    stage = ROOM.stage()
    with_box = places_for(stage, SIZE, everywhere(), supports=["table"])
    without = places_for(stage, SIZE, everywhere(), supports=["table"], instead_of="box")
    assert set(with_box) < set(without)
    assert "box" not in {place.support for place in places_for(stage, SIZE, everywhere(), instead_of="box")}


def test_people_carry_nothing_and_are_in_the_way() -> None:
    places = places_for(ROOM.stage(), SIZE, everywhere())
    assert not {place.support for place in places} & {"P1", "P2"}
    assert not any(
        np.linalg.norm(np.array(p.position_m[:2]) - (0.45, -0.09)) < 0.04 for p in places if p.position_m[2] > 0
    )


def test_places_lie_in_the_zone_that_is_asked_for() -> None:
    stage = ROOM.stage()
    near = ability_map(stage, "P1", "reach", grid=GRID, settings=SMALL).at_most(2)
    places = places_for(stage, SIZE, near)
    every = places_for(stage, SIZE, everywhere())
    middles = np.array([place.position_m for place in every]) + (0, 0, SIZE[2] / 2)
    assert places == tuple(place for place, inside in zip(every, near.contains(middles), strict=True) if inside)
    assert 0 < len(places) < len(every)


def of_meshes() -> Scene:
    boxed = body("bin", "bin", (0.7, -0.4, 0.0), free=False) + body("shelf", "shelf", (1.1, 0.2, 0.0), free=False)
    return mesh_scene(boxed, "[agents.P1]\nprofile = 'human'", bin=shell_bin((0.3, 0.2, 0.2)), shelf=shelf())


def before(stage: Stage, person: str) -> Zone:
    """The space before somebody."""
    x, y, _ = stage.state.qpos[stage.scene.base_slice(person)][:3]
    grid = Grid((float(x), float(y), 0.0), 0.3, 0.05, (18, 16, 40))
    return Zone(grid, np.ones(grid.shape, dtype=bool))


def rounded(place: Place) -> tuple[str, ...]:
    return place.support, *(f"{value:.6f}" for value in place.position_m)


SCENES: dict[str, Callable[[], Scene]] = {
    "made by hand": ROOM.scene,
    "of meshes": of_meshes,
    "ordinary": furnished(7, 5).scene,
}


@pytest.mark.parametrize("size", [SIZE, (0.3, 0.2, 0.02)])
@pytest.mark.parametrize("room", SCENES)
def test_the_slow_twin_finds_the_same_places(room: str, size: tuple[float, float, float]) -> None:
    stage = Stage(SCENES[room]())
    where = Zone(GRID, np.ones(GRID.shape, dtype=bool)) if room == "of meshes" else before(stage, "P1")
    found = places_for(stage, size, where)
    twin = PlacesTwin(stage, size, where)
    theirs = {rounded(place): place for place in twin.places()}
    assert not {rounded(place) for place in found} - set(theirs)
    closer = PlacesTwin(stage, size, where, fine_m=0.001)
    overlooked = set(theirs) - {rounded(place) for place in found}
    assert not any(closer.stands(*theirs[each].position_m) for each in overlooked), "it sees boxes as points 8 mm apart"
    assert len(overlooked) <= 0.002 * len(theirs)
    assert len({place.support for place in found}) > (1 if size == SIZE else 0)


@pytest.mark.parametrize("size", [(0.0, 0.1, 0.1), (0.1, -1.0, 0.1), (0.1, 0.1, float("inf")), (float("nan"), 1, 1)])
def test_sizes_that_cannot_be(size: tuple[float, float, float]) -> None:
    with pytest.raises(InputError, match="an object needs positive sizes"):
        places_for(ROOM.stage(), size, everywhere())


def perspectives(*untracked: str) -> SceneEfforts:
    stage = ROOM.stage()
    return SceneEfforts(Stage(stage.scene, State(stage.state.qpos, untracked=frozenset(untracked))), SMALL)


def test_set_questions_about_places_are_the_algebra_of_maps() -> None:
    asked = perspectives()
    found = zone_where(asked, parse_question("P1 reaches <= 2 and not (P2 sees = 1 or P2 reaches)", ["P1", "P2"]))
    maps = {(each.agent, each.ability): each for each in found.maps}
    reach, see, other = (maps[key] for key in (("P1", "reach"), ("P2", "see"), ("P2", "reach")))
    expected = reach.at_most(2) - (see.at_most(1) - see.at_most(0)) - other.at_most(4)
    solid = np.logical_or.reduce([each.solid for each in found.maps])
    assert np.array_equal(found.yes.cells, expected.cells & ~solid)
    assert found.unknown.count == 0
    assert found.yes.grid == Grid.around(asked.stage, "P1", "P2", settings=SMALL.maps)
    never = zone_where(asked, ~parse_question("P1 reaches", ["P1"]))
    assert not (never.yes.cells & never.maps[0].solid).any()


def test_unknown_places_are_told_apart() -> None:
    lost = perspectives("P1/legs")
    found = zone_where(lost, parse_question("P1 reaches", ["P1"]))
    assert found.yes.count == found.maps[0].at_most(2).count > 0
    assert found.unknown.count == found.maps[0].unknown.count > 0
    assert zone_where(lost, parse_question("P1 reaches <= 2", ["P1"])).unknown.count > 0


def test_questions_that_maps_do_not_answer() -> None:
    with pytest.raises(InputError, match="maps tell where agents see and reach"):
        zone_where(perspectives(), parse_question("P1 grasps", ["P1"]))
    with pytest.raises(UnknownNameError, match="no agent 'P9'"):
        zone_where(perspectives(), parse_question("P9 sees", ["P9"]))


def maps_of_one_grid() -> tuple[AbilityMap, ...]:
    stage = ROOM.stage()
    grid = Grid.around(stage, "P1", settings=SMALL.maps)
    return tuple(ability_map(stage, agent, "reach", grid=grid, settings=SMALL) for agent in ("P1", "P2"))


def test_maps_come_back_from_disk(tmp_path: Path) -> None:
    maps = maps_of_one_grid()
    with (tmp_path / "maps.npz").open("wb") as stream:
        write_maps(stream, maps)
    for before, after in zip(maps, read_maps(tmp_path / "maps.npz"), strict=True):
        assert (after.agent, after.ability, after.grid) == (before.agent, before.ability, before.grid)
        assert after.settings_digest == before.settings_digest == SMALL.digest
        assert np.array_equal(after.levels, before.levels)
        assert np.array_equal(after.solid, before.solid)
    with np.load(tmp_path / "maps.npz") as arrays:
        assert arrays["centers_m"].reshape(-1, 3) == pytest.approx(maps[0].grid.centers(), abs=1e-5)


def test_maps_of_different_grids_do_not_share_a_file(tmp_path: Path) -> None:
    stage = ROOM.stage()
    maps = [ability_map(stage, agent, "reach", settings=SMALL) for agent in ("P1", "P2")]
    for wrong in (maps, []):
        with (
            (tmp_path / "maps.npz").open("wb") as stream,
            pytest.raises(InputError, match="one or more maps of one grid"),
        ):
            write_maps(stream, wrong)


def test_files_that_hold_no_maps(tmp_path: Path) -> None:
    (tmp_path / "text.npz").write_text("levels")
    np.savez(tmp_path / "other.npz", a=np.zeros(3))
    with (tmp_path / "good.npz").open("wb") as stream:
        write_maps(stream, maps_of_one_grid())
    (tmp_path / "cut.npz").write_bytes((tmp_path / "good.npz").read_bytes()[:300])
    for name, message in {
        "none": "cannot be read: No such file",
        "text": "text.npz: not a file of plain arrays",
        "other": "holds no ability maps; write it",
        "cut": "cut.npz: not a file of plain arrays",
    }.items():
        with pytest.raises(InputError, match=message):
            read_maps(tmp_path / f"{name}.npz")
