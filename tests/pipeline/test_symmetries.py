"""Laws of whole recordings: where the room stands changes nothing, and a mirror changes left and right alone."""

from __future__ import annotations

from functools import cache

import pytest

from taskgist.facts import STANDARD_TREE, Node, Unknown
from taskgist.learning import Explanation
from taskgist.pipeline import explain_recording
from taskgist.recording import Recording
from taskgist.world import Stage
from tests.pipeline.mirrors import mirrored, moved, swapped
from tests.shipped import excerpt, label

SAMPLE = ("handover_2", "handover_5", "show_d", "hide_b")
"""Tracked and simulated, sitting and standing, whole bodies and one with parts that were not tracked."""


@cache
def sample(name: str) -> Recording:
    """What happens between the ends of the label, at half the rate."""
    ends = label(name)
    return excerpt(name, ends.start_s - 0.4, ends.end_s + 0.3, every=2)


@cache
def original(name: str) -> dict[str, str | None]:
    return values(explain_recording(sample(name)))


def values(explained: Explanation) -> dict[str, str | None]:
    return {name: None if isinstance(node.value, Unknown) else node.value for name, node in explained.nodes.items()}


@pytest.mark.parametrize(("name", "yaw_rad"), [*zip(SAMPLE, (2.0, -0.7, 3.0, -2.4), strict=True)])
def test_moving_and_turning_the_whole_recording_changes_no_fact(name: str, yaw_rad: float) -> None:
    elsewhere = moved(sample(name), yaw_rad, 1.3, -2.1)
    assert elsewhere.digest != sample(name).digest
    assert values(explain_recording(elsewhere)) == original(name)


@pytest.mark.parametrize("name", SAMPLE)
def test_a_mirrored_recording_has_the_same_efforts_and_mirrored_hands(name: str) -> None:
    seen = values(explain_recording(mirrored(sample(name))))
    for node in STANDARD_TREE.nodes:
        if ".state." not in node.name:  # joint angles: torso and head turn the other way
            assert seen[node.name] == in_mirror(node, original(name)[node.name]), node.name


def in_mirror(node: Node, value: str | None) -> str | None:
    if value is None or not node.name.startswith(("hands", "reach", "grasp")):
        return value
    if not value.startswith("left: "):
        return swapped(value)
    return ", ".join(sorted(swapped(value).split(", ")))


def test_the_mirror_shows_what_it_should() -> None:
    """The helper itself: eyes and hands lie where a mirror would show them."""
    shown, image = sample("handover_2"), mirrored(sample("handover_2"))
    before, after = (Stage(each.scene, each.at(3.0)) for each in (shown, image))
    for name in ("P1", "P2"):
        agent, other = shown.scene.agent(name), image.scene.agent(name)
        flipped = before.eye(agent).position * (1, -1, 1)
        assert after.eye(other).position == pytest.approx(flipped, abs=1e-9)
        for side in ("left", "right"):
            hand = before.body(agent.arm(side).hand_body).position * (1, -1, 1)
            assert after.body(other.arm(swapped(side)).hand_body).position == pytest.approx(hand, abs=1e-9)
    assert mirrored(image).qpos == pytest.approx(shown.qpos)
