"""docs/howto/files.md keeps its word: its table lists all formats, and its snippets import files of our own."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from taskgist.importing import load_mapping, look, mapping_text, read_tracks
from taskgist.importing.readers import CONVERSIONS, READERS
from taskgist.world.geometry.transforms import matrix_from_wxyz
from tests.importing.takes import cup, matrices, write_c3d
from tests.importing.test_camera_files import zed
from tests.importing.test_readers import PREFIXED, motive

PAGE = (Path(__file__).parents[2] / "docs" / "howto" / "files.md").read_text(encoding="utf-8")
LOADS = PAGE[PAGE.index("## What loads") : PAGE.index("## What it finds out")]
SNIPPETS: list[str] = re.findall(r"^```toml\n(.*?)^```$", PAGE, flags=re.DOTALL | re.MULTILINE)


def snippet(section: str) -> list[str]:
    """The lines of the snippet that begins with this table, without it."""
    return next(text for text in SNIPPETS if text.startswith(f"[{section}]")).splitlines()[1:]


def test_every_format_has_a_row() -> None:
    rows = re.findall(r"^\| [^|]+ \| (`[^|]+`) \|", LOADS, flags=re.MULTILINE)
    named = {name for row in rows for name in re.findall(r"`(\w+)`", row)} - {"format"}
    assert named == {*READERS, "csv", "npz", "npy", "mat"}


def test_files_that_do_not_load_are_named_by_the_reader_too() -> None:
    table = PAGE[PAGE.index("## What does not load") : PAGE.index("## From Python")]
    for suffix in re.findall(r"`(\.\w+)`", table):
        assert suffix in CONVERSIONS or suffix == ".trc", suffix


def test_the_cup_of_motive_gets_its_shape(tmp_path: Path) -> None:
    path = motive(tmp_path / "take.csv")
    shape = next(line for line in snippet("objects.cup") if line.startswith("shape"))
    mapping = tmp_path / "take.toml"
    mapping.write_text(mapping_text(look(path), path.name).replace("# shape", f"{shape}\n#"), encoding="utf-8")
    track = read_tracks(load_mapping(mapping)).objects["cup"]
    assert (track.shapes[0].kind, track.shapes[0].size_m) == ("cylinder", (0.04, 0.10))
    np.testing.assert_allclose(track.position_m[:, 2], cup()[0][:, 2], atol=1e-5)


def test_a_depth_camera_is_smoothed_and_set_at_its_height(tmp_path: Path) -> None:
    path = zed(tmp_path / "bodies.json")
    proposed = mapping_text(look(path), path.name).splitlines()
    kept = [line for line in proposed if not line.startswith(("transform", "# confidence"))]
    at = kept.index("[sources.take]") + 1
    mapping = tmp_path / "bodies.toml"
    mapping.write_text("\n".join([*kept[:at], *snippet("sources.take"), *kept[at:]]), encoding="utf-8")
    loaded = load_mapping(mapping)
    assert loaded.source("take").smooth_s == 0.2
    head = read_tracks(loaded).people["P7"].points["left_eye"]
    assert 1.4 < np.nanmedian(head[:, 2]) < 1.7


def test_a_box_with_markers_is_an_object(tmp_path: Path) -> None:
    position, wxyz = cup()
    corners = np.array([(0.15, 0.1, 0.05), (-0.15, 0.1, 0.05), (-0.15, -0.1, 0.05), (0.15, -0.1, -0.05)])
    seen = position[:, None] + corners @ np.swapaxes(matrices(wxyz), 1, 2)
    markers = {f"box{k + 1}": seen[:, k] for k in range(4)}
    write_c3d(tmp_path / "take.c3d", {**PREFIXED, **markers})
    text = mapping_text(look(tmp_path / "take.c3d"), "take.c3d")
    assert '# points = ["box1", "box2", "box3"]' in text
    (tmp_path / "take.toml").write_text("\n".join([text, "[objects.box]", *snippet("objects.box")]), encoding="utf-8")
    box = read_tracks(load_mapping(tmp_path / "take.toml")).objects["box"]
    np.testing.assert_allclose(box.position_m, seen.mean(axis=1), atol=1e-3)
    turned = matrix_from_wxyz(box.wxyz)[-1] @ matrices(wxyz)[0]
    np.testing.assert_allclose(turned, matrices(wxyz)[-1], atol=1e-2)
