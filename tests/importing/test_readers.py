"""Published formats of motion capture: the same person and cup come out of each, and broken files are named."""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from taskgist.errors import InputError, MappingError, UnknownNameError
from taskgist.importing import (
    Proposal,
    Take,
    import_recording,
    load_mapping,
    look,
    mapping_text,
    read_take,
    read_tracks,
)
from taskgist.importing.readers import CONVERSIONS, READERS, kind_of
from taskgist.world.geometry.transforms import matrix_from_wxyz, wxyz_from_matrix
from tests.importing import takes
from tests.importing.skeletons import Array
from tests.importing.takes import Y_UP, cup, in_y_up, points_of
from tests.importing.test_skeletons import FRAMES

PREFIXED = {f"Anna:{name}": position for name, position in points_of("plug_in_gait").items()}
XYZW = [1, 2, 3, 0]


def bones() -> dict[str, Array]:
    return points_of("optitrack")


def motive(path: Path) -> Path:
    """A skeleton, a cup with its markers, and a loose marker; a bone's orientation is that of the source's axes."""
    turn = np.tile(np.array((0.0, 0.0, 0.0, 1.0)), (FRAMES, 1))
    position, wxyz = cup()
    in_source = Y_UP @ matrix_from_wxyz(wxyz) @ Y_UP.T
    columns = takes.motive_columns("Rigid Body", "cup", in_y_up(position), wxyz_from_matrix(in_source)[:, XYZW])
    columns += takes.motive_columns("Rigid Body Marker", "cup:Marker1", in_y_up(position + 0.03))
    for name, place in bones().items():
        columns += takes.motive_columns("Bone", f"Anna:{'Anna' if name == 'Hip' else name}", in_y_up(place), turn)
    columns += takes.motive_columns("Marker", "cup:Marker1", in_y_up(position + 0.03))
    return takes.write_motive(path, [*columns, *takes.motive_columns("Marker", "Unlabeled 1189", in_y_up(position))])


def written(folder: Path, kind: str) -> tuple[Path, dict[str, Array]]:
    """A file of each kind, and where its points are in the room, metres."""
    writers: dict[str, Callable[[], tuple[Path, dict[str, Array]]]] = {
        "c3d": lambda: (takes.write_c3d(folder / "take.c3d", PREFIXED), PREFIXED),
        "trc": lambda: (
            takes.write_trc(folder / "take.trc", points_of("openpose_body_25")),
            points_of("openpose_body_25"),
        ),
        "nexus": lambda: (takes.write_nexus(folder / "take.csv", PREFIXED, angles=False), PREFIXED),
        "qualisys": lambda: (takes.write_qualisys(folder / "take.tsv", PREFIXED), PREFIXED),
        "motive": lambda: (motive(folder / "take.csv"), {f"Anna:{name}": at for name, at in bones().items()}),
    }
    return writers[kind]()


def proposed(path: Path) -> tuple[Proposal, Path]:
    proposal = look(path)
    mapping = path.with_suffix(".toml")
    mapping.write_text(mapping_text(proposal, path.name), encoding="utf-8")
    return proposal, mapping


@pytest.mark.parametrize("kind", ["c3d", "trc", "nexus", "qualisys", "motive"])
def test_a_person_comes_back_from_each_format(tmp_path: Path, kind: str) -> None:
    path, points = written(tmp_path, kind)
    assert kind_of(path) == kind
    proposal, mapping = proposed(path)
    (subject,) = proposal.people
    if proposal.things:
        text = mapping.read_text(encoding="utf-8")
        mapping.write_text(text.replace("# shape", "shape"), encoding="utf-8")
    else:
        assert not proposal.open
    tracks = read_tracks(load_mapping(mapping))
    person = tracks.people[subject.name]
    shared = [name for name in ("left_wrist", "right_elbow", "right_knee") if name in person.points]
    assert len(shared) == 3
    for name in shared:
        x = person.points[name][:, 0]
        assert np.ptp(x) < 1.0
        assert np.isfinite(x).all()
    heights = np.concatenate([values[:, 2] for values in person.points.values()])
    truth = np.concatenate([values[:, 2] for values in points.values()])
    assert heights.min() == pytest.approx(truth.min(), abs=0.03)
    assert heights.max() == pytest.approx(truth.max(), abs=0.1)


