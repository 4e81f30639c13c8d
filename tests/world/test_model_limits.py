"""What a model asks for is refused before memory is taken for it, and what MuJoCo must not see, before it does."""

from __future__ import annotations

import logging
import os
import pickle
import struct
import zlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from taskgist.errors import InputError, SceneError
from taskgist.settings import DEFAULT
from taskgist.world import Scene
from taskgist.world.bodies.collada import triangles_from_dae
from taskgist.world.bodies.markup import parse_markup, written
from tests import meshes
from tests.world.test_urdf import ROOM as URDF_ROOM
from tests.world.test_urdf import dae

CUP = '<body name="cup" pos="0 0 0.8"><freejoint/><geom type="cylinder" size="{} {}"/></body>'
SCENE = b'[scene]\nmodel = "room.xml"\n'


def bundle(text: str, scene: bytes = SCENE, **files: bytes) -> dict[str, bytes]:
    return {"scene.toml": scene, "room.xml": f"<mujoco>{text}</mujoco>".encode(), **files}


def body(text: str) -> str:
    return f"<worldbody>{CUP.format(0.04, 0.05)}{text}</worldbody>"


def png(width: int, height: int) -> bytes:
    """The head of an image."""
    head = b"IHDR" + struct.pack(">2I5B", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + struct.pack(">I", 13) + head + struct.pack(">I", zlib.crc32(head))


STL = bytes(80) + struct.pack("<I", 4_000_000_000) + bytes(500)
NOWHERE = bytes(80) + struct.pack("<I", 1) + struct.pack("<12f", *[0.0] * 8, np.nan, *[0.0] * 3) + bytes(2)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (
            f"<worldbody>{CUP.format(40, 50)}</worldbody>",
            r"the box around 'cup' is 100 m long; in millimetres\?.*0\.001",
        ),
        (
            "<worldbody><body name='cup'><freejoint/>" + "<geom size='0.1'/>" * 1001 + "</body></worldbody>",
            r"'cup' has too many shapes \(got 1001\).*limits\.body_shapes",
        ),
        (
            body('<replicate count="99999"><replicate count="99999"><geom size="1"/></replicate></replicate>'),
            "elements",
        ),
        (
            body("".join(f'<flexcomp name="f{i}" spacing="1 1 1" dim="3"/>' for i in range(4))),
            r"too many bodies .*4,00\d.*model_bodies",
        ),
        (body("<body/>" * 3_000), r"too many bodies .*3,00\d.*at most 3,000 .*limits\.model_bodies"),
        (body('<flexcomp name="f" type="grid" count="999 999 99" spacing="1 1 1" dim="3"/>'), "model_elements"),
        (body('<composite type="cable" count="99999999 1 1" size="1"><geom size=".1"/></composite>'), "model_elements"),
        (body("<body>" * 250 + "</body>" * 250), r"nested too deep; at most 200 .*limits\.model_depth"),
        (body("<site/>" * 30_000), r"too many elements; at most 30,000 .*limits\.model_elements"),
        ('<asset><hfield name="h" nrow="60000" ncol="60000" size="1 1 1 1"/></asset>', r"limits\.hfield_pixels"),
        ('<asset><hfield name="h" file="big.png" size="1 1 1 1"/></asset>', "900,000,000 pixels"),
        ('<asset><mesh name="m" builtin="plate" params="20000 20000"/></asset>', "params of <mesh> 'm'"),
        ('<size memory="500G"/>', r"memory of <size>: asks for too much .*500G.*limits\.arena_bytes"),
        ('<size nuser_geom="2000000000"/>', r"limits\.array_length"),
        ('<custom><numeric name="n" size="2000000000"/></custom>', "size of <numeric> 'n'"),
        ('<asset><mesh name="m" file="lie.stl"/></asset>', r"lie\.stl: too many triangles .*4,000,000,000.*mesh_faces"),
        ('<asset><mesh name="m" file="lie" content_type="model/stl"/></asset>', "too many triangles"),
        ('<asset><mesh name="m" file="nan.stl"/></asset>', r"nan\.stl: a mesh whose corners are not finite"),
        ('<asset><mesh name="m" file="nan.obj"/></asset>', r"nan\.obj: a mesh whose corners are not finite"),
        (
            body('<body pos="nan 0 0.8"/>'),
            r"room\.xml, line 1: pos of <body>: must be finite numbers \(got 'nan 0 0\.8'",
        ),
        (body('<body name="inf" quat="1 0 0 -Infinity"/>'), "quat of <body> 'inf'"),
        (body('<body pos="0 1e999 0"/>'), "must be finite"),
        (body('<body pos="0 nan(7) 0"/>'), "must be finite"),
        (body('<body name="a&#10;b"/>'), r"name of <body> 'a\\nb': holds a control character"),
        (body('<body name="a\u202eb"/>'), r"a\\u202eb"),
        ("<!DOCTYPE a [<!ENTITY b 'c'>]>", "not valid XML"),
    ],
)
def test_models_that_ask_for_too_much_are_refused(text: str, says: str) -> None:
    files = {"big.png": png(30_000, 30_000), "lie.stl": STL, "lie": STL, "nan.stl": NOWHERE, "nan.obj": b"v 0 NaN 0\n"}
    with pytest.raises(SceneError, match=says):
        Scene.from_bundle(bundle(text, **files))


