"""Meshes without thickness (floors, posters, cloth) are seen from both sides, carry, and block, whatever holds them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from taskgist.errors import SceneError
from taskgist.settings import DEFAULT
from taskgist.world import Scene, Stage, overlaps, support_of
from tests import meshes
from tests.meshes import Mesh

CONTACT = DEFAULT.contact
BALL = '<body name="ball" pos="{}"><freejoint/><geom type="sphere" size="0.03"/></body>'
SQUARE: Mesh = (
    np.array([(-0.5, -0.5, 0), (0.5, -0.5, 0), (0.5, 0.5, 0), (-0.5, 0.5, 0)], dtype=float),
    np.array([(0, 1, 2), (0, 2, 3)]),
)
ELL: Mesh = (
    np.array([(-1, -1, 0), (1, -1, 0), (1, 0, 0), (0, 0, 0), (0, 1, 0), (-1, 1, 0)], dtype=float),
    np.array([(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]),
)


def facing_down(mesh: Mesh) -> Mesh:
    return mesh[0], mesh[1][:, ::-1]


def on_both_sides(mesh: Mesh) -> Mesh:
    return meshes.joined(mesh, facing_down(mesh))


def rounded(mesh: Mesh) -> Mesh:
    """As exporters write the corners of a plane that is turned: the library that makes hulls warns of such meshes."""
    return mesh[0] + np.random.default_rng(3).normal(size=mesh[0].shape) * 1e-8, mesh[1]


KINDS = {
    "up": SQUARE,
    "down": facing_down(SQUARE),
    "both": on_both_sides(SQUARE),
    "rounded": rounded(SQUARE),
    "concave": ELL,
}


def flat_scene(mesh: Mesh, ball_at: str) -> Scene:
    """A board in the air and a ball somewhere."""
    return meshes.mesh_scene(meshes.body("board", "board", (0, 0, 1), free=False) + BALL.format(ball_at), board=mesh)


@pytest.mark.parametrize("kind", KINDS)
def test_it_is_seen_from_both_sides_carries_and_blocks(kind: str) -> None:
    stage = Stage(flat_scene(KINDS[kind], "-0.3 -0.3 1.03"))
    board = set(stage.scene.geoms_of("board").tolist())
    for height_m, way in ((2.0, -1.0), (0.5, 1.0)):
        hits, away_m = stage.cast((0.2, -0.3, height_m), [(0.0, 0.0, way)])
        assert hits[0] in board
        assert away_m[0] == pytest.approx(abs(height_m - 1.0), abs=0.002)
    assert support_of(stage, "ball", CONTACT) == "board"
    assert overlaps(stage, deeper_than_m=0.002) == {}
    at = stage.scene.object_slice("ball")
    stage.show(stage.state.replace(at=at, to=(-0.3, -0.3, 1.0, 1, 0, 0, 0)))
    assert ("ball", "board") in overlaps(stage, deeper_than_m=0.02)


def test_what_a_concave_floor_leaves_free_is_free() -> None:
    stage = Stage(flat_scene(ELL, "0.5 0.5 1.0"))
    assert overlaps(stage, deeper_than_m=0.0) == {}
    hits, _ = stage.cast((0.5, 0.5, 2.0), [(0.0, 0.0, -1.0)], exclude_body=stage.scene.object_body("ball"))
    assert stage.scene.owners[hits[0]] != "board"


def test_a_cloth_is_an_object_that_lies_on_what_is_beneath_it() -> None:
    cloth = meshes.body("cloth", "board", (0, 0, 1.001))
    table = '<body name="table" pos="0 0 0.95"><geom type="box" size="0.6 0.6 0.05"/></body>'
    files = meshes.mesh_files(cloth + table, board=SQUARE)
    stage = Stage(Scene.from_bundle(files))
    assert support_of(stage, "cloth", CONTACT) == "table"
    mass_kg = float(stage.scene.model.body_mass[stage.scene.object_body("cloth")])
    assert mass_kg == pytest.approx(1.0, rel=0.01), "a square metre of a millimetre"


def test_crossed_boards_without_thickness_are_what_they_are() -> None:
    upright = SQUARE[0][:, (0, 2, 1)], SQUARE[1]
    stage = Stage(flat_scene(meshes.joined(SQUARE, upright), "0.2 0.2 1.1"))
    assert overlaps(stage, deeper_than_m=0.0) == {}
    hits, away_m = stage.cast((0.2, 2.0, 1.2), [(0.0, -1.0, 0.0)], exclude_body=stage.scene.object_body("ball"))
    assert stage.scene.owners[hits[0]] == "board"
    assert away_m[0] == pytest.approx(2.0, abs=0.002)


def test_a_flat_part_of_a_solid_mesh_blocks_and_is_seen() -> None:
    lid = SQUARE[0] + (0, 0, 0.5), SQUARE[1]
    stage = Stage(flat_scene(meshes.joined(meshes.board((0, 0, 0), (0.1, 0.1, 0.1)), lid), "0.4 0.4 1.53"))
    assert support_of(stage, "ball", CONTACT) == "board"
    assert overlaps(stage, deeper_than_m=0.002) == {}


def test_a_wall_without_thickness_hides(capfd: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """As a file on disk, in which hulls are made of what is nearly flat: the terminal stays silent."""
    turned = rounded(SQUARE)[0][:, (2, 0, 1)], SQUARE[1]
    bodies = meshes.body("wall", "wall", (1, 0, 1), free=False) + BALL.format("2 0 1")
    for name, content in meshes.mesh_files(bodies, wall=turned).items():
        (tmp_path / name).write_bytes(content)
    scene = Scene.load(tmp_path / "scene.toml")
    hits, _ = Stage(scene).cast((0.0, 0.0, 1.0), [(1.0, 0.0, 0.0)])
    assert scene.owners[hits[0]] == "wall"
    assert Scene.from_bundle(scene.bundle).bundle == scene.bundle
    assert capfd.readouterr() == ("", "")


NEEDLE: Mesh = (np.array([(0, 0, 0), (1, 0, 0), (2, 1e-9, 0), (3, 0, 1e-9)]), np.array([(0, 1, 2), (0, 2, 3)]))


@pytest.mark.parametrize(
    ("mesh", "says"),
    [(NEEDLE, "a mesh that is a line"), ((SQUARE[0] * 1e9, SQUARE[1]), r"a mesh that is 1e\+09 m long")],
)
def test_of_what_no_hull_can_be_made_is_told_once(
    mesh: Mesh, says: str, capfd: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    for name, content in meshes.mesh_files(meshes.body("it", "it", (0, 0, 1), free=False), it=mesh).items():
        (tmp_path / name).write_bytes(content)
    with pytest.raises(SceneError, match=rf"room\.xml: mesh 'it': {says}"):
        Scene.load(tmp_path / "scene.toml")
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("kind", ["obj", "stl", "dae"])
def test_so_are_those_of_a_urdf(kind: str, tmp_path: Path) -> None:
    write = {"obj": meshes.obj, "stl": meshes.stl, "dae": meshes.dae}[kind]
    (tmp_path / f"poster.{kind}").write_bytes(write(SQUARE))
    shape = f'<geometry><mesh filename="poster.{kind}" scale="0.5 0.5 0.5"/></geometry>'
    ball = '<geometry><sphere radius="0.03"/></geometry>'
    (tmp_path / "room.urdf").write_text(
        f"""<robot name="room"><link name="room"/>
        <link name="poster"><visual>{shape}</visual><collision>{shape}</collision></link>
        <joint name="a" type="fixed"><parent link="room"/><child link="poster"/><origin xyz="0 0 1"/></joint>
        <link name="ball"><visual>{ball}</visual><collision>{ball}</collision></link>
        <joint name="b" type="floating"><parent link="room"/><child link="ball"/><origin xyz="0.1 0.1 1.03"/></joint>
        </robot>"""
    )
    (tmp_path / "scene.toml").write_text('[scene]\nmodel = "room.urdf"')
    stage = Stage(Scene.load(tmp_path / "scene.toml"))
    assert support_of(stage, "ball", CONTACT) == "poster"
    assert overlaps(stage, deeper_than_m=0.002) == {}
    assert len(stage.scene.solid_geoms_of("poster")) == 1
