"""The same motion in the layouts that trackers write: the tracks do not depend on which."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from taskgist.importing import Tracks, import_recording, load_mapping
from taskgist.world.geometry.transforms import matrix_from_wxyz, wxyz_from_rotation_vector
from tests.importing.skeletons import (
    NAMES,
    POINTS,
    RATE_HZ,
    TIMES_S,
    Array,
    cup_position,
    cup_wxyz,
    keypoints,
    mapping_file,
    npz_mapping,
    tracks_of,
    write_csv,
)

PEOPLE = f"""
[people.P1]
source = "body"
person = "one"
[people.P1.points]
{POINTS}
[people.P2]
like = "P1"
person = "two"
"""
WHO = ("one", "two")


def assert_same(tracks: Tracks, expected: Tracks) -> None:
    np.testing.assert_allclose(tracks.times_s, expected.times_s, atol=1e-9)
    assert tracks.people.keys() == expected.people.keys()
    for name, person in expected.people.items():
        other = tracks.people[name]
        for mine, theirs in ((other.points, person.points), (other.directions, person.directions)):
            assert mine.keys() == theirs.keys()
            for key, values in theirs.items():
                np.testing.assert_allclose(mine[key], values, atol=1e-9, err_msg=key)


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Tracks:
    folder = tmp_path_factory.mktemp("plain")
    return tracks_of(folder, npz_mapping(folder))


def test_plain_layout_is_the_motion_itself(plain: Tracks) -> None:
    for person, name in enumerate(("P1", "P2")):
        for landmark, source in (("pelvis", "PELVIS"), ("left_wrist", "LEFT_WRIST"), ("nose", "NOSE")):
            expected = keypoints()[:, person, NAMES.index(source)]
            np.testing.assert_allclose(plain.people[name].points[landmark], expected, atol=1e-12)
    np.testing.assert_allclose(plain.objects["cup"].position_m, cup_position(), atol=1e-12)
    face = plain.people["P1"].directions["face"]
    assert (face @ (1.0, 0.0, 0.0) > 0.9).all()


def wide_csv(folder: Path) -> str:
    """One file, millimetres, y up and z towards the viewer, milliseconds."""
    camera = 1000.0 * keypoints()[..., [1, 2, 0]] * (-1.0, 1.0, -1.0)
    header = ["stamp", *(f"{who}_{name}_{axis}" for who in WHO for name in NAMES for axis in "xyz")]
    rows = np.column_stack([1000.0 * TIMES_S + 5e6, camera.reshape(len(TIMES_S), -1)])
    write_csv(folder / "body.csv", header, rows)
    return """[sources.body]
file = "body.csv"
time = { column = "stamp", unit = "ms" }
units = "mm"
axes = { x = "-z", y = "-x", z = "y" }
position = "{person}_{point}_{axis}"
"""


def headerless_blocks(folder: Path) -> str:
    """A file per person without header: a block of three columns per point after the time."""
    for person, who in enumerate(WHO):
        rows = np.column_stack([TIMES_S, keypoints()[:, person].reshape(len(TIMES_S), -1)])
        write_csv(folder / f"{who}.txt", None, rows, delimiter=" ")
    return f"""[sources.body]
file = "{{person}}.txt"
time = {{ column = 0, unit = "s" }}
units = "m"
position = {{ first = 1, step = 3 }}
names = {NAMES}
"""


def long_table(folder: Path) -> str:
    """A row per frame, person and point, told apart by two columns."""
    lines = ["t_us;who;joint;X;Y;Z;note"]
    for time, frame in zip(TIMES_S, keypoints(), strict=True):
        for who, body in zip(WHO, frame, strict=True):
            for name, (x, y, z) in zip(NAMES, 100.0 * body, strict=True):
                lines.append(f"{1e6 * time!r};{who};{name};{x!r};{y!r};{z!r};ok".replace("np.float64", ""))
    text = "\n".join(lines).replace("(", "").replace(")", "").replace(".", ",")
    (folder / "long.csv").write_text(text, encoding="utf-8")
    return """[sources.body]
file = "long.csv"
decimal = ","
time = { column = "t_us", unit = "us" }
units = "cm"
where = { who = "{person}", joint = "{point}" }
position = "{AXIS}"
"""


def file_per_point(folder: Path) -> str:
    """A file per point with comments and a preamble, no time, tabs."""
    for person, who in enumerate(WHO):
        for point, name in enumerate(NAMES):
            file = folder / f"{who}-{name}.tsv"
            write_csv(file, ["px", "py", "pz"], keypoints()[:, person, point], delimiter="\t")
            file.write_text(f"Exported by a tracker\n# comment\n{file.read_text()}", encoding="utf-8")
    return f"""[sources.body]
file = "{{person}}-{{point}}.tsv"
skip_rows = 1
rate_hz = {RATE_HZ}
units = "m"
position = "p{{axis}}"
"""


def arrays_per_person(folder: Path) -> str:
    """An NPY per person whose axes stand in another order, left-handed (y mirrored)."""
    for person, who in enumerate(WHO):
        np.save(folder / f"{who}.npy", np.transpose(keypoints()[:, person] * (1.0, -1.0, 1.0), (1, 2, 0)))
    return f"""[sources.body]