@pytest.mark.parametrize("kind", ["c3d", "trc", "nexus", "qualisys", "motive"])
def test_every_sample_is_where_it_was(tmp_path: Path, kind: str) -> None:
    path, points = written(tmp_path, kind)
    take = read_take(path, kind)
    scale, axes = (0.001 if take.unit == "mm" else 1.0), (Y_UP if kind in ("trc", "motive") else np.eye(3))
    assert take.unit in ("mm", "m")
    for name, position in points.items():
        np.testing.assert_allclose(scale * take.tracks[name].position @ axes, position, atol=1e-6)
        np.testing.assert_allclose(take.tracks[name].times_s, takes.TIMES_S, atol=1e-5)


def with_gap(points: dict[str, Array]) -> dict[str, Array]:
    lost = {name: position.copy() for name, position in points.items()}
    lost["Anna:LFIN"][3:6] = np.nan
    return lost


@pytest.mark.parametrize("kind", ["c3d", "nexus", "qualisys"])
def test_what_was_lost_stays_so(tmp_path: Path, kind: str) -> None:
    writers: dict[str, Callable[[Path, dict[str, Array]], Path]] = {
        "c3d": takes.write_c3d,
        "nexus": takes.write_nexus,
        "qualisys": takes.write_qualisys,
    }
    take = read_take(writers[kind](tmp_path / "take", with_gap(PREFIXED)), kind)
    lost = np.isnan(take.tracks["Anna:LFIN"].position).all(axis=1)
    assert np.flatnonzero(lost).tolist() == [3, 4, 5]
    assert not np.isnan(take.tracks["Anna:RFIN"].position).any()
    assert f"{100 * 3 / take_samples(take):.1f} % lost, for 0.13 s at most (Anna:LFIN)" in mapping_text(
        look(tmp_path / "take"), "take"
    )


def take_samples(take: Take) -> int:
    return sum(len(track.times_s) for track in take.tracks.values())


# --- C3D.


@pytest.mark.parametrize("processor", [84, 85, 86])
@pytest.mark.parametrize("as_integers", [False, True])
def test_numbers_of_all_processors(tmp_path: Path, processor: int, as_integers: bool) -> None:
    path = takes.write_c3d(
        tmp_path / "a.c3d", with_gap(PREFIXED), processor=processor, as_integers=as_integers, analog=3
    )
    take = read_take(path, "c3d")
    assert (take.unit, take.up) == ("mm", "z")
    for name, position in with_gap(PREFIXED).items():
        np.testing.assert_allclose(take.tracks[name].position, 1000.0 * position, atol=0.051 if as_integers else 1e-3)


def test_ezc3d_reads_the_same(tmp_path: Path) -> None:
    """An independent reader, which the tests need and users do not."""
    ezc3d = pytest.importorskip("ezc3d")
    path = takes.write_c3d(tmp_path / "a.c3d", with_gap(PREFIXED), angles=["Anna:LANK"])
    take, theirs = read_take(path, "c3d"), ezc3d.c3d(str(path))
    labels = theirs["parameters"]["POINT"]["LABELS"]["value"]
    assert [label for label in labels if label != "Anna:LANK"] == list(take.tracks)
    for k, label in enumerate(labels):
        if label in take.tracks:
            np.testing.assert_allclose(take.tracks[label].position, theirs["data"]["points"][:3, k].T, rtol=1e-6)


