"""Meshes for tests, as OBJ text: closed shells of revolution, boards, tubes."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from taskgist.world import Scene
from tests.scenes import FLOOR

Vertices = NDArray[np.float64]
Faces = NDArray[np.intp]
Mesh = tuple[Vertices, Faces]
CORNERS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
BOARD = np.array(
    [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1)]
    + [(2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]
)


def obj(mesh: Mesh) -> bytes:
    vertices, faces = mesh
    lines = [f"v {x:.10g} {y:.10g} {z:.10g}" for x, y, z in vertices] + [f"f {a} {b} {c}" for a, b, c in faces + 1]
    return "\n".join(lines).encode()


def stl(mesh: Mesh) -> bytes:
    """Binary STL, in which every triangle has vertices of its own."""
    vertices, faces = mesh
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attributes", "<u2")])
    triangles = np.zeros(len(faces), dtype=record)
    triangles["corners"] = vertices[faces]
    return bytes(80) + np.array([len(faces)], dtype="<u4").tobytes() + triangles.tobytes()


def dae(mesh: Mesh) -> bytes:
    """COLLADA of one geometry, in metres."""
    vertices, faces = mesh
    numbers = " ".join(f"{number:.9g}" for number in vertices.ravel())
    source = f'<source id="p"><float_array id="a" count="{vertices.size}">{numbers}</float_array></source>'
    corners = '<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>'
    indices = f'<input semantic="VERTEX" source="#v" offset="0"/><p>{" ".join(map(str, faces.ravel()))}</p>'
    shape = f'<mesh>{source}{corners}<triangles count="{len(faces)}">{indices}</triangles></mesh>'
    geometries = f'<library_geometries><geometry id="g">{shape}</geometry></library_geometries>'
    node = '<visual_scene id="s"><node><instance_geometry url="#g"/></node></visual_scene>'
    scenes = f'<library_visual_scenes>{node}</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene>'
    return f'<COLLADA version="1.4.1"><asset><unit meter="1"/></asset>{geometries}{scenes}</COLLADA>'.encode()


def joined(*meshes: Mesh) -> Mesh:
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in meshes)])
    faces = [faces + start for (_, faces), start in zip(meshes, starts, strict=False)]
    return np.concatenate([vertices for vertices, _ in meshes]), np.concatenate(faces)


def board(center: tuple[float, float, float], half: tuple[float, float, float]) -> Mesh:
    return CORNERS * half + center, BOARD


def octahedron(radius: float) -> Mesh:
    tips = radius * np.concatenate((np.eye(3), -np.eye(3)))
    upper = [(0, 1, 2), (1, 3, 2), (3, 4, 2), (4, 0, 2)]
    return tips, np.array(upper + [(b, a, 5) for a, b, _ in upper])


def revolved(profile: list[tuple[float, float]], around: int) -> Mesh:
    """A closed profile (radius, height), counter-clockwise, turned about the vertical."""
    count = len(profile)
    angles = 2 * math.pi * np.arange(around) / around
    vertices = [(r * math.cos(a), r * math.sin(a), z) for a in angles for r, z in profile]
    faces = []
    for i in range(around):
        for j in range(count):
            a, b = i * count + j, (i + 1) % around * count + j
            c, d = (i + 1) % around * count + (j + 1) % count, i * count + (j + 1) % count
            faces += [(a, b, c), (a, c, d)]
    return np.array(vertices), np.array(faces)


def cup(radius: float = 0.04, height: float = 0.10, thick: float = 0.004, around: int = 12) -> Mesh:
    inner = radius - thick
    profile = [(1e-4, 0), (radius, 0), (radius, height), (inner, height), (inner, thick), (1e-4, thick)]
    return revolved(profile, around)


def handle(at: float = 0.038, out: float = 0.035, half: float = 0.03, thick: float = 0.012) -> Mesh:
    """A bow of boards beside a cup."""
    bar = board((at + out, 0, 0.05), (thick / 2, thick / 2, half + thick / 2))
    long = out - thick / 2
    ends = [board((at + long / 2, 0, 0.05 + sign * half), (long / 2, thick / 2, thick / 2)) for sign in (-1, 1)]
    return joined(bar, *ends)


def mug() -> Mesh:
    return joined(cup(), handle())


def bowl(radius: float = 0.08, thick: float = 0.005, around: int = 16) -> Mesh:
    angles = np.linspace(-math.pi / 2 + 1e-3, -0.1, 6)
    outer = [(radius * math.cos(a), radius * math.sin(a)) for a in angles]
    inner = [((radius - thick) * math.cos(a), (radius - thick) * math.sin(a)) for a in angles[::-1]]
    return revolved(outer + inner, around)


def shell_bin(half: tuple[float, float, float] = (0.15, 0.10, 0.10), thick: float = 0.01) -> Mesh:
    """One shell: outside, inside and rim."""
    outside = CORNERS * half + (0, 0, half[2])
    inside = CORNERS * (half[0] - thick, half[1] - thick, half[2] - thick / 2) + (0, 0, half[2] + thick / 2)
    rim: list[tuple[int, int, int]] = []
    top = (1, 5, 7, 3)
    for a, b in zip(top, (*top[1:], top[0]), strict=True):
        rim += [(a, b, b + 8), (a, b + 8, a + 8)]
    return np.concatenate((outside, inside)), np.concatenate((BOARD[:10], BOARD[:10, ::-1] + 8, rim))


def shelf() -> Mesh:
    """Narrow compartments of 20 cm between boards, open towards -x."""
    boards = [board((0, 0, z), (0.2, 0.14, 0.01)) for z in (0.79, 1.01, 1.23)]
    sides = [board((0, y, 1.01), (0.2, 0.01, 0.23)) for y in (-0.15, 0.15)]
    return joined(*boards, *sides, board((0.21, 0, 1.01), (0.01, 0.16, 0.23)))


def mesh_files(bodies: str, agents: str = "", /, **meshes: Mesh) -> dict[str, bytes]:
    """The files of a room with bodies that use meshes by name."""
    assets = "".join(f'<mesh name="{name}" file="{name}.obj"/>' for name in meshes)
    room = f"<mujoco><asset>{assets}</asset><worldbody>{FLOOR}{bodies}</worldbody></mujoco>"
    texts = {"scene.toml": f'[scene]\nmodel = "room.xml"\n{agents}'.encode(), "room.xml": room.encode()}
    return {**texts, **{f"{name}.obj": obj(mesh) for name, mesh in meshes.items()}}


def mesh_scene(bodies: str, agents: str = "", files: dict[str, bytes] | None = None, **meshes: Mesh) -> Scene:
    """A room with bodies that use meshes by name; ``files`` come in addition."""
    return Scene.from_bundle({**mesh_files(bodies, agents, **meshes), **(files or {})})


def body(name: str, mesh: str, place: tuple[float, float, float], *, free: bool = True) -> str:
    joint = "<freejoint/>" if free else ""
    at = " ".join(map(str, place))
    return f'<body name="{name}" pos="{at}">{joint}<geom type="mesh" mesh="{mesh}"/></body>'
