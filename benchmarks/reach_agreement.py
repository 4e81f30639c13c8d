"""How good reach is as perspective judges it, beside inverse kinematics on the real joints, the girdle at rest.

    python -m benchmarks.reach_agreement [BODY ...] [--targets 200] [--model sector]

Targets lie at random around the shoulder, in front of it or all round. Perspective says whether the arm reaches them
at an effort level; inverse kinematics, with the joints of that level only, says whether the palm comes within half a
cell. Neither looks at collisions of the arm.
"""

from __future__ import annotations

import argparse
import itertools
import math
import tempfile
from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path
from typing import get_args

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from benchmarks.ik import ArmIK
from taskgist.errors import TaskgistError
from taskgist.perspective import Viewpoint, actions_of, effort_from
from taskgist.settings import DEFAULT, ReachModel
from taskgist.world import Agent, ArmIndices, Scene, Stage, builtin_profiles

Array = NDArray[np.float64]
BALL_M = 0.002
NEAR_M = DEFAULT.reach.cell_m / 2
AROUND = 1.2
"""Radius, in lengths of the arm, of the ball around the shoulder in which targets lie."""
TORSO = ("Turn_Torso", "Lean_Torso")
COLUMNS = (
    *("body", "arm", "level", "targets", "agree"),
    *("both", "only perspective", "only joints", "neither", "precision", "recall"),
)


@dataclass(frozen=True)
class Agreement:
    """Targets by verdict: (perspective says yes, inverse kinematics says yes).

    Attributes:
        body: Profile.
        side: Which arm.
        level: Effort level: 1 the arm, 2 the torso as well.
        front: Whether all targets were in front of the shoulder.
        counts: Targets.
    """

    body: str
    side: str
    level: int
    front: bool
    counts: Counter[tuple[bool, bool]]

    @property
    def share(self) -> float:
        """Targets on which both agree, of all."""
        return (self.counts[True, True] + self.counts[False, False]) / self.counts.total()

    @property
    def precision(self) -> float:
        """Of the targets that perspective calls reached, those that the joints reach."""
        return self.counts[True, True] / max(1, self.counts[True, True] + self.counts[True, False])

    @property
    def recall(self) -> float:
        """Of the targets that the joints reach, those that perspective calls reached."""
        return self.counts[True, True] / max(1, self.counts[True, True] + self.counts[False, True])


def agreement(
    body: str,
    *,
    level: int,
    targets: int,
    front: bool = True,
    seed: int = 0,
    starts: int = 8,
    model: ReachModel = DEFAULT.reach.model,
) -> Agreement:
    """Compare both verdicts for a body's first arm.

    Args:
        body: A built-in profile.
        level: 1 or 2.
        targets: How many.
        front: Whether they all lie in front of the shoulder.
        seed: Of the targets.
        starts: Of the inverse kinematics.
        model: How perspective judges reach.
    """
    settings = replace(DEFAULT, reach=replace(DEFAULT.reach, model=model))
    scene = _scene(body)
    stage, agent = Stage(scene), scene.agent("A")
    arm = agent.arms[0]
    stretch = f"Stretch_Out_Arm({arm.profile.side})"
    allowed = [action for action in actions_of(agent) if action == stretch or (level > 1 and action in TORSO)]
    ik = ArmIK(scene, scene.initial, agent, arm, also=_torso(agent) if level > 1 else {}, starts=starts, seed=seed)
    counts: Counter[tuple[bool, bool]] = Counter()
    for target in _targets(stage, arm, targets, front, np.random.default_rng(seed)):
        stage.show(scene.initial.replace(at=scene.object_slice("ball"), to=(*target, 1, 0, 0, 0)))
        found = effort_from(Viewpoint(stage, "A", settings, actions=allowed), "ball", "reach").level
        counts[found in range(1, level + 1), ik.gap_m(target, enough_m=NEAR_M) <= NEAR_M] += 1
    return Agreement(body, arm.profile.side, level, front, counts)


def _scene(body: str) -> Scene:
    """The body alone on a floor, and a tiny ball."""
    ball = f'<body name="ball" pos="9 9 9"><freejoint/><geom type="sphere" size="{BALL_M}"/></body>'
    with tempfile.TemporaryDirectory() as folder:
        room = Path(folder) / "room.xml"
        room.write_text(
            f'<mujoco><worldbody><geom name="floor" type="plane" size="9 9 0.1"/>{ball}</worldbody></mujoco>'
        )
        file = Path(folder) / "scene.toml"
        file.write_text(f'[scene]\nmodel = "room.xml"\n[agents.A]\nprofile = "{body}"\n')
        return Scene.load(file)


def _torso(agent: Agent) -> dict[str, tuple[float, float]]:
    axes = (agent.profile.turn, agent.profile.lean, agent.arms[0].profile.thrust)
    return {axis.joint: axis.range_rad for axis in axes if axis}


def _targets(stage: Stage, arm: ArmIndices, count: int, front: bool, rng: np.random.Generator) -> list[Array]:
    """Points over the floor, evenly in a ball around the shoulder, or in its half in front."""
    shoulder, radius = stage.shoulder(arm), AROUND * arm.profile.length_m
    points: list[Array] = []
    while len(points) < count:
        direction = rng.normal(size=3)
        local = direction / np.linalg.norm(direction) * radius * math.cbrt(rng.random())
        if front:
            local[0] = abs(local[0])
        point = shoulder.to_world(local)
        if point[2] > 0.02:
            points.append(point)
    return points


def main() -> None:
    """Print the table of agreement."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("bodies", nargs="*", default=builtin_profiles())
    parser.add_argument("--targets", type=int, default=200)
    parser.add_argument("--model", choices=get_args(ReachModel), default=DEFAULT.reach.model)
    chosen = parser.parse_args()
    table = Table(box=None)
    for column in COLUMNS:
        table.add_column(column)
    for body in chosen.bodies:
        try:
            levels = (1, 2) if _torso(_scene(body).agent("A")) else (1,)
            for level, front in itertools.product(levels, (True, False)):
                _add(table, agreement(body, level=level, targets=chosen.targets, front=front, model=chosen.model))
        except TaskgistError as error:
            table.add_row(body, str(error))
    Console(width=120).print(table)


def _add(table: Table, found: Agreement) -> None:
    cells = ((True, True), (True, False), (False, True), (False, False))
    shares = (found.share, found.precision, found.recall)
    agree, precision, recall = (f"{100 * share:.0f} %" for share in shares)
    counts = (str(found.counts[cell]) for cell in cells)
    table.add_row(
        found.body,
        found.side,
        str(found.level),
        "in front" if found.front else "all round",
        agree,
        *counts,
        precision,
        recall,
    )


if __name__ == "__main__":
    main()
