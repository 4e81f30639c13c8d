"""A stranger's scene opens nothing but its own files: what it names elsewhere is refused; the kernel is the witness.

Each hostile scene names a file that is there and would do: were it opened, the scene would load, and inotify, which
sees what MuJoCo opens in C as well, would say so. The same scenes with a pipe in its place would never end.
"""

from __future__ import annotations

import ctypes
import os
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

import mujoco
import pytest

from taskgist.errors import InputError
from taskgist.world import Scene

OBJ = b"v 0 0 0\nv .1 0 0\nv 0 .1 0\nv 0 0 .1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
INNER = b"<mujoco><worldbody><body name='inner'><geom size='0.1'/></body></worldbody></mujoco>"
PROFILE_OF = "[agents.P1]\nprofile = '{}'\n"
SCENE = '[scene]\nmodel = "room.xml"\n'
MESH = "<asset><mesh name='m' file='{}'/></asset><worldbody><geom type='mesh' mesh='m'/></worldbody>"
URDF = (
    "<robot name='r'>{}<link name='w'/>"
    "<link name='a'><visual><geometry><mesh filename='{}'/></geometry></visual></link>"
    "<joint name='j' type='fixed'><parent link='w'/><child link='a'/></joint></robot>"
)
ENTITY = "<!DOCTYPE mujoco [<!ENTITY x SYSTEM '{}'>]><mujoco><worldbody><body name='b'>&x;</body></worldbody></mujoco>"


def room(text: str, **files: bytes) -> dict[str, bytes]:
    return {"scene.toml": SCENE.encode(), "room.xml": f"<mujoco>{text}</mujoco>".encode(), **files}


def hostile(secret: Path) -> Iterator[tuple[str, dict[str, bytes]]]:
    """Scenes that name files in a folder: an OBJ, an MJCF, a PNG and a profile."""
    mesh, inner, image = secret / "mesh.obj", secret / "inner.xml", secret / "image.png"
    there = os.path.relpath(mesh, Path.cwd())
    escaped = str(mesh).replace("/", "&#47;").replace("m", "&#x6d;")
    for name in (mesh, there, f"./{there}", f"file://{mesh}", f"FILE://{mesh}", f"package://{mesh}", escaped):
        yield f"mesh {name}", room(MESH.format(name))
    for name in (str(mesh).replace("/", "\\"), f"//{mesh}", f"/proc/self/cwd/{there}", "/proc/self/environ"):
        yield f"mesh {name}", room(MESH.format(name))
    typed = f"<asset><mesh name='m' content_type='model/obj' file='{mesh}'/></asset>"
    yield "mesh with a type", room(f"{typed}<worldbody><geom type='mesh' mesh='m'/></worldbody>")
    for key in ("meshdir", "assetdir"):
        yield key, room(f"<compiler {key}='{secret}'/>{MESH.format('mesh.obj')}")
        yield f"{key} that strips", room(f"<compiler {key}='{secret}' strippath='true'/>{MESH.format('a/mesh.obj')}")
    yield (
        "folder of an include",
        room(
            f"<include file='o.xml'/>{MESH.format('mesh.obj')}",
            **{"o.xml": f"<x><compiler meshdir='{secret}'/></x>".encode()},
        ),
    )
    yield "height field", room(f"<asset><hfield name='h' file='{image}' size='1 1 1 1'/></asset>")
    flex = f"<flexcomp name='f' type='mesh' dim='2' file='{mesh}'/>"
    yield "flexible mesh", room(f"<worldbody><body name='b'>{flex}</body></worldbody>")
    for name in (inner, os.path.relpath(inner, Path.cwd()), f"file://{inner}"):
        yield f"include {name}", room(f"<include file='{name}'/>")
    yield "INCLUDE", room(f"<INCLUDE file='{inner}'/>")
    outer = f"<x><include file='{inner}'/></x>".encode()
    yield "include of an include", room("<include file='outer.xml'/>", **{"outer.xml": outer})
    attach = "<worldbody><frame><attach model='c' body='inner' prefix='c'/></frame></worldbody>"
    yield "model", room(f"<asset><model name='c' file='{inner}'/></asset>{attach}")
    child = INNER.replace(b"<worldbody>", f"<include file='{inner}'/><worldbody>".encode())
    yield "include of a model", room(f"<asset><model name='c' file='c.xml'/></asset>{attach}", **{"c.xml": child})
    yield "entity", {"scene.toml": SCENE.encode(), "room.xml": ENTITY.format(inner).encode()}
    for name in (mesh, there, f"file://{mesh}", f"package://{mesh}"):
        yield f"URDF {name}", room("") | {"room.xml": URDF.format("", name).encode()}
    there_too = f"<mujoco><compiler meshdir='{secret}'/></mujoco>"
    yield "URDF meshdir", room("") | {"room.xml": URDF.format(there_too, "mesh.obj").encode()}
    yield "URDF entity", room("") | {"room.xml": ENTITY.format(inner).replace("mujoco", "robot").encode()}
    yield "model of the scene", room("") | {"scene.toml": f"[scene]\nmodel = '{inner}'".encode()}
    for table in (
        f"[furniture.f]\nmodel = '{inner}'",
        f"[objects.f]\nmodel = '{inner}'",
        f"[objects.f]\nmesh = '{mesh}'",
    ):
        yield f"put in {table}", room("") | {"scene.toml": f"{SCENE}{table}\n".encode()}
        whole = f"<mujoco>{MESH.format(mesh)}</mujoco>".encode()
        held = {"f.furniture.xml": whole, "f.object.xml": whole}
        yield f"mesh of {table}", room("") | held | {"scene.toml": f"{SCENE}{table}\n".encode()}
    for name in (secret / "own.toml", secret / "own", os.path.relpath(secret / "own", Path.cwd())):
        yield f"profile {name}", room("") | {"scene.toml": (SCENE + PROFILE_OF.format(name)).encode()}
    for name in (inner, f"package://{secret.name}/inner.xml"):
        own = f"model = '{name}'\nname = 'x'\n[eye]\nframe='inner'\nexclude='inner'\nfov_deg=[9,9]\nimage_px=[9,9]\n"
        files = {"P1.profile.toml": own.encode()}
        yield f"model {name}", room("") | files | {"scene.toml": (SCENE + PROFILE_OF.format("human")).encode()}


