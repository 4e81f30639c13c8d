"""Files of MATLAB: what SciPy writes comes back, structures by their fields, and what would not fit is refused."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from taskgist.errors import MappingError, UnknownNameError
from taskgist.importing import load_mapping, read_tracks
from taskgist.importing.mat import MatFile
from taskgist.importing.readers import kind_of
from tests.importing.skeletons import Array, cup_position

MOST = 2**20
PLACES = cup_position()


def saved(path: Path, values: dict[str, object], *, packed: bool = True) -> Path:
    savemat(path, values, do_compression=packed)
    return path


@pytest.mark.parametrize("packed", [False, True], ids=["plain", "packed"])
def test_variables_and_fields_come_back(tmp_path: Path, packed: bool) -> None:
    labeled = {"Count": 2, "Labels": np.array(["cup", "can"], dtype=object), "Data": np.arange(24.0).reshape(2, 3, 4)}
    values = {"t": np.arange(4), "note": "a take", "take": {"FrameRate": 30, "Trajectories": {"Labeled": labeled}}}
    file = MatFile(saved(tmp_path / "a.mat", values, packed=packed), most_bytes=MOST)
    assert file.names == ("t", "take.Trajectories.Labeled.Data")
    np.testing.assert_array_equal(file.array("take.Trajectories.Labeled.Data"), labeled["Data"])
    np.testing.assert_array_equal(file.array("t"), [0, 1, 2, 3])
    with pytest.raises(UnknownNameError, match=r"a.mat: no array 'take.Data'"):
        file.array("take.Data")


MAPPING = """
[sources.s]
file = "a.mat"
array = "take.Trajectories.Labeled.Data"
layout = ["{point}", "value", "time"]
rate_hz = 30
units = "mm"
names = ["can", "cup"]
[objects.cup]
source = "s"
shape = { type = "sphere", radius_m = 0.04 }
"""


def marker_first(places: Array) -> Array:
    """As Qualisys writes trajectories: markers, values and residual, frames; millimetres."""
    cup = np.vstack([1000.0 * places.T, np.ones(len(places))])
    return np.stack([cup + 500.0, cup])


def test_trajectories_of_a_structure_are_mapped(tmp_path: Path) -> None:
    saved(tmp_path / "a.mat", {"take": {"Trajectories": {"Labeled": {"Data": marker_first(PLACES)}}}})
    (tmp_path / "m.toml").write_text(MAPPING, encoding="utf-8")
    tracks = read_tracks(load_mapping(tmp_path / "m.toml"))
    np.testing.assert_allclose(tracks.objects["cup"].position_m, PLACES, atol=1e-9)


def test_a_file_of_unknown_layout_is_told_with_what_it_holds(tmp_path: Path) -> None:
    path = saved(tmp_path / "a.mat", {"q": np.zeros((5, 7)), "take": {"xyz": np.zeros((5, 3))}})
    with pytest.raises(MappingError, match=r"a table of arrays.*got 'q 5x7, take.xyz 5x3'.*write a mapping"):
        kind_of(path)


def test_what_would_unpack_to_too_much_is_refused_unread(tmp_path: Path) -> None:
    path = saved(tmp_path / "a.mat", {"q": np.zeros(10 * MOST // 8)})
    assert path.stat().st_size < MOST // 10
    with pytest.raises(MappingError, match=r"a.mat: is too large.*table_bytes"):
        MatFile(path, most_bytes=MOST)


def test_other_versions_and_damage_are_told(tmp_path: Path) -> None:
    stream = io.BytesIO()
    savemat(stream, {"q": np.arange(300.0)}, do_compression=True)
    good = stream.getvalue()
    for content, message in (
        (b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(128) + b"\x89HDF", r"MATLAB 7.3, which is HDF5.*'-v7'"),
        (b"\0\0\0\0 of version 4", "not a file of MATLAB 5 to 7"),
        (good[: len(good) // 2], "not a file of MATLAB 5 to 7"),
        (good[:200] + bytes(100) + good[300:], "not a file of MATLAB 5 to 7"),
    ):
        (tmp_path / "a.mat").write_bytes(content)
        with pytest.raises(MappingError, match=message):
            MatFile(tmp_path / "a.mat", most_bytes=MOST)
    rng = np.random.default_rng(0)
    for _ in range(200):
        damaged = bytearray(good)
        for at in rng.integers(0, len(good), 3):
            damaged[at] = rng.integers(256)
        (tmp_path / "a.mat").write_bytes(damaged)
        try:
            MatFile(tmp_path / "a.mat", most_bytes=MOST)
        except MappingError:
            continue
