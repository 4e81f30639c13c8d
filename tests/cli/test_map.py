"""``taskgist map``: pictures, arrays, places."""

from __future__ import annotations

from pathlib import Path

import pytest

from taskgist.maps.ability_map import ability_map, read_maps
from taskgist.world import Scene, Stage
from tests.cli.running import contents, refusal, run, run_json
from tests.cli.test_query import ROOM, SCENE

pytestmark = pytest.mark.usefixtures("coarse_maps")
PNG = b"\x89PNG\r\n"


@pytest.fixture
def room(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "room.xml").write_text(ROOM)
    (tmp_path / "room.toml").write_text(SCENE)
    return tmp_path


def test_a_picture_and_arrays(room: Path) -> None:
    text = run("map room.toml --agent P1 --level 2 -o map.png --npz map.npz")
    found = ability_map(Stage(Scene.load("room.toml")), "P1", "reach")
    assert f"where P1 reaches, effort level 2 at most: {found.at_most(2).count} cells" in text
    assert f"Arm_Effort {found.counts[1]}, " in text
    assert text.endswith("saved map.png\nsaved map.npz\n")
    assert (room / "map.png").read_bytes().startswith(PNG)
    (kept,) = read_maps(room / "map.npz")
    assert (kept.levels == found.levels).all()
    assert set(contents(room)) == {"room.toml", "room.xml", "map.png", "map.npz"}


@pytest.mark.usefixtures("room")
def test_questions_and_places() -> None:
    line = 'map room.toml --where "P1 reaches <= 2 and not P2 sees <= 1"'
    document = run_json(f"{line} --size 0.06,0.06,0.08")
    assert {(each["agent"], each["ability"]) for each in document["maps"]} == {("P1", "reach"), ("P2", "see")}
    assert "table" in {place["support"] for place in document["places"]}
    assert document["picture"] is document["arrays"] is None
    assert document["cells"] > 0
    run(f"{line} --size 2,2,2", exit_code=1)


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("", "--agent: whose map is not said; name --agent, or ask with --where"),
        ("--agent P3", "room.toml: no agent 'P3'"),
        ("--agent P1 --ability grasp", "--ability: no ability to map 'grasp'"),
        ("--agent P1 --where 'P1 sees'", "--agent: does not go with --where"),
        ("--where 'P1 grasps'", "--where: maps tell where agents see and reach"),
        ("--agent P1 --size 1,2", "--size: needs three numbers (got '1,2')"),
        ("--agent P1 --size 0,1,1", "--size: an object needs positive sizes"),
        ("--agent P1 -o map.jpg", "map.jpg: --out: pictures are PNG; name it .png"),
        ("--agent P1 --npz map.csv", "map.csv: --npz: arrays are NPZ; name it .npz"),
        ("--agent P1 -o nowhere/map.png", "nowhere/map.png: --out: cannot be written"),
    ],
)
def test_what_is_refused(room: Path, line: str, message: str) -> None:
    assert message in refusal(f"map room.toml {line}", room)
