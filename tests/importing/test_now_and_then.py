"""Things that are tracked now and then, or by markers, rows with the same time, and poses in two arrays."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from taskgist.errors import MappingError, UnknownNameError
from taskgist.importing import Tracks, load_mapping, read_tracks
from taskgist.importing.resampling import STAYED_M
from taskgist.world.geometry.transforms import about_z, matrix_from_wxyz, wxyz_from_rotation_vector
from tests.importing.skeletons import Array

SHAPE = 'shape = { type = "sphere", radius_m = 0.04 }'
TABLE = '[sources.s]\nfile = "{point}.csv"\ntime = { column = "t", unit = "s" }\nunits = "m"\n'


def table(path: Path, times_s: Array, place: Array) -> None:
    rows = np.column_stack([times_s, place])
    np.savetxt(path, rows, delimiter=",", header="t,x,y,z", comments="", fmt="%.4f")


def handled(path: Path, *spans: tuple[float, float], heights: tuple[float, ...], x: float = 0.4) -> None:
    """A thing that is tracked during some spans, and lifted in each from a height to the next one."""
    parts = []
    for (start_s, end_s), low, high in zip(spans, heights[:-1], heights[1:], strict=True):
        times_s = np.arange(start_s, end_s, 0.1)
        parts.append(
            np.column_stack([times_s, np.full(len(times_s), x), 0 * times_s, np.linspace(low, high, len(times_s))])
        )
    rows = np.vstack(parts)
    table(path, rows[:, 0], rows[:, 1:])


def tracks_of(folder: Path, names: tuple[str, ...], field: str = "", source: str = TABLE) -> Tracks:
    things = "".join(f'[objects.{name}]\nsource = "s"\n{SHAPE}\n{field}\n' for name in names)
    (folder / "m.toml").write_text(source + things, encoding="utf-8")
    return read_tracks(load_mapping(folder / "m.toml"))


def test_one_thing_after_the_other_is_one_clock_where_a_third_spans_both(tmp_path: Path) -> None:
    handled(tmp_path / "cup.csv", (1, 3), heights=(0.8, 0.9))
    handled(tmp_path / "can.csv", (101, 103), heights=(0.8, 0.9), x=0.6)
    with pytest.raises(MappingError, match=r"cup.csv: 1.000 to 2.900 s.*can.csv: 101.000.*offset_s"):
        tracks_of(tmp_path, ("cup", "can"))
    handled(tmp_path / "watch.csv", (0, 120), heights=(0.5, 0.5), x=0.0)
    tracks = tracks_of(tmp_path, ("cup", "can", "watch"))
    assert [tracks.objects[name].known.mean().round(2) for name in ("cup", "can", "watch")] == [0.02, 0.02, 1.0]


def test_what_stays_is_where_it_was_last_seen(tmp_path: Path) -> None:
    handled(tmp_path / "cup.csv", (1, 2), (4, 5), heights=(0.8, 1.0, 1.2))
    handled(tmp_path / "watch.csv", (0, 6), heights=(0.5, 0.5), x=0.0)
    without = tracks_of(tmp_path, ("cup", "watch"))
    assert without.objects["cup"].known.mean() < 0.4
    assert 'if it stays where it was last seen, say outside = "stays" in objects.cup' in without.notes[0]
    tracks = tracks_of(tmp_path, ("cup", "watch"), 'outside = "stays"')
    cup, times_s = tracks.objects["cup"], tracks.times_s
    assert cup.known.all()
    heights = [float(cup.position_m[np.searchsorted(times_s, at_s), 2]) for at_s in (0.1, 3.0, 5.5)]
    np.testing.assert_allclose(heights, (0.8, 1.0, 1.2))
    assert tracks.notes == ("cup is taken to stay where it was last seen in 66 % of the frames",)
    assert not tracks.objects["watch"].stayed.any()


def test_what_was_moved_unseen_is_unknown_meanwhile(tmp_path: Path) -> None:
    handled(tmp_path / "watch.csv", (0, 6), heights=(0.5, 0.5), x=0.0)
    for apart_m, known in ((0.9 * STAYED_M, True), (1.1 * STAYED_M, False)):
        spans = np.concatenate([np.arange(1, 2, 0.1), np.arange(4, 5, 0.1)])
        table(tmp_path / "cup.csv", spans, np.column_stack([0.4 + apart_m * (spans > 3), 0 * spans, 0.8 + 0 * spans]))
        tracks = tracks_of(tmp_path, ("cup", "watch"), 'outside = "stays"')
        assert tracks.objects["cup"].known[np.searchsorted(tracks.times_s, 3.0)] == known
        assert tracks.objects["cup"].known[[0, -1]].all()
        assert ("after which it is seen elsewhere" in tracks.notes[0]) != known


def test_rows_with_the_same_time_are_refused_until_one_is_chosen(tmp_path: Path) -> None:
    times_s = np.array([0.0, 0.1, 0.1, 0.2, 0.2, 0.2, 0.3])
    table(tmp_path / "cup.csv", times_s, np.column_stack([0.01 * np.arange(7), 0 * times_s, 0.8 + 0 * times_s]))
    with pytest.raises(MappingError, match=r'line 4.*times repeat.*0.1 s, then 0.1 s.*time.repeated = "first"'):
        tracks_of(tmp_path, ("cup",))
    for which, x in (("first", (0.00, 0.01, 0.03, 0.06)), ("last", (0.00, 0.02, 0.05, 0.06))):
        source = TABLE.replace('unit = "s"', f'unit = "s", repeated = "{which}"')
        position = tracks_of(tmp_path, ("cup",), source="[time]\nrate_hz = 10\n" + source).objects["cup"].position_m
        np.testing.assert_allclose(position[:, 0], x, atol=1e-9)


TURNS = {
    "quat": 'kind = "wxyz", columns = [0, 1, 2, 3]',
    "turn": 'kind = "matrix", columns = [0, 1, 2, 3, 4, 5, 6, 7, 8]',
}


@pytest.mark.parametrize("array", TURNS)
@pytest.mark.parametrize("several", [False, True], ids=["one thing", "several things"])
def test_position_and_rotation_in_two_arrays(tmp_path: Path, array: str, several: bool) -> None:
    wxyz = np.array([about_z(0.1 * k) for k in range(30)])
    arrays = {"pos": np.random.default_rng(0).normal(size=(30, 3)), "quat": wxyz, "turn": matrix_from_wxyz(wxyz)}
    if several:
        arrays = {name: np.stack([np.roll(values, 1, axis=0), values], axis=1) for name, values in arrays.items()}
    np.savez(tmp_path / "o.npz", **arrays)  # type: ignore[arg-type] # its options are no arrays
    source = '[sources.s]\nfile = "o.npz"\narray = "pos"\nrate_hz = 30\nunits = "m"\nnames = ["other", "cup"]\n'
    layout = 'layout = ["time", "{point}", "value"]\n' if several else ""
    cup = tracks_of(
        tmp_path, ("cup",), source=source + layout + f'rotation = {{ array = "{array}", {TURNS[array]} }}\n'
    )
    np.testing.assert_allclose(cup.objects["cup"].wxyz, wxyz, atol=1e-9)


def test_arrays_of_rotations_that_cannot_be_right_are_named(tmp_path: Path) -> None:
    np.savez(tmp_path / "o.npz", pos=np.zeros((30, 3)), quat=np.tile((1.0, 0, 0, 0), (29, 1)))
    source = '[sources.s]\nfile = "o.npz"\narray = "pos"\nrate_hz = 30\nunits = "m"\n'
    with pytest.raises(MappingError, match=r"o.npz: rotation: there are 30 positions, but 29 orientations"):
        tracks_of(tmp_path, ("cup",), source=source + f'rotation = {{ array = "quat", {TURNS["quat"]} }}\n')
    with pytest.raises(UnknownNameError, match=r"o.npz: no array .squat.; did you mean .quat."):
        tracks_of(tmp_path, ("cup",), source=source + f'rotation = {{ array = "squat", {TURNS["quat"]} }}\n')
    with pytest.raises(MappingError, match=r"rotation.*array.*only NPZ and MAT files hold several arrays"):
        tracks_of(tmp_path, ("cup",), source=TABLE + f'rotation = {{ array = "quat", {TURNS["quat"]} }}\n')


CORNERS = np.array([(0.05, 0.0, 0.02), (-0.03, 0.04, 0.0), (-0.02, -0.04, 0.01), (0.01, 0.02, -0.05)])
"""Of four markers on a thing, in its axes, metres."""
MARKED = """
[sources.s]
file = "m.npz"
rate_hz = 30
units = "m"
names = ["a", "b", "c", "d", "far"]
[objects.cup]
source = "s"
points = ["a", "b", "c", "d"]
shape = { type = "box", size_m = [0.1, 0.1, 0.1] }
"""


def marked() -> tuple[Array, Array, Array]:
    """Markers over time (30, 5, 3) of a thing that is moved and turned, and its true places and turns."""
    angles = np.linspace(0.0, 2.5, 30)
    wxyz = wxyz_from_rotation_vector(np.array([0.4, -0.3, 1.0]) * angles[:, None])
    place = np.array([0.5, 0.1, 0.9]) + np.array([0.1, 0.05, 0.2]) * angles[:, None]
    body = place[:, None] + CORNERS @ np.swapaxes(matrix_from_wxyz(wxyz), 1, 2)
    return np.concatenate([body, body[:, :1] + 3.0], axis=1), place, wxyz


def test_a_thing_is_tracked_by_the_markers_on_it(tmp_path: Path) -> None:
    markers, place, wxyz = marked()
    rng = np.random.default_rng(5)
    lost = rng.random((30, 4)) < 0.15
    lost[0] = False
    lost[7] = [True, True, False, False]  # two say too little
    markers[:, :4][lost] = np.nan
    np.savez(tmp_path / "m.npz", markers=markers)
    (tmp_path / "m.toml").write_text(MARKED, encoding="utf-8")
    cup = read_tracks(load_mapping(tmp_path / "m.toml")).objects["cup"]
    enough = lost.sum(axis=1) <= 1
    assert enough.sum() > 20
    middle = place + CORNERS.mean(axis=0) @ np.swapaxes(matrix_from_wxyz(wxyz), 1, 2)
    np.testing.assert_allclose(cup.position_m[enough], middle[enough], atol=1e-9)
    np.testing.assert_allclose(matrix_from_wxyz(cup.wxyz[enough]), matrix_from_wxyz(wxyz[enough]), atol=1e-9)
    assert cup.known.all(), "shorter gaps are bridged as those of a body are"


MISMARKED = {
    "few": ('"c", "d"]\nshape', "]\nshape", r"objects.cup.points: must list 3 markers, or more"),
    "twice": ('"d"]\nshape', '"a"]\nshape', r"objects.cup.points: names a marker twice"),
    "unknown": ('"d"]\nshape', '"d", "never"]\nshape', r"no point in names 'never'"),
}


@pytest.mark.parametrize("mistake", MISMARKED)
def test_markers_that_cannot_be_a_thing_are_told(mistake: str, tmp_path: Path) -> None:
    old, new, message = MISMARKED[mistake]
    assert old in MARKED
    np.savez(tmp_path / "m.npz", markers=marked()[0])
    (tmp_path / "m.toml").write_text(MARKED.replace(old, new), encoding="utf-8")
    with pytest.raises((MappingError, UnknownNameError), match=message):
        read_tracks(load_mapping(tmp_path / "m.toml"))


def test_markers_in_a_line_or_never_seen_together_fix_no_pose(tmp_path: Path) -> None:
    markers, _, _ = marked()
    for change, message in ((np.s_[::2, 0], None), (np.s_[:, 3], "never all seen at once")):
        some = markers.copy()
        some[change] = np.nan
        np.savez(tmp_path / "m.npz", markers=some)
        (tmp_path / "m.toml").write_text(MARKED, encoding="utf-8")
        if message is None:
            assert read_tracks(load_mapping(tmp_path / "m.toml")).objects["cup"].known.all()
        else:
            with pytest.raises(MappingError, match=rf"objects.cup.points: its markers are {message}"):
                read_tracks(load_mapping(tmp_path / "m.toml"))
    row = markers[:, :1] + np.linspace(0.0, 0.3, 4)[:, None] * (1.0, 0.0, 0.0)
    np.savez(tmp_path / "m.npz", markers=np.concatenate([row, markers[:, 4:]], axis=1))
    with pytest.raises(MappingError, match=r"objects.cup.points: its markers lie in a line"):
        read_tracks(load_mapping(tmp_path / "m.toml"))
