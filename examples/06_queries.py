"""Questions about a room: who reaches what by which actions, what A reaches and B does not see, and why."""

from taskgist import Scene, SceneEfforts, Stage, objects_where, parse_question
from taskgist.language.efforts import why
from taskgist.perspective.queries import Condition
from taskgist.perspective.scene_efforts import becoming_able_by

ROOM = """<mujoco><worldbody>
  <geom name="floor" type="plane" size="5 5 0.1"/>
  <body name="table" pos="0 0 0.7"><geom type="box" size="0.4 0.6 0.02"/></body>
  <body name="chair" pos="-0.95 0 0"><geom type="box" size="0.2 0.2 0.225" pos="0 0 0.225"/></body>
  <body name="box" pos="0 0.1 0.87"><freejoint/><geom type="box" size="0.02 0.25 0.15"/></body>
  <body name="cup" pos="-0.15 0.1 0.77"><freejoint/><geom type="cylinder" size="0.04 0.05"/></body>
  <body name="ball" pos="0.2 -0.3 0.75"><freejoint/><geom type="sphere" size="0.03"/></body>
</worldbody></mujoco>"""

SCENE = """
[scene]
model = "room.xml"
[agents.P1]
position_m = [-0.95, 0.0]
posture = "sitting"
[agents.P2]
position_m = [0.85, 0.0]
yaw_deg = 180
"""


def main() -> None:
    scene = Scene.from_bundle({"scene.toml": SCENE.encode(), "room.xml": ROOM.encode()})
    asked = SceneEfforts(Stage(scene))  # each effort is found once, however many questions

    actions = ("Lean_Torso", "Stretch_Out_Arm(left)")
    efforts = asked.efforts_with("P1", "reach", actions)
    print(f"with {' + '.join(actions)} P1 comes to reach: {', '.join(becoming_able_by(efforts))}")

    hidden = objects_where(asked, Condition("P1", "reach", max_level=2) & ~Condition("P2", "see", max_level=1))
    print(f"P1 reaches, and P2 does not see by turning the head: {', '.join(hidden.yes)}")
    same = objects_where(asked, parse_question("P1 reaches <= 2 and not P2 sees <= 1", scene.agents))
    assert same == hidden

    for agent, ability in (Condition("P1", "reach") & Condition("P2", "see")).abilities:
        for name in scene.objects:
            print(f"{why(asked.effort(agent, name, ability))}.")


if __name__ == "__main__":
    main()
