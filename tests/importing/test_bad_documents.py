"""Mapping files whose tables are of another kind than they should be: one clear error each."""

from importlib.resources import as_file, files
from pathlib import Path

import pytest

from taskgist.errors import InputError
from taskgist.importing import load_mapping

CHANGES = [
    ("[sources.bones]", "sources.bones = 3\n[sources.other]", "bones"),
    ('source = "bones"\nperson = "giver"', 'source = "bones"\nperson = "giver"\nstature_m = ' + "9" * 400, "stature_m"),
    ('like = "P1"', "like = { x = 1 }", "like"),
    ('like = "P1"', "like = 3", "like"),
    ("rate_hz = 120", "rate_hz = " + "9" * 400, "rate_hz"),
    ("size_m = [0.80, 1.20, 0.04]", "size_m = [nan, 1.20, 0.04]", "size_m"),
]


@pytest.mark.parametrize(("before", "after", "field"), CHANGES)
def test_wrong_kinds(before: str, after: str, field: str, tmp_path: Path) -> None:
    with as_file(files("taskgist") / "data" / "mappings" / "kth_handovers.toml") as shipped:
        text = shipped.read_text(encoding="utf-8")
    assert before in text
    mapping = tmp_path / "mapping.toml"
    mapping.write_text(text.replace(before, after, 1))
    with pytest.raises(InputError, match=field) as caught:
        load_mapping(mapping, parameters={"folder": "x"})
    assert "mapping.toml" in str(caught.value)
