"""Robots in recordings: where the base stands and how the joints are, from tracked frames and published joint states.

The base stands on the floor, so that of its tracked frame the place on it and the heading count. Joints that nobody
published stay at rest, but for those that the model has follow another one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import mujoco
import numpy as np

from taskgist.common.arrays import Array, Mask
from taskgist.common.text import shortened
from taskgist.errors import MappingError
from taskgist.importing.mapping import FixedPose, ImportMapping, JointColumns, Robot
from taskgist.importing.resampling import percent, resample, series_at
from taskgist.importing.table_values import Track
from taskgist.importing.tables import Tables
from taskgist.world.bodies.agent import couplings
from taskgist.world.geometry.transforms import about_z, rotate
from taskgist.world.scene import Scene
from taskgist.world.scene_file import AgentEntry

SLACK = 0.1
"""How far beyond its model's limits a joint may be published, radians or metres: calibrations differ (ours)."""


@dataclass(frozen=True, eq=False)
class RobotTrack:
    """One robot over time.

    Attributes:
        profile: Its profile: a built-in one, or a file.
        position_m: Floor point of its base, (N, 2); NaN where unknown.
        yaw_rad: Its heading, (N,); NaN where unknown.
        joints: Angles (radians) or places (metres) of the joints that were published, by name, (N,) each; NaN where
            unknown.
        known: Frames in which base and published joints are known, (N,).
        silent: Its joints that nobody published and that follow no other.
    """

    profile: str
    position_m: Array
    yaw_rad: Array
    joints: Mapping[str, Array]
    known: Mask
    silent: tuple[str, ...]


def robot_entry(name: str, profile: str) -> AgentEntry:
    """A robot as an agent of a scene; its frames are placed by their own numbers."""
    return AgentEntry(name, profile=profile)


def joint_names(profile: str) -> tuple[str, ...]:
    """Names of the joints of a robot.

    Args:
        profile: A built-in profile, or a file.

    Raises:
        SceneError: It, or its model, cannot be read.
    """
    return Scene.from_spec(mujoco.MjSpec(), [robot_entry("R1", profile)]).joints("R1")


@dataclass(frozen=True, eq=False)
class RobotSamples:
    """What the sources hold of a robot.

    Attributes:
        robot: What the mapping says.
        base: Samples of its base; None where it stands still.
        joints: Times in seconds and values, (n,) each, of the joints that were published, by name.
        silent: Joints that were not.
    """

    robot: Robot
    base: Track | None
    joints: Mapping[str, tuple[Array, Array]]
    silent: tuple[str, ...]

    @property
    def spans_s(self) -> list[tuple[float, float]]:
        """First and last time of each of its sources."""
        times = [*([] if self.base is None else [self.base.times_s]), *(times_s for times_s, _ in self.joints.values())]
        return [(float(times_s[0]), float(times_s[-1])) for times_s in times]


def robot_samples(robot: Robot, tables: Tables, mapping: ImportMapping) -> RobotSamples:
    """Read what the sources hold of a robot.

    Raises:
        MappingError: No joint of it is there; one is far beyond its limits; the base's point does not say which way it
            faces.
        SceneError: Its profile or model cannot be read.
    """
    scene = Scene.from_spec(mujoco.MjSpec(), [robot_entry(robot.name, robot.profile)], where=str(mapping.file))
    field = f"robots.{robot.name}"
    base = None if isinstance(robot.pose, FixedPose) else tables.track(robot.pose, robot.name)
    if base is not None and base.wxyz is None:
        hint = "add the rotation to its source, or take a frame that has one"
        raise MappingError("a bare point does not say which way it faces", where=mapping.file, field=field, hint=hint)
    names = scene.joints(robot.name)
    joints = {} if robot.joints is None else _published(scene, robot, robot.joints, tables, mapping)
    followers = {str(scene.model.joint(each.follower).name).partition("/")[2] for each in couplings(scene.model)}
    return RobotSamples(robot, base, joints, tuple(name for name in names if name not in {*joints, *followers}))


