"""Tables of anybody: bounded before they are unpacked, numbers as data sheets write them, and inputs that are named."""

from __future__ import annotations

import os
import re
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from taskgist.errors import InputError, MappingError
from taskgist.importing import input_files, load_mapping
from taskgist.importing.csv import CsvTable, number
from taskgist.importing.mapping import TableFormat
from taskgist.importing.tables import ArrayTable
from tests.importing.skeletons import TIMES_S, cup_position, cup_wxyz, keypoints, mapping_file, npz_mapping, tracks_of


def table(folder: Path, text: str, **form: str) -> CsvTable:
    (folder / "t.csv").write_text(text, encoding="utf-8")
    return CsvTable(folder / "t.csv", TableFormat(**form), "m.toml: sources.t", most_bytes=2**20)  # type: ignore[arg-type]


@pytest.mark.parametrize("text", ["1", "-1.5", "+.5", "5.", "1e3", "-1.25E-07", "007", "0"])
def test_numbers_of_data_sheets_are_those_of_python(text: str) -> None:
    assert number(text) == float(text)


@pytest.mark.parametrize(
    "text",
    ["1_0", "١٢", "４２", "²", "½", "0x10", "1e", "e5", ".", "--1", "1 2", "infinity", "inf", "-nan", "1e400", "1,5"],
)
def test_other_spellings_are_refused_by_file_line_and_value(text: str, tmp_path: Path) -> None:
    cells = table(tmp_path, f"t;x\n0;1\n1;{text}\n2;3\n")
    message = rf"m.toml: sources.t: .*t.csv, line 3: column 'x': is no number \(got {re.escape(repr(text))}\)"
    with pytest.raises(MappingError, match=message):
        cells.numbers(["x"], cells.rows_where([]))


def test_what_stands_for_not_tracked_stays_so(tmp_path: Path) -> None:
    cells = table(tmp_path, "t,x\n0,1\n1,\n2,NaN\n3,n/a\n4,null\n")
    values = cells.numbers(["x"], cells.rows_where([]))[:, 0]
    np.testing.assert_array_equal(values, [1, np.nan, np.nan, np.nan, np.nan])


def test_a_table_takes_no_more_than_its_limit(tmp_path: Path) -> None:
    with pytest.raises(MappingError, match=r"t.csv, line \d+: the table is too large; .*limits.table_bytes"):
        table(tmp_path, "1,2\n" * 200_000)
    with pytest.raises(MappingError, match="the table is too large"):
        table(tmp_path, "a,b\n" * 200_000)  # texts take more than numbers
    with pytest.raises(MappingError, match="a line without end"):
        table(tmp_path, "1," * 2**24)


def test_a_table_is_read_in_little_more_than_its_numbers(tmp_path: Path) -> None:
    text = "\n".join(f"{row},{row}.5,-{row}.25" for row in range(25_000))
    tracemalloc.start()
    try:
        cells = table(tmp_path, text)
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert cells.numbers([2], cells.rows_where([]))[-1, 0] == -24_999.25
    assert most < len(text) + 6 * 8 * 3 * 25_000


@pytest.mark.parametrize(
    ("delimiter", "decimal"), [(",", "."), (";", ","), ("\t", "."), ("|", "."), ("whitespace", ".")]
)
@pytest.mark.parametrize("header", [False, True])
def test_many_lines_at_once_are_what_they_are_one_by_one(
    delimiter: str, decimal: str, header: bool, tmp_path: Path
) -> None:
    rng = np.random.default_rng(3)
    between = "  " if delimiter == "whitespace" else delimiter
    spelled = [["1", "-2.5", "+.5", "1e3", "-1.25E-07", "007"][k] for k in rng.integers(0, 6, 3 * 5000)]
    if delimiter != "whitespace":
        spelled = ["" if rng.random() < 0.1 and k % 3 else cell for k, cell in enumerate(spelled)]
    rows = [spelled[k : k + 3] for k in range(0, len(spelled), 3)]
    rows[3000][1], rows[3001] = "lost", ["0", '"7"' if delimiter != "whitespace" else "7", "9"]
    lines = ["# of a tracker", *(["a" + between + "b" + between + "c"] if header else [])]
    lines += [between.join(row).replace(".", decimal) for row in rows]
    (tmp_path / "t.csv").write_text("\n\n".join(lines), encoding="utf-8")
    form = TableFormat(delimiter=delimiter, decimal=decimal)
    cells = CsvTable(tmp_path / "t.csv", form, "m.toml: sources.t", most_bytes=2**24)
    values = cells.numbers([0, 2], cells.rows_where([]))
    assert len(values) == 5000
    truth = [[float(cell.strip('"') or "nan") for cell in (row[0], row[2])] for row in rows]
    np.testing.assert_array_equal(values, truth)
    line = 2 * (3000 + 1 + header) + 1
    with pytest.raises(MappingError, match=rf"t.csv, line {line}: column 1: is no number \(got 'lost'\)"):
        cells.numbers([1], cells.rows_where([]))


