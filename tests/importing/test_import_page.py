"""The examples of docs/howto/import.md are real: they load, read the files they describe, and are the shipped ones."""

from __future__ import annotations

import re
from importlib.resources import files
from pathlib import Path

import numpy as np

from taskgist.importing import load_mapping, read_tracks
from taskgist.importing.mapping_people import DIRECTIONS, LANDMARKS, PARTS
from taskgist.importing.skeletons import SKELETONS
from tests.importing.skeletons import NAMES, TIMES_S, cup_position, cup_wxyz, keypoints, mapping_file, write_csv

PAGE = (Path(__file__).parents[2] / "docs" / "howto" / "import.md").read_text(encoding="utf-8")
EXAMPLES = dict(re.findall(r"^```toml\n# (\S+\.toml)\n(.*?)^```$", PAGE, flags=re.DOTALL | re.MULTILINE))


def test_keypoints_example(tmp_path: Path) -> None:
    stamps_ms = 1000.0 * TIMES_S[:, None] + 1.7e12
    camera_mm = 1000.0 * keypoints()[..., [1, 2, 0]] * (-1.0, 1.0, -1.0)
    header = ["stamp", *(f"{who}_{name}_{axis}" for who in ("one", "two") for name in NAMES for axis in "xyz")]
    write_csv(tmp_path / "body.csv", header, np.hstack([stamps_ms, camera_mm.reshape(len(TIMES_S), -1)]))
    header = ["stamp", "x", "y", "z", "qx", "qy", "qz", "qw"]
    write_csv(tmp_path / "cup.csv", header, np.hstack([stamps_ms, cup_position(), cup_wxyz()[:, [1, 2, 3, 0]]]))
    tracks = read_tracks(load_mapping(mapping_file(tmp_path, EXAMPLES["keypoints.toml"])))
    toe = NAMES.index("RIGHT_FOOT")
    np.testing.assert_allclose(tracks.people["P2"].points["right_toe"], keypoints()[:, 1, toe], atol=1e-3)
    np.testing.assert_allclose(tracks.objects["cup"].position_m, cup_position(), atol=1e-3)
    assert {"face", "left_hand", "right_hand"} == tracks.people["P1"].directions.keys()


def test_shipped_examples() -> None:
    for name in ("kth_handovers.toml", "kth_sample_old.toml"):
        assert EXAMPLES[name] == (files("taskgist") / "data" / "mappings" / name).read_text(encoding="utf-8")


def test_every_name_is_explained() -> None:
    lefts = {name for name in LANDMARKS if not name.startswith("right_")}
    axes = {axis for part in DIRECTIONS.values() for axis in part}
    for name in lefts | set(PARTS) | set(DIRECTIONS) | axes | set(SKELETONS):
        assert f"`{name}`" in PAGE, name
