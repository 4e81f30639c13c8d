"""Capability maps: telescopes, elbows that bend one way, and maps that are kept."""

from __future__ import annotations

import logging
from pathlib import Path

import mujoco
import numpy as np
import pytest

from taskgist.world.bodies import capability
from taskgist.world.bodies.arm_chain import LOW, SPAN, STEPS, ArmChain, chain_of
from taskgist.world.bodies.capability import CapabilityMap, reach_of, usual_arm
from tools.rooms import Person, Room

MORE = 30_000
TELESCOPE = '<joint name="out" type="slide" axis="1 0 0" range="0 0.5"/>'
ELBOW = '<joint name="elbow" axis="0 -1 0" range="0 150"/>'


def arm(root: str, forearm: str) -> ArmChain:
    """An arm of two links of 0.3 m along x, a palm at its end; joints of the root and of the forearm."""
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><worldbody><body name="torso"><site name="shoulder"/><body name="root">{root}
        <geom type="capsule" size="0.03" fromto="0.05 0 0 0.25 0 0"/><body name="hand" pos="0.3 0 0">{forearm}
        <geom type="capsule" size="0.03" fromto="0.05 0 0 0.25 0 0"/><site name="palm" pos="0.3 0 0"/></body></body>
        </body></worldbody></mujoco>"""
    )
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    indices = {name: int(model.body(name).id) for name in ("root", "hand")} | {"carrier": int(model.body("torso").id)}
    indices |= {name: int(model.site(name).id) for name in ("shoulder", "palm")}
    return chain_of(model, data, indices, np.arange(model.ngeom))


def test_a_telescope_reaches_as_far_as_it_slides() -> None:
    palms = CapabilityMap.of(arm(TELESCOPE, ""), MORE).palms  # of each cell the one nearest to its middle
    assert palms[:, 0].min() == pytest.approx(0.6, abs=0.03)
    assert palms[:, 0].max() == pytest.approx(1.1, abs=0.03)
    assert np.abs(palms[:, 1:]).max() == pytest.approx(0.0, abs=1e-6)


def test_an_elbow_that_bends_upwards_only_reaches_nothing_below() -> None:
    palms = CapabilityMap.of(arm("", ELBOW), MORE).palms
    assert palms[:, 2].min() >= -1e-6
    assert palms[:, 2].max() == pytest.approx(0.3, abs=0.01)


def test_an_eighth_of_a_cell_is_reached_if_its_middle_is_half_a_cell_from_a_palm() -> None:
    """An elbow on a telescope: all palms are known beforehand."""
    found = CapabilityMap.of(arm(TELESCOPE, ELBOW), 10 * MORE)
    out, bent = (each.ravel() for each in np.meshgrid(np.linspace(0, 0.5, 120), np.radians(np.linspace(0, 150, 120))))
    palms = np.stack((0.3 + out + 0.3 * np.cos(bent), np.zeros_like(out), 0.3 * np.sin(bent)), axis=1)
    i, j, k = np.indices([2 * side for side in found.shape]).reshape(3, -1)
    middles = found.corner + (np.column_stack((i, j, k)) + 0.5) * found.cell_m / 2
    away = np.array([np.linalg.norm(palms - middle, axis=1).min() for middle in middles])
    cells = np.ravel_multi_index((i // 2, j // 2, k // 2), found.shape)
    reached = found.eighths[cells] >> (4 * (i % 2) + 2 * (j % 2) + k % 2) & 1 == 1
    assert reached.sum() > 200
    assert (away[reached] <= found.cell_m / 2 + 0.003).all()
    assert (away[~reached] >= found.cell_m / 2 - 0.003).all()


def test_the_same_arm_has_the_same_map_and_mirrored_ones_share_it() -> None:
    one, other = (CapabilityMap.of(arm(TELESCOPE, ELBOW), MORE) for _ in range(2))
    assert np.array_equal(one.configurations, other.configurations)
    agent = Room((), (Person("P1", (0.0, 0.0)),)).scene().agent("P1")
    left, right = agent.arms
    assert left.reach.map is right.reach.map
    assert (left.reach.mirrored, right.reach.mirrored) == (False, True)
    assert left.chain.mirrored().mirrored().digest == left.chain.digest


@pytest.mark.parametrize("stature", [1.5, 1.62, 1.93])
def test_people_of_usual_proportions_share_one_map(stature: float) -> None:
    usual = Room((), (Person("P1", (0.0, 0.0)),)).scene().agent("P1").arm("left")
    other = Room((), (Person("P1", (0.0, 0.0), stature=stature),)).scene().agent("P1").arm("right")
    assert other.reach.map is usual.reach.map
    assert other.reach.scale == pytest.approx(stature / 1.75)


@pytest.mark.parametrize("side", ["left", "right"])
def test_a_shoulder_does_not_do_all_that_its_hinges_would_do_together(side: str) -> None:
    """Upper arms go back as far as shoulders do, and twist by a quarter of a turn from their shortest swing."""
    stage = Room((), (Person("P1", (0.0, 0.0), stature=1.75),)).stage()
    agent, model = stage.scene.agent("P1"), stage.scene.model
    found = agent.arm(side).reach.map
    upper, torso = int(model.body(f"P1/{side}_upper_arm").id), int(model.body("P1/torso").id)
    joints = [agent.joints[f"{side}_shoulder_{name}"] for name in ("flexion", "abduction", "rotation")]
    rows = []
    for steps in found.configurations[::20, :3]:
        angles = found.chain.joints[:3, LOW] + found.chain.joints[:3, SPAN] * steps / STEPS
        stage.show(stage.scene.initial.replace(dict(zip(joints, angles.tolist(), strict=True))))
        turned = stage.body(torso).matrix.T @ stage.body(upper).matrix
        quaternion = np.empty(4)
        mujoco.mju_mat2Quat(quaternion, turned.ravel())
        twist = 2 * np.arctan2(abs(quaternion[3]), abs(quaternion[0]))
        rows.append((*-turned[:, 2], twist))
    x, y, z, twist_deg = np.array(rows).T * ((1.0,), (1.0 if side == "left" else -1.0,), (1.0,), (180 / np.pi,))
    hanging, level = (z < 0) & (np.abs(y) < 0.1), (np.abs(z) < 0.1) & (y > 0)
    assert np.degrees(np.arctan2(-x, -z))[hanging].max() == pytest.approx(50, abs=5)
    assert np.degrees(np.arctan2(-x, y))[level].max() == pytest.approx(45, abs=6)
    assert twist_deg[z < 0.95].max() == pytest.approx(90, abs=1)  # straight up, all twists are one
    assert z.max() > 0.98


def test_the_map_of_people_comes_with_the_package_and_is_the_one_that_would_be_made() -> None:
    """To rounding, which other processors may do otherwise; after a change of the arm: python -m tools.arm_maps."""
    (file,) = capability.SHIPPED.glob("*.npz")
    shipped = capability._kept(usual_arm(), file)
    assert shipped is not None
    assert file.name == capability._file(usual_arm()).name
    made = CapabilityMap.of(usual_arm(), capability.SAMPLES)
    assert (shipped.shape, shipped.cell_m) == (made.shape, made.cell_m)
    bits = np.unpackbits(shipped.eighths ^ made.eighths).sum() / np.unpackbits(made.eighths).sum()
    assert bits < 1e-3
    assert len(shipped.palms) == pytest.approx(len(made.palms), rel=1e-3)
    assert file.stat().st_size < 1_500_000


def test_people_are_answered_without_making_a_map(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    capability.capability.cache_clear()
    with caplog.at_level(logging.INFO, "taskgist.world"):
        assert len(Room((), (Person("P1", (0.0, 0.0), stature=1.62),)).scene().agent("P1").arm("right").reach.map.palms)
    assert "first time" not in caplog.text
    assert not (tmp_path / "taskgist" / "arms").exists()


@pytest.fixture
def kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache, and maps that are made in no time."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(capability, "SAMPLES", MORE + 1)
    capability.capability.cache_clear()
    return tmp_path / "taskgist" / "arms"


def test_maps_are_kept_for_the_next_time(kept: Path, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.INFO, "taskgist.world"):
        made = reach_of(arm(TELESCOPE, ELBOW), "left").map
        assert "first time" in caplog.text
        (file,) = kept.iterdir()
        caplog.clear()
        capability.capability.cache_clear()
        again = reach_of(arm(TELESCOPE, ELBOW), "left").map
        assert caplog.text == ""
    assert file.name.startswith("arm-")
    for name in ("corner", "eighths", "starts", "configurations", "palms"):
        assert np.array_equal(getattr(made, name), getattr(again, name))


@pytest.mark.parametrize("text", [b"", b"no archive", b"PK\x03\x04 damaged"])
def test_a_damaged_map_is_made_anew(kept: Path, text: bytes) -> None:
    made = reach_of(arm(TELESCOPE, ELBOW), "left").map
    (file,) = kept.iterdir()
    file.write_bytes(text)
    capability.capability.cache_clear()
    assert np.array_equal(reach_of(arm(TELESCOPE, ELBOW), "left").map.palms, made.palms)


def test_a_map_whose_parts_do_not_fit_is_made_anew(kept: Path) -> None:
    made = reach_of(arm(TELESCOPE, ELBOW), "left").map
    (file,) = kept.iterdir()
    arrays = dict(np.load(file))
    arrays["starts"] = arrays["starts"] + 5
    np.savez(file, **arrays)
    capability.capability.cache_clear()
    assert np.array_equal(reach_of(arm(TELESCOPE, ELBOW), "left").map.starts, made.starts)


def test_without_a_cache_maps_are_made_each_time(kept: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", "/dev/null/nowhere")
    assert len(reach_of(arm(TELESCOPE, ELBOW), "left").map.palms)
    assert not kept.exists()
