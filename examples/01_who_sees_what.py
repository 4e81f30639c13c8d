"""A scene, and who sees what: two people at a table, a box between one of them and the cup."""

from taskgist import Scene, Stage, least_effort, visibility
from taskgist.perspective import ABILITIES

ROOM = """<mujoco><worldbody>
  <geom name="floor" type="plane" size="5 5 0.1"/>
  <body name="table" pos="0 0 0.7"><geom type="box" size="0.4 0.6 0.02"/></body>
  <body name="chair" pos="-0.95 0 0"><geom type="box" size="0.2 0.2 0.225" pos="0 0 0.225"/></body>
  <body name="box" pos="0 0 0.82"><freejoint/><geom type="box" size="0.05 0.15 0.10"/></body>
  <body name="cup" pos="0.12 0 0.77"><freejoint/><geom type="cylinder" size="0.04 0.05"/></body>
</worldbody></mujoco>"""

SCENE = """
[scene]
name = "a table for two"
model = "room.xml"

[agents.P1]
position_m = [-0.95, 0.0]
posture = "sitting"

[agents.P2]
position_m = [0.85, 0.0]
yaw_deg = 180
body = { stature_m = 1.65 }
"""


def main() -> None:
    # Usually: Scene.load("kitchen.toml"), with the model in a file beside it.
    scene = Scene.from_bundle({"scene.toml": SCENE.encode(), "room.xml": ROOM.encode()})
    stage = Stage(scene)
    for agent in scene.agents:
        seen = visibility(stage, agent, "cup")
        assert seen is not None  # everything is tracked in a scene
        occluders = ", ".join(owner for owner, _ in seen.occluders) or "nothing"
        print(f"{agent}: visibility score {100 * seen.score:.2f} %, occluded by {occluders}")
        for ability in ABILITIES:
            effort = least_effort(stage, agent, "cup", ability)
            print(f"  {ability}: {effort.name} by {' + '.join(effort.actions)} ({effort.reason})")


if __name__ == "__main__":
    main()
