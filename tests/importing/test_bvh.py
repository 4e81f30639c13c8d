"""BVH: joints move as their channels say, whatever their order; and what the file leaves open is found out or asked."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from taskgist.errors import MappingError
from taskgist.importing import load_mapping, look, mapping_text, read_take, read_tracks
from taskgist.importing.formats.bvh import read_bvh
from taskgist.world.geometry.transforms import matrix_from_wxyz
from tests.importing.skeletons import Array

Joint = tuple[str, str, tuple[float, float, float]]
"""Name, name of the parent, offset in centimetres: y up, facing z, so that the left is at +x."""


def _arm(side: str, sign: float, names: Sequence[str]) -> list[Joint]:
    arm, forearm, hand = names
    return [
        (f"{side}{arm}", "Spine", (18.0 * sign, 22.0, 0.0)),
        (f"{side}{forearm}", f"{side}{arm}", (28.0 * sign, 0.0, 0.0)),
        (f"{side}{hand}", f"{side}{forearm}", (25.0 * sign, 0.0, 0.0)),
    ]


def _leg(side: str, sign: float, names: Sequence[str]) -> list[Joint]:
    thigh, shank, foot, toe = names
    return [
        (f"{side}{thigh}", "Hips", (9.0 * sign, -8.0, 0.0)),
        (f"{side}{shank}", f"{side}{thigh}", (0.0, -42.0, 0.0)),
        (f"{side}{foot}", f"{side}{shank}", (0.0, -41.0, 0.0)),
        (f"{side}{toe}", f"{side}{foot}", (0.0, -5.0, 13.0)),
    ]


def skeleton(names: str = "humanik") -> list[Joint]:
    arm, leg = {
        "humanik": (("Arm", "ForeArm", "Hand"), ("UpLeg", "Leg", "Foot", "ToeBase")),
        "biovision": (("Shoulder", "Elbow", "Wrist"), ("Hip", "Knee", "Ankle", "Toe")),
    }[names]
    joints: list[Joint] = [("Hips", "", (0.0, 0.0, 0.0)), ("Spine", "Hips", (0.0, 20.0, 0.0))]
    joints += [("Head", "Spine", (0.0, 35.0, 2.0))]
    for side, sign in (("Left", 1.0), ("Right", -1.0)):
        joints += _arm(side, sign, arm) + _leg(side, sign, leg)
    return joints


def written(
    path: Path,
    joints: Sequence[Joint],
    frames: Array,
    *,
    order: str = "ZXY",
    six: bool = False,
    prefix: str = "",
    scale: float = 1.0,
) -> Path:
    """A BVH whose frames (n, 3 + 3 · joints) are the root's place and each joint's turns in degrees."""
    lines, depth = ["HIERARCHY"], 0
    children = {name: [joint for joint in joints if joint[1] == name] for name in ("", *(j[0] for j in joints))}

    def describe(joint: Joint) -> None:
        nonlocal depth
        name, parent, offset = joint
        indent = "\t" * depth
        channels = " ".join(f"{axis}rotation" for axis in order)
        places = "Xposition Yposition Zposition "
        lines.append(f"{indent}{'JOINT' if parent else 'ROOT'} {prefix}{name}")
        lines.append(f"{indent}{{")
        lines.append(f"{indent}\tOFFSET {' '.join(str(scale * value) for value in offset)}")
        lines.append(
            f"{indent}\tCHANNELS {6 if six or not parent else 3} {places if six or not parent else ''}{channels}"
        )
        depth += 1
        for child in children[name]:
            describe(child)
        if not children[name]:
            lines.extend([f"{indent}\tEnd Site", f"{indent}\t{{", f"{indent}\t\tOFFSET 0 1 0", f"{indent}\t}}"])
        depth -= 1
        lines.append(f"{indent}}}")

    def depth_first(name: str) -> list[Joint]:
        return [j for child in children[name] for j in (child, *depth_first(child[0]))]

    describe(children[""][0])
    lines += ["MOTION", f"Frames: {len(frames)}", "Frame Time: 0.0333333"]
    index = {joint[0]: k for k, joint in enumerate(joints)}
    for row in frames:
        cells: list[float] = []
        for name, parent, offset in depth_first(""):
            if six or not parent:
                cells += [scale * value for value in (offset if parent else row[:3])]
            cells += list(row[3 + 3 * index[name] : 6 + 3 * index[name]])
        lines.append(" ".join(f"{value:.6f}" for value in cells) + " ")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def motion(joints: Sequence[Joint], seed: int = 0, frames: int = 8) -> Array:
    """Somebody who stands at 95 cm and moves all joints a little."""
    turns = np.random.default_rng(seed).uniform(-20.0, 20.0, size=(frames, 3 * len(joints)))
    turns[:, :3] *= 0.3
    return np.hstack([np.tile((10.0, 96.0, 30.0), (frames, 1)), turns])


def slowly(joints: Sequence[Joint], row: Array, order: str) -> dict[str, Array]:
    """Where joints are: the obvious way, one after the other, one turn at a time."""
    places: dict[str, Array] = {}
    turns: dict[str, Array] = {}
    for k, (name, parent, offset) in enumerate(joints):
        turn = np.eye(3)
        for axis, degrees in zip(order, row[3 + 3 * k : 6 + 3 * k], strict=True):
            c, s, i = np.cos(np.radians(degrees)), np.sin(np.radians(degrees)), "XYZ".index(axis)
            one = np.eye(3)
            j, m = (i + 1) % 3, (i + 2) % 3
            one[j, j], one[m, m], one[j, m], one[m, j] = c, c, -s, s
            turn = turn @ one
        above = turns.get(parent, np.eye(3))
        places[name] = places[parent] + above @ np.array(offset) if parent else row[:3]
        turns[name] = above @ turn
    return places


@pytest.mark.parametrize("order", ["ZXY", "XYZ", "YXZ", "ZYX"])
@pytest.mark.parametrize("six", [False, True])
def test_joints_are_where_their_channels_put_them(tmp_path: Path, order: str, six: bool) -> None:
    joints = skeleton()
    frames = motion(joints)
    take = read_take(written(tmp_path / "a.bvh", joints, frames, order=order, six=six), "bvh")
    for k, row in enumerate(frames):
        for name, place in slowly(joints, row, order).items():
            np.testing.assert_allclose(take.tracks[name].position[k], place, atol=1e-4)
    np.testing.assert_allclose(take.tracks["Head"].times_s[-1], 7 * 0.0333333)


def test_pybvh_reads_the_same(tmp_path: Path) -> None:
    """An independent reader, which the tests need and users do not."""
    pybvh = pytest.importorskip("pybvh")
    joints = skeleton()
    path = written(tmp_path / "a.bvh", joints, motion(joints))
    take, theirs = read_take(path, "bvh"), pybvh.read_bvh_file(str(path), world_up="+y")
    places = theirs.node_positions()
    for name in theirs.joint_names:
        node = theirs.node_index[name] if isinstance(theirs.node_index, dict) else theirs.node_index(name)
        np.testing.assert_allclose(take.tracks[name].position, places[:, node], atol=1e-3)


@pytest.mark.parametrize(("names", "prefix"), [("humanik", ""), ("humanik", "mixamorig:"), ("biovision", "")])
@pytest.mark.parametrize(("scale", "unit"), [(1.0, "cm"), (0.01, "m"), (1 / 2.54, "inch")])
def test_a_person_of_a_bvh(tmp_path: Path, names: str, prefix: str, scale: float, unit: str) -> None:
    """Its unit follows from its forearms, its face from the head's own axes."""
    joints = skeleton(names)
    path = written(tmp_path / "walk.bvh", joints, motion(joints), prefix=prefix, scale=scale)
    proposal = look(path)
    assert [subject.skeleton for subject in proposal.people] == [names]
    assert (proposal.unit.value, proposal.up.value, proposal.open) == (unit, "y", ())
    mapping = tmp_path / "walk.toml"
    mapping.write_text(mapping_text(proposal, "walk.bvh"), encoding="utf-8")
    person = read_tracks(load_mapping(mapping)).people[proposal.people[0].name]
    wrist = person.points["left_wrist"]
    truth = np.array(
        [slowly(joints, row, "ZXY")[f"Left{'Hand' if names == 'humanik' else 'Wrist'}"] for row in motion(joints)]
    )
    np.testing.assert_allclose(wrist[0], 0.01 * truth[0, [2, 0, 1]] * (-1, -1, 1), atol=1e-3)
    head = read_take(path, "bvh").tracks[f"{prefix}Head"].wxyz
    assert head is not None
    forward = matrix_from_wxyz(head)[0, :, 2]  # a head's own z, in the file's axes
    np.testing.assert_allclose(person.directions["face"][0], forward[[2, 0, 1]] * (-1, -1, 1), atol=1e-3)
    assert {"left_palm", "right_thumb"} <= person.directions.keys()


