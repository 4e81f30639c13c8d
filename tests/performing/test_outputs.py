"""What others take from a performance says what the recording says, and needs no taskgist to be read."""

from __future__ import annotations

import io
import itertools
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import matplotlib.image
import mujoco
import numpy as np
import pytest
from PIL import Image

from taskgist.common.arrays import Array
from taskgist.errors import InputError
from taskgist.performing.execution import phase_frames
from taskgist.performing.outputs import plan_document, robot_trajectory, write_document, write_positions
from taskgist.planning.plan import RATE_HZ
from taskgist.view import performance as view
from taskgist.view.rendering import pinhole, render
from taskgist.view.scene import FOV_RAD, camera_outside
from taskgist.world import Stage
from taskgist.world.geometry.transforms import Pose, matrix_from_wxyz, yaw_of
from tests.performing.performances import CarriedOut, carried
from tests.schemas import hold_to_schema

NEAR = 2e-6
"""Documents are rounded to six decimals."""


@pytest.fixture(scope="module")
def hidden() -> CarriedOut:
    return carried("hide")


@pytest.fixture(scope="module")
def trajectory(hidden: CarriedOut) -> Any:
    return json.loads(json.dumps(robot_trajectory(hidden.plan, hidden.execution)))


@pytest.fixture(scope="module")
def document(hidden: CarriedOut) -> Any:
    return json.loads(json.dumps(plan_document(hidden.plan, hidden.execution)))


def seconds(points: list[Any]) -> Array:
    return np.array([each["time_from_start"]["sec"] + each["time_from_start"]["nanosec"] * 1e-9 for each in points])


def matrix_of(pose: Any) -> Pose:
    return Pose(np.array(pose["position_m"]), matrix_from_wxyz(pose["wxyz"]))


# --- Trajectories.


def test_documents_are_as_their_schemas_say(trajectory: Any, document: Any) -> None:
    hold_to_schema("perform_trajectory", trajectory)
    hold_to_schema("perform_plan", document)


def test_joints_are_the_models_and_their_positions_the_recordings(hidden: CarriedOut, trajectory: Any) -> None:
    recording = hidden.execution.recording
    agent, qpos = recording.scene.agent("Jido"), np.array(recording.qpos)
    assert set(trajectory["joint_trajectories"]) == {"right_arm"}, "Jido has no lift, and its fingers no joints"
    arm = trajectory["joint_trajectories"]["right_arm"]
    assert arm["joint_names"] == [f"arm_{number}" for number in range(1, 8)]
    columns = [agent.joints[name] for name in arm["joint_names"]]
    times_s, points = seconds(arm["points"]), arm["points"]
    assert (np.diff(times_s) > 0).all()
    assert (times_s[0], times_s[-1]) == (0.0, pytest.approx(recording.times_s[-1]))
    frames = np.round(times_s * RATE_HZ).astype(int)
    assert np.abs(np.array([each["positions"] for each in points]) - qpos[frames][:, columns]).max() < NEAR
    assert points[-1]["positions"] == pytest.approx(qpos[-1, columns], abs=NEAR)


def test_velocities_are_finite_differences(hidden: CarriedOut, trajectory: Any) -> None:
    recording = hidden.execution.recording
    arm = trajectory["joint_trajectories"]["right_arm"]
    positions = np.array(recording.qpos)[:, [recording.scene.agent("Jido").joints[name] for name in arm["joint_names"]]]
    for point, frame in zip(arm["points"], np.round(seconds(arm["points"]) * RATE_HZ).astype(int), strict=True):
        before, after = max(0, frame - 1), min(len(positions) - 1, frame + 1)
        expected = (positions[after] - positions[before]) / ((after - before) / RATE_HZ)
        assert np.array(point["velocities"]) == pytest.approx(expected, abs=1e-4)