def _published(
    scene: Scene, robot: Robot, columns: JointColumns, tables: Tables, mapping: ImportMapping
) -> dict[str, tuple[Array, Array]]:
    known = tables.columns(columns.source)
    found: dict[str, tuple[Array, Array]] = {}
    for name in scene.joints(robot.name):
        column = columns.column.replace("{joint}", name)
        if column not in known:
            continue
        joint = scene.model.joint(f"{robot.name}/{name}")
        turns = int(joint.type[0]) == int(mujoco.mjtJoint.mjJNT_HINGE)
        times_s, values = tables.column(columns.source, column)
        found[name] = times_s, values * (columns.unit_rad if turns else 1.0)
        _check_limits(joint, turns, found[name][1], f"{mapping.file}: robots.{robot.name}.joints", name)
    if not found:
        wanted = ", ".join(scene.joints(robot.name)[:6])
        hint = f"its joints are {wanted}, ...; the source has {', '.join(sorted(known)[:6])}, ...: say column"
        where, field = mapping.file, f"robots.{robot.name}.joints"
        raise MappingError("none of its joints is in the source", where=where, field=field, hint=hint)
    return found


def _check_limits(joint: mujoco.MjModel, turns: bool, values: Array, where: str, name: str) -> None:
    low, high = (float(limit) for limit in joint.range)
    if not joint.limited[0] or not np.isfinite(values).any():
        return
    middle = float(np.nanmedian(values))
    if not low - SLACK <= middle <= high + SLACK:
        unit = "rad" if turns else "m"
        hint = f'it goes from {low:.3g} to {high:.3g} {unit}: check unit ("rad" or "deg"), column and profile'
        raise MappingError("beyond its joint", where=where, field=name, value=f"{middle:.3g} {unit}", hint=hint)


def tracked_robot(samples: RobotSamples, frames_s: Array, mapping: ImportMapping) -> RobotTrack:
    """A robot at the frames of a recording.

    Args:
        samples: What the sources hold of it.
        frames_s: Times of the frames, (N,), in the time of the sources.
        mapping: The whole mapping.
    """
    max_gap_s = mapping.timeline.max_gap_s
    pose = samples.robot.pose
    if isinstance(pose, FixedPose):
        position_m = np.tile(pose.position_m[:2], (len(frames_s), 1))
        yaw_rad = np.full(len(frames_s), pose.yaw_rad)
    else:
        assert samples.base is not None
        frames = resample(samples.base, frames_s, max_gap_s=max_gap_s)
        assert frames.wxyz is not None
        ahead = rotate(frames.wxyz, (1.0, 0.0, 0.0))
        position_m, yaw_rad = frames.position_m[:, :2], np.arctan2(ahead[:, 1], ahead[:, 0])
    joints = {
        name: series_at(times_s, values, frames_s, max_gap_s=max_gap_s)
        for name, (times_s, values) in samples.joints.items()
    }
    numbers = np.column_stack([position_m, yaw_rad, *joints.values()])
    known = np.asarray(np.isfinite(numbers).all(axis=1))
    profile = samples.robot.profile
    return RobotTrack(profile, position_m, yaw_rad, MappingProxyType(joints), known, samples.silent)


def robot_positions(scene: Scene, name: str, track: RobotTrack) -> Array:
    """Positions of a scene's robot, (N, nq): its own columns are those of the track, where it is known.

    Args:
        scene: The scene.
        name: The robot.
        track: The robot over time.
    """
    qpos = np.tile(scene.initial.qpos, (len(track.known), 1))
    base = scene.base_slice(name)
    qpos[:, base.start : base.start + 2] = track.position_m
    qpos[:, base.start + 3 : base.stop] = [about_z(yaw_rad) for yaw_rad in track.yaw_rad]
    agent = scene.agent(name)
    for joint, values in track.joints.items():
        qpos[:, agent.joints[joint]] = values
    for coupling in couplings(scene.model):
        leader, follower = (str(scene.model.joint(j).name) for j in (coupling.leader, coupling.follower))
        owner, _, joint = follower.partition("/")
        if owner == name and joint not in track.joints and joint in agent.joints:
            qpos[:, agent.joints[joint]] = coupling.led(scene.model, qpos[:, agent.joints[leader.partition("/")[2]]])
    return qpos


def robot_notes(name: str, track: RobotTrack) -> list[str]:
    """What a user should know of a robot: joints that nobody published, and frames in which it is unknown."""
    notes = []
    if track.silent:
        shown = shortened(track.silent, 8)
        notes.append(f"{name}: nobody published {len(track.silent)} of its joints, which stay at rest: {shown}")
    if not track.known.all():
        notes.append(f"{name} is unknown in {percent(~track.known)} % of the frames")
    return notes
