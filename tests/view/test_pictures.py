"""Pictures: the right pixels in the right colour, whole files or none, and no display."""

from __future__ import annotations

import dataclasses
import os
import subprocess
import sys
from pathlib import Path

import matplotlib
import matplotlib.image
import numpy as np
import pytest
from matplotlib.figure import Figure
from numpy.typing import NDArray

from taskgist.errors import InputError, UnknownNameError
from taskgist.perspective import visibility
from taskgist.view import before_after_picture, looking, pinhole, render, save_figure, see_picture
from taskgist.view.rendering import HIGHLIGHT, SKY
from taskgist.world import Scene, Stage
from tests.scenes import TABLE, agent, box, cylinder, scene
from tests.shipped import label, recording

CUP = ("cup", 0.1, 0.0, 0.771)


def room(*bodies: str) -> Scene:
    return scene(TABLE, cylinder(*CUP), *bodies, agents=agent("P1", -0.8, 0.0) + agent("P2", 0.8, 0.0, 180))


def rendered_eye(stage: Stage, name: str, target: str) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Colours and shapes of the image whose pixels make the visibility score."""
    body = stage.scene.agent(name)
    eye = body.profile.eye
    image = render(
        stage,
        stage.eye(body),
        pinhole(eye.fov_rad, *eye.image_px),
        exclude_body=body.eye_exclude_body,
        highlight=[int(geom) for geom in stage.scene.object_geoms(target)],
    )
    return image.rgb, image.geoms


def highlighted(rgb: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Pixels that have the hue of attention, whatever their light."""
    return np.asarray(np.all(np.isclose(rgb / rgb[..., :1], HIGHLIGHT / HIGHLIGHT[0]), axis=-1))


@pytest.mark.parametrize(
    ("name", "time_s"), [("handover_1", 1.7), ("handover_1", 3.7), ("show_a", 6.4), ("hide_a", 0.6)]
)
def test_highlighted_pixels_are_the_visible_pixels(name: str, time_s: float) -> None:
    subject = label(name)
    stage = Stage(recording(name).scene, recording(name).at(time_s))
    seen = visibility(stage, subject.target_agent, subject.target_object)
    assert seen is not None
    rgb, geoms = rendered_eye(stage, subject.target_agent, subject.target_object)
    marked = np.isin(geoms, stage.scene.object_geoms(subject.target_object))
    assert np.array_equal(highlighted(rgb), marked)
    assert int(marked.sum()) == pytest.approx(seen.visible_px, rel=0.1)  # where it has few, parts of them count
    assert seen.visible_px > 0


def test_nothing_is_highlighted_behind_a_box() -> None:
    stage = Stage(room(box("wall", -0.1, 0.0, 1.0, (0.02, 0.5, 0.5))))
    rgb, _ = rendered_eye(stage, "P1", "cup")
    assert not highlighted(rgb).any()
    assert highlighted(rendered_eye(stage, "P2", "cup")[0]).any()


def test_rays_of_a_pinhole() -> None:
    rays = pinhole((np.radians(90), np.radians(60)), 8, 6)
    assert rays.shape == (6, 8, 3)
    assert np.linalg.norm(rays, axis=-1) == pytest.approx(1.0)
    assert rays[:, ::-1] == pytest.approx(rays * (1, -1, 1)), "left and right are alike"
    assert rays[::-1] == pytest.approx(rays * (1, 1, -1)), "up and down are alike"
    assert rays[0, 0, 1] > 0, "the first pixel looks left"
    assert rays[0, 0, 2] > 0, "and up"


def test_a_camera_looks_where_it_is_told() -> None:
    camera = looking((2.0, -1.0, 1.5), (0.1, 0.0, 0.771))
    stage = Stage(room())
    image = render(stage, camera, pinhole((0.02, 0.02), 3, 3))
    assert stage.scene.owners[int(image.geoms[1, 1])] == "cup"
    assert camera.matrix.T @ camera.matrix == pytest.approx(np.eye(3))
    assert camera.matrix[2, 1] == pytest.approx(0.0), "level"
    away = render(stage, looking((2.0, -1.0, 1.5), (4.0, -3.0, 3.0)), pinhole((0.02, 0.02), 3, 3))
    assert (away.geoms == -1).all()
    assert away.rgb == pytest.approx(np.broadcast_to(SKY, (3, 3, 3)))


