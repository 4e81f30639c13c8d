"""Concave meshes are what they are: for contact by their convex parts, for sight by their triangles."""

import logging
import pickle
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from taskgist.errors import SceneError
from taskgist.settings import DEFAULT, Limits
from taskgist.world import Scene, Stage, container_of, overlaps, support_of
from taskgist.world.geometry import coacd_process
from taskgist.world.geometry.convex import cache_folder, read_parts
from taskgist.world.geometry.pieces import Piece, is_hollow, joined, pieces
from tests import meshes
from tests.meshes import Mesh, mesh_files, mesh_scene

BALL = '<body name="ball" pos="0 0 {}"><freejoint/><geom type="sphere" size="0.03"/></body>'
CONTACT = DEFAULT.contact
FLOOR_M, RADIUS_M = 0.01, 0.03


@pytest.fixture(scope="module", autouse=True)
def cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A cache of its own for this module: a mesh is cut once."""
    with pytest.MonkeyPatch.context() as patch:
        folder = tmp_path_factory.mktemp("cache")
        patch.setenv("XDG_CACHE_HOME", str(folder))
        yield folder


def with_bin(ball_z: float) -> Scene:
    bodies = meshes.body("bin", "bin", (0, 0, 0), free=False) + BALL.format(ball_z)
    return mesh_scene(bodies, bin=meshes.shell_bin())


def parts_of(scene: Scene) -> list[str]:
    return [name for name in scene.bundle if name.startswith("parts-")]


def test_a_ball_in_a_bin_is_inside_and_touches_its_floor() -> None:
    stage = Stage(with_bin(FLOOR_M + RADIUS_M))
    assert container_of(stage, "ball", CONTACT) == "bin"
    assert support_of(stage, "ball", CONTACT) == "bin"
    assert overlaps(stage, deeper_than_m=0.001) == {}
    solid = [stage.scene.solid_geoms_of(name) for name in ("ball", "bin")]
    assert stage.closest(*solid, limit_m=0.1)[0] == pytest.approx(0.0, abs=0.001)


def test_what_floats_in_a_bin_does_not_touch_it_and_what_is_in_its_wall_does() -> None:
    stage = Stage(with_bin(0.1))
    assert support_of(stage, "ball", CONTACT) is None
    solid = [stage.scene.solid_geoms_of(name) for name in ("ball", "bin")]
    assert stage.closest(*solid, limit_m=0.1)[0] == pytest.approx(0.06, abs=0.006)
    at = stage.scene.object_slice("ball")
    stage.show(stage.state.replace(at=at, to=(0.145, 0, 0.1, 1, 0, 0, 0)))
    assert set(overlaps(stage, deeper_than_m=0.02)) == {("ball", "bin")}


def test_rays_meet_the_mesh_and_never_its_parts() -> None:
    scene = with_bin(0.5)
    stage, (seen,) = Stage(scene), scene.seen_geoms("bin")
    rng = np.random.default_rng(5)
    directions = rng.normal(size=(300, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    geoms, _ = stage.cast((0.0, 0.0, 0.1), directions, only=scene.geoms_of("bin"))
    assert set(geoms.tolist()) == {-1, int(seen)}
    assert seen not in scene.solid_geoms_of("bin")
    assert len(scene.solid_geoms_of("bin")) >= 5
    assert {scene.owners[geom] for geom in scene.geoms_of("bin")} == {"bin"}


def test_parts_are_files_of_the_scene_and_make_the_same_scene_again(cache: Path) -> None:
    scene = with_bin(0.2)
    (name,) = parts_of(scene)
    assert (cache / "taskgist" / "parts" / name).read_bytes() == scene.bundle[name]
    for again in (pickle.loads(pickle.dumps(scene)), with_bin(0.2)):
        assert again.bundle == scene.bundle
        np.testing.assert_array_equal(again.model.mesh_vert, scene.model.mesh_vert)


def test_a_scene_that_has_its_parts_needs_neither_cache_nor_coacd(monkeypatch: pytest.MonkeyPatch) -> None:
    bundle = dict(with_bin(0.2).bundle)
    monkeypatch.setitem(sys.modules, "coacd", None)
    monkeypatch.setenv("XDG_CACHE_HOME", "/dev/null/nowhere")
    assert len(Scene.from_bundle(bundle).solid_geoms_of("bin")) >= 5


def test_without_coacd_the_hull_collides_and_a_warning_names_mesh_and_remedy(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, tmp_path: Path
) -> None:
    monkeypatch.setitem(sys.modules, "coacd", None)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    with caplog.at_level(logging.WARNING, "taskgist.world"):
        scene = with_bin(FLOOR_M + RADIUS_M)
    assert "mesh 'bin' is concave" in caplog.text
    assert "pip install coacd" in caplog.text
    assert len(only_parts_of(scene)) == 1
    assert ("ball", "bin") in overlaps(Stage(scene), deeper_than_m=0.01)
    assert not list(tmp_path.rglob("parts-*")), "the next time, CoACD may be there"
    monkeypatch.undo()
    again = Scene.from_bundle(scene.bundle)
    assert again.bundle == scene.bundle, "a scene in a recording is the same everywhere"
    assert caplog.text.count("mesh 'bin' is concave") == 2


def test_damaged_parts_are_refused_by_name() -> None:
    bundle = dict(with_bin(0.2).bundle)
    (name,) = [name for name in bundle if name.startswith("parts-")]
    for damage in (b"", b"v 1 2 3", b"o part0\nv 1 2", b"o part0\nv 1 2 x", b"\xff"):
        with pytest.raises(SceneError, match=rf"{name}: damaged convex parts of mesh 'bin'.*delete it"):
            Scene.from_bundle(bundle | {name: damage})


def test_a_cache_that_cannot_be_written_is_no_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", "/dev/null/nowhere")
    scene = mesh_scene(meshes.body("shelf", "shelf", (0, 0, 0), free=False), shelf=meshes.shelf())
    assert len(parts_of(scene)) == 1


def test_the_cache_is_where_the_platform_keeps_caches(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert cache_folder() == tmp_path / ".cache" / "taskgist" / "parts"


@pytest.mark.parametrize("mesh", [meshes.board((0, 0, 0), (0.1, 0.2, 0.05)), meshes.octahedron(0.1)])
def test_a_convex_mesh_is_left_alone(mesh: Mesh) -> None:
    scene = mesh_scene(meshes.body("thing", "thing", (0, 0, 1)), thing=mesh)
    assert parts_of(scene) == []
    assert scene.solid_geoms_of("thing").tolist() == scene.seen_geoms("thing").tolist()


def test_boards_are_parts_as_they_are() -> None:
    scene = mesh_scene(meshes.body("shelf", "shelf", (1, 2, 0)), shelf=meshes.shelf())
    (name,) = parts_of(scene)
    corners = np.concatenate(read_parts(scene.bundle[name]))
    assert len(read_parts(scene.bundle[name])) == 6
    expected = np.unique(meshes.shelf()[0].round(6), axis=0)
    np.testing.assert_allclose(np.unique(corners.round(6), axis=0), expected, atol=2e-6)


def test_parts_lie_where_the_mesh_is_scaled_turned_and_shifted() -> None:
    shelf = '<mesh name="shelf" file="shelf.obj" scale="0.5 0.5 2" refpos="0.1 0 0"/>'
    geom = '<geom type="mesh" mesh="shelf" pos="0 0.3 0" euler="10 20 30"/>'
    body = f'<body name="shelf" pos="1 2 0" euler="0 0 90"><freejoint/>{geom}</body>'
    scene = room(shelf, body, {"shelf.obj": meshes.obj(meshes.shelf())})
    stage, (seen,), parts = Stage(scene), scene.seen_geoms("shelf"), scene.solid_geoms_of("shelf")
    assert len(parts) == 6
    corners = np.concatenate([vertices(stage, int(part)) for part in parts])
    for point in vertices(stage, int(seen)):
        assert np.linalg.norm(corners - point, axis=1).min() < 1e-5


def vertices(stage: Stage, geom: int) -> np.ndarray:
    """Vertices of a shape's mesh in the world."""
    model = stage.scene.model
    mesh = int(model.geom_dataid[geom])
    return stage.geom(geom).to_world(model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]])


