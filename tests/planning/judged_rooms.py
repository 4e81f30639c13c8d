"""Generated rooms with goals of learned clauses, and final states of all kinds to be judged in them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from taskgist.facts import STANDARD_TREE, Observation, Raw
from taskgist.learning import clause_of, understand
from taskgist.observe import resting_snapshot
from taskgist.planning import Attention, Goal, Judge
from taskgist.world import Scene, Stage, State
from taskgist.world.geometry.transforms import wxyz_from_matrix
from taskgist_lab.generator import simulate
from tests.learning.learning_samples import study

SEED = 13
ABOUT_M = 1.0
"""How far from where it was the thing is put."""


@dataclass(frozen=True, eq=False)
class JudgedRoom:
    """A room in which a task begins."""

    scene: Scene
    start: State
    performer: str
    target: str
    thing: str
    goal: Goal

    def judge(self, attention: Attention = "stays") -> Judge:
        return Judge(
            self.scene,
            self.start,
            self.target,
            self.thing,
            self.goal,
            attention=attention,
            performer=self.performer,
        )

    def candidates(self, count: int, seed: int = 0) -> list[State]:
        """States in which the thing is elsewhere: on, in, over whatever is there, in hands, on bodies, in the air."""
        rng, stage, at = np.random.default_rng(seed), Stage(self.scene, self.start), self.scene.object_slice(self.thing)
        pose = np.array(self.start.qpos[at])
        lowest = stage.bounds(self.scene.seen_geoms(self.thing))[0, 2] - pose[2]
        others = [g for g in range(self.scene.model.ngeom) if self.scene.owners[g] != self.thing and stage.seen[g]]
        states: list[State] = []
        while len(states) < count:
            to = np.array(pose)
            if rng.random() < 0.2:
                agent = self.scene.agent(str(rng.choice([self.performer, self.target])))
                palm = stage.site(agent.arms[rng.integers(len(agent.arms))].palm_site)
                to[:3] = palm.position + rng.normal(0, 0.02, 3)
            else:
                to[:2] += rng.uniform(-ABOUT_M, ABOUT_M, 2)
                above = float(rng.choice([1.9, 1.2, 0.7]))
                (geom,), (down,) = stage.cast((*to[:2], above), [(0.0, 0.0, -1.0)], only=others)
                if geom < 0:
                    continue
                gap = 0.0 if rng.random() < 0.9 else rng.uniform(0.0, 0.2)
                to[2] = above - down - lowest + 0.001 + gap
            if rng.random() < 0.3:
                yaw = rng.uniform(-np.pi, np.pi)
                turn = np.array([[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])
                to[3:] = wxyz_from_matrix(turn @ stage.body(self.scene.object_body(self.thing)).matrix)
            states.append(self.start.replace(at=at, to=to))
        return states


@cache
def room(task: str, number: int) -> JudgedRoom:
    """The room of a generated demonstration, with the goal of the clause that the paper's study teaches."""
    recording = simulate(task, seed=SEED, number=number)
    label = recording.label
    assert label is not None
    start = recording.at(label.start_s)
    who, thing = label.target_agent, label.target_object
    known = resting_snapshot(Stage(recording.scene, start), agent=who, name=thing)
    goal = Goal.of(clause_of(understand(study(task))), known, STANDARD_TREE)
    return JudgedRoom(recording.scene, start, label.performing_agent, who, thing, goal)


def raws(snapshot: dict[str, Observation[Raw]]) -> dict[str, Raw]:
    return {name: observation.value for name, observation in snapshot.items()}
