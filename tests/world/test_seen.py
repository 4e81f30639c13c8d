"""Which shapes are seen: groups that a scene names, and models that keep coarse shapes for collisions in a seen one."""

from __future__ import annotations

import mujoco
import pytest

from taskgist.errors import SceneError
from taskgist.perspective import least_effort, visibility
from taskgist.world import Scene, Stage

WALLS = (
    ("0.05 0.05 0.003", "0 0 0.003"),
    ("0.003 0.05 0.04", "0.047 0 0.04"),
    ("0.003 0.05 0.04", "-0.047 0 0.04"),
    ("0.05 0.003 0.04", "0 0.047 0.04"),
    ("0.05 0.003 0.04", "0 -0.047 0.04"),
)
FINE = 'contype="0" conaffinity="0"'
COARSE = '<geom name="coarse" type="box" size="0.05 0.05 0.045" pos="0 0 0.045" group="{group}"/>'


def bowl(group: int, looks: int = 1) -> str:
    fine = "".join(f'<geom type="box" size="{size}" pos="{pos}" group="{looks}" {FINE}/>' for size, pos in WALLS)
    return fine + COARSE.format(group=group)


def scene(shapes: str, *, more: str = "", seen_groups: str = "") -> Scene:
    """A ball in a bowl on a table, before P1."""
    room = (
        '<mujoco><worldbody><geom type="box" size=".3 .4 .02" pos="1 0 .73" group="1"/>'
        f'<body name="bowl" pos=".7 0 .75"><freejoint/>{shapes}</body>{more}'
        '<body name="ball" pos=".7 0 .78"><freejoint/><geom group="1" type="sphere" size=".025"/></body>'
        "</worldbody></mujoco>"
    )
    named = f"seen_groups = {seen_groups}\n" if seen_groups else ""
    text = f'[scene]\nmodel = "room.xml"\n{named}[agents.P1]\nposition_m = [0.3, 0]\n'
    return Scene.from_bundle({"scene.toml": text.encode(), "room.xml": room.encode()})


def seen_names(found: Scene, owner: str) -> set[str]:
    return {str(found.model.geom(int(geom)).name) for geom in found.seen_geoms(owner)}


def level(found: Scene) -> int | None:
    return least_effort(Stage(found), "P1", "ball", "see").level


@pytest.mark.parametrize("group", [0, 1, 3])
def test_a_ball_in_a_bowl_is_seen_wherever_the_bowl_keeps_its_coarse_shape(group: int) -> None:
    found = scene(bowl(group))
    assert "coarse" not in seen_names(found, "bowl")
    assert level(found) == level(scene(bowl(3)))
    assert level(found) in (0, 1, 2)
    assert "coarse" in {str(found.model.geom(int(geom)).name) for geom in found.solid_geoms_of("bowl")}


def test_a_label_or_a_handle_does_not_take_the_place_of_its_box() -> None:
    label = f'<geom name="label" type="box" size="0.03 0.001 0.03" pos="0 0.051 0.045" {FINE}/>'
    handle = f'<geom name="handle" type="capsule" size="0.005 0.045" pos="0.06 0 0.045" {FINE}/>'
    found = scene(COARSE.format(group=0) + label + handle)
    assert seen_names(found, "bowl") == {"coarse", "label", "handle"}
    assert level(found) == 5


def test_shapes_that_nobody_sees_are_no_looks() -> None:
    fine = f'<geom type="box" size="0.05 0.05 0.045" pos="0 0 0.045" rgba="1 1 1 0" {FINE}/>'
    assert seen_names(scene(fine + COARSE.format(group=0)), "bowl") == {"coarse"}


