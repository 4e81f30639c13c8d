"""Steps of a fit: bodies are where MuJoCo says, and what is met is met as by mink's quadratic programs."""

from __future__ import annotations

import math
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from benchmarks.peers.mink_fit import MinkFitter
from taskgist.common.arrays import Array
from taskgist.common.compiled import compiled
from taskgist.errors import SceneError
from taskgist.world import Fitter, Scene
from taskgist.world.fit import Marker, joint_tree
from taskgist.world.fit_steps import solve_positive
from tests.scenes import agent, scene

POINTS = ("left_wrist", "right_wrist", "left_elbow", "right_elbow", "nose", "left_shoulder", "right_shoulder", "pelvis")
LEGS = ("left_knee", "right_knee", "left_ankle", "right_ankle")
MARKERS = {
    "band": Marker("right_wrist", (0.05, -0.03, -0.10)),
    "strap": Marker("left_elbow", (0.0, 0.07, 0.02), axes="left_shoulder"),
}


@pytest.fixture(scope="module")
def room() -> Scene:
    return scene(agents=agent("P1", 0.3, -0.2, yaw_deg=70))


def somewhere(room: Scene, rng: np.random.Generator, name: str = "P1") -> Array:
    """Positions within the joints' ranges, the root anywhere, (nq,)."""
    qpos, body = np.array(room.initial.qpos), room.agent(name)
    turn = rng.normal(size=4)
    qpos[body.base] = (*rng.uniform(-1.0, 1.0, 3), *(turn / np.linalg.norm(turn)))
    for joint, column in body.joints.items():
        limits = room.model.joint(f"{name}/{joint}")
        low, high = limits.range if limits.limited[0] else (-math.pi, math.pi)
        qpos[column] = rng.uniform(low, high)
    return qpos


@pytest.mark.parametrize("profile", ["human", "jido", "hrp2"])
def test_features_are_where_mujoco_says(profile: str) -> None:
    room = scene(agents=agent("R", 0.0, 0.0, extra=f'profile = "{profile}"'))
    rng, data = np.random.default_rng(1), mujoco.MjData(room.model)
    sites = [str(room.model.site(s).name) for s in range(room.model.nsite) if room.model.site(s).name.startswith("R/")]
    names = [name.removeprefix("R/") for name in sites]
    axes = {f"{name} x": (name, (1.0, 0.0, 0.0)) for name in names}
    fitter = Fitter(room, "R", axes=axes)
    features = fitter.features(names, axes)
    for _ in range(5):
        qpos = somewhere(room, rng, "R")
        data.qpos[:] = qpos
        mujoco.mj_kinematics(room.model, data)
        truth = [*(data.site(site).xpos for site in sites), *(data.site(site).xmat[::3] for site in sites)]
        np.testing.assert_allclose(fitter.places(features, qpos[None])[0], truth, atol=1e-9)


def targets_of(
    room: Scene, names: tuple[str, ...], directions: tuple[str, ...], rng: np.random.Generator, *, noise_m: float
) -> tuple[dict[str, Array], dict[str, Array]]:
    """Where points are and directions point in some posture, with noise on the places."""
    fitter = Fitter(room, "P1", markers=MARKERS)
    places = fitter.places(fitter.features(names, directions), somewhere(room, rng)[None])[0]
    points = {name: place + rng.normal(scale=noise_m, size=3) for name, place in zip(names, places, strict=False)}
    return points, dict(zip(directions, places[len(names) :], strict=True))


