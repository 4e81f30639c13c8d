"""What other programs take from a performance: trajectories for a robot's controllers, the plan, positions for MuJoCo.

Three documents, one clock: time 0 is the first frame of the recording, and all joints are named as in the body's own
model, without the agent's prefix, so that they are those of its URDF.

``robot_trajectory``
    Messages as ROS 2 has them. Joints that one controller drives are one ``trajectory_msgs/JointTrajectory``: each
    arm, the torso (lifts), each gripper. The base is a ``trajectory_msgs/MultiDOFJointTrajectory``, whose only joint
    is planar: x, y and yaw in the frame "world". Frames in which nothing of a group moves are left out: its velocity
    is zero on both sides of such a gap, so that a controller, which interpolates by cubics, stays where it is.
``plan_document``
    Action by action who brings what where, and what for; phase by phase when it begins and ends, what is attached to
    which hand and what is let go, and where base, palm, joints and thing are at its end; the grasp; where the robot
    stands meanwhile.
``write_positions``
    Every frame as MuJoCo's ``qpos``, with the model of the whole scene: a file that numpy and MuJoCo read without
    taskgist.

Example::

    found = outcome.performances[0]
    document = robot_trajectory(found.plan, found.execution)
    arm = document["joint_trajectories"]["right_arm"]        # for FollowJointTrajectory
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import groupby
from pathlib import Path
from typing import IO, Any

import numpy as np

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.common.files import writing
from taskgist.common.text import one_or_list
from taskgist.performing.execution import Execution, phase_frames
from taskgist.planning.gripper import Gripper
from taskgist.planning.inverse_kinematics import chain_of_arm
from taskgist.planning.persons import moves_itself
from taskgist.planning.plan import RATE_HZ, Action, Cost, PhaseName, Plan
from taskgist.recording.recording import Recording
from taskgist.world.geometry.transforms import Pose, wxyz_from_matrix, yaw_of
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist.world.state import Hold

FORMAT = 1
"""Version of both documents."""
WORLD = "world"
"""The frame of all poses."""
DECIMALS = 6
"""Of metres, radians and seconds in documents."""
STILL = 1e-6
"""Slower than this, in metres or radians a second, is no motion but the last digits of one that has ended."""

DRIVES: frozenset[PhaseName] = frozenset({"drive", "transport", "withdraw"})
"""Phases in which the base moves."""

Document = dict[str, Any]


# --- Trajectories.


def robot_trajectory(plan: Plan, execution: Execution) -> Document:
    """What the controllers of the performer, and of those who help it, are to follow.

    Args:
        plan: What was done.
        execution: How it was carried out.

    Returns:
        ``joint_trajectories`` by group ("left_arm", "torso", "right_gripper", ...; those without joints are not
        there, and "body" is what moves beside them), ``base_trajectory``, and whose they are; ``helpers`` has the same
        of each other agent that acts, and of a robot that takes what it is given.
    """
    takers = [action.taker for action in plan.actions if action.taker is not None]
    robots = [name for name in takers if not moves_itself(execution.recording.scene.agent(name))]
    helpers = dict.fromkeys(name for name in (*plan.performers, *robots) if name != plan.performer)
    return {
        "format": FORMAT,
        "task": plan.task,
        "duration_s": _number(execution.recording.times_s[-1]),
        **_trajectories(execution.recording, plan.performer),
        "helpers": [_trajectories(execution.recording, name) for name in helpers],
    }


def _trajectories(recording: Recording, name: str) -> Document:
    """The trajectories of one agent, on the clock of all."""
    times_s, qpos, agent = recording.times_s, np.array(recording.qpos), recording.scene.agent(name)
    groups = joint_groups(recording.scene, name, qpos)
    return {
        "robot": name,
        "profile": agent.profile.name,
        "joint_trajectories": {group: _joint_trajectory(times_s, qpos, joints) for group, joints in groups.items()},
        "base_trajectory": _base_trajectory(times_s, qpos[:, agent.base], _root(recording.scene, name)),
    }


def joint_groups(scene: Scene, name: str, qpos: Array) -> dict[str, dict[str, int]]:
    """An agent's joints by what they are for, each with its index into qpos.

    Args:
        scene: The scene.
        name: The agent.
        qpos: Positions over time, (n, nq): joints of no group are listed if they move.
    """
    agent, stage = scene.agent(name), Stage(scene)
    names = {position: joint for joint, position in agent.joints.items()}
    groups: dict[str, dict[str, int]] = {}
    for arm in agent.arms:
        side, chain = arm.profile.side, chain_of_arm(stage, agent, arm)
        groups[f"{side}_arm"] = _named(names, chain.positions[~chain.lifts])
        groups.setdefault("torso", {}).update(_named(names, chain.positions[chain.lifts]))
        if agent.profile.hand is not None:
            groups[f"{side}_gripper"] = _named(names, Gripper(stage, agent, arm, agent.profile.hand).positions)
    grouped = {position for group in groups.values() for position in group.values()}
    others = np.array([position for position in names if position not in grouped], dtype=np.intp)
    groups["body"] = _named(names, others[np.ptp(qpos[:, others], axis=0) > STILL / RATE_HZ])
    return {group: joints for group, joints in groups.items() if joints}


def _named(names: Mapping[int, str], positions: Indices) -> dict[str, int]:
    return {names[position]: position for position in positions.tolist()}


def _joint_trajectory(times_s: Array, qpos: Array, joints: Mapping[str, int]) -> Document:
    """A ``trajectory_msgs/JointTrajectory`` of some joints."""
    positions = qpos[:, list(joints.values())]
    velocities = np.gradient(positions, times_s, axis=0)
    points = [
        {
            "positions": _numbers(positions[frame]),
            "velocities": _numbers(velocities[frame]),
            "time_from_start": _duration(times_s[frame]),
        }
        for frame in np.flatnonzero(_telling(velocities)).tolist()
    ]
    return {"header": _header(""), "joint_names": list(joints), "points": points}


def _base_trajectory(times_s: Array, bases: Array, joint: str) -> Document:
    """A ``trajectory_msgs/MultiDOFJointTrajectory`` of a base, (n, 7), which drives and turns on the floor."""
    yaws = np.unwrap([yaw_of(base[3:]) for base in bases])
    velocities = np.gradient(np.column_stack((bases[:, :3], yaws)), times_s, axis=0)
    points = [
        {
            "transforms": [_transform(bases[frame])],
            "velocities": [_twist(*velocities[frame].tolist())],
            "time_from_start": _duration(times_s[frame]),
        }
        for frame in np.flatnonzero(_telling(velocities)).tolist()
    ]
    return {"header": _header(WORLD), "joint_names": [joint], "points": points}


def _telling(velocities: Array) -> Mask:
    """Which frames a trajectory needs, (n,): the first, the last, those in motion, and rest on both sides of them."""
    moves: Mask = np.any(np.abs(velocities) > STILL, axis=1)
    telling = moves.copy()
    telling[[0, -1]] = True
    telling[1:] |= moves[:-1]
    telling[:-1] |= moves[1:]
    return telling


def _root(scene: Scene, name: str) -> str:
    """The joint of an agent's base, without the agent's prefix."""
    first: str = scene.columns[scene.base_slice(name).start]
    return first.removesuffix(".x").partition("/")[2]


def _header(frame_id: str) -> Document:
    return {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": frame_id}


def _duration(time_s: float) -> Document:
    sec, nanosec = divmod(round(float(time_s) * 1e9), 1_000_000_000)
    return {"sec": sec, "nanosec": nanosec}


def _transform(base: Array) -> Document:
    """A ``geometry_msgs/Transform``; its quaternion has the order of ROS, and names."""
    (x, y, z), (qw, qx, qy, qz) = _numbers(base[:3]), _numbers(base[3:])
    return {"translation": {"x": x, "y": y, "z": z}, "rotation": {"x": qx, "y": qy, "z": qz, "w": qw}}


def _twist(x: float, y: float, z: float, yaw: float) -> Document:
    linear = {"x": _number(x), "y": _number(y), "z": _number(z)}
    return {"linear": linear, "angular": {"x": 0.0, "y": 0.0, "z": _number(yaw)}}


# --- The plan.


def plan_document(plan: Plan, execution: Execution) -> Document:
    """A plan as it was carried out, action by action and phase by phase.

    Args:
        plan: What was done.
        execution: How it was carried out.
    """
    frames, actions = list(phase_frames(plan)), []
    for action in plan.actions:
        own, frames = frames[: len(action.phases)], frames[len(action.phases) :]
        actions.append(_action(action, own, execution.recording))
    return {
        "format": FORMAT,
        "task": plan.task,
        "rule": plan.clause.rule,
        "clause": plan.clause.to_json(),
        "performer": plan.performer,
        "target": one_or_list(plan.targets),
        "object": one_or_list(plan.things),
        "cost": cost_document(plan.cost),
        "attained": one_or_list([_attained(execution.recording, thing, -1) for thing in plan.things]),
        "actions": actions,
        "notes": list(plan.notes),
    }


def cost_document(cost: Cost) -> Document:
    """What a plan costs: its actions, and effort levels by agent."""
    return {"actions": cost.actions, "efforts": dict(cost.efforts), "total": round(cost.total, 3)}


def _action(action: Action, frames: Sequence[range], recording: Recording) -> Document:
    phases = list(_phases(action, frames, recording))
    grasps = (each["in_palm"] for phase in phases for each in phase["attach"] if each["agent"] == action.performer)
    return {
        "purpose": action.purpose,
        "performer": action.performer,
        "side": action.side,
        "object": action.thing,
        "means": action.candidate.means,
        "carrier": action.candidate.carrier,
        "effort": action.effort,
        "planned": _pose_of(action.candidate.pose),
        "attained": _attained(recording, action.thing, frames[-1].stop - 1),
        "grasp": next(grasps),
        "stands": list(_stands(phases)),
        "phases": phases,
    }


def _attained(recording: Recording, thing: str, frame: int) -> Document:
    return _pose_of(np.array(recording.qpos[frame])[recording.scene.object_slice(thing)])


def _phases(action: Action, spans: Sequence[range], recording: Recording) -> Iterator[Document]:
    scene, qpos = recording.scene, np.array(recording.qpos)
    agent, stage = scene.agent(action.performer), Stage(scene)
    joints = {name: at for group in joint_groups(scene, action.performer, qpos).values() for name, at in group.items()}
    moving = {name: at for name, at in joints.items() if np.ptp(qpos[:, at]) > STILL / RATE_HZ}
    arm, hand = agent.arm(action.side), agent.profile.hand
    gripper = None if hand is None else Gripper(stage, agent, arm, hand)
    before: frozenset[Hold] = frozenset()
    for phase, frames in zip(action.phases, spans, strict=True):
        last = qpos[frames[-1]]
        stage.show(recording.state(frames[-1]))
        yield {
            "name": phase.name,
            "start_s": _number(frames.start / RATE_HZ),
            "end_s": _number(frames.stop / RATE_HZ),
            "holds": [hold_document(hold) for hold in sorted(phase.holds)],
            "attach": [
                hold_document(hold) | {"in_palm": _in_palm(stage, hold)} for hold in sorted(phase.holds - before)
            ],
            "detach": [hold_document(hold) for hold in sorted(before - phase.holds)],
            "base": _planar(last[agent.base]),
            "palm": _pose(stage.site(arm.palm_site)),
            "opening_m": _opening_m(gripper, last),
            "joints": {name: _number(last[at]) for name, at in moving.items()},
            "object": _pose_of(last[scene.object_slice(action.thing)]),
        }
        before = phase.holds


def _stands(phases: Iterable[Document]) -> Iterator[Document]:
    """Where the robot stands between its drives, from when to when, and what it does there."""
    for drives, group in groupby(phases, key=lambda phase: phase["name"] in DRIVES):
        if not drives:
            own = list(group)
            times = {"start_s": own[0]["start_s"], "end_s": own[-1]["end_s"]}
            yield {"base": own[-1]["base"], **times, "phases": [phase["name"] for phase in own]}


def _opening_m(gripper: Gripper | None, qpos: Array) -> float | None:
    """How far a hand whose fingers move is open."""
    if gripper is None or not len(gripper.positions):
        return None
    return _number(gripper.pads(qpos[gripper.positions]).opening_m)


def hold_document(hold: Hold) -> Document:
    """Which hand holds which object."""
    return {"agent": hold.agent, "side": hold.side, "object": hold.object}


def _in_palm(stage: Stage, hold: Hold) -> Document:
    """A held thing's body in the frame of the palm that holds it."""
    palm = stage.site(stage.scene.agent(hold.agent).arm(hold.side).palm_site)
    thing = stage.body(stage.scene.object_body(hold.object))
    return _pose(Pose(palm.to_local(thing.position), palm.matrix.T @ thing.matrix))


