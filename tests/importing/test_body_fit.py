"""Bodies fitted to keypoints of bodies that are known: posed models stand in for people."""

from pathlib import Path

import numpy as np
import pytest

from taskgist.importing import import_recording, load_mapping
from taskgist.importing.sizes import estimate_size, stands
from taskgist.recording import Recording, read, write
from taskgist.settings import DEFAULT
from taskgist.world import Fitter, Scene, Stage, posture_of
from taskgist.world.geometry.transforms import about_z, matrix_from_wxyz
from tests.importing.skeletons import NAMES as KEYPOINTS
from tests.importing.skeletons import standing
from tests.scenes import CHAIR, agent, scene

STATURE_M = 1.68
FRAMES = 24
NOISE_M = 0.005
SIDED = ("shoulder", "elbow", "wrist", "fingertip", "hip", "knee", "ankle", "heel", "toe", "eye", "ear")
NAMES = ["pelvis", "neck", "head", "nose", *(f"{side}_{name}" for side in ("left", "right") for name in SIDED)]


def person(posture: str) -> tuple[Scene, np.ndarray]:
    """A person who reaches out and looks at the hand: the scene and the true positions (frames, nq)."""
    chair = CHAIR if posture == "sitting" else ""
    room = scene(chair, agents=agent("P1", -0.95, 0, posture=posture, extra=f"body = {{ stature_m = {STATURE_M} }}"))
    fitter = Fitter(room, "P1", moving="trunk_and_arms")
    state, states = room.initial, []
    shoulder = Stage(room).shoulder(room.agent("P1").arm("right")).position
    for frame in range(FRAMES):
        hand = shoulder + (0.25 + 0.01 * frame, 0.1, -0.35 + 0.01 * frame)
        face = (1.0, 0.02 * frame, -0.4)
        state = fitter.fit(state, points={"right_wrist": hand}, directions={"face": face}).state
        states.append(state.qpos)
    return room, np.array(states)


def keypoints(room: Scene, states: np.ndarray) -> np.ndarray:
    """The landmarks of those states as a noisy tracker gives them, (frames, points, 3)."""
    stage, noise = Stage(room), np.random.default_rng(7)
    sites = [room.model.site(f"P1/{name}").id for name in NAMES]
    truth = [[stage.show(room.initial.replace(at=slice(None), to=q)).site(s).position for s in sites] for q in states]
    return np.array(truth) + noise.normal(scale=NOISE_M, size=(len(states), len(NAMES), 3))


def imported(folder: Path, points: np.ndarray, names: list[str] = NAMES, extra: str = "", after: str = "") -> Recording:
    np.savez(folder / "points.npz", points=points)
    mapping = folder / "mapping.toml"
    mapping.write_text(
        '[sources.tracker]\nfile = "points.npz"\narray = "points"\nlayout = ["time", "{point}", "value"]\n'
        f'names = {NAMES!r}\nrate_hz = 30\nunits = "m"\n'.replace("'", '"')
        + '[people.P1]\nsource = "tracker"\n'
        + extra
        + "[people.P1.points]\n"
        + "".join(f'{name} = "{name}"\n' for name in names)
        + after
    )
    return import_recording(load_mapping(mapping))


@pytest.fixture(scope="module", params=["standing", "sitting"])
def known(request: pytest.FixtureRequest) -> tuple[str, Scene, np.ndarray]:
    return (request.param, *person(request.param))


def test_hands_gaze_size_and_posture_come_back(known: tuple[str, Scene, np.ndarray], tmp_path: Path) -> None:
    posture, room, states = known
    recording = imported(tmp_path, keypoints(room, states))
    truth, fitted = Stage(room), Stage(recording.scene)
    body, copy = room.agent("P1"), recording.scene.agent("P1")
    assert copy.stature_m == pytest.approx(STATURE_M, abs=0.06)
    for frame in range(FRAMES):
        truth.show(room.initial.replace(at=slice(None), to=states[frame]))
        fitted.show(recording.state(frame))
        for side in ("left", "right"):
            for point in ("wrist", "fingertip"):
                places = [s.scene.model.site(f"P1/{side}_{point}").id for s in (truth, fitted)]
                assert np.linalg.norm(truth.site(places[0]).position - fitted.site(places[1]).position) < 0.03
        eyes = truth.eye(body), fitted.eye(copy)
        assert np.linalg.norm(eyes[0].position - eyes[1].position) < 0.03
        assert eyes[0].matrix[:, 0] @ eyes[1].matrix[:, 0] > np.cos(np.radians(10))  # ears and nose, 5 mm off each
        assert posture_of(fitted, copy, DEFAULT.contact) == posture
    errors = recording.provenance.fit["P1"]["points_cm"]
    assert errors["right_wrist"]["median"] < 1.5


LEGLESS = [n for n in NAMES if not n.endswith(("knee", "ankle", "heel", "toe"))]
SEAT = """
[supports.stool]
size_m = [0.4, 0.4, 0.05]
position_m = [-0.95, 0.0, 0.43]
"""


