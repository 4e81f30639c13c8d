"""Grasps of things of one form are sampled once for all scenes."""

from dataclasses import replace

import numpy as np
import pytest

from taskgist.perspective import grasp_sampling as samples
from taskgist.perspective.grasp_sampling import Grasps, form_of, grasps_in_object
from taskgist.settings import DEFAULT
from taskgist.world import Hand, Scene, Stage
from taskgist_lab.generator.things import SHAPES
from tests import meshes
from tests.meshes import mesh_scene
from tests.scenes import agent, cylinder

P1 = agent("P1", 0, 0)
PIECES = meshes.joined(*SHAPES["bowl"])


def alone() -> Scene:
    return mesh_scene(meshes.body("thing", "thing", (0.5, 0.2, 1.15)), P1, thing=PIECES)


def among_others() -> Scene:
    """Elsewhere, under another name, and with other indices."""
    bodies = cylinder("tin", 0.6, -0.4, 1.0) + meshes.body("bowl", "bowl", (-0.3, 0.7, 0.9))
    return mesh_scene(bodies, P1, bowl=PIECES)


def hand_of(scene: Scene) -> Hand:
    hand = scene.agent("P1").profile.hand
    assert hand is not None
    return hand


def told(scene: Scene, grasps: Grasps, name: str) -> list[object]:
    """All of them, with shapes as numbers among those of the object."""
    solids = scene.solid_geoms_of(name)
    counted = replace(grasps, solids=np.searchsorted(solids, grasps.solids), shapes=grasps.shapes - solids.min())
    return [np.asarray(value).tolist() if value is not None else None for value in vars(counted).values()]


def test_the_same_thing_elsewhere_has_the_same_grasps_and_is_not_sampled_again(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(samples, "_BY_FORM", {})
    first, second = alone(), among_others()
    one = grasps_in_object(Stage(first), "thing", hand_of(first), DEFAULT.grasp)
    assert len(one) > 0
    monkeypatch.setattr(samples, "_BY_FORM", {})
    anew = grasps_in_object(Stage(second), "bowl", hand_of(second), DEFAULT.grasp)
    assert told(first, one, "thing") == told(second, anew, "bowl")
    monkeypatch.setattr(samples, "_sampled", None)  # it would be called
    third = among_others()
    again = grasps_in_object(Stage(third), "bowl", hand_of(third), DEFAULT.grasp)
    assert told(third, again, "bowl") == told(second, anew, "bowl")
    assert set(again.solids) == set(third.solid_geoms_of("bowl"))


def test_another_size_is_another_form() -> None:
    larger = (PIECES[0] * 1.001, PIECES[1])
    scenes = [alone(), mesh_scene(meshes.body("thing", "thing", (0.5, 0.2, 1.15)), P1, thing=larger)]
    forms = [form_of(bench(scene), "thing") for scene in scenes]
    assert forms[0] != forms[1]
    assert forms[0] == form_of(bench(alone()), "thing")


def bench(scene: Scene) -> Stage:
    at_origin = scene.initial.replace(at=scene.object_slice("thing"), to=(0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0))
    return Stage(scene, at_origin)