def marked_pixels(path: Path) -> int:
    """Pixels of a saved picture in the colour of attention, in any light."""
    pixels = matplotlib.image.imread(path)[..., :3].astype(float)
    bright = pixels[..., 0] > 0.3
    return int(
        (bright & (np.abs(pixels / np.maximum(pixels[..., :1], 0.01) - HIGHLIGHT / HIGHLIGHT[0]) < 0.03).all(-1)).sum()
    )


def test_a_picture_marks_its_target(tmp_path: Path) -> None:
    stage = Stage(room())
    marked = see_picture(stage, "P1", tmp_path / "marked.png", target="cup")
    plain = see_picture(stage, "P1", tmp_path / "plain.png")
    assert marked_pixels(marked) > 50 > marked_pixels(plain)
    assert {path.name for path in tmp_path.iterdir()} == {"marked.png", "plain.png"}
    with pytest.raises(UnknownNameError, match="no object 'cap'; did you mean 'cup'"):
        see_picture(stage, "P1", tmp_path / "cap.png", target="cap")
    assert not (tmp_path / "cap.png").exists()


def test_a_target_that_is_not_visible(tmp_path: Path) -> None:
    stage = Stage(room(box("wall", -0.1, 0.0, 1.0, (0.02, 0.5, 0.5))))
    hidden = see_picture(stage, "P1", tmp_path / "hidden.png", target="cup", title="a title of one's own")
    assert marked_pixels(hidden) < 50


@pytest.mark.usefixtures("coarse_pictures")
def test_before_and_after(tmp_path: Path) -> None:
    """All target objects are marked, and each target agent's eyes have a row."""
    shown, subject = recording("show_a"), label("show_a")
    states = (shown.at(subject.start_s), shown.at(subject.end_s))
    things = dataclasses.replace(subject, target_objects=("cup", "white_box"))
    stage = Stage(shown.scene)
    one, two = (
        before_after_picture(stage, states, each, tmp_path / f"{len(each.target_objects)}.png")
        for each in (subject, things)
    )
    assert stage.state is states[1]
    assert matplotlib.image.imread(one).shape[:2] == (860, 1200)
    assert marked_pixels(one) > 200
    assert marked_pixels(two) > marked_pixels(one) + 200
    both = dataclasses.replace(subject, performing_agent="nobody", target_agents=("P1", "P2"))
    path = before_after_picture(Stage(shown.scene), states, both, tmp_path / "both.png")
    assert matplotlib.image.imread(path).shape[:2] == (1340, 1200)


def test_a_picture_appears_whole_or_not_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "picture.png"
    save_figure(Figure(), path)
    before = path.read_bytes()

    def broken(_self: Figure, file: object, **_: object) -> None:
        file.write(b"\x89PNG half of it")  # type: ignore[attr-defined]
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Figure, "savefig", broken)
    with pytest.raises(InputError, match=r"picture.png: cannot be written: No space left on device; free some space"):
        save_figure(Figure(), path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_the_same_picture_has_the_same_bytes(tmp_path: Path) -> None:
    first, second = (save_figure(Figure(), tmp_path / name) for name in ("first.png", "second.png"))
    assert first.read_bytes() == second.read_bytes()


def test_pictures_can_be_read_by_others(tmp_path: Path) -> None:
    """They are made as private temporary files, but are no secrets."""
    path = save_figure(Figure(), tmp_path / "picture.png")
    umask = os.umask(0)
    os.umask(umask)
    assert path.stat().st_mode & 0o777 == 0o666 & ~umask


@pytest.mark.parametrize("target", ["nowhere/picture.png", "folder"])
def test_places_that_cannot_be_written(target: str, tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    with pytest.raises(InputError, match=rf"{target}: cannot be written: .*; name a file"):
        save_figure(Figure(), tmp_path / target)
    assert [path.name for path in tmp_path.rglob("*")] == ["folder"]


def test_no_display_is_needed(tmp_path: Path) -> None:
    """In a process that has none, and with no other backend than the one that draws files."""
    code = (
        "import sys; from pathlib import Path; from matplotlib.figure import Figure\n"
        "from taskgist.view import save_figure\n"
        "save_figure(Figure(), Path('picture.png'))\n"
        "assert not {'tkinter', 'PyQt6', 'gi', 'matplotlib.pyplot'} & set(sys.modules)"
    )
    environment = {
        key: value for key, value in os.environ.items() if key not in ("DISPLAY", "WAYLAND_DISPLAY", "MUJOCO_GL")
    }
    subprocess.run([sys.executable, "-c", code], cwd=tmp_path, env=environment, check=True, timeout=300)
    assert (tmp_path / "picture.png").read_bytes().startswith(b"\x89PNG")
