"""Bodies for tests: the built-in profiles, and a room with any of them; those of a package are skipped without it."""

from __future__ import annotations

import mujoco
import pytest

from taskgist.errors import SceneError
from taskgist.world import Scene, builtin_profiles
from taskgist.world.bodies.model_files import find_file
from taskgist.world.scene_file import parse_scene_file

FLOOR = '<geom name="floor" type="plane" size="9 9 0.1"/>'
CUP = '<body name="cup" pos="{} {} {}"><freejoint/><geom type="cylinder" size="0.03 0.05" rgba="1 0 0 1"/></body>'
URDFS = {
    "pr2": "package://example-robot-data/robots/pr2_description/urdf/pr2.urdf",
    "talos": "package://example-robot-data/robots/talos_data/robots/talos_full_v2.urdf",
    "tiago": "package://example-robot-data/robots/tiago_description/robots/tiago.urdf",
}


def is_there(name: str) -> bool:
    """Whether the model of a body is installed."""
    try:
        find_file(URDFS[name], near=None, where="tests", field="model")
    except SceneError:
        return False
    return True


def needs(name: str) -> pytest.MarkDecorator:
    """Skips a test where the package that a body comes from is missing."""
    missing = name in URDFS and not is_there(name)
    return pytest.mark.skipif(missing, reason="example-robot-data is not installed")


EVERY_BODY = [pytest.param(name, marks=needs(name)) for name in builtin_profiles()]


def room(*agents: str, cup: tuple[float, float, float] = (0.6, 0.0, 1.0), things: str = "") -> Scene:
    """A floor, a cup in the air, and agents given as TOML tables."""
    model = f"<mujoco><worldbody>{FLOOR}{CUP.format(*cup)}{things}</worldbody></mujoco>"
    toml = '[scene]\nmodel = "room.xml"\n' + "\n".join(agents)
    placed = parse_scene_file(toml, where="a test").agents
    return Scene.from_spec(mujoco.MjSpec.from_string(model), placed)


def standing(name: str, profile: str, x: float = 0.0, y: float = 0.0, yaw_deg: float = 0.0) -> str:
    return f'[agents.{name}]\nprofile = "{profile}"\nposition_m = [{x}, {y}]\nyaw_deg = {yaw_deg}\n'
