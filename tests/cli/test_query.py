"""``taskgist query``: tables, least actions, what actions bring about, set questions, and why."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

from taskgist.language.efforts import why
from taskgist.perspective import ABILITIES, EFFORT_NAMES
from taskgist.perspective.scene_efforts import SceneEfforts
from taskgist.world import Scene, Stage
from tests import meshes
from tests.cli.running import Result, refusal, run, run_json
from tests.shipped import PATHS

ROOM = """<mujoco><worldbody>
  <geom name="floor" type="plane" size="5 5 0.1"/>
  <body name="table" pos="0 0 0.7"><geom type="box" size="0.4 0.6 0.02"/></body>
  <body name="box" pos="0 0.1 0.87"><freejoint/><geom type="box" size="0.02 0.25 0.15"/></body>
  <body name="cup" pos="-0.15 0.1 0.77"><freejoint/><geom type="cylinder" size="0.04 0.05"/></body>
</worldbody></mujoco>"""
SCENE = """[scene]
model = "room.xml"
[agents.P1]
position_m = [-0.75, 0]
[agents.P2]
position_m = [0.75, 0]
yaw_deg = 180
"""


@pytest.fixture
def room(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "room.xml").write_text(ROOM)
    (tmp_path / "room.toml").write_text(SCENE)
    return tmp_path


def asked(room: Path) -> SceneEfforts:
    return SceneEfforts(Stage(Scene.load(room / "room.toml")))


def test_a_table_of_efforts(room: Path) -> None:
    lines = run("query room.toml").splitlines()
    assert [line.split()[0] for line in lines] == ["P1", "box", "cup", "P2", "box", "cup"]
    for agent, start in (("P1", 0), ("P2", 3)):
        assert lines[start].split() == [agent, *ABILITIES]
        for row, name in ((1, "box"), (2, "cup")):
            efforts = [asked(room).effort(agent, name, ability) for ability in ABILITIES]
            assert lines[start + row].split() == [name, *(word for e in efforts for word in (str(e.level), e.name))]


def test_the_least_actions_for_an_object_and_why(room: Path) -> None:
    text = run("query room.toml --object cup --agent P1 --why")
    for ability in ABILITIES:
        effort = asked(room).effort("P1", "cup", ability)
        assert f"{effort.level} {EFFORT_NAMES[ability][effort.level or 0]}" in text
        assert f"{why(effort)}." in text
    document = run_json("query room.toml --object cup --ability reach --why")
    assert [(each["agent"], each["object"], each["ability"]) for each in document["efforts"]] == [
        ("P1", "cup", "reach"),
        ("P2", "cup", "reach"),
    ]
    first = document["efforts"][0]
    assert first["effort"] == EFFORT_NAMES["reach"][first["level"]]
    assert first["why"].startswith("P1 reaches the cup by ")
    assert {"actions", "amount", "joints_rad", "posture", "evidence", "reason"} <= set(first)


def test_what_actions_bring_about(room: Path) -> None:
    line = "query room.toml --agent P1 --ability reach --actions"
    found = run_json(f"{line} 'Lean_Torso,Stretch_Out_Arm(left)'")["abilities"]["reach"]
    able = asked(room).efforts_with("P1", "reach", ["Lean_Torso", "Stretch_Out_Arm(left)"])
    assert found["yes"] == found["becomes"] == [name for name, effort in able.items() if effort.level == 2] != []
    assert found["unknown"] == []
    assert "P1 reaches the cup by leaning forward" in run(f"{line} 'Lean_Torso,Stretch_Out_Arm(left)' --why")
    assert run_json(f"{line} Lean_Torso", exit_code=1)["abilities"]["reach"]["yes"] == []


@pytest.mark.usefixtures("room")
def test_set_questions() -> None:
    question = '--where "P1 reaches <= 2 and not P2 sees <= 1"'
    document = run_json(f"query room.toml {question}")
    assert (document["yes"], document["no"], document["unknown"]) == (["cup"], ["box"], [])
    assert {(e["agent"], e["ability"]) for e in document["efforts"]["cup"]} == {("P1", "reach"), ("P2", "see")}
    text = run(f"query room.toml {question} --why")
    assert text.index("yes:") < text.index("cup") < text.index("no:") < text.index("  box")
    assert "unknown: none" in text
    assert "P2 sees the box" in text
    run('query room.toml --where "P1 reaches = 0"', exit_code=1)


URDF = """<robot name="r"><link name="room"/><link name="door"><visual><geometry><box size="0.1 0.1 0.1"/></geometry>
</visual><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
<joint name="j" type="KIND"><parent link="room"/><child link="door"/><origin xyz="0.5 0 1"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"""


@pytest.mark.parametrize("kind", ["revolute", "fixed", "floating"])
def test_links_of_a_urdf_are_objects_if_they_float(room: Path, kind: str) -> None:
    (room / "room.urdf").write_text(URDF.replace("KIND", kind))
    (room / "room.toml").write_text(SCENE.replace("room.xml", "room.urdf"))
    if kind == "floating":
        assert "door" in run("query room.toml --ability see")
    else:
        assert "scene.objects: no object in this scene; objects are bodies that move" in refusal(
            "query room.toml", room
        )


def test_a_scene_without_agents_is_refused(room: Path) -> None:
    (room / "room.toml").write_text('[scene]\nmodel = "room.xml"\n')
    assert "agents: no agent in this scene; add a table" in refusal("query room.toml", room)


def test_a_moment_of_a_recording() -> None:
    document = run_json(f"query {PATHS['show_a']} --at 2 --agent P1 --object cup --ability see")
    assert document["efforts"][0]["level"] in range(6)


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("--agent P3", "room.toml: no agent 'P3'; did you mean"),
        ("--object cub", "room.toml: no object 'cub'; did you mean 'cup'?"),
        ("--ability smell", "--ability: no ability 'smell'"),
        ("--agent P1 --actions Pan_Hed", "no virtual action 'Pan_Hed'; did you mean 'Pan_Head'?"),
        ("--actions Pan_Head", "--actions: bodies differ in their actions; name --agent, too"),
        ("--where 'P1 reaches' --object cup", "--object: does not go with --where"),
        ("--where 'P1 reaches 3'", "room.toml: --where: '3' is too much"),
        ("--where 'P3 sees'", "room.toml: no agent 'P3'"),
        ("--at 3", "room.toml: --at: a scene has no time"),
    ],
)
def test_questions_that_are_refused(room: Path, line: str, message: str) -> None:
    assert message in refusal(f"query room.toml {line}", room)


def test_what_is_coarse_in_a_scene_is_told_beside_the_answer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "coacd", None)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    bodies = meshes.body("bin", "bin", (1, 0, 0), free=False) + meshes.body("cup", "cup", (0.5, 0, 1))
    cup = meshes.board((0, 0, 0), (0.03, 0.03, 0.05))
    files = meshes.mesh_files(bodies, "[agents.P1]", bin=meshes.shell_bin(), cup=cup)
    for name, content in files.items():
        (tmp_path / name).write_bytes(content)
    result = Result(f"query {tmp_path / 'scene.toml'} --object cup --ability see --json")
    assert result.exit_code == 0
    assert json.loads(result.stdout)["efforts"][0]["object"] == "cup"
    note = "note: mesh 'bin' is concave, but the convex hull is taken: nothing fits into hollows"
    assert result.stderr == f"{note} (to mend: pip install coacd)\n"
