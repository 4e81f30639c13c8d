"""Meshes of every kind that is read make the same scene, however many triangles they have."""

from __future__ import annotations

import struct
from collections.abc import Callable
from functools import partial
from pathlib import Path

import mujoco
import numpy as np
import pytest

from taskgist.errors import SceneError
from taskgist.world import Scene
from taskgist.world.bodies.meshes import STL_FACES, STL_HEADER, readable_mesh
from taskgist.world.bodies.ply import triangles_from_ply
from tests import meshes
from tests.meshes import Mesh

HEAD = "ply\nformat {order} 1.0\ncomment a ball\nelement vertex {points}\nproperty float x\nproperty float y\n"
HEAD += "property double z\nproperty uchar red\nelement face {faces}\nproperty list uchar int vertex_indices\n"
HEAD += "property uchar shade\nelement edge 1\nproperty int a\nend_header\n"


def ply(mesh: Mesh, order: str = "ascii") -> bytes:
    """With colours of vertices, a shade of each face, and edges, none of which matter."""
    vertices, faces = mesh
    head = HEAD.format(order=order, points=len(vertices), faces=len(faces)).encode()
    if order == "ascii":
        lines = [f"{x:.9g} {y:.9g} {z:.9g} 255" for x, y, z in vertices]
        return head + "\n".join([*lines, *(f"3 {a} {b} {c} 7" for a, b, c in faces), "0"]).encode()
    sign = "<" if "little" in order else ">"
    points = b"".join(struct.pack(f"{sign}ffdB", x, y, z, 255) for x, y, z in vertices)
    return head + points + b"".join(struct.pack(f"{sign}B3iB", 3, *face, 7) for face in faces) + bytes(4)


def stl_text(mesh: Mesh) -> bytes:
    vertices, faces = mesh
    lines = ["solid ball"]
    for corners in vertices[faces]:
        loop = "\n".join(f"      vertex {x:.9e} {y:.9e} {z:.9e}" for x, y, z in corners)
        lines.append(f"  facet normal 0 0 0\n    outer loop\n{loop}\n    endloop\n  endfacet")
    return "\n".join([*lines, "endsolid ball"]).encode()


def obj_with_looks(mesh: Mesh) -> bytes:
    """As modelling programs write it: normals and texture that MuJoCo stumbles on, materials, polygons."""
    vertices, faces = mesh
    lines = ["# made in 2020/10/1", "mtllib ball.mtl", "o Ball"]
    lines += [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in vertices] + ["vt 0.5 0.5", "vn 0 0 1", "usemtl red"]
    lines += [f"f {a}/9/9 {b}/9/9 {c}//9" for a, b, c in faces + 1]
    return "\n".join(lines).encode()


KINDS: dict[str, Callable[[Mesh], bytes]] = {
    "obj": meshes.obj,
    "looks.obj": obj_with_looks,
    "stl": meshes.stl,
    "text.stl": stl_text,
    "dae": meshes.dae,
    "ply": ply,
    "little.ply": partial(ply, order="binary_little_endian"),
    "big.ply": partial(ply, order="binary_big_endian"),
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("model", ["xml", "urdf"])
def test_every_kind_is_the_same_shape(kind: str, model: str, tmp_path: Path) -> None:
    mesh = meshes.octahedron(0.1)
    (tmp_path / f"ball.{kind}").write_bytes(KINDS[kind](mesh))
    shape = f'<geometry><mesh filename="ball.{kind}"/></geometry>'
    texts = {
        "xml": f'<mujoco><asset><mesh name="m" file="ball.{kind}"/></asset><worldbody><body name="ball"><freejoint/>'
        '<geom type="mesh" mesh="m"/></body></worldbody></mujoco>',
        "urdf": f'<robot name="r"><link name="r"/><link name="ball"><visual>{shape}</visual></link>'
        '<joint name="j" type="floating"><parent link="r"/><child link="ball"/></joint></robot>',
    }
    (tmp_path / f"room.{model}").write_text(texts[model])
    (tmp_path / "scene.toml").write_text(f'[scene]\nmodel = "room.{model}"')
    scene = Scene.load(tmp_path / "scene.toml")
    (geom,) = scene.seen_geoms("ball").tolist()
    points, _ = scene.surface_points(geom, 0.01)
    assert np.abs(points).sum(axis=1) == pytest.approx(0.1, abs=1e-5)
    assert Scene.from_bundle(scene.bundle).bundle == scene.bundle


@pytest.mark.parametrize("kind", KINDS)
def test_a_specification_may_have_every_kind_too(kind: str) -> None:
    spec = mujoco.MjSpec()
    spec.add_mesh(name="m", file=f"ball.{kind}")
    spec.assets = {f"ball.{kind}": KINDS[kind](meshes.octahedron(0.1))}
    spec.worldbody.add_body(name="ball").add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="m")
    scene = Scene.from_spec(spec)
    assert scene.model.nmeshface == 8
    assert scene.model.mesh_vertnum.tolist() == [6]