def test_pipes_and_zeros_are_refused_without_waiting(tmp_path: Path) -> None:
    text = npz_mapping(tmp_path)
    (tmp_path / "data.npz").unlink()
    os.mkfifo(tmp_path / "data.npz")
    with pytest.raises(MappingError, match=r"mapping.toml: sources.body: .*data.npz: .*it is a pipe"):
        tracks_of(tmp_path, text)
    with pytest.raises(MappingError, match="it is a pipe"):
        load_mapping(tmp_path / "data.npz")


def test_names_with_a_nul_are_told(tmp_path: Path) -> None:
    text = npz_mapping(tmp_path).replace('file = "data.npz"', 'file = "da\\u0000ta.npz"')
    with pytest.raises(MappingError, match=r"sources.body.file: holds a control character"):
        tracks_of(tmp_path, text)


def test_an_array_without_frames_is_told(tmp_path: Path) -> None:
    text = npz_mapping(tmp_path)
    np.savez(tmp_path / "data.npz", t=TIMES_S[:0], body=keypoints()[:0], cup=np.zeros((0, 7)))
    with pytest.raises(MappingError, match="body: holds no numbers"):
        tracks_of(tmp_path, text)


def test_an_array_that_is_not_asked_for_is_not_loaded(tmp_path: Path) -> None:
    npz_mapping(tmp_path)
    np.savez_compressed(tmp_path / "data.npz", t=TIMES_S, vast=np.zeros(2**20))
    arrays = ArrayTable(tmp_path / "data.npz", "npz", "m.toml: sources.t", most_bytes=2**16)
    assert arrays.array("t").tolist() == TIMES_S.tolist()
    with pytest.raises(MappingError, match="vast: is too large"):
        arrays.array("vast")


@pytest.mark.parametrize("far", [1e7, -1e200])
def test_nothing_is_farther_than_a_thousand_kilometres(far: float, tmp_path: Path) -> None:
    text = npz_mapping(tmp_path)
    cup = np.hstack([cup_position(), cup_wxyz()])
    cup[3, 0] = far
    np.savez(tmp_path / "data.npz", t=TIMES_S, body=keypoints(), cup=cup)
    with pytest.raises(MappingError, match=r"data.npz, frame 3: position: is too far away \(got \["):
        tracks_of(tmp_path, text)


def test_a_clock_that_jumps_makes_no_million_frames(tmp_path: Path) -> None:
    text = npz_mapping(tmp_path)
    times_s = np.append(TIMES_S[:-1], 1e9)
    np.savez(tmp_path / "data.npz", t=times_s, body=keypoints(), cup=np.hstack([cup_position(), cup_wxyz()]))
    with pytest.raises(MappingError, match=r"time: too many frames \(got '\d+,.*limits.frame_bytes"):
        tracks_of(tmp_path, text)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('array = "body"', 'array = "body"\nlayout = [["time"], "value"]'),
        (
            "[people.P1.points]",
            '[people.P1.directions]\nhead = { from = [["nose"]], to = ["nose"] }\n[people.P1.points]',
        ),
        ('nose = "NOSE"', 'nose = ["NOSE"]'),
        ('nose = "NOSE"', 'nose = { mean = [["NOSE"]] }'),
        ("[people.P2]", "[people.P2]\nunknown = [[1]]"),
        ("[people.P1]", f"x{'.a' * 3000} = 1\n[people.P1]"),
        ("[people.P1]", f"x = {'[' * 3000}{']' * 3000}\n[people.P1]"),
    ],
)
def test_what_is_of_another_type_or_too_deep_is_told(old: str, new: str, tmp_path: Path) -> None:
    text = npz_mapping(tmp_path)
    assert old in text
    with pytest.raises(InputError, match=r"mapping.toml"):
        tracks_of(tmp_path, text.replace(old, new, 1))


def test_files_that_an_import_reads(tmp_path: Path) -> None:
    (tmp_path / "part.obj").write_text("v 0 0 0\n")
    base = mapping_file(tmp_path, npz_mapping(tmp_path))
    base = base.rename(tmp_path / "base.toml")
    mesh = (
        '[objects.ball]\nfixed = { position_m = [0, 0, 1] }\nshape = { type = "mesh", file = "part.obj", units = "m" }'
    )
    mapping = load_mapping(mapping_file(tmp_path, f'extends = "base.toml"\n{mesh}'))
    assert set(input_files(mapping)) == {
        tmp_path / name for name in ("mapping.toml", "base.toml", "data.npz", "part.obj")
    }