WHOLE = (*POINTS, *LEGS, *MARKERS)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize(
    ("moving", "root", "names", "directions"),
    [
        ("body", True, WHOLE, ("face", "left_hand", "pelvis_up")),
        ("body", True, ("pelvis", "left_wrist", "nose"), ()),
        ("upper_body", True, POINTS, ("face",)),
        ("arms", False, ("left_wrist", "right_wrist", "band"), ("left_palm", "right_hand")),
        ("arms", False, (), ("left_palm", "left_hand")),
    ],
)
def test_fits_are_those_of_quadratic_programs(
    room: Scene, seed: int, moving: str, root: bool, names: tuple[str, ...], directions: tuple[str, ...]
) -> None:
    """Targets of a posture anywhere, from one that is a little aside: limits hold, and not all can be met."""
    rng = np.random.default_rng(seed)
    points, aimed = targets_of(room, names, directions, rng, noise_m=0.05)
    weights = {"left_wrist": 2.0, "nose": 0.5, "face": 3.0}
    ours = Fitter(room, "P1", moving=moving, root=root, weights=weights, markers=MARKERS)
    witness = MinkFitter(room, "P1", moving=moving, root=root, weights=weights, markers=MARKERS)
    features = ours.features(points, aimed)
    targets, start = np.array([*points.values(), *aimed.values()]), np.array(room.initial.qpos)
    for iterations in (1, 3, 40):
        found = ours.settle(features, start, targets, rest=room.initial.qpos, iterations=iterations)
        expected, _ = witness.fit(start, points, aimed, rest=room.initial.qpos, iterations=iterations)
        np.testing.assert_allclose(found, expected, atol=1e-5)


def test_a_target_that_is_not_known_is_left_out(room: Scene) -> None:
    rng = np.random.default_rng(3)
    points, _ = targets_of(room, POINTS, (), rng, noise_m=0.0)
    fitter, start, rest = Fitter(room, "P1"), room.initial.qpos, room.initial.qpos
    features, targets = fitter.features(points), np.array(list(points.values()))
    targets[2, 1] = np.nan
    few = fitter.features([name for name in points if name != POINTS[2]])
    found = fitter.settle(features, start, targets, rest=rest, iterations=30)
    without = fitter.settle(few, start, np.delete(targets, 2, axis=0), rest=rest, iterations=30)
    np.testing.assert_allclose(found, without, atol=1e-7)
    assert np.isnan(fitter.errors(features, found[None], targets[None])[0, 2])


def test_joints_out_of_reach_of_their_targets_stop_at_their_limits(room: Scene) -> None:
    """An elbow that would have to bend backwards stays straight, and comes no nearer to its limit than it may."""
    joint = room.model.joint("P1/right_elbow")
    fitter = Fitter(room, "P1", moving=["right_elbow"])
    start = room.initial.replace({int(joint.qposadr[0]): 0.3})
    forward = fitter.fit(start, directions={"right_hand": (-1.0, 0.0, -1.0)}, iterations=60).state
    assert joint.range[0] <= forward.qpos[joint.qposadr[0]] < 1e-3


def test_a_ball_is_refused() -> None:
    """A robot that turns one of its bodies by a ball."""
    room = scene(agents=agent("P1", 0.0, 0.0))
    spec = mujoco.MjSpec.from_string(
        '<mujoco><worldbody><body name="P1/a"><freejoint/><geom size="1"/><body name="P1/b"><joint name="P1/neck" '
        'type="ball"/><geom size="1"/></body></body></worldbody></mujoco>'
    )
    body = replace(room.agent("P1"), bodies=np.array([1, 2]), base=slice(0, 7))
    with pytest.raises(SceneError, match=r"P1: joint: .* \(got \'P1/neck\'\); make it of hinges"):
        joint_tree(spec.compile(), body)


@pytest.mark.parametrize("count", [1, 2, 7, 38])
def test_positive_equations_are_solved(count: int) -> None:
    rng = np.random.default_rng(count)
    factor, right, found = rng.normal(size=(count + 2, count)), rng.normal(size=count), np.empty(count)
    normal = factor.T @ factor
    solved(normal, right, found)
    np.testing.assert_allclose(found, np.linalg.solve(normal, right), rtol=1e-9, atol=1e-12)


@compiled
def solved(normal: Array, right: Array, found: Array) -> None:
    solve_positive(normal, right, found, len(right))
