"""Files of other programs, given as a model or as a mesh: named for what they are, with the way to convert them.

The content tells where it can, the ending of the name otherwise.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import PurePath
from typing import NamedTuple

from taskgist.errors import SceneError

MODELS = "models are MJCF (<mujoco>) and URDF (<robot>)"
MESHES = "meshes are OBJ, STL, COLLADA, PLY and MSH: save it as one of these"
BLENDER = "import it in Blender and export each thing as OBJ"
NAMED = "name these meshes in an MJCF"


class Foreign(NamedTuple):
    """What a file is, and the way out where it was given as a model, and as a mesh."""

    what: str
    as_model: str
    as_mesh: str


def _shapes(what: str, way: str = BLENDER) -> Foreign:
    return Foreign(what, f"{way}; {NAMED}", f"{way}, and name that file")


def _mesh(what: str) -> Foreign:
    return Foreign(f"{what}, a mesh and no model", f"name it in an MJCF: <mesh file=...>; {MODELS}", MESHES)


_SDF = Foreign(
    "SDF, the format of Gazebo",
    "convert it to MJCF: sdf2mjcf model.sdf model.xml (pip install sdformat-mjcf), or name the URDF that it came from",
    "name the mesh itself",
)
_USD = Foreign(
    "USD (Universal Scene Description)",
    f"export it as URDF (USD to URDF Exporter of Isaac Sim), or {BLENDER} and {NAMED}",
    f"{BLENDER}, and name that file",
)
_MESHLAB = "open it in MeshLab and export it as OBJ"
_CAD = "open it in FreeCAD and export each part as STL or OBJ"
KNOWN: Mapping[str, Foreign] = {
    "sdf": _SDF,
    "world": _SDF,
    **dict.fromkeys(("usd", "usda", "usdc", "usdz"), _USD),
    **dict.fromkeys(("glb", "gltf"), _shapes("glTF")),
    "fbx": _shapes("FBX"),
    "blend": _shapes("a Blender file", "open it in Blender and export each thing as OBJ"),
    "3ds": _shapes("3DS (3D Studio)", _MESHLAB),
    "max": _shapes("a file of 3ds Max", "export it there as OBJ"),
    "skp": _shapes("a SketchUp model", "export it there as COLLADA or OBJ"),
    **dict.fromkeys(("wrl", "vrml", "x3d"), _shapes("VRML or X3D", _MESHLAB)),
    **dict.fromkeys(("step", "stp"), _shapes("STEP, solids of CAD", _CAD)),
    **dict.fromkeys(("iges", "igs"), _shapes("IGES, surfaces of CAD", _CAD)),
    "ifc": _shapes("IFC, a building", "open it in Blender (Bonsai) or FreeCAD and export each thing as OBJ"),
    "off": _shapes("OFF", _MESHLAB),
    "3mf": _shapes("3MF", _CAD),
    "mesh": _shapes("a mesh of Ogre", "export it as OBJ where it was made"),
    "obj": _mesh("OBJ"),
    "stl": _mesh("STL"),
    "dae": _mesh("COLLADA"),
    "ply": _mesh("PLY"),
    "msh": _mesh("MSH"),
    "srdf": Foreign(
        "SRDF, which tells MoveIt about a robot of another file", "name the URDF of that robot", "name the mesh itself"
    ),
    "mjb": Foreign("MJB, a compiled model", "name the MJCF that it was compiled from", "name the mesh itself"),
    "mujocoinclude": Foreign(
        "a part of an MJCF, to be included", "name the document whose root is <mujoco>", "name the mesh itself"
    ),
    "xacro": Foreign(
        "xacro that is not expanded", "expand it first: xacro {name} > {new}, and name that file", "as a model"
    ),
}
"""By the endings of names, and the roots of XML documents that are called otherwise."""

BEGINNINGS: Mapping[bytes, str] = {
    b"#usda": "usda",
    b"PXR-USDC": "usdc",
    b"glTF": "glb",
    b"Kaydara FBX": "fbx",
    b"; FBX": "fbx",
    b"BLENDER": "blend",
    b"\xff\xfe\xff\x0eS\x00k\x00e\x00t\x00c\x00h\x00U\x00p": "skp",
    b"#VRML": "wrl",
    b"ply\n": "ply",
    b"ply\r": "ply",
    b"OFF\n": "off",
    b"MM": "3ds",
}
ROOTS = {"sdf": "sdf", "gazebo": "sdf", "COLLADA": "dae", "X3D": "x3d", "mujocoinclude": "mujocoinclude"}
HEAD_BYTES = 65_536
"""How much of a file is looked at."""
ROOT = re.compile(rb"<([A-Za-z][\w.-]*)")


def foreign_in(data: bytes, name: str) -> Foreign | None:
    """What a file is that is no MJCF or URDF; None if that is not known.

    Args:
        data: Its content, or the beginning of it.
        name: Its name.
    """
    head, ending = data[:HEAD_BYTES], PurePath(name.replace("\\", "/")).suffix.lower().removeprefix(".")
    start = head.lstrip(b"\xef\xbb\xbf \t\r\n")
    if start.startswith(b"ISO-10303-21"):
        return KNOWN["ifc" if b"FILE_SCHEMA(('IFC" in head.replace(b" ", b"") else "step"]
    if start.startswith(b"PK\x03\x04") and re.search(rb"\.usd[ac]?", head):
        return KNOWN["usdz"]
    for beginning, kind in BEGINNINGS.items():
        if start.startswith(beginning) and (len(beginning) > 2 or kind == ending):
            return KNOWN[kind]
    if start.startswith(b"{") and b'"asset"' in head:
        return KNOWN["gltf"]
    root = ROOT.search(re.sub(rb"<!--.*?-->", b"", start, flags=re.DOTALL)) if start.startswith(b"<") else None
    if root is not None and root[1].decode() in ROOTS:
        return KNOWN[ROOTS[root[1].decode()]]
    if root is not None and ending != "xacro":
        return None  # a document of its own kind, whatever its name
    return KNOWN.get(ending)


def check_model(data: bytes, name: str, where: str) -> None:
    """Refuse as a model what is none.

    Args:
        data: Its content, or the beginning of it.
        name: Its name.
        where: How messages name it.

    Raises:
        SceneError: It is known to be something else.
    """
    found = foreign_in(data, name)
    if found is not None:
        raise not_a_model(found, name, where)


def not_a_model(found: Foreign, name: str, where: str) -> SceneError:
    """The error to raise about a file that is no model."""
    old = PurePath(name).name
    stem = old.partition(".")[0]
    hint = found.as_model.format(name=old, new=f"{stem}_expanded.urdf" if old == f"{stem}.urdf" else f"{stem}.urdf")
    return SceneError(f"is {found.what}", where=where, hint=hint)