def test_a_file_that_ezc3d_wrote(tmp_path: Path) -> None:
    """Not by our own writer, and with analog channels of another rate."""
    ezc3d = pytest.importorskip("ezc3d")
    made, lost = ezc3d.c3d(), with_gap(PREFIXED)
    for name, value in {"RATE": [30.0], "LABELS": list(lost), "UNITS": ["mm"]}.items():
        made["parameters"]["POINT"][name]["value"] = value
    for name, value in {"RATE": [300.0], "LABELS": ["Fx", "Fz"]}.items():
        made["parameters"]["ANALOG"][name]["value"] = value
    points = np.ones((4, len(lost), FRAMES))
    points[:3] = 1000.0 * np.stack(list(lost.values())).transpose(2, 0, 1)
    made["data"]["points"], made["data"]["analogs"] = points, np.zeros((1, 2, 10 * FRAMES))
    made.write(str(tmp_path / "a.c3d"))
    take = read_take(tmp_path / "a.c3d", "c3d")
    assert take.unit == "mm"
    for name, position in lost.items():
        np.testing.assert_allclose(take.tracks[name].position, 1000.0 * position, rtol=1e-6)


def test_modelled_angles_are_no_points(tmp_path: Path) -> None:
    take = read_take(takes.write_c3d(tmp_path / "a.c3d", PREFIXED, angles=["Anna:LANK", "Anna:RANK"]), "c3d")
    assert "Anna:LANK" not in take.tracks
    assert "Anna:LKNE" in take.tracks


def test_a_c3d_that_is_cut_off_or_damaged_is_refused(tmp_path: Path) -> None:
    whole = takes.write_c3d(tmp_path / "a.c3d", PREFIXED).read_bytes()
    cut = tmp_path / "cut.c3d"
    cut.write_bytes(whole[:-2000])
    with pytest.raises(MappingError, match=r"cut.c3d: is cut off: it holds \d+ of 12 frames; copy it again"):
        read_take(cut, "c3d")
    rng = np.random.default_rng(3)
    for size in (0, 1, 2, 511, 600, 700, 1100, 1500):
        cut.write_bytes(whole[:size])
        with pytest.raises(MappingError):
            read_take(cut, "c3d")
    for _ in range(300):
        damaged = bytearray(whole)
        for at in rng.integers(2048, size=4):
            damaged[at] = rng.integers(256)
        cut.write_bytes(damaged)
        with suppress(MappingError):
            read_take(cut, "c3d")


# --- Poses of things.


def test_a_cup_of_motive_has_its_pose(tmp_path: Path) -> None:
    proposal, mapping = proposed(motive(tmp_path / "take.csv"))
    assert proposal.things == ("cup",)
    assert proposal.loose == ("Unlabeled 1189",)
    assert proposal.open == ("objects.cup.shape: what does it look like?",)
    with pytest.raises(MappingError, match=r"objects\.cup"):
        load_mapping(mapping)
    mapping.write_text(mapping.read_text(encoding="utf-8").replace("# shape", "shape"), encoding="utf-8")
    track = read_tracks(load_mapping(mapping)).objects["cup"]
    np.testing.assert_allclose(matrix_from_wxyz(track.wxyz)[:, 2, 1], 1.0, atol=1e-5)  # its own y points up, too
    turned = matrix_from_wxyz(track.wxyz) @ matrix_from_wxyz(track.wxyz[0]).T
    truth = matrix_from_wxyz(cup()[1]) @ matrix_from_wxyz(cup()[1][0]).T
    np.testing.assert_allclose(turned, truth, atol=1e-5)


def test_time_codes_and_lost_bodies_of_motive(tmp_path: Path) -> None:
    position, wxyz = cup()
    position[2:4], wxyz[2:4] = np.nan, np.nan
    columns = takes.motive_columns("Rigid Body", "cup", position, wxyz[:, XYZW])
    track = read_take(takes.write_motive(tmp_path / "a.csv", columns, timecode=True), "motive").tracks["cup"]
    assert track.wxyz is not None
    np.testing.assert_allclose(track.wxyz, wxyz, atol=1e-5)
    np.testing.assert_allclose(track.position, position, atol=1e-5)