def test_a_controller_that_interpolates_by_cubics_stays_where_frames_are_left_out(
    hidden: CarriedOut, trajectory: Any
) -> None:
    recording = hidden.execution.recording
    arm = trajectory["joint_trajectories"]["right_arm"]
    points, times_s = arm["points"], seconds(arm["points"])
    positions = np.array(recording.qpos)[:, [recording.scene.agent("Jido").joints[name] for name in arm["joint_names"]]]
    left_out = 0
    for frame, time_s in enumerate(recording.times_s):
        after = min(int(np.searchsorted(times_s, time_s - 1e-6)), len(points) - 1)
        if abs(times_s[after] - time_s) > 1e-6:
            assert cubic(points[after - 1], points[after], times_s[after - 1 : after + 1], time_s) == pytest.approx(
                positions[frame], abs=1e-5
            )
            left_out += 1
    assert left_out > 100, "Jido drives, and rests in the end"


def cubic(one: Any, other: Any, times_s: Array, time_s: float) -> Array:
    """The cubic between two points at rest or in motion [Hermite]."""
    long_s = times_s[1] - times_s[0]
    s = (time_s - times_s[0]) / long_s
    weights = (2 * s**3 - 3 * s**2 + 1, -2 * s**3 + 3 * s**2, long_s * (s**3 - 2 * s**2 + s), long_s * (s**3 - s**2))
    values = (one["positions"], other["positions"], one["velocities"], other["velocities"])
    return np.asarray(sum(weight * np.array(value) for weight, value in zip(weights, values, strict=True)))


def test_the_base_is_a_planar_joint(hidden: CarriedOut, trajectory: Any) -> None:
    recording, base = hidden.execution.recording, trajectory["base_trajectory"]
    rows = np.array(recording.qpos)[:, recording.scene.base_slice("Jido")]
    assert base["header"]["frame_id"] == "world"
    assert f"Jido/{base['joint_names'][0]}.x" in recording.scene.columns
    times_s = seconds(base["points"])
    turned = 0.0
    for (one, other), step_s in zip(itertools.pairwise(base["points"]), np.diff(times_s), strict=True):
        rates = [each["velocities"][0]["angular"]["z"] for each in (one, other)]
        turned += float(np.mean(rates)) * float(step_s)
    assert turned == pytest.approx(yaw_of(rows[-1, 3:]) - yaw_of(rows[0, 3:]), abs=0.01), "rates add up to the turn"
    for point, frame in zip(base["points"], np.round(times_s * RATE_HZ).astype(int), strict=True):
        (transform,) = point["transforms"]
        assert list(transform["translation"].values()) == pytest.approx(rows[frame, :3], abs=NEAR)
        assert [transform["rotation"][axis] for axis in "wxyz"] == pytest.approx(rows[frame, 3:], abs=NEAR)


# --- The plan.


def test_phases_follow_one_another_and_end_where_the_recording_is(hidden: CarriedOut, document: Any) -> None:
    (action,) = document["actions"]
    recording, phases = hidden.execution.recording, action["phases"]
    assert [each["name"] for each in phases] == [phase.name for phase in hidden.plan.phases]
    assert all(one["end_s"] == other["start_s"] for one, other in itertools.pairwise(phases))
    scene, stage = recording.scene, Stage(recording.scene)
    palm = scene.agent("Jido").arm("right").palm_site
    for phase, frames in zip(phases, phase_frames(hidden.plan), strict=True):
        assert phase["end_s"] == pytest.approx(recording.times_s[frames[-1]] + 1 / RATE_HZ)
        shown = stage.show(recording.state(frames[-1]))
        assert phase["palm"]["position_m"] == pytest.approx(shown.site(palm).position, abs=NEAR)
        thing = shown.body(scene.object_body("cup"))
        assert phase["object"]["position_m"] == pytest.approx(thing.position, abs=NEAR)
    assert document["attained"]["position_m"] == pytest.approx(phases[-1]["object"]["position_m"], abs=0.002)


def test_the_thing_is_attached_once_and_let_go_once_and_stays_in_the_palm_between(document: Any) -> None:
    (action,) = document["actions"]
    phases = action["phases"]
    (first,) = (index for index, each in enumerate(phases) if each["attach"])
    (last,) = (index for index, each in enumerate(phases) if each["detach"])
    assert (phases[first]["name"], phases[last - 1]["name"]) == ("lift", "lower")
    grasp = matrix_of(action["grasp"])
    for phase in phases[first:last]:
        palm, thing = matrix_of(phase["palm"]), matrix_of(phase["object"])
        assert palm.to_world(grasp.position) == pytest.approx(thing.position, abs=1e-3)
        assert palm.matrix @ grasp.matrix == pytest.approx(thing.matrix, abs=0.02)


