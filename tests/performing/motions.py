"""A Jido that takes a small box from one post and puts it on another, frame by frame, without any planner."""

from __future__ import annotations

from dataclasses import dataclass, replace

import mujoco
import numpy as np

from taskgist.common.arrays import Array
from taskgist.performing.audit import audit
from taskgist.performing.findings import Audit, MotionLimits
from taskgist.world import Hold, Scene, Stage, State
from taskgist.world.geometry.transforms import wxyz_from_matrix
from taskgist.world.scene_file import parse_scene_file

RATE_HZ = 30.0
GRASP = (0.67, 1.2, 1.72, 1.57, 1.29, -1.31, 0.23)
"""Joints of Jido's arm with the hand over a post."""
HALF = (0.012, 0.012, 0.035)
LIFT_RAD, ASIDE_M = 0.25, 0.3
HOLD = Hold("J", "right", "box")
LIMITS = {
    "J": MotionLimits(
        {f"arm_{number}": 0.5 for number in range(1, 8)},
        {f"arm_{number}": 1.5 for number in range(1, 8)},
        base_m_s=0.5,
        base_m_s2=1.0,
        base_rad_s=0.5,
        base_rad_s2=1.0,
    )
}


@dataclass(frozen=True, eq=False)
class Performance:
    scene: Scene
    qpos: Array
    holding: tuple[frozenset[Hold], ...]

    @property
    def times_s(self) -> Array:
        return np.arange(len(self.qpos)) / RATE_HZ

    def audited(self, **changes: object) -> Audit:
        changed = replace(self, **changes)  # type: ignore[arg-type]
        return audit(changed.scene, changed.times_s, changed.qpos, changed.holding, LIMITS)

    @property
    def taken(self) -> int:
        """The first frame in which the box is held."""
        return next(frame for frame, held in enumerate(self.holding) if held)

    @property
    def released(self) -> int:
        """The first frame afterwards in which it is not."""
        return next(frame for frame in range(self.taken, len(self.holding)) if not self.holding[frame])

    @property
    def box(self) -> slice:
        return self.scene.object_slice("box")

    def joint(self, name: str) -> int:
        return int(self.scene.agent("J").joints[name])


def scene(*bodies: str, profile: str = "jido", more: str = "") -> Scene:
    """A floor, bodies on it, and an agent J; and what more a scene file says, of other agents, say."""
    text = "".join(bodies)
    room = f'<mujoco><worldbody><geom name="floor" type="plane" size="5 5 0.1"/>{text}</worldbody></mujoco>'
    file = f'[scene]\nmodel = "room.xml"\n[agents.J]\nprofile = "{profile}"\n{more}'
    return Scene.from_spec(mujoco.MjSpec.from_string(room), parse_scene_file(file, where="a test").agents)


def with_arm(of: Scene, angles: tuple[float, ...]) -> State:
    agent = of.agent("J")
    return of.initial.replace({agent.joints[f"arm_{n}"]: angle for n, angle in enumerate(angles, 1)})


def carry(
    *bodies: str,
    half: tuple[float, float, float] = HALF,
    deeper_m: float = 0.0,
    higher_m: tuple[float, float] = (0.0, 0.0),
    more: str = "",
) -> Performance:
    """The whole performance, among more bodies, with another box, one that reaches farther down, or other posts.

    What more the scene file says, of other agents, say, stands in ``more``.
    """
    alone = scene()
    palm = Stage(alone, with_arm(alone, GRASP)).site(alone.agent("J").arms[0].palm_site)
    x, y, z = palm.position
    top = z - half[2] - deeper_m
    posts = [
        f'<body name="{name}" pos="{x} {y + aside} {(top + more) / 2}">'
        f'<geom type="cylinder" size="0.03 {(top + more) / 2} 0"/></body>'
        for name, aside, more in (("post", 0.0, higher_m[0]), ("goal", ASIDE_M, higher_m[1]))
    ]
    size = f"{half[0]} {half[1]} {half[2] + deeper_m / 2}"
    shape = f'<geom type="box" size="{size}" pos="0 0 {-deeper_m / 2}"/>'
    box = f'<body name="box" pos="{x} {y} {z}"><freejoint/>{shape}</body>'
    room = scene(*posts, box, *bodies, more=more)
    rows, held = _frames(room)
    return Performance(room, rows, held)


def ramp(start: float, end: float, duration_s: float) -> Array:
    """Smoothly from one number to another."""
    share = np.linspace(0.0, 1.0, round(duration_s * RATE_HZ) + 1)[1:]
    return start + (end - start) * (share**3 * (10 - 15 * share + 6 * share**2))


def _frames(room: Scene) -> tuple[Array, tuple[frozenset[Hold], ...]]:
    """Wait, lift, drive aside, lower, let go, and lift the arm again."""
    wait, up, aside = np.zeros(6), ramp(0.0, LIFT_RAD, 2.0), ramp(0.0, ASIDE_M, 2.0)
    lifts = np.concatenate((wait, up, np.full(len(aside), LIFT_RAD), up[::-1], wait, wait, up))
    asides = np.concatenate((wait, 0 * up, aside, np.full(2 * len(up) + 12, ASIDE_M)))
    begin, end = len(wait) - 1, len(wait) + 2 * len(up) + len(aside) + 5
    start, agent, box = with_arm(room, GRASP), room.agent("J"), room.object_slice("box")
    rows: list[Array] = []
    held: list[frozenset[Hold]] = []
    stage = Stage(room, start)
    grip: tuple[Array, Array] | None = None
    for frame, (lift, moved) in enumerate(zip(lifts, asides, strict=True)):
        row = np.array(rows[-1] if rows else start.qpos)
        row[agent.joints["arm_2"]] = GRASP[1] - lift
        row[agent.base.start + 1] = moved
        palm = stage.show(State(row)).site(agent.arms[0].palm_site)
        body = stage.body(room.object_body("box"))
        if begin <= frame <= end:
            grip = grip or (palm.to_local(body.position), palm.matrix.T @ body.matrix)
            row[box] = (*palm.to_world(grip[0]), *wxyz_from_matrix(palm.matrix @ grip[1]))
        rows.append(row)
        held.append(frozenset({HOLD} if begin <= frame <= end else ()))
    return np.array(rows), tuple(held)