def test_a_cup_of_qualisys_has_its_pose(tmp_path: Path) -> None:
    """As in a published file: roll −0.6563° has −0.01145 in Rot[5] and 0.01145 in Rot[7]."""
    position, wxyz = cup()
    take = read_take(takes.write_qualisys_6d(tmp_path / "a.tsv", position, wxyz, lost=[4]), "qualisys")
    track = take.tracks["cup"]
    assert track.wxyz is not None
    known = np.arange(FRAMES) != 4
    np.testing.assert_allclose(track.wxyz[known], wxyz[known], atol=1e-5)
    assert np.isnan(track.wxyz[4]).all()
    assert np.isnan(track.position[4]).all()
    roll = np.radians(-0.6563)
    row = [1, 0.0, -194.91974, 2.2415, 0.99661, -0.6563, 0.0, 0.0, 4.98536, 1.0, 0.0, 0.0]
    row += [0.0, 0.99993, -0.01145, 0.0, 0.01145, 0.99993]
    head = ["NO_OF_FRAMES\t1", "FREQUENCY\t100", "DATA_INCLUDED\t6D", "BODY_NAMES\tPSVH"]
    published = read_take(takes.write_rows(tmp_path / "b.tsv", head, [row[2:]], "\t"), "qualisys").tracks["PSVH"]
    assert published.wxyz is not None
    np.testing.assert_allclose(published.wxyz[0, 1], np.sin(roll / 2), atol=1e-5)


def test_sections_of_nexus(tmp_path: Path) -> None:
    proposal, _ = proposed(takes.write_nexus(tmp_path / "a.csv", PREFIXED))
    assert "Anna:LKneeAngles" not in proposal.take.tracks
    assert proposal.things == ("cup",)
    track = proposal.take.tracks["cup"]
    assert track.wxyz is not None
    np.testing.assert_allclose(track.wxyz, cup()[1], atol=1e-5)
    np.testing.assert_allclose(track.position, 1000.0 * cup()[0], atol=1e-3)


def test_segments_of_nexus_have_places_and_no_rotation(tmp_path: Path) -> None:
    """Which kind of angles RX, RY and RZ are, no field tells."""
    rows = [f"{k + 1},0,10,20,30,{100 + k},200,800,1,2,3,4,5,6" for k in range(3)]
    head = ["Segments", "100", ",,cup:cup,,,,,,Anna:Root,,,,,", "Frame,Sub Frame" + ",RX,RY,RZ,TX,TY,TZ" * 2]
    path = takes.write_rows(tmp_path / "a.csv", [*head, ",," + ",".join(["deg,deg,deg,mm,mm,mm"] * 2), *rows], [], ",")
    assert kind_of(path) == "nexus"
    take = read_take(path, "nexus")
    assert take.things == {"cup"}
    assert take.tracks["cup"].wxyz is None
    np.testing.assert_array_equal(take.tracks["cup"].position[:, 0], [100, 101, 102])
    assert take.notes == ("rotations of cup:cup, Anna:Root are not read: export them as quaternions (RX, RY, RZ, RW)",)


def test_qualisys_with_a_row_of_columns(tmp_path: Path) -> None:
    plain = read_take(takes.write_qualisys(tmp_path / "a.tsv", PREFIXED), "qualisys")
    named = read_take(takes.write_qualisys(tmp_path / "b.tsv", PREFIXED, columns=True), "qualisys")
    for name, track in plain.tracks.items():
        np.testing.assert_array_equal(track.position, named.tracks[name].position)


# --- What is wrong with a file is told by file, line and value.


def test_a_row_that_is_cut_off_names_its_line(tmp_path: Path) -> None:
    path = takes.write_trc(tmp_path / "a.trc", points_of("openpose_body_25"))
    text = path.read_text(encoding="utf-8").rstrip().rsplit("\t", 1)[0]
    path.write_text(text, encoding="utf-8")
    with pytest.raises(MappingError, match=r"a.trc, line 18: the row has \d+ cells, its header \d+; .*cut off"):
        read_take(path, "trc")


