"""A body that follows its hand: it gets to the goal, leaning a little more where that helps, or says it does not."""

from __future__ import annotations

from contextlib import suppress

import numpy as np
import pytest

from taskgist.errors import SceneError
from taskgist.moving.body import LARGEST_ERROR_M, MORE_LEAN_RAD, SHORTEST_S, Body, followed, paced
from taskgist.moving.hand_pose import HandPose, sampled, upright
from taskgist.world import Scene
from taskgist_lab.simulator import Room
from taskgist_lab.simulator.room import TABLE, left, on_table

AHEAD = (1.0, 0.0)
UPRIGHT = np.zeros(2)


@pytest.fixture(scope="module")
def scene() -> Scene:
    return Room("one", (left(1.80, 0.67),), (on_table("cup", 0.0, 0.1),), TABLE).scene()


@pytest.fixture(scope="module")
def body(scene: Scene) -> Body:
    return Body(scene, "P1")


def _way(scene: Scene, body: Body, share: float) -> list[HandPose]:
    """A way to before the right shoulder, so far off as a share of the arm's length."""
    shoulder = body.shoulder(scene.initial, "right")
    goal = upright("right", shoulder + (share * body.agent.arm("right").profile.length_m, 0.0, 0.0), AHEAD)
    return sampled([body.hand(scene.initial, "right"), *body.raising("right"), goal])[1:]


def test_the_hand_gets_to_its_goal_and_the_other_one_stays(scene: Scene, body: Body) -> None:
    way = _way(scene, body, 0.8)
    states = followed(body, scene.initial, "right", way, torso_rad=UPRIGHT, phase="out", role="performing")
    assert states[0] is scene.initial
    assert np.linalg.norm(body.hand(states[-1], "right").palm - way[-1].palm) < LARGEST_ERROR_M
    resting = body.hand(scene.initial, "left").palm
    assert max(np.linalg.norm(body.hand(state, "left").palm - resting) for state in states) < 0.01


def test_who_does_not_get_there_leans_a_little_more(scene: Scene, body: Body) -> None:
    leans = []
    for share in np.linspace(1.0, 1.2, 9):
        with suppress(SceneError):
            states = followed(
                body,
                scene.initial,
                "right",
                _way(scene, body, share),
                torso_rad=UPRIGHT,
                phase="out",
                role="performing",
            )
            leans.append(body.posture(states[-1])[1])
    assert leans == sorted(leans)
    assert set(np.round(leans, 6)) == set(np.round(MORE_LEAN_RAD, 6))


def test_who_does_not_get_there_at_all_says_how_far_off_it_is(scene: Scene, body: Body) -> None:
    with pytest.raises(SceneError, match=r"P1: right_palm: the right hand ends \d+ mm .* nearer to the target agent"):
        followed(body, scene.initial, "right", _way(scene, body, 1.6), torso_rad=UPRIGHT, phase="out", role="target")


def test_the_way_back_ends_at_rest(scene: Scene, body: Body) -> None:
    way = _way(scene, body, 0.8)
    out = followed(body, scene.initial, "right", way, torso_rad=UPRIGHT, phase="out", role="performing")
    home = sampled([way[-1], *reversed(body.raising("right"))])[1:]
    back = followed(body, out[-1], "right", home, torso_rad=UPRIGHT, phase="back", role="performing")
    assert body.posture(back[-1]) == pytest.approx(body.resting_posture)


def test_motions_take_as_long_as_people_do_or_as_asked(scene: Scene, body: Body) -> None:
    way = _way(scene, body, 0.8)
    states = followed(body, scene.initial, "right", way, torso_rad=UPRIGHT, phase="out", role="performing")
    usual = paced(body, "right", states, start_s=1.0, tempo=1.0, duration_s=None)
    slow = paced(body, "right", states, start_s=1.0, tempo=1.5, duration_s=None)
    asked = paced(body, "right", states, start_s=1.0, tempo=1.0, duration_s=0.9)
    still = paced(body, "right", [states[-1], states[-1]], start_s=0.0, tempo=1.0, duration_s=None)
    assert slow.duration_s == pytest.approx(1.5 * usual.duration_s)
    assert (asked.duration_s, still.duration_s) == (0.9, SHORTEST_S)
    assert usual.at(np.array([0.0, 99.0])) == pytest.approx(
        np.array([body.posture(states[0]), body.posture(states[-1])])
    )