def test_legs_that_were_not_tracked_are_estimated(known: tuple[str, Scene, np.ndarray], tmp_path: Path) -> None:
    posture, room, states = known
    recording = imported(tmp_path, keypoints(room, states), LEGLESS, after=SEAT if posture == "sitting" else "")
    fitted = Stage(recording.scene, recording.state(5))
    assert posture_of(fitted, recording.scene.agent("P1"), DEFAULT.contact) == posture
    assert any("legs" in note and "estimated" in note for note in recording.provenance.notes)


def test_low_hips_over_no_seat_do_not_sit(tmp_path: Path) -> None:
    """They may crouch, or the floor is elsewhere: the posture is unknown, and a note says so."""
    room, states = person("sitting")
    recording = imported(tmp_path, keypoints(room, states), LEGLESS)
    fitted = Stage(recording.scene, recording.state(5))
    assert posture_of(fitted, recording.scene.agent("P1"), DEFAULT.contact) is None
    assert any("no seat beneath" in note for note in recording.provenance.notes)


def test_lost_parts_are_unknown_in_their_frames_only(tmp_path: Path) -> None:
    room, states = person("standing")
    points = keypoints(room, states)
    gone = [NAMES.index(f"right_{name}") for name in ("wrist", "fingertip")]
    points[5:20, gone] = np.nan
    recording = imported(tmp_path, points)
    assert "P1/right_arm" not in recording.state(0).untracked
    assert "P1/right_arm" in recording.state(12).untracked
    assert "P1/left_arm" not in recording.state(12).untracked


def test_a_declared_unknown_hand_stays_unknown(tmp_path: Path) -> None:
    room, states = person("standing")
    extra = 'unknown = { left_arm = "hidden behind the table" }\n'
    recording = imported(tmp_path, keypoints(room, states), extra=extra)
    assert all("P1/left_arm" in recording.state(i).untracked for i in range(FRAMES))
    assert any("hidden behind the table" in note for note in recording.provenance.notes)


def test_declared_unknown_legs_have_no_posture(tmp_path: Path) -> None:
    room, states = person("sitting")
    extra = 'unknown = { legs = "swapped by the tracker" }\n'
    recording = imported(tmp_path, keypoints(room, states), extra=extra)
    fitted = Stage(recording.scene, recording.state(5))
    assert "P1/legs" in recording.state(5).untracked
    assert posture_of(fitted, recording.scene.agent("P1"), DEFAULT.contact) is None


def test_a_body_that_only_has_a_trunk_and_a_head(tmp_path: Path) -> None:
    room, states = person("standing")
    few = ["pelvis", "neck", "head", "left_shoulder", "right_shoulder"]
    recording = imported(tmp_path, keypoints(room, states), few)
    assert {"P1/head", "P1/left_arm", "P1/right_arm"} <= recording.state(3).untracked  # no face direction, no hands


def test_sizes_are_measured_between_landmarks() -> None:
    room, states = person("standing")
    points = dict(zip(NAMES, np.moveaxis(keypoints(room, states), 1, 0), strict=True))
    size = estimate_size(points, None)
    assert size.upper_arm_m == pytest.approx(0.186 * STATURE_M, abs=0.01)
    assert size.forearm_m == pytest.approx(0.146 * STATURE_M, abs=0.01)
    assert stands(points).all()
    assert estimate_size(points, 1.9).stature_m == 1.9


def test_an_imported_recording_survives_the_disk(tmp_path: Path) -> None:
    room, states = person("sitting")
    recording = imported(tmp_path, keypoints(room, states))
    write(recording, tmp_path / "a.mcap")
    again = read(tmp_path / "a.mcap")
    np.testing.assert_allclose(again.qpos, recording.qpos, atol=2e-4)
    assert again.scene.agent("P1").stature_m == recording.scene.agent("P1").stature_m


def test_a_body_is_fitted_alike_whichever_way_it_faces() -> None:
    """Targets that no body meets exactly weigh the same for all headings."""
    rng = np.random.default_rng(5)
    room = scene(agents=agent("P1", 0.0, 0.0))
    names = ["pelvis", "nose", *(f"{side}_{part}" for side in ("left", "right") for part in SIDED[:3])]
    body = standing()[[KEYPOINTS.index(name.upper()) for name in names]] + rng.normal(scale=0.03, size=(len(names), 3))
    start, base = room.initial, room.base_slice("P1")
    joints = []
    for yaw in (0.0, 1.0, np.pi, -2.0):
        turned = body @ matrix_from_wxyz(about_z(yaw)).T
        facing = start.replace(at=base, to=(*start.qpos[base][:3], *about_z(yaw)))
        fit = Fitter(room, "P1").fit(facing, points=dict(zip(names, turned, strict=True)), iterations=200)
        joints.append(fit.state.qpos[room.joint_indices("P1")])
    assert np.degrees(np.ptp(joints, axis=0)).max() < 0.1
