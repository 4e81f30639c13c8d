"""An agent alone is the same agent: same names, same frames, same fits."""

from __future__ import annotations

import numpy as np
import pytest

from taskgist.errors import UnknownNameError
from taskgist.world import Fitter, Scene, Stage
from taskgist.world.fit import alone
from taskgist_lab.simulator import Room
from taskgist_lab.simulator.room import TABLE, left, on_table, right


@pytest.fixture(scope="module")
def scene() -> Scene:
    people = (left(1.80, 0.67), right(1.66, 0.63, posture="standing"))
    return Room("two", people, (on_table("cup", 0.0, 0.1),), TABLE).scene()


@pytest.mark.parametrize("name", ["P1", "P2"])
def test_only_the_agent_is_left_and_all_of_it(scene: Scene, name: str) -> None:
    there, apart = scene.agent(name), alone(scene, name)
    assert apart.model.nq == 7 + len(there.joints)
    assert tuple(apart.agent.joints) == tuple(there.joints)
    assert set(apart.columns.tolist()) == {*range(there.base.start, there.base.stop), *there.joints.values()}


@pytest.mark.parametrize("name", ["P1", "P2"])
def test_its_positions_go_there_and_back(scene: Scene, name: str) -> None:
    apart = alone(scene, name)
    qpos = np.random.default_rng(0).normal(size=scene.nq)
    assert apart.within(qpos, apart.qpos(qpos)) == pytest.approx(qpos)
    moved = apart.within(qpos, np.zeros(apart.model.nq))
    assert np.flatnonzero(moved != qpos).tolist() == sorted(apart.columns.tolist())


def test_who_is_alone_already_stays_as_it_is(scene: Scene) -> None:
    lonely = Room("one", (right(1.66, 0.63, posture="standing"),), (), TABLE).scene()
    assert alone(lonely, "P2").model is lonely.model
    assert alone(scene, "P2").model is not scene.model


def test_a_fit_moves_the_agent_in_its_room_to_the_goal(scene: Scene) -> None:
    goal = (0.2, 0.2, 1.0)
    fit = Fitter(scene, "P2", moving="arms").fit(scene.initial, points={"right_palm": goal}, iterations=60)
    stage = Stage(scene, fit.state)
    reached = stage.site(scene.agent("P2").arm("right").palm_site).position
    assert np.linalg.norm(reached - goal) == pytest.approx(fit.errors_m["right_palm"])
    arms = [column for joint, column in scene.agent("P2").joints.items() if "right" in joint or "left" in joint]
    others = np.setdiff1d(np.arange(scene.nq), arms)
    assert fit.state.qpos[others] == pytest.approx(scene.initial.qpos[others])


def test_nobody_unknown_is_alone(scene: Scene) -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'P1'"):
        alone(scene, "P11")