def _planar(base: Array) -> Document:
    return {"x_m": _number(base[0]), "y_m": _number(base[1]), "yaw_rad": _number(yaw_of(base[3:]))}


def _pose(pose: Pose) -> Document:
    return {"position_m": _numbers(pose.position), "wxyz": _numbers(wxyz_from_matrix(pose.matrix))}


def _pose_of(row: Array) -> Document:
    return {"position_m": _numbers(row[:3]), "wxyz": _numbers(row[3:])}


def _numbers(values: Array) -> list[float]:
    return [_number(value) for value in values.tolist()]


def _number(value: float) -> float:
    return round(float(value), DECIMALS) + 0.0  # no negative zero


# --- Files: whole or not at all.


def write_document(document: Document, path: Path, *, replace: bool = True) -> None:
    """Write a document as JSON.

    Raises:
        InputError: The file cannot be written, or is there already and not to be replaced.
    """
    with writing(path, replace=replace) as stream:
        stream.write(json.dumps(document, ensure_ascii=False, allow_nan=False).encode() + b"\n")


def write_positions(recording: Recording, stream: IO[bytes]) -> None:
    """Write every frame of a recording as a ``.npz`` file for numpy and MuJoCo.

    ``times_s`` (n,) and ``qpos`` (n, nq) are the frames, ``columns`` (nq,) names each position, ``model`` is the MJCF
    text of the whole scene, and ``assets/NAME`` the bytes of each file that it names::

        with np.load("done.npz") as file:
            assets = {name[7:]: file[name].tobytes() for name in file.files if name.startswith("assets/")}
            model = mujoco.MjModel.from_xml_string(str(file["model"]), assets)
    """
    text, assets = recording.scene.mjcf()
    arrays: dict[str, Any] = {
        "times_s": recording.times_s,
        "qpos": np.array(recording.qpos),
        "columns": np.array(recording.scene.columns),
        "model": np.array(text),
        **{f"assets/{name}": np.frombuffer(data, dtype=np.uint8) for name, data in assets.items()},
    }
    np.savez_compressed(stream, **arrays)
