"""The shoulder girdle: at rest with the arm alone, thrust forward by a hand's breadth with the torso's effort."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from taskgist.perspective import Viewpoint, effort_from
from taskgist.perspective.candidates import TorsoPose, thrust_of
from taskgist.perspective.reach import Reach
from taskgist.perspective.search import least
from taskgist.settings import DEFAULT
from taskgist.world import Stage
from tests.bodies import needs
from tests.ordinary import Line, a, robot, stands

SECTOR = replace(DEFAULT, reach=replace(DEFAULT.reach, model="sector"))


def viewpoint(x: float, *, tall: float = 1.75, profile: str = "human") -> Viewpoint:
    """Who stands upright, with a cup so far ahead of the right shoulder."""
    body = stands(tall=tall) if profile == "human" else robot(profile)
    cup = a("cup", x, -0.13 * tall, 0.7 * tall)
    return Viewpoint(Stage(Line("", body, (), cup, "?", "?", "?").scene()), "P")


@pytest.mark.parametrize("tall", [1.55, 1.75, 1.90])
def test_thrusting_brings_a_shoulder_forward_by_8_to_10_cm(tall: float) -> None:
    here = viewpoint(0.5, tall=tall)
    for arm in here.agent.arms:
        before = here.stage.show(here.state).shoulder(arm).position
        after = here.stage.show(here.state.replace(thrust_of(here.agent, arm, here.state))).shoulder(arm).position
        assert 0.08 <= (after - before)[0] * 1.75 / tall <= 0.10
        assert abs((after - before)[2]) < 0.001
        assert abs(after[1]) < abs(before[1])


def test_where_thrust_shoulders_are_is_where_mujoco_has_them() -> None:
    here = viewpoint(0.5)
    candidates = next(iter(here.candidates.of_level(2, here.target("thing").middle)))
    count = len(here.agent.arms)
    for index in range(0, len(candidates), 7):
        state = candidates[index].state
        for number, arm in enumerate(here.agent.arms):
            stage = here.stage.show(state.replace(thrust_of(here.agent, arm, state)))
            clavicle = stage.body(int(stage.scene.model.body(f"P/{arm.profile.root}").id))
            found = candidates.shoulder(index, count + number)
            assert found.position == pytest.approx(stage.shoulder(arm).position, abs=1e-9)
            assert found.matrix == pytest.approx(clavicle.matrix, abs=1e-9)


def test_the_torso_reaches_farther_by_the_thrust_and_the_arm_alone_does_not() -> None:
    """With the girdle at rest no farther than published, 0.66 to 0.71 m from the shoulder; a cup is 4 cm thick."""
    levels = {x: effort_from(viewpoint(x), "thing", "reach").level for x in np.arange(0.6, 1.3, 0.02).round(2).tolist()}
    farthest = {level: max(x for x, found in levels.items() if found == level) for level in (1, 2)}
    assert 0.66 <= farthest[1] - 0.04 <= 0.72
    at_rest = Viewpoint(viewpoint(0.9).stage, "P")
    found = effort_from(at_rest, "thing", "reach")
    assert (found.level, found.amount and round(found.amount.torso_rad, 2)) == (2, 0.25)
    lean = TorsoPose({at_rest.agent.joints["torso_lean"]: 0.25})
    shoulder = at_rest.stage.show(at_rest.state.replace(lean.changes)).shoulder(at_rest.agent.arm("right")).position
    nearest = np.linalg.norm(at_rest.target("thing").points - shoulder, axis=1).min()
    assert nearest > at_rest.agent.arm("right").reach.map.radius_m  # leaning alone would not do


@pytest.mark.parametrize("ability", ["reach", "grasp"])
def test_the_attained_state_has_the_shoulder_thrust_only_where_that_is_needed(ability: str) -> None:
    for x, needed in ((0.76, False), (0.9, True)):
        here = viewpoint(x)
        effort = effort_from(here, "thing", ability)  # type: ignore[arg-type]
        assert effort.level == 2
        assert effort.actions == ("Lean_Torso", "Stretch_Out_Arm(right)")
        solution = least(here, Reach(here, here.target("thing")), 2, here.target("thing").middle)
        girdle = solution.state.qpos[here.agent.joints["right_girdle_protraction"]]  # type: ignore[union-attr]
        assert bool(girdle > 0.4) is needed


def test_the_papers_reach_and_bodies_without_a_girdle_know_no_thrust() -> None:
    here = viewpoint(0.9)
    assert not Reach(Viewpoint(here.stage, "P", SECTOR), here.target("thing")).thrusts
    assert Reach(here, here.target("thing")).thrusts
    with_arms_only = Viewpoint(here.stage, "P", actions=("Stretch_Out_Arm(right)",))
    assert effort_from(with_arms_only, "thing", "reach").level == 5


@pytest.mark.parametrize("profile", [pytest.param(name, marks=needs(name)) for name in ("pr2", "talos", "hrp2")])
def test_robots_without_a_girdle_stay_as_they_were(profile: str) -> None:
    here = viewpoint(0.7, profile=profile)
    assert not Reach(here, here.target("thing")).thrusts
    assert all(not thrust_of(here.agent, arm, here.state) for arm in here.agent.arms)