def test_a_rest_pose_that_lies_gives_places_only(tmp_path: Path) -> None:
    """Some files have all bones along x at rest: a head's own axes then say nothing of its face."""
    joints = [(name, parent, (float(np.linalg.norm(offset)), 0.0, 0.0)) for name, parent, offset in skeleton()]
    take = read_take(written(tmp_path / "a.bvh", joints, motion(joints)), "bvh")
    assert all(track.wxyz is None for track in take.tracks.values())
    assert "rest pose" in take.notes[0]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("Frames: 8", "Frames: 80", r"a.bvh: Frames: holds 8 of 80 frames; .*cut off"),
        ("Frame Time: 0.0333333", "Frame Time: 0", r"line \d+: Frame Time: must be a positive number \(got ' 0'\)"),
        ("OFFSET 0.0 20.0 0.0", "OFFSET 0.0 20.0", r"line 8: OFFSET: must be three numbers"),
        ("CHANNELS 3 Z", "CHANNELS 4 Z", r"line 9: CHANNELS: cannot be understood"),
        ("MOTION", "", r"cannot be understood \(got 'Frames: 8'\)"),
        ("96.000000", "96,0", r"line \d+: column Hips Yposition: is no number \(got '96,0'\)"),
        ("96.000000", "1e400", r"row 1 of numbers: column Hips Yposition: is too large"),
        ("OFFSET 0.0 20.0 0.0", "OFFSET 0.0 1e300 0.0", r"line 8: OFFSET: must be three numbers"),
        ("JOINT Head", "JOINT Spine", r"two joints have one name \(got 'Spine'\)"),
    ],
)
def test_what_is_wrong_is_told_by_line(tmp_path: Path, old: str, new: str, message: str) -> None:
    joints = skeleton()
    path = written(tmp_path / "a.bvh", joints, motion(joints))
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(MappingError, match=message):
        read_bvh(path, str(path), 2**20)
