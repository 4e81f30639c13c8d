"""Two hours of two people and six objects at 30 Hz: memory and time to write, read, judge and label them.

Each step is a process of its own, which tells how much memory it has had at most.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks.figure import Figure
from benchmarks.rooms import furnished
from taskgist.recording import Label, Recording

HOURS, RATE_HZ = 2.0, 30.0
PERIOD_S = 8.0
"""As often a thing is lifted and put back."""
GOALS_MB = {"write": 600, "read": 400, "label": 400, "check": 400, "learn": 400, "facts": 400}

PROGRAM = """
import resource, sys, time
step, path, frames = sys.argv[1], sys.argv[2], int(sys.argv[3])
start_s = time.perf_counter()
if step == "write":
    from benchmarks.memory import long_recording
    from taskgist.recording import write
    write(long_recording(frames), path)
elif step == "read":
    from taskgist.recording import read
    read(path)
else:
    from taskgist.cli import main
    more = {"label": ["--task", "show"], "learn": ["-k", path + ".db"], "facts": ["--every", "60", "--json"]}
    sys.argv = ["taskgist", step, path, *more.get(step, [])]
    try:
        main()
    except SystemExit as done:
        assert done.code in (0, 1, None), done.code
print(time.perf_counter() - start_s, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024, file=sys.stderr)
"""


def figures() -> Iterator[Figure]:
    """Every step of two hours, beside its goal."""
    frames = int(HOURS * 3600 * RATE_HZ)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "long.mcap"
        for step, goal_mb in GOALS_MB.items():
            seconds, most_mb = measured(step, path, frames)
            counts = {"MB at most": round(most_mb), "frames": frames, "MB on disk": round(path.stat().st_size / 1e6)}
            goal = f"at most {goal_mb} MB of memory"
            yield Figure("memory", f"{step} 2 h", seconds, goal=goal, met=most_mb <= goal_mb, counts=counts)


def measured(step: str, path: Path, frames: int) -> tuple[float, float]:
    """Seconds, and memory at most in MB, of one step in a process of its own."""
    command = [sys.executable, "-c", PROGRAM, step, str(path), str(frames)]
    done = subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, env=os.environ)
    seconds, most_mb = done.stderr.split()[-2:]
    return float(seconds), float(most_mb)


def long_recording(frames: int) -> Recording:
    """Two people who move all the time, and six objects, one of which is lifted and put back again and again."""
    scene = furnished(2, 6)
    times_s = np.arange(frames) / RATE_HZ
    qpos = np.empty((frames, scene.nq))
    qpos[:] = scene.initial.qpos
    for number, agent in enumerate(scene.agents):
        joints = scene.joint_indices(agent)
        phases = np.arange(len(joints)) + number
        for joint, phase in zip(joints.tolist(), phases.tolist(), strict=True):
            qpos[:, joint] += 0.05 * np.sin(2 * np.pi * times_s / PERIOD_S + phase)
    thing = scene.objects[0]
    height = scene.object_slice(thing).start + 2
    qpos[:, height] += 0.3 * np.maximum(np.sin(2 * np.pi * times_s / PERIOD_S), 0.0)
    end_s = float(times_s[-1])
    label = Label("show", scene.agents[0], scene.agents[1], thing, end_s / 2, end_s / 2 + PERIOD_S / 4)
    times_s.flags.writeable = qpos.flags.writeable = False
    return Recording(scene, times_s, qpos, label=label, name="two hours")