def test_a_cell_that_is_no_number_names_its_line_and_column(tmp_path: Path) -> None:
    path = takes.write_trc(tmp_path / "a.trc", points_of("openpose_body_25"))
    lines = path.read_text(encoding="utf-8").splitlines()
    row = lines[8].split("\t")
    row[3] = "lost?"
    lines[8] = "\t".join(row)
    path.write_text("\n".join(lines), encoding="utf-8")
    with pytest.raises(MappingError, match=r"a.trc, line 9: column \w+ Y: is no number \(got 'lost\?'\)"):
        read_take(path, "trc")


def test_a_header_without_frames_is_refused(tmp_path: Path) -> None:
    path = takes.write_trc(tmp_path / "a.trc", points_of("openpose_body_25"))
    path.write_text("\n".join(path.read_text(encoding="utf-8").splitlines()[:6]), encoding="utf-8")
    with pytest.raises(MappingError, match=r"a.trc: holds no frames; export"):
        read_take(path, "trc")


def test_two_dimensional_tsv_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.tsv").write_text("NO_OF_FRAMES\t1\nFREQUENCY\t100\nDATA_INCLUDED\t2D\n")
    with pytest.raises(MappingError, match=r"DATA_INCLUDED: holds no places \(got '2D'\); export 3D"):
        read_take(tmp_path / "a.tsv", "qualisys")


@pytest.mark.parametrize("suffix", sorted(CONVERSIONS))
def test_other_files_are_named_with_the_way_to_convert_them(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"take{suffix}"
    path.write_bytes(b"something else")
    with pytest.raises(MappingError) as refused:
        look(path)
    assert str(path) in str(refused.value)
    assert CONVERSIONS[suffix] in str(refused.value)
    mapping = tmp_path / "m.toml"
    mapping.write_text(f'[sources.s]\nfile = "take{suffix}"\nrate_hz = 30\nunits = "m"\n[objects.cup]\nsource = "s"\n')
    with pytest.raises(MappingError, match=r"sources.s.*file"):
        load_mapping(mapping)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.fbx", b"Kaydara FBX Binary  \0", "Blender"),
        ("take.csv", b"Kaydara FBX Binary  \0", "Blender"),
        ("a.csv", b"t,x,y,z\n0,1,2,3\n", "a table of text whose layout is not known; write a mapping"),
        ("a.trc", b"Time\tForce\n0\t1\n", "is no TRC .* though its name says so"),
        ("a.c3d", b"", "the file is empty"),
        ("a.xyz", b"what?", "of a kind that is not known; export it as one of these: C3D, "),
    ],
)
def test_a_file_is_known_by_what_it_holds(tmp_path: Path, name: str, content: bytes, message: str) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(MappingError, match=message):
        look(tmp_path / name)


def test_fields_of_tables_are_none_of_a_take(tmp_path: Path) -> None:
    mapping = tmp_path / "m.toml"
    rest = 'units = "m"\n[people.P1]\nsource = "s"\npoints = { head = "LASI", left_wrist = "LWRIST" }\n'
    mapping.write_text(f'[sources.s]\nfile = "a.c3d"\nposition = ["x", "y", "z"]\n{rest}')
    with pytest.raises(UnknownNameError, match=r"sources.s.*no field 'position'"):
        load_mapping(mapping)
    takes.write_c3d(tmp_path / "a.c3d", PREFIXED)
    mapping.write_text(f'[sources.s]\nfile = "a.c3d"\n{rest}'.replace("LASI", "Anna:LASI"))
    with pytest.raises(UnknownNameError, match=r"a.c3d.*no point 'LWRIST'"):
        read_tracks(load_mapping(mapping))


# --- What a file leaves open.


