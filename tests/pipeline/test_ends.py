"""Explanations from the frames around the label's ends are those from all frames, value by value, evidence included."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import cast

import numpy as np
import pytest

from taskgist.observe import Observer, status_observations
from taskgist.pipeline import episodes_of, explain_recording
from taskgist.recording import Recording
from tests.observe.states import said
from tests.observe.step_by_step import Watching
from tests.shipped import excerpt, explanation, label, recording


def watched(whole: Recording) -> Observer:
    """The slow twin, frame by frame; asked for the same, it is taken for an observer."""
    return cast(Observer, Watching.of(whole.scene, map(whole.state, range(len(whole)))))


@cache
def watched_shipped(name: str) -> Observer:
    """As ``watched``, of a whole shipped recording."""
    return watched(recording(name))


@pytest.mark.parametrize("name", [*(f"handover_{number}" for number in range(1, 6)), "hide_b", "show_d"])
def test_shipped_recordings_are_explained_as_if_all_of_them_had_been_watched(name: str) -> None:
    by_all = explain_recording(recording(name), predicates=(), observer=watched_shipped(name))
    assert explanation(name).to_json() == by_all.to_json()


@pytest.mark.parametrize("name", ["handover_2", "handover_5", "hide_b"])
def test_wherever_the_label_ends(name: str) -> None:
    """Real hands tremble, and some were not tracked: facts of the label's agent and object, at every third frame."""
    whole, ends = recording(name), label(name)
    by_all, by_some = watched_shipped(name), Observer(whole.scene, whole)
    for time_s in whole.times_s[::-3].tolist():
        found, expected = (
            status_observations(each, ends.target_agent, ends.target_object, time_s) for each in (by_some, by_all)
        )
        assert found == expected, f"at {time_s:.3f} s"


def noisy(clean: Recording, sigma_m: float, seed: int) -> Recording:
    """Everything trembles, every tenth frame is missing; the object and one agent's right arm are lost at times."""
    rng, scene = np.random.default_rng(seed), clean.scene
    kept = np.flatnonzero(rng.random(len(clean)) > 0.1)
    qpos = clean.qpos[kept].copy()
    for name in scene.objects:
        qpos[:, scene.object_slice(name)][:, :3] += rng.normal(scale=sigma_m, size=(len(kept), 3))
    for name in scene.agents:
        joints = scene.joint_indices(name)
        qpos[:, joints] += rng.normal(scale=sigma_m, size=(len(kept), len(joints)))
    lost = {name: rng.random(len(kept)) > 0.05 for name in (scene.objects[0], f"{scene.agents[1]}/right_arm")}
    return replace(clean, times_s=clean.times_s[kept], qpos=qpos, tracked=lost, signals={})


@pytest.mark.parametrize(("name", "sigma_m"), [("handover_1", 0.003), ("hide_b", 0.01), ("show_d", 0.03)])
def test_however_much_it_trembles(name: str, sigma_m: float) -> None:
    ends = label(name)
    trembling = noisy(excerpt(name, ends.start_s - 0.3, ends.end_s + 0.3), sigma_m, seed=len(name))
    by_all, by_some = watched(trembling), Observer(trembling.scene, trembling)
    for time_s in trembling.times_s[::-12].tolist():
        assert said(by_some, time_s) == said(by_all, time_s), f"at {time_s:.3f} s"
    assert episodes_of(trembling) == episodes_of(trembling, observer=by_all)