def test_the_robot_stands_still_where_it_stands(hidden: CarriedOut, document: Any) -> None:
    recording = hidden.execution.recording
    rows = np.array(recording.qpos)[:, recording.scene.base_slice("Jido")]
    stands = document["actions"][0]["stands"]
    assert len(stands) == 2, "for picking up, and for putting down"
    for stand in stands:
        there = rows[round(stand["start_s"] * RATE_HZ) : round(stand["end_s"] * RATE_HZ)]
        assert np.ptp(there, axis=0).max() < 1e-6
        assert (stand["base"]["x_m"], stand["base"]["y_m"]) == pytest.approx(there[0, :2], abs=NEAR)


def test_a_thing_that_is_handed_over_goes_from_palm_to_palm() -> None:
    given = carried("give")
    document = plan_document(given.plan, given.execution)
    hold_to_schema("perform_plan", document)
    hold_to_schema("perform_trajectory", robot_trajectory(given.plan, given.execution))
    (action,) = document["actions"]
    attached = [(each["agent"], phase["name"]) for phase in action["phases"] for each in phase["attach"]]
    detached = [each["agent"] for phase in action["phases"] for each in phase["detach"]]
    assert attached == [("Jido", "lift"), ("P2", "take")]
    assert detached == ["Jido"]
    assert (action["purpose"], action["means"]) == ("move", "hand_over")


# --- Positions, and files.


def test_positions_are_replayed_by_mujoco_alone(hidden: CarriedOut) -> None:
    recording, stream = hidden.execution.recording, io.BytesIO()
    write_positions(recording, stream)
    with np.load(io.BytesIO(stream.getvalue()), allow_pickle=False) as file:
        assets = {name[7:]: file[name].tobytes() for name in file.files if name.startswith("assets/")}
        model = mujoco.MjModel.from_xml_string(str(file["model"]), assets)
        times_s, qpos, columns = file["times_s"], file["qpos"], file["columns"].tolist()
    assert qpos.shape == (len(recording.times_s), model.nq)
    assert times_s[-1] == recording.times_s[-1]
    assert columns[columns.index("cup.x") :][:7] == [f"cup.{part}" for part in ("x", "y", "z", "qw", "qx", "qy", "qz")]
    assert qpos[-1, columns.index("Jido/arm_3")] == recording.qpos[-1][recording.scene.agent("Jido").joints["arm_3"]]
    data, stage = mujoco.MjData(model), Stage(recording.scene)
    for frame in (0, 200, len(qpos) - 1):
        data.qpos[:] = qpos[frame]
        mujoco.mj_kinematics(model, data)
        shown = stage.show(recording.state(frame))
        for body in range(model.nbody):
            name = str(model.body(body).name)
            same = recording.scene.model.body(name).id if name else 0
            assert data.xpos[body] == pytest.approx(shown.body_position(int(same)), abs=1e-5), name


def test_what_is_there_is_kept_unless_it_may_be_replaced(tmp_path: Path, document: Any) -> None:
    path = tmp_path / "plan.json"
    write_document(document, path, replace=False)
    with pytest.raises(InputError, match="is there already"):
        write_document({}, path, replace=False)
    assert json.loads(path.read_text(encoding="utf-8")) == document


