"""Ability maps: where to put a cup so that P1 reaches it easily and P2 does not see it at once."""

from taskgist import Grid, Scene, Stage, ability_map, places_for
from taskgist.settings import Maps

ROOM = """<mujoco><worldbody>
  <geom name="floor" type="plane" size="5 5 0.1"/>
  <body name="table" pos="0 0 0.7"><geom type="box" size="0.4 0.6 0.02"/></body>
  <body name="chair" pos="-0.95 0 0"><geom type="box" size="0.2 0.2 0.225" pos="0 0 0.225"/></body>
  <body name="box" pos="0 0.1 0.87"><freejoint/><geom type="box" size="0.02 0.25 0.15"/></body>
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
    stage = Stage(Scene.from_bundle({"scene.toml": SCENE.encode(), "room.xml": ROOM.encode()}))
    grid = Grid.around(stage, "P1", "P2", settings=Maps(cell_m=0.1))  # coarse, for speed; both agents' workspaces
    reach = ability_map(stage, "P1", "reach", grid=grid)
    see = ability_map(stage, "P2", "see", grid=grid)
    print(f"cells that P1 reaches, by effort level: {reach.counts}")

    easy, in_view = reach.at_most(2), see.at_most(1)
    print(f"P1 reaches {easy.volume_m3:.2f} m³ with arm and torso, {(easy & in_view).volume_m3:.2f} m³ in P2's sight")

    hidden = easy - in_view
    places = places_for(stage, (0.08, 0.08, 0.10), hidden, supports=["table"])
    print(f"places on the table for a cup that P2 does not see by turning the head: {len(places)}")
    for place in places[:3]:
        print("  at {:.2f}, {:.2f}, {:.2f} m".format(*place.position_m))


if __name__ == "__main__":
    main()