def test_entities_are_refused_before_they_grow() -> None:
    lol = "".join(f'<!ENTITY {chr(98 + i)} "{f"&{chr(97 + i)};" * 10}">' for i in range(9))
    for root in ("mujoco", "robot", "COLLADA"):
        text = f'<!DOCTYPE {root} [<!ENTITY a "ha">{lol}]><{root} name="&j;">&j;</{root}>'.encode()
        with pytest.raises(SceneError, match="a document type that may define entities; leave"):
            parse_markup(text, where="it")
    assert parse_markup(b"<!DOCTYPE mujoco><mujoco/>", where="it").tag == "mujoco", "a plain one defines nothing"


def test_what_mujoco_reads_says_the_same_on_the_same_lines() -> None:
    text = '<a>\n<!-- x -- y\n -->\n  <b c="&lt;&quot;\n1"\n/><d>\n<e/></d>\n</a>'
    root = parse_markup(text.encode(), where="it")
    again = parse_markup(written(root).encode(), where="it")
    for first, second in zip(root.iter(), again.iter(), strict=True):
        assert (first.tag, first.attrib, first.line) == (second.tag, second.attrib, second.line)  # type: ignore[attr-defined]
    assert [element.line for element in root.iter()] == [1, 4, 6, 7]  # type: ignore[attr-defined]


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "iso-8859-1"])
def test_models_are_read_in_the_encoding_that_they_have(encoding: str) -> None:
    head = '<?xml version="1.0" encoding="utf-16"?>' if encoding == "utf-16" else ""
    text = f"{head}<mujoco><worldbody><body name='Küche'/></worldbody></mujoco>"
    root = parse_markup(text.encode(encoding), where="it")
    assert [each.get("name") for each in root.iter("body")] == ["Küche"]


def test_a_limit_can_be_raised_and_stays_so_in_other_processes() -> None:
    files = bundle(f"<worldbody>{CUP.format(6, 7)}</worldbody>")
    with pytest.raises(SceneError, match=r"14 m long.*at most 10 m: setting limits\.object_extent_m"):
        Scene.from_bundle(files)
    scene = Scene.from_bundle(files, limits=replace(DEFAULT.limits, object_extent_m=20.0))
    assert pickle.loads(pickle.dumps(scene)).objects == ("cup",)


def test_a_bundle_is_refused_by_its_size() -> None:
    limits = replace(DEFAULT.limits, bundle_bytes=10_000)
    files = bundle(body(""))
    assert Scene.from_bundle(files, limits=limits).objects == ("cup",)
    with pytest.raises(
        SceneError, match=r"too large \(got '2\d,\d\d\d bytes'\); at most 10,000 .*limits\.bundle_bytes"
    ):
        Scene.from_bundle(files | {"more": bytes(20_000)}, limits=limits)


@pytest.mark.parametrize(
    ("right", "wrong", "says"),
    [
        ('xyz="1 0 0.7"', 'xyz="1 nan 0.7"', "xyz of <origin>: must be finite"),
        ('<sphere radius="0.1"/>', '<sphere radius="inf"/>', "radius of <sphere>"),
        (
            '<parent link="floor"/><child link="table"/>',
            '<parent link="lamp"/><child link="table"/>',
            "none is its own",
        ),
        ('<link name="lamp">', '<link name="la&#9;mp">', r"la\\tmp"),
    ],
)
def test_urdf_is_held_to_the_same(tmp_path: Path, right: str, wrong: str, says: str) -> None:
    (tmp_path / "m.dae").write_bytes(dae())
    (tmp_path / "room.urdf").write_text(URDF_ROOM.replace("MESH", "m.dae").replace(right, wrong))
    (tmp_path / "scene.toml").write_text('[scene]\nmodel = "room.urdf"\n')
    with pytest.raises(SceneError, match=says):
        Scene.load(tmp_path / "scene.toml")


