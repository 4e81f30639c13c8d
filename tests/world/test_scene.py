"""Scene files: what they give, and what is refused, with file, field, value and the way out."""

from pathlib import Path

import numpy as np
import pytest

from taskgist.errors import SceneError, UnknownNameError
from taskgist.world import Scene, Stage, State
from tests.scenes import CHAIR, TABLE, agent, cylinder, scene

ROOM = f"<mujoco><worldbody>{TABLE}{cylinder('cup', 0, 0, 0.77)}</worldbody></mujoco>"


def written(folder: Path, toml: str, room: str = ROOM) -> Path:
    (folder / "room.xml").write_text(room)
    (folder / "scene.toml").write_text(toml)
    return folder / "scene.toml"


def test_a_bundle_is_the_whole_scene(tmp_path: Path) -> None:
    text = '[scene]\nmodel = "room.xml"\n' + agent("P1", 1, 0, extra="joints_deg = { head_pan = 20 }")
    first = Scene.load(written(tmp_path, text))
    again = Scene.from_bundle(dict(first.bundle))
    np.testing.assert_array_equal(first.initial.qpos, again.initial.qpos)
    assert first.owners == again.owners


def test_meshes_of_one_base_name_stay_apart(tmp_path: Path) -> None:
    for folder, size in (("a", 0.05), ("b", 0.3)):
        (tmp_path / folder).mkdir()
        corners = [(0, 0, 0), (size, 0, 0), (0, size, 0), (0, 0, size)]
        lines = [f"v {x} {y} {z}" for x, y, z in corners] + ["f 1 3 2", "f 1 2 4", "f 1 4 3", "f 2 3 4"]
        (tmp_path / folder / "m.obj").write_text("\n".join(lines))
    assets = '<asset><mesh name="a" file="a/m.obj"/><mesh name="b" file="b/m.obj"/></asset>'
    bodies = "".join(
        f'<body name="{n}" pos="{x} 0 1"><freejoint/><geom type="mesh" mesh="{n}"/></body>'
        for n, x in (("a", 0), ("b", 1))
    )
    room = f"<mujoco>{assets}<worldbody>{bodies}</worldbody></mujoco>"
    loaded = Scene.load(written(tmp_path, '[scene]\nmodel = "room.xml"', room))
    sizes = [loaded.model.geom_rbound[loaded.object_geoms(name)[0]] for name in ("a", "b")]
    assert sizes[1] > 4 * sizes[0]
    assert Scene.from_bundle(dict(loaded.bundle)).objects == ("a", "b")


@pytest.mark.parametrize(
    ("toml", "message"),
    [
        ("[agents]\nP1 = 3", r"agents\.P1: must be a table \(got 3\)"),
        ('agents = "x"', "agents: must be a table"),
        ("[agents.P1]\nposition_m = 3", r"agents\.P1\.position_m: must be two finite numbers"),
        ("[agents.P1]\nposition_m = [1e300, 0]", r"position_m: must be two finite numbers"),
        ("[agents.P1]\nbody = 3", r"agents\.P1\.body: must be a table"),
        ("[agents.P1]\nbody = { stature_m = 170 }", r"agents\.P1\.body\.stature_m: .* check the unit"),
        ("[agents.P1]\nbody = { tail_m = 1 }", r"body\.tail_m: no such body size"),
        ("[agents.P1]\nyaw_deg = " + "9" * 400, r"agents\.P1\.yaw_deg: must be a finite number"),
        ("[agents.P1]\nyaw_deg = nan", r"agents\.P1\.yaw_deg: must be a finite number"),
        ("[agents.P1]\nposture = 'lying'", "no posture 'lying'"),
        ("[agents.P1]\nposture = 'sitting'\nposition_m = [3, 3]", "nothing to sit on there.*seat_height_m"),
        ("[agents.P1]\nposture = 'sitting'\nseat_height_m = 50", "nobody sits at that height"),
        ("[agents.P1]\nprofile = 'robot'", "no profile 'robot'.*known: hrp2, human"),
        ("[agents.P1]\njoints_deg = { head_pam = 3 }", "no joint 'head_pam'; did you mean 'head_pan'"),
        ("[agents.P1]\njoints_deg = { head_tilt = -200 }", "head_tilt: beyond the joint .*from -60 to 60 degrees"),
        ("[agents.P1]\nyaw = 3", "no field 'yaw'; did you mean 'yaw_deg'"),
        ("[agents.table]\nyaw_deg = 3", "the model has something of that name"),
        ("[agents.'a/b']\nyaw_deg = 3", "not a name for an agent"),
        ("[agent.P1]\nyaw_deg = 3", "no field 'agent'; did you mean 'agents'"),
    ],
)
def test_wrong_agents_are_refused(tmp_path: Path, toml: str, message: str) -> None:
    prefix = "" if toml.startswith("agents =") else '[scene]\nmodel = "room.xml"\n'
    text = prefix + toml if prefix else f'{toml}\n[scene]\nmodel = "room.xml"\n'
    with pytest.raises((SceneError, UnknownNameError), match=message) as caught:
        Scene.load(written(tmp_path, text))
    assert "scene.toml" in str(caught.value)