def test_the_room_itself_is_no_one_body() -> None:
    """A poster and a lamp on opposite walls: the walls between them are seen."""
    found = scene(COARSE.format(group=0), more="")
    room = found.bundle["room.xml"].decode()
    walls = '<geom name="wall" type="box" size=".02 .5 .5" pos="2 0 1"/>'
    posters = "".join(f'<geom type="box" size=".5 .5 .5" pos="{x} 0 1" {FINE}/>' for x in (-4, 5))
    room = room.replace("<worldbody>", f"<worldbody>{walls}{posters}")
    again = Scene.from_bundle({**found.bundle, "room.xml": room.encode()})
    assert seen_names(again, "wall") == {"wall"}


def test_agents_that_keep_coarse_shapes_in_a_seen_group_are_seen_as_they_look() -> None:
    found = scene(bowl(3))
    files = dict(found.bundle)
    model = mujoco.MjSpec.from_string(files["P1.model.xml"].decode())
    (torso,) = [body for body in model.bodies if body.name == "torso"]
    for geom in list(torso.geoms):
        low = torso.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, pos=geom.pos, quat=geom.quat, size=[0.3, 0.3, 0.3])
        low.name = f"coarse {geom.name}"
        geom.contype = geom.conaffinity = 0
    files["P1.model.xml"] = model.to_xml().encode()
    # boxes of 60 cm extend far beyond the chest: they are seen; in boxes of its own size, it is
    assert any("coarse" in name for name in seen_names(Scene.from_bundle(files), "P1"))
    for geom in torso.geoms:
        if geom.name.startswith("coarse"):
            geom.size = [0.1, 0.1, 0.1]
    files["P1.model.xml"] = model.to_xml().encode()
    assert not any("coarse" in name for name in seen_names(Scene.from_bundle(files), "P1"))


@pytest.mark.parametrize(("groups", "coarse"), [("[1]", False), ("[0, 1]", True), ("[5, 1, 0]", True)])
def test_a_scene_names_the_groups_that_are_seen(groups: str, coarse: bool) -> None:
    found = scene(bowl(0), seen_groups=groups)
    assert ("coarse" in seen_names(found, "bowl")) == coarse
    assert (level(found) == 5) == coarse
    assert level(Scene.from_bundle(found.bundle)) == level(found)


def test_objects_in_no_seen_group_are_refused() -> None:
    with pytest.raises(SceneError, match=r"without a shape that can be seen .*in a seen group \(2, 4\)"):
        scene(bowl(0), seen_groups="[2, 4]")


def test_groups_that_are_mostly_hidden_may_be_seen() -> None:
    """Those of the room: agents are as they are."""
    more = '<geom name="curtain" type="box" size=".01 .5 .9" pos="2 0 1" group="4"/>'
    named, plain = scene(bowl(3), more=more, seen_groups="[1, 4]"), scene(bowl(3), more=more)
    assert seen_names(named, "curtain") == {"curtain"}
    assert not seen_names(plain, "curtain")
    assert visibility(Stage(named), "P1", "ball") == visibility(Stage(plain), "P1", "ball")
    assert len(named.seen_geoms("P1")) == len(plain.seen_geoms("P1")) > 0


@pytest.mark.parametrize("groups", ["[]", "[6]", "[-1]", "[0.5]", '["0"]', "[true]", "1"])
def test_groups_that_cannot_be_are_refused(groups: str) -> None:
    with pytest.raises(SceneError, match=r"scene\.seen_groups: must be a list of geom groups"):
        scene(bowl(0), seen_groups=groups)


def test_groups_come_from_values_as_well() -> None:
    room = mujoco.MjSpec.from_string(scene(bowl(0)).bundle["room.xml"].decode())
    assert "coarse" in seen_names(Scene.from_spec(room, seen_groups=[0, 1]), "bowl")
    assert "coarse" not in seen_names(Scene.from_spec(room), "bowl")


def test_cloth_is_refused_by_its_name() -> None:
    cloth = '<flexcomp name="curtain" type="grid" count="4 4 1" spacing=".1 .1 .1" pos="1 0 1" radius=".01" mass="1"/>'
    with pytest.raises(SceneError, match=r"room\.xml: flex: a flex .* is not read \(got 'curtain'\)"):
        scene(bowl(3), more=cloth)