@pytest.mark.parametrize(
    ("right", "wrong", "says"),
    [
        (b'meter="0.01"', b'meter="-0.01"', "its unit is -0.01 metres"),
        (b'meter="0.01"', b'meter="nan"', "its unit is nan metres"),
        (b'semantic="VERTEX"', b'semantic="NORMAL"', "<triangles> has no input VERTEX"),
        (b'offset="1"', b'offset="99999999999"', "offset"),
        (b'id="pa" count="24">-5', b'id="pa" count="24">nan', "no plain number"),
        (b'id="pa" count="24">-5', b'id="pa" count="24">-5_0', "no plain number"),
        (b'id="pa" count="24">-5', b'id="pa" count="24">1e300', "not finite"),
        (b"<p>0 0", b"<p>-9 0", "before the first"),
        (b"<p>0 0", b"<p>99999999999999999999999 0", "too large"),
        (b"float_array", b"int_array", "<float_array>"),
    ],
)
def test_collada_that_lies_is_refused(right: bytes, wrong: bytes, says: str) -> None:
    assert right in dae()
    with pytest.raises(SceneError, match=rf"part\.dae: .*{says}.*save it as STL or OBJ"):
        triangles_from_dae(dae().replace(right, wrong), "part.dae")


def test_collada_that_multiplies_is_refused() -> None:
    limits = replace(DEFAULT.limits, mesh_faces=100)
    many = dae().replace(b'<instance_geometry url="#cube"/>', b'<instance_geometry url="#cube"/>' * 9)
    with pytest.raises(SceneError, match=r"more than 100 triangles \(setting limits\.mesh_faces\)"):
        triangles_from_dae(many, "part.dae", limits=limits)


def test_what_is_no_file_is_refused_by_its_kind(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.xml")
    (tmp_path / "loop.xml").symlink_to("loop.xml")
    room = tmp_path / "room.toml"
    for name, says in (
        ("pipe.xml", "pipe"),
        ("loop.xml", "symbolic links"),
        (".", "folder"),
        (r"a\u0000.xml", "control"),
    ):
        room.write_text(f'[scene]\nmodel = "{name}"\n')
        with pytest.raises(SceneError, match=says):
            Scene.load(room)
        room.write_text('[scene]\nmodel = "room.xml"\n')
        if "\\" not in name:
            (tmp_path / "room.xml").write_text(f'<mujoco><include file="{name}"/></mujoco>')
            with pytest.raises(SceneError, match=says):
                Scene.load(room)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("a = " + "[" * 5000, "nested too deep"),
        ("a = " + "9" * 5000, "a number of too many digits"),
        ('["agents"."P\\u001b[31m"]', r"a name that holds a character that is not seen \(got 'P\\x1b\[31m'\)"),
        ('[scene]\nmodel = "a\\u0000"', r"scene\.model: holds a control character"),
        ('[scene]\nname = "a\\nb"\nmodel = "a"', r"scene\.name: holds a control character"),
        ("#" * (DEFAULT.limits.toml_bytes + 1), r"too large.*limits\.toml_bytes"),
    ],
)
def test_scene_files_are_bounded_and_hold_names_that_can_be_shown(text: str, says: str) -> None:
    with pytest.raises(InputError, match=says):
        Scene.from_bundle({"scene.toml": text.encode()})


def test_images_and_bodies_have_their_limits() -> None:
    scene = SCENE + b"[agents.P1]\n"
    profile = dict(Scene.from_bundle(bundle(body(""), scene)).bundle)["P1.profile.toml"]
    wide = profile.replace(b"[320, 240]", b"[30000, 30000]")
    assert wide != profile
    with pytest.raises(SceneError, match=r"image_px: an image too large .*4,000,000 pixels .*limits\.image_pixels"):
        Scene.from_bundle(bundle(body(""), scene, **{"P1.profile.toml": wide}))
    with pytest.raises(SceneError, match=r"a body of too many shapes .*limits\.body_shapes"):
        Scene.from_bundle(bundle(body(""), scene), limits=replace(DEFAULT.limits, body_shapes=10))


def test_warnings_of_mujoco_are_logged_and_not_printed(capfd: pytest.CaptureFixture[str]) -> None:
    """Where nobody configured logging, Python would print what MuJoCo warns of."""
    logger = logging.getLogger("taskgist.world.mujoco")
    assert any(isinstance(handler, logging.NullHandler) for handler in logger.handlers)
    vertices = " ".join(f"{x:.4f}" for x in np.asarray(meshes.board((0, 0, 0), (0.1, 0.2, 0.05))[0]).ravel())
    Scene.from_bundle(bundle(f'<asset><mesh name="m" vertex="{vertices}"/></asset>{body("")}'))
    assert capfd.readouterr() == ("", "")