# --- Pictures.


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures of a fifth of the size, and films of six frames."""
    for name in ("PICTURE_WIDTH_PX", "FILM_WIDTH_PX", "CHOOSING_WIDTH_PX"):
        monkeypatch.setattr(view, name, 120)
    monkeypatch.setattr(view, "MOST_FRAMES", 6)


def test_moments_tell_the_story_in_order(hidden: CarriedOut) -> None:
    shown = view.moments(hidden.plan, hidden.execution)
    assert [text for _, text in shown] == [
        "at the start",
        "brings its right hand around the cup",
        "drives with it",
        "brings it over its place",
        "lowers it",
        "at the end",
    ]
    given = [text for _, text in view.moments(carried("give").plan, carried("give").execution)]
    assert len(given) == 6
    assert given[-2:] == ["waits until P2 has taken it", "at the end"]


def test_few_phases_have_moments_enough(hidden: CarriedOut) -> None:
    """People have fewer phases than robots."""
    (action,) = hidden.plan.actions
    action = replace(action, phases=tuple(phase for phase in action.phases if phase.name == "drive"))
    short = replace(hidden.plan, actions=(action,))
    frames = [frame for frame, _ in view.moments(short, hidden.execution)]
    assert len(frames) == 6
    assert (np.diff(frames) > 12).all(), "none of them is near another"
    assert frames[0] == 0
    assert frames[-1] == len(hidden.execution.recording.times_s) - 1


@pytest.mark.usefixtures("small")
def test_a_picture_shows_different_moments(hidden: CarriedOut, tmp_path: Path) -> None:
    path = view.performance_picture(hidden.plan, hidden.execution, tmp_path / "hide.png")
    image = matplotlib.image.imread(path)[..., :3]
    assert image.shape[:2] == (1130, 1300)
    start, later = image[90:350, 20:420], image[90:350, 450:850]
    assert 0.01 < (np.abs(start - later).sum(axis=2) > 0.1).mean() < 0.6


@pytest.mark.usefixtures("small")
@pytest.mark.parametrize("suffix", view.FILMS)
def test_a_film_moves_and_is_small(hidden: CarriedOut, tmp_path: Path, suffix: str) -> None:
    path = view.performance_film(hidden.plan, hidden.execution, tmp_path / f"hide{suffix}")
    assert path.stat().st_size < view.MOST_BYTES
    with Image.open(path) as film:
        assert (film.n_frames, film.size) == (6, (820, 380))  # type: ignore[attr-defined]
        frames = []
        for number in range(6):
            film.seek(number)
            frames.append(np.asarray(film.convert("RGB"), dtype=float))
            assert film.info["duration"] == (1500 if number == 5 else pytest.approx(125, abs=5))
    assert all(np.abs(one - other).max() > 50 for one, other in itertools.pairwise(frames))


@pytest.mark.usefixtures("small")
def test_a_film_that_is_interrupted_leaves_nothing(hidden: CarriedOut, tmp_path: Path) -> None:
    def interrupt(what: str, share: float) -> None:
        assert what == "drawing the film"
        if share > 0:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        view.performance_film(hidden.plan, hidden.execution, tmp_path / "hide.webp", progress=interrupt)
    assert not list(tmp_path.iterdir())


def test_what_stands_still_is_drawn_as_it_is_in_every_frame(hidden: CarriedOut) -> None:
    """A film's frames are those of the plain renderer, though most of their pixels are rendered once."""
    recording = hidden.execution.recording
    stage, frames = Stage(recording.scene), view.film_frames(len(recording.times_s))
    camera = camera_outside(stage, [recording.state(0), recording.state(-1)], "cup", width_px=160)
    outside = view.Outside(stage, recording, frames, camera)
    rays = pinhole(FOV_RAD, view.SMOOTHING * camera.width_px, view.SMOOTHING * camera.height_px)
    marked = recording.scene.object_geoms("cup").tolist()
    for frame in frames[:: len(frames) // 5].tolist():
        stage.show(recording.state(frame))
        plain = np.clip(render(stage, camera.pose, rays, highlight=marked).rgb, 0, 1)
        shape = (camera.height_px, view.SMOOTHING, camera.width_px, view.SMOOTHING, 3)
        assert np.array_equal(outside.picture(), plain.reshape(shape).mean(axis=(1, 3)))


def test_a_film_has_frames_for_as_long_as_it_lasts_up_to_a_limit() -> None:
    assert len(view.film_frames(61)) == 16, "two seconds, eight a second"
    assert len(view.film_frames(9000)) == view.MOST_FRAMES
    assert view.film_frames(9000)[[0, -1]].tolist() == [0, 8999]
