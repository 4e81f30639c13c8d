"""Each mistake in a mapping, or in the tables that it names, gives one error: file, field, value, way out."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from taskgist.errors import InputError, LabelError, MappingError, UnknownNameError
from taskgist.importing import load_mapping, read_tracks
from tests.importing.skeletons import (
    RATE_HZ,
    TIMES_S,
    Array,
    cup_position,
    cup_wxyz,
    keypoints,
    mapping_file,
    npz_mapping,
    tracks_of,
)

LABEL = """
[label]
task = "give"
performing_agent = "P1"
target_agent = {target}
target_object = "cup"
start_s = {start}
end_s = 0.9
"""


def error_of(folder: Path, text: str) -> str:
    with pytest.raises(InputError) as caught:
        tracks_of(folder, text)
    message = str(caught.value)
    assert "mapping.toml" in message, "every error names the mapping"
    return message


MISTAKES = {
    "unknown field": ('units = "m"', 'units = "m"\naxis = { x = "y" }',
                      r"\[sources.body\]: no field 'axis'; did you mean 'axes'"),
    "unknown section": ("[people.P1]", "[persons.P1]", r"mapping.toml: no field 'persons' .known: .*people"),
    "unknown unit": ('units = "m"', 'units = "meter"', r"sources.body.units: .*got 'meter'.*cm, inch, m, mm"),
    "no unit": ('units = "m"', "", r"sources.body.units: is missing"),
    "no time": ('time = { column = "t", unit = "s" }', "", r"sources.body.time: .*neither a time.*rate_hz"),
    "no time unit": (', unit = "s"', "", r"sources.body.time.unit: is missing"),
    "time and rate": ('units = "m"', 'units = "m"\nrate_hz = 30', r"rate_hz: .*both a time and a rate"),
    "axis twice": ('units = "m"', 'units = "m"\naxes = { x = "y" }', r"axes: uses one of the source's axes twice"),
    "no axis": ('units = "m"', 'units = "m"\naxes = { x = "up" }', r"axes.x: .*got 'up'.*allowed: \+x"),
    "layout": ('array = "body"', 'array = "body"\nlayout = ["t", "value"]', r"sources.body.layout: .*\['t', 'value'\]"),
    "rotation kind": ('kind = "wxyz"', 'kind = "xyzx"', r"rotation.kind: .*did you mean 'xyzw'"),
    "rotation columns": ("columns = [3, 4, 5, 6]", "columns = [3, 4, 5]", r"rotation.columns: must list 4 columns"),
    "nothing fills": ('file = "data.npz"', 'file = "{folder}.npz"', r"nothing fills \{folder\}.*\[parameters\]"),
    "format": ('file = "data.npz"', 'file = "data.bin"', r"sources.body.file: cannot tell the format.*'data.bin'"),
    "landmark": ('nose = "NOSE"', 'noze = "NOSE"', r"people.P1.points: no landmark 'noze'; did you mean 'nose'"),
    "source": ('source = "body"', 'source = "bodies"', r"people.P1.points: no source 'bodies'; did you mean 'body'"),
    "part": ("person = 0", 'person = 0\nunknown = ["left_leg"]', r"no part 'left_leg'; did you mean 'left_arm'"),
    "stature": ("person = 0", "person = 0\nstature_m = 175", r"people.P1.stature_m: .*got 175.*between 0.5 and 2.5"),
    "like": ('like = "P1"', 'like = "Q1"', r"people.P2.like: no person 'Q1'; did you mean 'P1'. .known: P1, P2"),
    "shape": ('type = "cylinder"', 'type = "cylinda"', r"objects.cup.shape.type: .*did you mean 'cylinder'"),
    "size": ("radius_m = 0.04", "radius_m = -0.04", r"objects.cup.shape.radius_m: .*got -0.04"),
    "no pose": ('source = "things"', "", r"objects.cup.source: the object has no pose.*fixed"),
    "mesh": ('type = "cylinder", radius_m = 0.04, length_m = 0.1', 'type = "mesh", file = "cup.obj", units = "m"',
             r"objects.cup.shape.file: the mesh file does not exist.*cup.obj"),
    "same name": ("[objects.cup]", "[objects.P1]", r"same name.*'P1'"),
    "long mesh": (
        'type = "cylinder", radius_m = 0.04, length_m = 0.1',
        f'type = "mesh", file = "{"x" * 5000}"',
        r"file: the mesh file does not exist",
    ),
    "name of the room": ("[objects.cup]", "[objects.world]", r"the room itself has that name.*'world'"),
    "not a number": ("person = 0", 'person = 0\nstature_m = "tall"',
                     r"stature_m: must be a finite number \(got 'tall'\)"),
    "toml": ("[people.P1]", "[people.P1", r"not valid TOML.*line"),
    "bare axes": ("[people.P2]", '[people.P1.directions]\nhead = { forward = "-y" }\n[people.P2]',
                  r"people.P1.directions \(face\): a bare point has no local axes.*from = "),
    "no direction": ("[people.P2]", '[people.P1.directions]\nhead = { of = "nose" }\n[people.P2]',
                     r"people.P1.directions.head: does not say which way"),
    "bad axis": ("[people.P2]", '[people.P1.directions]\nhead = { forward = "front" }\n[people.P2]',
                 r"directions.head.forward: is no axis \(got 'front'\)"),
    "bare offset": ('pelvis = "PELVIS"', 'pelvis = { point = "PELVIS", offset_m = [0, 0, 1] }',
                    r"offset_m: a bare point has no axes"),
    "no such array": ('array = "body"', 'array = "bodies"', r"data.npz: .*no array 'bodies'; did you mean 'body'"),
    "no such point": ('nose = "NOSE"', 'nose = "NOZE"', r"no point in names 'NOZE'; did you mean 'NOSE'"),
    "no such person": ("person = 1", "person = 7", r"layout: \{person\}: .*out of range.*got 7.*0 to 1"),
    "person by name": ("person = 1", 'person = "Ann"', r"sources.body: person: must be an index here \(got 'Ann'\)"),
    "no such file": ('file = "data.npz"', 'file = "date.npz"', r"date.npz: .*cannot be read: No such file"),
    "cut": ("[sources.body]", "[time]\nstart_s = 0.5\nend_s = 0.2\n[sources.body]", r"time.end_s: ends before it"),
    "short": ("[sources.body]", "[time]\nstart_s = 9.0\n[sources.body]", r"time: fewer than two frames"),
    "wrong time unit": ('unit = "s"', 'unit = "us"', r"frames are 3.33e-08 s apart.*change time.unit"),
}  # fmt: skip


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistakes(mistake: str, tmp_path: Path) -> None:
    old, new, expected = MISTAKES[mistake]
    text = npz_mapping(tmp_path)
    assert old in text
    assert re.search(expected, error_of(tmp_path, text.replace(old, new, 1)))


@pytest.mark.parametrize(("unit", "factor"), [("mm", 1000.0), ("cm", 100.0)])
def test_a_person_of_wrong_units(unit: str, factor: float, tmp_path: Path) -> None:
    np.savez(tmp_path / "data.npz", t=TIMES_S, body=factor * keypoints(), cup=np.hstack([cup_position(), cup_wxyz()]))
    message = error_of(tmp_path, npz_mapping(tmp_path))
    assert re.search(rf'people.P1: no person has this size \(got .* m.*\); change units to "{unit}"', message)


def test_a_person_of_millimetres(tmp_path: Path) -> None:
    text = npz_mapping(tmp_path).replace('units = "m"', 'units = "mm"', 1)
    assert 'change units to "m"' in error_of(tmp_path, text)


def test_an_object_far_away(tmp_path: Path) -> None:
    text = npz_mapping(tmp_path).replace("[objects.cup]", "[objects.tree]\nfixed = { position_m = [100, 0, 0] }\n"
                                         'shape = { type = "sphere", radius_m = 1 }\n[objects.cup]')  # fmt: skip
    assert re.search(r"objects.tree: .*far away.*got '10\d m'.*units, axes", error_of(tmp_path, text))


def test_wrong_axes_and_floor(tmp_path: Path) -> None:
    sideways = npz_mapping(tmp_path).replace('units = "m"', 'units = "m"\naxes = { x = "x", y = "z", z = "-y" }', 1)
    assert "people.P1: the head is not above the trunk" in error_of(tmp_path, sideways)
    sunk = npz_mapping(tmp_path).replace('units = "m"', 'units = "m"\ntransform = { position_m = [0, 0, -1.5] }', 1)
    assert re.search(r"people.P1: the head is not at a person's height \(got 0.1.*z = 0", error_of(tmp_path, sunk))


def save(folder: Path, body: Array, *, cup: Array | None = None, times_s: Array = TIMES_S) -> None:
    pose = np.hstack([cup_position(), cup_wxyz()]) if cup is None else cup
    np.savez(folder / "data.npz", t=times_s, body=body, cup=pose)


def test_copied_points(tmp_path: Path) -> None:
    body = keypoints()
    body[:, 0, 14] = body[:, 0, 7]
    save(tmp_path, body)
    text = npz_mapping(tmp_path)
    expected = r"people.P1.points.right_wrist: .*P1.left_wrist and P1.right_wrist.*unknown = \{ right_hand"
    assert re.search(expected, error_of(tmp_path, text))
    tracks = tracks_of(tmp_path, npz_mapping(tmp_path, people='unknown = ["right_hand"]'))
    assert "right_wrist" not in tracks.people["P1"].points


def test_points_that_were_never_tracked(tmp_path: Path) -> None:
    body = keypoints()
    body[:, :, 19:21] = 0.0
    save(tmp_path, body)
    assert "missing = 0" in error_of(tmp_path, npz_mapping(tmp_path))
    tracks = tracks_of(tmp_path, npz_mapping(tmp_path, source="missing = 0"))
    assert "P1: never seen: left_knee, left_ankle" in tracks.notes


def test_the_same_person_twice(tmp_path: Path) -> None:
    text = npz_mapping(tmp_path).replace("person = 1", "person = 0")
    assert "check what person = ... stands for in P1 and P2" in error_of(tmp_path, text)


def test_nobody_and_nothing_seen(tmp_path: Path) -> None:
    save(tmp_path, np.full_like(keypoints(), np.nan))
    assert "people.P1: the person is never seen" in error_of(tmp_path, npz_mapping(tmp_path))
    save(tmp_path, keypoints(), cup=np.full((len(TIMES_S), 7), np.nan))
    assert "objects.cup: the object is never seen" in error_of(tmp_path, npz_mapping(tmp_path))


def test_bad_numbers_in_arrays(tmp_path: Path) -> None:
    body = keypoints()
    body[3, 0, 0, 1] = np.inf
    save(tmp_path, body)
    assert re.search(r"data.npz, frame 3: position: is infinite", error_of(tmp_path, npz_mapping(tmp_path)))
    cup = np.hstack([cup_position(), cup_wxyz()])
    cup[5, 3:] = 0.0
    save(tmp_path, keypoints(), cup=cup)
    message = error_of(tmp_path, npz_mapping(tmp_path))
    assert re.search(r"frame 5: rotation \(wxyz\): the numbers are no rotation \(got \[0.0.*missing = 0", message)
    save(tmp_path, keypoints(), times_s=np.r_[TIMES_S[:7], 0.1, TIMES_S[8:]])
    assert re.search(
        r"frame 7: time: t: times run backwards: 0.2 s, then 0.1 s", error_of(tmp_path, npz_mapping(tmp_path))
    )
    save(tmp_path, keypoints(), times_s=TIMES_S[:-1])
    assert "there are 31 positions, but 30 times" in error_of(tmp_path, npz_mapping(tmp_path))


CSV_MISTAKES = {
    "empty": ("", "the table is empty"),
    "header only": ("t,x,y,z\n", "no rows below its header"),
    "text": ("t,x,y,z\n0,1,2,3\n0.1,1,oops,3\n", r"cup.csv, line 3: column 'y': is no number \(got 'oops'\)"),
    "infinite": ("t,x,y,z\n0,1,2,3\n0.1,1,inf,3\n", r"line 3: column 'y': is no number \(got 'inf'\)"),
    "cut off": ("t,x,y,z\n0,1,2,3\n0.1,1\n", r"line 3: the row has 2 cells, the first one 4"),
    "column": ("t,x,y,w\n0,1,2,3\n0.1,1,2,3\n", r"no column 'z' \(known: t, w, x, y\)"),
    "column twice": ("t,x,y,z,z\n0,1,2,3,3\n0.1,1,2,3,3\n", r"two columns have the name \(got 'z'\)"),
    "backwards": ("t,x,y,z\n0.2,1,2,3\n0.1,1,2,3\n", r"line 3: time: t: times run backwards: 0.2 s, then 0.1 s"),
    "repeated": ("t,x,y,z\n0.2,1,2,3\n0.2,1,2,3\n", r"line 3: time: t: times repeat"),
    "no header": ("0.2,1,2,3\n0.3,1,2,3\n", r"the table has no header"),
    "binary": ("\udcff\udcfe", "the table is not text"),
}
CUP_CSV = """[sources.cup]
file = "cup.csv"
time = { column = "t", unit = "s" }
units = "m"
[objects.cup]
source = "cup"
shape = { type = "sphere", radius_m = 0.04 }
"""


@pytest.mark.parametrize("mistake", CSV_MISTAKES)
def test_bad_tables(mistake: str, tmp_path: Path) -> None:
    content, expected = CSV_MISTAKES[mistake]
    (tmp_path / "cup.csv").write_bytes(content.encode("utf-8", errors="surrogateescape"))
    assert re.search(expected, error_of(tmp_path, CUP_CSV))


def test_missing_table(tmp_path: Path) -> None:
    assert re.search(r"sources.cup: .*cup.csv: cannot be read: No such file", error_of(tmp_path, CUP_CSV))


def test_rows_of_nobody(tmp_path: Path) -> None:
    (tmp_path / "cup.csv").write_text("t,id,x,y,z\n0,1,0,0,1\n0.1,1.0,0,0,1\n0,2,0,0,1\n0.1,02,0,0,2\n")
    text = CUP_CSV.replace('units = "m"', 'units = "m"\nwhere = { id = WHO }')
    assert tracks_of(tmp_path, text.replace("WHO", "2")).objects["cup"].position_m[-1, 2] == pytest.approx(2.0)
    assert re.search(r"where: no row has these values.*'3'.*has: 1, 2", error_of(tmp_path, text.replace("WHO", "3")))


def test_bad_archives(tmp_path: Path) -> None:
    text = npz_mapping(tmp_path)
    (tmp_path / "data.npz").write_bytes((tmp_path / "data.npz").read_bytes()[:1000])
    assert "not a file of plain arrays" in error_of(tmp_path, text)
    np.savez(tmp_path / "data.npz", t=TIMES_S, body=np.array([{"x": 1}], dtype=object))
    assert "body: not a plain array" in error_of(tmp_path, text)
    np.savez(tmp_path / "data.npz", t=TIMES_S, body=np.array(["a"]))
    assert "not an array of numbers" in error_of(tmp_path, text)
    np.savez(tmp_path / "data.npz", t=TIMES_S, body=np.zeros((2, 2, 2, 2, 2)))
    assert re.search(r"does not fit an array of shape \(2, 2, 2, 2, 2\)", error_of(tmp_path, text))


def test_labels(tmp_path: Path) -> None:
    text = npz_mapping(tmp_path)
    mapping = load_mapping(mapping_file(tmp_path, text + LABEL.format(target='"P2"', start=0.1)))
    assert mapping.label is not None
    assert mapping.label.how == "set in the mapping file"
    with pytest.raises(UnknownNameError, match=r"mapping.toml: label: no agent 'P3'; did you mean 'P2'"):
        load_mapping(mapping_file(tmp_path, text + LABEL.format(target='["P2", "P3"]', start=0.1)))
    with pytest.raises(LabelError, match=r"mapping.toml: label: target_agent: one target agent stands twice"):
        load_mapping(mapping_file(tmp_path, text + LABEL.format(target='["P2", "P2"]', start=0.1)))
    with pytest.raises(LabelError, match="ends before it starts"):
        load_mapping(mapping_file(tmp_path, text + LABEL.format(target='"P2"', start=0.95)))
    with pytest.raises(UnknownNameError, match=r"mapping.toml: label: no agent 'P3'"):
        load_mapping(mapping_file(tmp_path, text + LABEL.format(target='"P3"', start=0.1)))
    outside = text + LABEL.format(target='"P2"', start=0.1).replace("0.9", "1.5")
    assert "label: end_s: the label reaches outside of the recording (got 1.5)" in error_of(tmp_path, outside)


def test_missing_mapping(tmp_path: Path) -> None:
    with pytest.raises(MappingError, match=r"none.toml: cannot be read: No such file"):
        load_mapping(tmp_path / "none.toml")


def test_parameters_and_extension(tmp_path: Path) -> None:
    text = npz_mapping(tmp_path).replace("data.npz", "{take}.npz")
    (tmp_path / "base.toml").write_text(f'[parameters]\ntake = ""\n{text}')
    with pytest.raises(
        MappingError, match=r"parameters.take: the parameter has no value; give it with --set take=VALUE"
    ):
        load_mapping(tmp_path / "base.toml")
    with pytest.raises(UnknownNameError, match="no parameter 'tak'; did you mean 'take'"):
        load_mapping(tmp_path / "base.toml", parameters={"tak": "data"})
    given = read_tracks(load_mapping(tmp_path / "base.toml", parameters={"take": "data"}))
    over = mapping_file(tmp_path, 'extends = "base.toml"\n[parameters]\ntake = "data"\n[people.P1]\nstature_m = 1.8')
    extended = load_mapping(over)
    assert extended.people[0].stature_m == 1.8
    assert "base.toml" in extended.about.mapping
    assert "CHEST_SPINE" in extended.about.mapping
    np.testing.assert_array_equal(read_tracks(extended).times_s, given.times_s)
    (tmp_path / "base.toml").write_text('extends = "mapping.toml"')
    with pytest.raises(MappingError, match="extend each other in a circle"):
        load_mapping(over)


def test_data_folder(tmp_path: Path) -> None:
    (tmp_path / "data").mkdir()
    text = npz_mapping(tmp_path / "data")
    mapping = load_mapping(mapping_file(tmp_path, text), data_dir=tmp_path / "data")
    assert len(read_tracks(mapping).times_s) == round(TIMES_S[-1] * RATE_HZ) + 1