def decorated(image: Path) -> Iterator[dict[str, bytes]]:
    """Scenes whose textures and skins name a file in a folder."""
    yield room(f"<deformable><skin name='s' file='{image}'/></deformable>")
    yield room(f"<asset><texture name='t' type='2d' file='{image}'/><material name='m' texture='t'/></asset>")
    yield room(f"<asset><texture name='t' type='cube' fileright='{image}'/></asset>")
    asset = f"<asset><texture name='t' type='2d' file='{image.name}'/></asset>"
    yield room(f"<compiler texturedir='{image.parent}'/>{asset}")


@pytest.fixture
def secret(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with files that a scene might want; processes run in one beside it."""
    folder, beside = tmp_path / "secret", tmp_path / "beside"
    folder.mkdir()
    beside.mkdir()
    monkeypatch.chdir(beside)
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    return folder


def filled(secret: Path) -> None:
    contents: Mapping[str, bytes] = {
        "mesh.obj": OBJ,
        "inner.xml": INNER,
        "image.png": b"no image",
        "own.toml": b"name='x'",
    }
    for name, content in contents.items():
        (secret / name).write_bytes(content)


IN_OPEN = 0x20


class Opened:
    """Names of files in a folder that anybody opened, as the kernel tells."""

    def __init__(self, folder: Path) -> None:
        libc = ctypes.CDLL(None, use_errno=True)
        self._descriptor = libc.inotify_init1(os.O_NONBLOCK)
        assert libc.inotify_add_watch(self._descriptor, str(folder).encode(), IN_OPEN) >= 0

    def __call__(self) -> bytes:
        try:
            return os.read(self._descriptor, 1 << 16)
        except BlockingIOError:
            return b""


@pytest.mark.skipif(sys.platform != "linux", reason="inotify is Linux's")
def test_nothing_outside_of_a_strangers_scene_is_opened(secret: Path) -> None:
    filled(secret)
    opened = Opened(secret)
    mujoco.MjSpec.from_string(f"<mujoco>{MESH.format(secret / 'mesh.obj')}</mujoco>").compile()
    assert b"mesh.obj" in opened(), "the witness sees what MuJoCo opens"
    for what, bundle in hostile(secret):
        with pytest.raises(InputError):
            Scene.from_bundle(bundle)
        assert not opened(), what
    for bundle in decorated(secret / "image.png"):
        assert Scene.from_bundle(bundle).model.ntex == 0, "nothing here looks at images"
        assert not opened()


def test_pipes_that_a_strangers_scene_names_hold_nobody_up(secret: Path) -> None:
    for name in ("mesh.obj", "inner.xml", "image.png", "own.toml"):
        os.mkfifo(secret / name)
    code = (
        "import sys\nfrom pathlib import Path\n"
        "from taskgist.errors import InputError\nfrom taskgist.world import Scene\n"
        "from tests.world.test_strangers_scenes import hostile\n"
        "for what, bundle in hostile(Path(sys.argv[1])):\n"
        "    try:\n        Scene.from_bundle(bundle)\n        sys.exit(what)\n    except InputError:\n        pass\n"
        "print('done')\n"
    )
    root = str(Path(__file__).parents[2])
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([root, *sys.path])}
    done = subprocess.run(
        [sys.executable, "-c", code, str(secret)],
        env=environment,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert (done.returncode, done.stdout) == (0, "done\n"), done.stderr
    assert done.stderr == "", "nothing of MuJoCo's reaches the terminal"


def test_a_users_own_scene_follows_its_files_and_becomes_a_scene_of_its_own(tmp_path: Path) -> None:
    """Every kind of file that a scene on disk may name is found, carried along, and found again without the disk."""
    (tmp_path / "models" / "meshes").mkdir(parents=True)
    (tmp_path / "models" / "parts").mkdir()
    (tmp_path / "scenes").mkdir()
    (tmp_path / "models" / "meshes" / "cup.obj").write_bytes(OBJ)
    (tmp_path / "models" / "parts" / "cup.obj").write_bytes(OBJ.replace(b".1", b".2"))
    (tmp_path / "models" / "parts" / "more.xml").write_text("<x><include file='most.xml'/></x>")
    (tmp_path / "models" / "parts" / "most.xml").write_text(
        "<x><asset><mesh name='large' file='../parts/cup.obj'/></asset>"
        "<worldbody><body name='large'><freejoint/><geom type='mesh' mesh='large'/></body></worldbody></x>"
    )
    (tmp_path / "models" / "parts" / "child.xml").write_text(
        "<mujoco model='child'><asset><mesh file='cup.obj'/></asset>"
        "<worldbody><body name='third'><geom type='mesh' mesh='cup'/></body></worldbody></mujoco>"
    )
    (tmp_path / "models" / "room.xml").write_text(
        "<mujoco><!-- who made it --><compiler meshdir='meshes'/><include file='parts/more.xml'/>"
        "<asset><mesh file='cup.obj'/><model name='child' file='parts/child.xml'/></asset>"
        "<worldbody><body name='cup'><freejoint/><geom type='mesh' mesh='cup'/></body>"
        "<attach model='child' body='third' prefix='a-'/></worldbody></mujoco>"
    )
    path = tmp_path / "scenes" / "scene.toml"
    path.write_text("[scene]\nmodel = '../models/room.xml'\n")
    scene = Scene.load(path)
    for folder in ("models", "scenes"):
        (tmp_path / folder).rename(tmp_path / f"no {folder}")
    again = Scene.from_bundle(scene.bundle)
    assert again.bundle == scene.bundle
    for each in (scene, again):
        assert each.objects == ("large", "cup")
        half_m = [each.model.geom_aabb[each.object_geoms(name)[0], 3:].max() for name in each.objects]
        assert half_m[0] > 1.9 * half_m[1], "two files of one name stay two"
        assert "a-third" in each.bodies