@pytest.mark.parametrize(
    ("extra", "message"),
    [
        ("objects = 3", r"scene\.objects: must be a list of texts"),
        ("objects = [[1]]", r"scene\.objects: must be a list of texts"),
        ("objects = ['cap']", "no object .*'cap'; did you mean 'cup'"),
        ("estimated = 4", r"scene\.estimated: must be a list of texts"),
        ("estimated = ['nix']", "no body 'nix'"),
        ("modell = 'x'", "no field 'modell'; did you mean 'model'"),
    ],
)
def test_wrong_scene_tables_are_refused(tmp_path: Path, extra: str, message: str) -> None:
    with pytest.raises((SceneError, UnknownNameError), match=message):
        Scene.load(written(tmp_path, f'[scene]\nmodel = "room.xml"\n{extra}\n'))


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("<body name='hull'><freejoint/><geom size='0.1' group='3'/></body>", "without a shape that can be seen"),
        ("<body name='air'><freejoint/><geom size='0.1' rgba='1 0 0 0'/></body>", "without a shape that can be seen"),
        ("<body name='x'><geom size='nan'/></body>", r"room\.xml, line 1: size of <geom>: must be finite"),
        ("<body><geom form='ball'/></body>", "MuJoCo cannot read this model"),
        ("<body", r"room\.xml: not valid XML"),
    ],
)
def test_models_without_usable_objects_are_refused(tmp_path: Path, body: str, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        Scene.load(written(tmp_path, '[scene]\nmodel = "room.xml"', f"<mujoco><worldbody>{body}</worldbody></mujoco>"))


def test_things_without_a_name_get_one(tmp_path: Path) -> None:
    """Published models often leave it out; ``objects`` of the scene file may then name them."""
    ball = "<body {} pos='{} 0 1'>{}<geom size='0.1'/></body>"
    free, slides = "<freejoint/>", "".join(f"<joint type='slide' axis='{a}'/>" for a in ("1 0 0", "0 1 0", "0 0 1"))
    model = "".join(
        (
            ball.format("", 0, free),
            ball.format("name='thing_1'", 1, free),
            ball.format("", 2, free),
            ball.format("name='slid'", 3, slides + "<joint type='ball'/>"),
        )
    )
    text = f"<mujoco><worldbody>{model}</worldbody></mujoco>"
    scene = Scene.load(written(tmp_path, '[scene]\nmodel = "room.xml"', text))
    places = {name: scene.initial.qpos[scene.object_slice(name)][0] for name in scene.objects}
    assert places == {"thing_2": 0, "thing_1": 1, "thing_3": 2, "slid": 3}
    assert list(Scene.from_bundle(scene.bundle).objects) == list(scene.objects)
    chosen = Scene.load(written(tmp_path, '[scene]\nmodel = "room.xml"\nobjects = ["thing_3"]', text))
    assert list(chosen.objects) == ["thing_3"]


def test_missing_and_broken_files_are_named(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"nowhere\.toml: cannot be read"):
        Scene.load(tmp_path / "nowhere.toml")
    (tmp_path / "latin.toml").write_bytes("[scene]\nname = 'Küche'".encode("latin-1"))
    with pytest.raises(SceneError, match=r"latin\.toml: not valid TOML"):
        Scene.load(tmp_path / "latin.toml")
    (tmp_path / "lost.toml").write_text('[scene]\nmodel = "lost.xml"')
    with pytest.raises(SceneError, match=r"scene\.model: no such file"):
        Scene.load(tmp_path / "lost.toml")


def test_no_objects_means_none(tmp_path: Path) -> None:
    assert Scene.load(written(tmp_path, '[scene]\nmodel = "room.xml"\nobjects = []')).objects == ()


def test_seats_are_found_beneath() -> None:
    room = scene(CHAIR, agents=agent("P1", -0.95, 0, posture="sitting"))
    assert Stage(room).body_position(room.agent("P1").root_body)[2] == pytest.approx(0.45 + 0.045 * 1.75, abs=1e-4)


def test_a_state_is_its_own_whatever_it_was_made_of() -> None:
    numbers = np.zeros(7)
    window = numbers[:]
    numbers.flags.writeable = False
    state = State(numbers)
    window[0] = 5.0
    assert state.qpos[0] == 0.0
    whole = np.zeros(7, dtype=int)
    whole.flags.writeable = False
    assert State(whole).replace({0: 0.7}).qpos[0] == 0.7
    assert State([0.0] * 7).qpos.shape == (7,)  # type: ignore[arg-type]
    changed = state.replace({1: 1.0})
    with pytest.raises(ValueError, match="read-only"):
        changed.qpos[1] = 2.0
    assert (state.qpos[1], changed.qpos[1], changed.time_s) == (0.0, 1.0, state.time_s)
