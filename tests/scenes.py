"""Small scenes for tests, from MJCF bodies and agents given as text: the same text gives the same scene."""

from functools import lru_cache

from taskgist.world import Scene

FLOOR = '<geom name="floor" type="plane" size="5 5 0.1"/>'
TABLE = '<body name="table" pos="0 0 0.7"><geom type="box" size="0.4 0.6 0.02"/></body>'
CHAIR = '<body name="chair" pos="-0.95 0 0"><geom type="box" size="0.2 0.2 0.225" pos="0 0 0.225"/></body>'


def cylinder(name: str, x: float, y: float, z: float, radius: float = 0.04, half: float = 0.05) -> str:
    return f'<body name="{name}" pos="{x} {y} {z}"><freejoint/><geom type="cylinder" size="{radius} {half}"/></body>'


def box(name: str, x: float, y: float, z: float, half: tuple[float, float, float]) -> str:
    size = " ".join(map(str, half))
    return f'<body name="{name}" pos="{x} {y} {z}"><freejoint/><geom type="box" size="{size}"/></body>'


def agent(name: str, x: float, y: float, yaw_deg: float = 0.0, posture: str = "standing", extra: str = "") -> str:
    return f'[agents.{name}]\nposition_m = [{x}, {y}]\nyaw_deg = {yaw_deg}\nposture = "{posture}"\n{extra}\n'


@lru_cache(maxsize=128)
def scene(*bodies: str, agents: str = "", scene_extra: str = "") -> Scene:
    room = f"<mujoco><worldbody>{FLOOR}{''.join(bodies)}</worldbody></mujoco>"
    toml = f'[scene]\nname = "test"\nmodel = "room.xml"\n{scene_extra}\n{agents}'
    return Scene.from_bundle({"scene.toml": toml.encode(), "room.xml": room.encode()})