def room(assets: str, bodies: str, files: dict[str, bytes]) -> Scene:
    text = f"<mujoco><asset>{assets}</asset><worldbody>{bodies}</worldbody></mujoco>"
    return Scene.from_bundle({"scene.toml": b'[scene]\nmodel = "room.xml"', "room.xml": text.encode(), **files})


def test_a_shape_of_the_room_is_cut_too_and_keeps_its_name() -> None:
    """In STL files every triangle has vertices of its own."""
    bodies = f'<geom type="mesh" mesh="bin" name="bin"/>{BALL.format(0.04)}'
    scene = room('<mesh name="bin" file="bin.stl"/>', bodies, {"bin.stl": meshes.stl(meshes.shell_bin())})
    assert overlaps(Stage(scene), deeper_than_m=0.003) == {}
    assert set(scene.owners) == {"bin", "ball"}


def test_shapes_that_nothing_collides_with_are_not_cut() -> None:
    quiet = meshes.body("bin", "bin", (0, 0, 0), free=False).replace("<geom", '<geom contype="0" conaffinity="0"')
    assert parts_of(mesh_scene(quiet, bin=meshes.shell_bin())) == []


@pytest.mark.parametrize(
    ("mesh", "deep_m"),
    [(meshes.board((0, 0, 0), (0.1, 0.2, 0.05)), 0.0), (meshes.shell_bin(), 0.29), (meshes.cup(), 0.096)],
)
def test_hollows_are_measured_along_the_faces_normals(mesh: Mesh, deep_m: float) -> None:
    assert not is_hollow(Piece(*mesh), deeper_than_m=deep_m + 1e-3)
    assert deep_m == 0.0 or is_hollow(Piece(*mesh), deeper_than_m=deep_m - 1e-3)