file = "{{person}}.npy"
layout = ["{{point}}", "value", "time"]
rate_hz = {RATE_HZ}
units = "m"
axes = {{ y = "-y" }}
names = {NAMES}
"""


@pytest.mark.parametrize("layout", [wide_csv, headerless_blocks, long_table, file_per_point, arrays_per_person])
def test_layouts_give_the_same_tracks(layout: Callable[[Path], str], plain: Tracks, tmp_path: Path) -> None:
    assert_same(tracks_of(tmp_path, layout(tmp_path) + PEOPLE), plain)


def test_offset_brings_sources_together(tmp_path: Path) -> None:
    np.savez(tmp_path / "late.npz", t=1e3 * TIMES_S + 500.0, cup=cup_position())
    text = (
        npz_mapping(tmp_path)
        + """
[sources.late]
file = "late.npz"
array = "cup"
time = { column = "t", unit = "ms" }
offset_s = -0.5
units = "m"
[objects.late]
source = "late"
shape = { type = "sphere", radius_m = 0.05 }
"""
    )
    tracks = tracks_of(tmp_path, text)
    np.testing.assert_allclose(tracks.objects["late"].position_m, tracks.objects["cup"].position_m, atol=1e-9)
    np.testing.assert_array_equal(tracks.objects["late"].wxyz, np.tile((1.0, 0.0, 0.0, 0.0), (len(TIMES_S), 1)))


def _euler_zyx_deg() -> Array:
    """Intrinsic z, y', x'' in degrees, from the matrix elements themselves."""
    m = matrix_from_wxyz(cup_wxyz())
    yaw, pitch = np.arctan2(m[:, 1, 0], m[:, 0, 0]), -np.arcsin(m[:, 2, 0])
    return np.asarray(np.degrees(np.column_stack([yaw, pitch, np.arctan2(m[:, 2, 1], m[:, 2, 2])])))


def _rotation_vector() -> Array:
    w, v = cup_wxyz()[:, :1], cup_wxyz()[:, 1:]
    angle = 2 * np.arctan2(np.linalg.norm(v, axis=1, keepdims=True), w)
    return np.asarray(angle * v / np.linalg.norm(v, axis=1, keepdims=True))


NOTATIONS: dict[str, tuple[Callable[[], Array], str]] = {
    "xyzw": (lambda: cup_wxyz()[:, [1, 2, 3, 0]], 'kind = "xyzw", columns = [3, 4, 5, 6]'),
    "negated": (lambda: -cup_wxyz(), 'kind = "wxyz", columns = { first = 3 }'),
    "rough": (lambda: 1.01 * cup_wxyz(), 'kind = "wxyz", columns = [3, 4, 5, 6]'),
    "matrix": (lambda: matrix_from_wxyz(cup_wxyz()).reshape(-1, 9), 'kind = "matrix", columns = { first = 3 }'),
    "euler": (_euler_zyx_deg, 'kind = "euler_intrinsic", order = "zyx", unit = "deg", columns = [3, 4, 5]'),
    "fixed axes": (
        lambda: np.radians(_euler_zyx_deg()[:, ::-1]),
        'kind = "euler_extrinsic", order = "xyz", unit = "rad", columns = [3, 4, 5]',
    ),
    "vector": (_rotation_vector, 'kind = "rotation_vector", unit = "rad", columns = [3, 4, 5]'),
}


@pytest.mark.parametrize("notation", NOTATIONS)
def test_notations_of_orientation_are_the_same(notation: str, tmp_path: Path) -> None:
    numbers, rotation = NOTATIONS[notation]
    np.savez(tmp_path / "cup.npz", cup=np.hstack([cup_position(), numbers()]))
    tracks = tracks_of(tmp_path, _cup_mapping(f"rotation = {{ {rotation} }}"))
    expected = matrix_from_wxyz(cup_wxyz())
    np.testing.assert_allclose(matrix_from_wxyz(tracks.objects["cup"].wxyz), expected, atol=1e-9)


def test_transformation_matrices(tmp_path: Path) -> None:
    matrices = np.tile(np.eye(4), (len(TIMES_S), 1, 1))
    matrices[:, :3, :3], matrices[:, :3, 3] = matrix_from_wxyz(cup_wxyz()), cup_position()
    np.savez(tmp_path / "cup.npz", cup=matrices)
    rotation = 'rotation = { kind = "matrix", columns = [0, 1, 2, 4, 5, 6, 8, 9, 10] }'
    layout = 'layout = ["time", "value", "value"]\nposition = [3, 7, 11]'
    cup = tracks_of(tmp_path, _cup_mapping(f"{rotation}\n{layout}")).objects["cup"]
    np.testing.assert_allclose(cup.position_m, cup_position(), atol=1e-12)
    np.testing.assert_allclose(matrix_from_wxyz(cup.wxyz), matrix_from_wxyz(cup_wxyz()), atol=1e-9)


def test_rotation_vector_of_no_turn() -> None:
    np.testing.assert_allclose(wxyz_from_rotation_vector(np.zeros((2, 3))), np.tile((1.0, 0, 0, 0), (2, 1)))


def _cup_mapping(source: str) -> str:
    return f"""[sources.cup]
file = "cup.npz"
rate_hz = {RATE_HZ}
units = "m"
{source}
[objects.cup]
source = "cup"
shape = {{ type = "cylinder", radius_m = 0.04, length_m = 0.1 }}
"""


def test_a_name_may_hold_any_sign(tmp_path: Path) -> None:
    """It is written into the scene as it is."""
    about = "[about]\nname = 'say \"hi\" & <wave>'"
    recording = import_recording(load_mapping(mapping_file(tmp_path, npz_mapping(tmp_path, top=about))))
    assert recording.name == recording.scene.name == 'say "hi" & <wave>'