def test_an_unknown_unit_follows_from_forearms_or_is_asked(tmp_path: Path) -> None:
    points = points_of("openpose_body_25")
    path = takes.write_trc(tmp_path / "a.trc", points)
    text = path.read_text(encoding="utf-8").replace("\tmm\t", "\t\t")
    path.write_text(text, encoding="utf-8")
    proposal = look(path)
    assert proposal.unit.value == "mm"
    assert "a forearm is 2" in proposal.unit.why
    takes.write_trc(path, {name: 0.0177 * position for name, position in points.items()})
    path.write_text(path.read_text(encoding="utf-8").replace("\tmm\t", "\t\t"), encoding="utf-8")
    proposal = look(path)
    assert proposal.unit.value is None
    assert proposal.open[0].startswith("sources.take.units: the file does not say its unit")
    mapping = tmp_path / "m.toml"
    filled = mapping_text(proposal, "a.trc").replace("# units = ", "units = 0.0565 # ")
    mapping.write_text(filled, encoding="utf-8")
    assert read_tracks(load_mapping(mapping)).people["P1"].points["nose"][0, 2] == pytest.approx(1.5, abs=0.2)


def test_a_file_that_contradicts_itself_about_up_is_asked(tmp_path: Path) -> None:
    proposal = look(takes.write_c3d(tmp_path / "a.c3d", PREFIXED, y_screen="+Y"))
    assert proposal.up.value is None
    assert proposal.open == ("sources.take.axes: the file says that y points up, but heads lie over feet along z",)


def test_points_without_a_skeleton_are_asked_for(tmp_path: Path) -> None:
    points = {f"m{k}": position for k, position in enumerate(points_of("plug_in_gait").values())}
    proposal, mapping = proposed(takes.write_c3d(tmp_path / "a.c3d", points))
    assert not proposal.people
    assert "no skeleton is recognised" in proposal.open[0]
    with pytest.raises(MappingError, match="brings in nobody and nothing"):
        load_mapping(mapping)


def test_two_people_of_one_file_and_what_one_of_them_lacks(tmp_path: Path) -> None:
    bob = {
        name.replace("Anna", "Bob's"): position + (0.0, 2.0, 0.0)
        for name, position in PREFIXED.items()
        if name != "Anna:LFIN"
    }
    proposal, mapping = proposed(takes.write_c3d(tmp_path / "a.c3d", {**PREFIXED, **bob}))
    assert [subject.name for subject in proposal.people] == ["Anna", "Bob_s"]
    assert not proposal.open
    tracks = read_tracks(load_mapping(mapping))
    assert "left_hand" in tracks.people["Anna"].points
    assert "left_hand" not in tracks.people["Bob_s"].points
    shift = tracks.people["Bob_s"].points["right_hand"] - tracks.people["Anna"].points["right_hand"]
    np.testing.assert_allclose(shift, np.tile((0.0, 2.0, 0.0), (len(shift), 1)), atol=1e-5)


def test_names_that_differ_in_case_alone_tell_skeletons_apart(tmp_path: Path) -> None:
    """LWrist is OpenPose's, l_wrist that of ROS4HRI, though a mapping takes either for the other."""
    joints = ("Shoulder", "Elbow", "Wrist", "Hip", "Knee", "Ankle")
    body = points_of("openpose_body_25")
    points = {name: at for name, at in body.items() if name[1:] in joints} | {"Head": body["Nose"]}
    (subject,) = look(takes.write_trc(tmp_path / "a.trc", points)).people
    assert subject.skeleton == "openpose_body_25"


def test_a_take_is_imported_whole(tmp_path: Path) -> None:
    _, mapping = proposed(takes.write_c3d(tmp_path / "a.c3d", PREFIXED))
    recording = import_recording(load_mapping(mapping))
    assert recording.scene.agents
    errors = recording.provenance.fit["Anna"]["points_cm"]
    assert all(error["median"] < 3.0 for error in errors.values())


def test_without_its_package_the_line_that_installs_it_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "take.bag").write_bytes(b"#ROSBAG V2.0\n")
    monkeypatch.setitem(sys.modules, "rosbags.highlevel", None)
    with pytest.raises(InputError, match=r"rosbags.highlevel is not installed .*pip install 'taskgist\[recordings\]'"):
        look(tmp_path / "take.bag")


def test_every_reader_is_tried() -> None:
    assert {*READERS} == {"c3d", "trc", "bvh", "motive", "nexus", "qualisys", "zed", "mediapipe", "smplx", "ros"}