def test_a_fine_mesh_is_compared_with_its_hull_without_a_table_of_both() -> None:
    """A ball of 40,000 triangles, all of them on its hull: their table alone would hold 1.6 billion numbers."""
    latitudes, longitudes = np.linspace(0.01, np.pi - 0.01, 101), np.linspace(0, 2 * np.pi, 200, endpoint=False)
    a, b = (each.ravel() for each in np.meshgrid(latitudes, longitudes, indexing="ij"))
    vertices = 0.1 * np.stack((np.sin(a) * np.cos(b), np.sin(a) * np.sin(b), np.cos(a)), axis=1)
    i, j = (each.ravel() for each in np.meshgrid(np.arange(100), np.arange(200), indexing="ij"))
    k = (j + 1) % 200
    corners = (200 * i + j, 200 * (i + 1) + j, 200 * (i + 1) + k, 200 * i + k)
    sides = np.concatenate([np.stack([corners[n] for n in each], axis=1) for each in ((0, 1, 2), (0, 2, 3))])
    caps = [(start, start + n, start + n + 1)[::step] for start, step in ((0, 1), (20_000, -1)) for n in range(1, 199)]
    ball = Piece(vertices, np.concatenate((sides, np.array(caps))))
    assert ball.is_closed
    assert not is_hollow(ball, deeper_than_m=0.001)


def test_an_open_surface_is_hollow_and_a_flat_one_is_not() -> None:
    vertices, faces = meshes.board((0, 0, 0), (0.1, 0.2, 0.05))
    assert is_hollow(Piece(vertices, faces[:10]), deeper_than_m=1e6)
    assert not is_hollow(Piece(vertices[:4], faces[:2]), deeper_than_m=0.0)


