"""Things of random rooms: bins hold, covers cover, meshes are sets of convex pieces."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from taskgist.settings import DEFAULT
from taskgist.world import Scene, Stage, container_of, object_points, overlaps, support_of
from taskgist_lab.generator.things import (
    COVERABLE,
    LARGE,
    PICTURES,
    SHAPES,
    SMALL,
    WALL_M,
    MeshThing,
    OpenBox,
    Piece,
    any_of,
    at,
    bin_of,
    cover_for,
    extent_m,
    mesh_text,
    radius_m,
)
from taskgist_lab.simulator import Room, Table, Thing

PLACE = np.array([0.1, 0.2, 0.72])


def scene_of(*things: Thing) -> Scene:
    return Room("room", (), things, Table("table"), ()).scene()


def pieces() -> list[tuple[str, Piece]]:
    return [(name, piece) for name, shape in SHAPES.items() for piece in shape]


@pytest.mark.parametrize("kind", [*SMALL, *LARGE, *PICTURES])
def test_things_are_as_large_as_they_say_and_stand(kind: str) -> None:
    thing = at({**SMALL, **LARGE, **PICTURES}[kind](np.random.default_rng(0)), PLACE, 0.4)
    scene = scene_of(thing)
    points = object_points(Stage(scene), kind, 0.01)
    assert np.ptp(points[:, 2]) == pytest.approx(thing.height_m, abs=1e-3)
    assert np.linalg.norm(points[:, :2] - PLACE[:2], axis=1).max() == pytest.approx(radius_m(thing), abs=4e-3)
    assert points[:, 2].min() == pytest.approx(0.72, abs=1e-3)
    assert support_of(Stage(scene), kind, DEFAULT.contact) == "table"


def test_sizes_and_colours_vary_and_a_seed_decides_them() -> None:
    drawn = [any_of(np.random.default_rng(seed), SMALL) for seed in range(40)]
    assert len({thing.name for thing in drawn}) == len(SMALL)
    assert len({thing.size_m for thing in drawn}) > 15
    assert drawn[7] == any_of(np.random.default_rng(7), SMALL)
    assert any_of(np.random.default_rng(0), SMALL, but=frozenset(set(SMALL) - {"tape"})).name == "tape"


def test_a_bin_holds_what_is_put_into_it() -> None:
    container = at(bin_of(np.random.default_rng(1)), PLACE, 0.3)
    cube = at(SMALL["cube"](np.random.default_rng(1)), PLACE + (0.0, 0.0, WALL_M), 0.0)
    stage = Stage(scene_of(container, cube))
    assert container_of(stage, "cube", DEFAULT.contact) == "bin"
    assert overlaps(stage, deeper_than_m=0.001) == {}


@pytest.mark.parametrize("kind", COVERABLE)
@pytest.mark.parametrize("seed", range(4))
def test_a_cover_goes_over_a_thing_however_it_is_turned(kind: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    thing = COVERABLE[kind](rng)
    cover = at(cover_for(rng, thing), PLACE, rng.uniform(-3.0, 3.0))
    stage = Stage(scene_of(at(thing, PLACE, rng.uniform(-3.0, 3.0)), cover))
    assert overlaps(stage, deeper_than_m=1e-6) == {}
    assert container_of(stage, kind, DEFAULT.contact) is None
    middle = stage.body_position(stage.scene.object_body(kind))
    around = np.array([(1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.6, 0.0, 0.8), (0.0, 0.0, 1.0)])
    geoms, _ = stage.cast(middle, around, exclude_body=stage.scene.object_body(kind))
    assert {stage.scene.owners[geom] for geom in geoms} == {"cover"}


def test_an_open_box_is_open_on_one_side_only() -> None:
    box = OpenBox("bin", (0.2, 0.3, 0.25), (0.0, 0.0, 0.72))
    for upside_down in (False, True):
        stage = Stage(scene_of(replace(box, upside_down=upside_down)))
        middle = stage.body_position(stage.scene.object_body("bin"))
        ways = np.array([(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)], dtype=float)
        geoms, distances = stage.cast(middle, ways)
        open_way = 5 if upside_down else 4
        assert [stage.scene.owners[geom] if geom >= 0 else "" for geom in np.delete(geoms, open_way)] == ["bin"] * 5
        inner = [0.1 - WALL_M] * 2 + [0.15 - WALL_M] * 2 + [0.125 - WALL_M]
        assert np.delete(distances, open_way) == pytest.approx(inner)


@pytest.mark.parametrize(("name", "piece"), pieces(), ids=lambda value: value if isinstance(value, str) else "")
def test_pieces_of_meshes_are_closed_and_convex(name: str, piece: Piece) -> None:
    vertices, faces = piece
    assert name in SHAPES
    edges = {(a, b) for face in faces.tolist() for a, b in zip(face, (*face[1:], face[0]), strict=True)}
    assert len(edges) == 3 * len(faces)
    assert {(b, a) for a, b in edges} == edges
    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.all(np.linalg.norm(normals, axis=1) > 1e-9)
    heights = np.einsum("fk,fvk->fv", normals, vertices[None] - corners[:, :1])
    assert heights.max() <= 1e-4 * np.linalg.norm(normals, axis=1).max()


@pytest.mark.parametrize("name", SHAPES)
def test_what_collides_of_a_mesh_is_what_is_seen(name: str) -> None:
    scene = scene_of(
        at(
            SMALL[name](np.random.default_rng(0)) if name in SMALL else LARGE[name](np.random.default_rng(0)),
            PLACE,
            0.0,
        )
    )
    assert len(scene.solid_geoms_of(name)) == len(SHAPES[name])
    assert extent_m(name)[1] < 0.25
    assert mesh_text(name).count(b"\nv ") == sum(len(vertices) for vertices, _ in SHAPES[name]) - 1


def test_two_things_of_a_mesh_share_its_file() -> None:
    mug = SMALL["mug"](np.random.default_rng(0))
    assert isinstance(mug, MeshThing)
    scene = scene_of(at(mug, PLACE, 0.0), at(replace(mug, name="mug_2"), PLACE + (0.0, 0.3, 0.0), 1.0))
    assert sum(file == "mug.obj" for file in scene.bundle) == 1
    assert scene.objects == ("mug", "mug_2")
    assert overlaps(Stage(scene), deeper_than_m=1e-3) == {}
