"""Scenes from outside and trees: everything is in the picture, and nothing covers anything else."""

from __future__ import annotations

from functools import cache
from itertools import combinations
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from taskgist.errors import InputError
from taskgist.facts import STANDARD_TREE
from taskgist.learning import understand
from taskgist.recording import Recording
from taskgist.view import pinhole, render
from taskgist.view.rendering import HIGHLIGHT
from taskgist.view.scene import FOV_RAD, camera_outside, draw_outside
from taskgist.world import Stage, State
from taskgist_lab.view import BOX, ROW_IN, demonstration_picture, layout, task_picture, tree_picture
from tests.learning.learning_samples import study
from tests.shipped import label, recording

SHOWN = ("hide_a", "show_d")


@cache
def ends(name: str) -> tuple[Recording, tuple[State, State]]:
    shown, subject = recording(name), label(name)
    return shown, (shown.at(subject.start_s), shown.at(subject.end_s))


@pytest.mark.parametrize("name", SHOWN)
def test_everybody_and_everything_is_in_the_picture(name: str) -> None:
    shown, states = ends(name)
    stage = Stage(shown.scene)
    camera = camera_outside(stage, states, label(name).target_object, width_px=120)
    assert camera.pose.matrix[2, 1] == pytest.approx(0.0), "level"
    for state in states:
        stage.show(state)
        points = [stage.eye(shown.scene.agent(agent)).position for agent in shown.scene.agents]
        points += [state.qpos[shown.scene.object_slice(thing)][:3] for thing in shown.scene.objects]
        for point in points:
            column, row = camera.pixel(point)
            assert 0 < column < camera.width_px
            assert 0 < row < camera.height_px


@pytest.mark.parametrize("name", SHOWN)
def test_the_target_object_is_seen_from_outside(name: str) -> None:
    """Also where it is hidden from the target agent."""
    shown, states = ends(name)
    stage, target = Stage(shown.scene), label(name).target_object
    camera = camera_outside(stage, states, target, width_px=120)
    rays = pinhole(FOV_RAD, camera.width_px, camera.height_px)
    for state in states:
        stage.show(state)
        seen = np.isin(render(stage, camera.pose, rays).geoms, shown.scene.object_geoms(target))
        assert seen.any()
        rows, columns = np.nonzero(seen)
        column, row = camera.pixel(state.qpos[shown.scene.object_slice(target)][:3])
        assert column == pytest.approx(columns.mean() + 0.5, abs=2.5)
        assert row == pytest.approx(rows.mean() + 0.5, abs=3.5)


def test_names_stand_above_heads_and_say_who_is_who() -> None:
    shown, states = ends("hide_a")
    stage = Stage(shown.scene)
    camera = camera_outside(stage, states, "cup", width_px=120)
    stage.show(states[0])
    axes: Axes = Figure().subplots()
    draw_outside(axes, stage, camera, label("hide_a"), "start")
    told = {text.get_text(): text.get_position() for text in axes.texts}
    assert set(told) == {"P1, performer", "P2, target agent"}
    for name, (column, row) in told.items():
        head = camera.pixel(stage.eye(shown.scene.agent(name[:2])).position)
        assert column == pytest.approx(head[0], abs=2.0)
        assert 0 < row < head[1]


def marked_share(path: Path) -> float:
    pixels = matplotlib.image.imread(path)[..., :3].astype(float)
    hue = np.abs(pixels / np.maximum(pixels[..., :1], 0.01) - HIGHLIGHT / HIGHLIGHT[0]) < 0.03
    return float(((pixels[..., 0] > 0.3) & hue.all(-1)).mean())


def test_a_demonstration_from_everybodys_perspective(tmp_path: Path) -> None:
    path = demonstration_picture(recording("show_a"), tmp_path / "show_a.png")
    assert matplotlib.image.imread(path).shape[:2] == (1060, 900)
    assert marked_share(path) > 1e-4


def test_a_task_has_two_demonstrations_in_a_row(tmp_path: Path) -> None:
    path = task_picture([recording(name) for name in ("hide_a", "show_d")], tmp_path / "hide.png")
    assert matplotlib.image.imread(path).shape[:2] == (205, 1040)
    assert marked_share(path) > 1e-4
    assert [each.name for each in tmp_path.iterdir()] == ["hide.png"]


def test_no_two_nodes_of_a_tree_share_a_place() -> None:
    places = layout(STANDARD_TREE)
    assert set(places) == {node.name for node in STANDARD_TREE.nodes}
    for (column, row), (other_column, other_row) in combinations(places.values(), 2):
        assert column != other_column or abs(row - other_row) * ROW_IN > BOX[1]
    for node in STANDARD_TREE.nodes:
        if node.parent is not None:
            assert places[node.name][0] == places[node.parent][0] + 1


def test_a_tree_is_saved(tmp_path: Path) -> None:
    stages = {str(count): understand(study("show", count)) for count in (2, 4)}
    first = tree_picture(stages, tmp_path / "tree.png", title="show").read_bytes()
    assert tree_picture(stages, tmp_path / "again.png", title="show").read_bytes() == first
    other = tree_picture({"2": stages["2"]}, tmp_path / "other.png", title="show").read_bytes()
    assert other != first
    with pytest.raises(InputError, match="cannot be written"):
        tree_picture(stages, tmp_path / "nowhere" / "tree.png")