@pytest.mark.parametrize("seed", range(5))
def test_pieces_are_found_whatever_the_order_of_triangles_and_which_way_they_face(seed: int) -> None:
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 6))
    apart = [meshes.board((i, 0, 0), tuple(rng.uniform(0.05, 0.4, 3))) for i in range(count)]
    vertices, faces = meshes.joined(*((v, f[:, ::-1] if rng.integers(2) else f) for v, f in apart))
    found = pieces(joined(Piece(vertices, rng.permutation(faces))))
    assert len(found) == count
    assert all(piece.is_closed for piece in found)
    volumes = sorted(float(np.linalg.det(piece.corners).sum()) / 6 for piece in found)
    assert volumes == pytest.approx(sorted(float(np.ptp(v, axis=0).prod()) for v, _ in apart))


def cell_scene(bodies: str, thing: Mesh) -> Scene:
    """A scene with a mesh, made without CoACD."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, "coacd", None)
        return mesh_scene(bodies, thing=thing)


def only_parts_of(scene: Scene) -> list[np.ndarray]:
    """The parts of the only mesh of a scene that has some."""
    (name,) = parts_of(scene)
    return read_parts(scene.bundle[name])


def cell_parts(mesh: Mesh) -> list[np.ndarray]:
    """The parts of a mesh that lies in a room, found without CoACD."""
    return only_parts_of(cell_scene(meshes.body("thing", "thing", (0, 0, 1)), mesh))


@pytest.mark.parametrize("fault", ["no end", "breakdown"])
def test_where_coacd_comes_to_no_end_cells_part_the_mesh_and_a_warning_says_so(
    fault: str, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, tmp_path: Path
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    if fault == "no end":
        monkeypatch.setattr(coacd_process, "CLOCK_S", 0.01)
    else:
        monkeypatch.setattr(coacd_process, "__file__", str(tmp_path / "missing.py"))
    with caplog.at_level(logging.WARNING, "taskgist.world"):
        scene = with_bin(FLOOR_M + RADIUS_M)
    assert "mesh 'bin' is concave, and parted by the cells of a grid" in caplog.text
    assert ("ball", "bin") not in overlaps(Stage(scene), deeper_than_m=0.01)


def test_coacd_in_its_own_process_gives_what_it_gives_in_this_one() -> None:
    coacd = pytest.importorskip("coacd")
    vertices, faces = meshes.shell_bin()
    found = coacd_process.searched(vertices, faces, 0.005)
    coacd.set_log_level("off")
    here = coacd.run_coacd(coacd.Mesh(vertices, faces), threshold=0.005, real_metric=True, **coacd_process.SEARCH)
    assert found is not None
    assert len(found) == len(here) > 4
    for ours, theirs in zip(found, here, strict=True):
        np.testing.assert_array_equal(ours[0], theirs[0])
        np.testing.assert_array_equal(ours[1], theirs[1])


def test_a_mesh_that_ends_coacds_process_ends_no_other() -> None:
    """A cup with points on its axis where triangles have no area: CoACD breaks down."""
    vertices, faces = meshes.revolved([(0.0, 0), (0.04, 0), (0.04, 0.1), (0.03, 0.1), (0.03, 0.01), (0.0, 0.01)], 12)
    assert coacd_process.searched(vertices, faces, 0.005) is None


def test_an_open_surface_is_parted_by_cells_that_hold_all_of_it_and_leave_its_inside_free() -> None:
    """Without a lid; CoACD takes it for a shell of 180,000 triangles."""
    vertices, faces = meshes.revolved([(0.0399, 0), (0.04, 0), (0.04, 0.1), (0.0399, 0.1)], 24)
    found = cell_parts((vertices, faces[: len(faces) - 8]))
    assert 20 < len(found) <= 6**3
    for vertex in vertices:
        assert any(
            (part.min(axis=0) - 1e-5 <= vertex).all() and (vertex <= part.max(axis=0) + 1e-5).all() for part in found
        )
    assert min(np.hypot(part[:, 0], part[:, 1]).min() for part in found) > 0.035


def test_a_mesh_too_fine_to_be_searched_is_parted_by_cells() -> None:
    scene = cell_scene(
        meshes.body("thing", "thing", (0, 0, 0), free=False) + BALL.format(0.06), meshes.cup(around=1_000)
    )
    assert 20 < len(only_parts_of(scene)) <= 6**3
    assert overlaps(Stage(scene), deeper_than_m=0.001) == {}


def test_more_large_triangles_than_cells_can_be_given_leave_the_hull(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr("taskgist.world.geometry.convex.PATCHES", 1_000)
    with caplog.at_level(logging.WARNING, "taskgist.world"):
        scene = mesh_scene(meshes.body("thing", "cup", (0, 0, 0)), cup=meshes.cup(around=999))
    assert len(only_parts_of(scene)) == 1
    assert "mesh 'cup' is concave, but the convex hull is taken" in caplog.text
    assert "simplify it" in caplog.text


def bins_in_a_room(count: int, *, limits: Limits) -> Scene:
    """A scene of bins, each a little wider than the one before."""
    bins: dict[str, Mesh] = {f"bin{i}": meshes.shell_bin((0.15 + i / 50, 0.1, 0.1)) for i in range(count)}
    bodies = "".join(meshes.body(name, name, (i, 0, 0), free=False) for i, name in enumerate(bins))
    return Scene.from_bundle(mesh_files(bodies, "", **bins), limits=limits)


def test_meshes_are_cut_for_so_long_and_the_rest_are_hulls_until_the_next_time(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, tmp_path: Path
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    with caplog.at_level(logging.WARNING, "taskgist.world"):
        scene = bins_in_a_room(8, limits=replace(DEFAULT.limits, cutting_s=0.0))
    first, *rest = [len(read_parts(scene.bundle[name])) for name in parts_of(scene)]
    assert first > 1, "what takes too long even if it is the first is parted by cells, for all times"
    assert rest == [1] * 7
    alone, others = caplog.messages
    assert alone.startswith("mesh 'bin0' is concave, and parted by the cells of a grid")
    assert others.startswith(
        "meshes 'bin1', 'bin2', 'bin3', 'bin4', 'bin5' and 2 more are concave, but the convex hull"
    )
    assert "limits.cutting_s" in others
    (kept,) = tmp_path.rglob("parts-*")
    assert kept.name == parts_of(scene)[0], "the next time, there is time again for the others"


def test_a_mesh_of_more_parts_than_allowed_is_a_hull_and_keeps_its_parts_for_who_allows_more(
    caplog: pytest.LogCaptureFixture,
) -> None:
    bodies = meshes.body("shelf", "shelf", (0, 0, 0), free=False)
    bundle = mesh_files(bodies, shelf=meshes.shelf())
    with caplog.at_level(logging.WARNING, "taskgist.world"):
        scene = Scene.from_bundle(bundle, limits=replace(DEFAULT.limits, mesh_parts=5))
    assert len(scene.solid_geoms_of("shelf")) == 1
    assert "mesh 'shelf' is concave, but the convex hull is taken: more than 5 parts" in caplog.text
    assert len(Scene.from_bundle(scene.bundle).solid_geoms_of("shelf")) == 6


def test_it_is_told_which_mesh_is_cut_of_how_many(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, tmp_path: Path
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    with caplog.at_level(logging.INFO, "taskgist.world"):
        bins_in_a_room(2, limits=replace(DEFAULT.limits, cutting_s=0.0))
    cutting = [message for message in caplog.messages if message.startswith("cutting")]
    assert cutting == [f"cutting concave meshes, once: 'bin{i}', {i + 1} of 2" for i in range(2)]