def fine_ball(steps: int) -> Mesh:
    angles = np.linspace(0.05, np.pi - 0.05, steps)
    return meshes.revolved([(0.02 * np.sin(a), 0.02 * np.cos(a)) for a in angles[::-1]], steps)


def test_stl_has_no_most_triangles_of_its_own() -> None:
    vertices, faces = fine_ball(320)
    assert len(faces) > STL_FACES, "more than MuJoCo reads from STL"
    data, ending = readable_mesh(meshes.stl((vertices, faces)), "ball.stl", where="room.urdf")
    assert ending == ".msh"
    count, _, _, triangles = struct.unpack("<4i", data[:16])
    assert (count, triangles) == (len(vertices), len(faces)), "corners that are shared are kept once"
    text = '<mujoco><asset><mesh name="m" file="m.msh"/></asset><worldbody>'
    text += '<geom type="mesh" mesh="m" contype="0" conaffinity="0"/></worldbody></mujoco>'
    bundle = {"scene.toml": b'[scene]\nmodel = "room.xml"', "room.xml": text.encode(), "m.msh": data}
    assert Scene.from_bundle(bundle).model.nmeshface == len(faces)


def test_nor_has_collada(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("taskgist.world.bodies.meshes.STL_FACES", 100)
    vertices, faces = fine_ball(10)
    data, ending = readable_mesh(meshes.dae((vertices, faces)), "ball.dae", where="room.urdf")
    assert (ending, struct.unpack("<4i", data[:16])) == (".msh", (100, 0, 0, 200))


def test_small_ones_stay_stl() -> None:
    data, ending = readable_mesh(meshes.dae(meshes.octahedron(1.0)), "ball.dae", where="room.urdf")
    assert (ending, int.from_bytes(data[STL_HEADER - 4 : STL_HEADER], "little")) == (".stl", 8)


SOLID = b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 {} 0\nendloop\nendfacet\n"


@pytest.mark.parametrize(
    ("data", "name", "says"),
    [
        (SOLID.replace(b"{}", b"nan"), "a.stl", "not finite numbers"),
        (SOLID.replace(b"{}", b"one"), "a.stl", "not an STL that can be read"),
        (b"solid a\nfacet\nendsolid", "a.stl", "no triangles in this mesh"),
        (b"ply\nformat ascii 1.0\n", "a.ply", "its head has no end; save it as STL or OBJ"),
        (b"ply\nformat strange 1.0\nelement vertex 1\nend_header\n", "a.ply", "not a PLY mesh that can be read"),
        (ply(meshes.octahedron(1.0)).replace(b"3 0 1 2 7", b"3 0 1 99 7"), "a.ply", "not a PLY mesh that can be read"),
        (ply(meshes.octahedron(1.0)).replace(b"3 0 1 2 7", b"3 0 -1 2 7"), "a.ply", "before the first"),
        (ply(meshes.octahedron(1.0)).replace(b"vertex 6", b"vertex 999999999"), "a.ply", "limits.mesh_faces"),
        (ply(meshes.octahedron(1.0))[:-40], "a.ply", "not a PLY mesh that can be read"),
        (ply((meshes.octahedron(1.0)[0], np.empty((0, 3), int))), "a.ply", "no triangles in this mesh"),
        (b"glTF\x02\0\0\0", "a.glb", "is glTF; import it in Blender and export each thing as OBJ, and name that file"),
        (b"glTF\x02\0\0\0", "a.bin", "is glTF"),
        (b"BLENDER-v300", "a.blend", "is a Blender file"),
        (b"ISO-10303-21;HEADER;", "part.stp", "is STEP, solids of CAD; open it in FreeCAD"),
        (b"whatever", "a.xyz", "is no mesh that is read; meshes are OBJ, STL, COLLADA, PLY and MSH"),
    ],
)
def test_what_cannot_be_read_is_told_with_the_way_out(data: bytes, name: str, says: str) -> None:
    with pytest.raises(SceneError) as error:
        readable_mesh(data, name, where="room.xml")
    assert says in str(error.value)
    assert name in str(error.value)


@pytest.mark.parametrize("order", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_polygons_of_ply_are_cut_into_fans(order: str) -> None:
    square = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], dtype=float)
    data = ply((square, np.array([(0, 1, 2)])), order)
    if order == "ascii":
        data = data.replace(b"3 0 1 2 7", b"4 0 1 2 3 7")
    else:
        sign = "<" if "little" in order else ">"
        data = data.replace(struct.pack(f"{sign}B3iB", 3, 0, 1, 2, 7), struct.pack(f"{sign}B4iB", 4, 0, 1, 2, 3, 7))
    triangles = triangles_from_ply(data, "a.ply")
    assert triangles.tolist() == square[[(0, 1, 2), (0, 2, 3)]].tolist()
