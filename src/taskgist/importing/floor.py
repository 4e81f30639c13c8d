"""People under or over the floor: by how much they would have to be shifted to stand on it.

Cameras measure from themselves, and some trackers from the hips; the floor is z = 0 here. A person whose soles are
elsewhere for most of the time was given in another frame, unless something is there to stand on.
"""

from __future__ import annotations

import numpy as np

from taskgist.recording.recording import Recording
from taskgist.settings import DEFAULT, Settings
from taskgist.world.bodies.agent import Agent, body_index
from taskgist.world.stage import Stage, floor_height_m, posture_of

DOWN = (0.0, 0.0, -1.0)
LOOKS = 30
"""In as many frames at most it is looked where the soles are."""


def off_the_floor_m(recording: Recording, agent: str, stage: Stage, settings: Settings = DEFAULT) -> float | None:
    """How far an agent's soles are over the floor, or what else is beneath, metres; negative: under the floor.

    The median of the frames in which its legs were tracked; None if they never were, or if it stands on the floor, or
    sits with its feet no higher than from a bar stool.

    Args:
        recording: The recording.
        agent: A person; others stand as they do.
        stage: The recording's scene; it shows other states afterwards.
        settings: Heights that count.
    """
    body = stage.scene.agent(agent)
    if not body.profile.legs.feet or not any(arm.human_stature_m for arm in body.arms):
        return None
    known = np.ones(len(recording), dtype=np.bool_)
    for name in (agent, f"{agent}/legs"):
        known &= recording.tracked.get(name, True)
    frames = np.flatnonzero(known)
    found = [
        _height_m(stage.show(recording.state(int(index))), body, settings)
        for index in frames[:: max(len(frames) // LOOKS, 1)]
    ]
    height_m = float(np.median(found)) if found else 0.0
    return height_m if abs(height_m) > settings.checks.off_floor_m else None


def floor_problem(height_m: float) -> str:
    """What is wrong with a person that far over the floor, in metres; negative: under it."""
    return f"the soles are {abs(height_m):.2f} m {'over' if height_m > 0 else 'under'} the floor (median)"


def floor_remedy(name: str, height_m: float) -> str:
    """What would bring it onto the floor."""
    return f"give {name}'s source transform = {{ position_m = [0, 0, {-height_m:.2f}] }}, added to what it has"


def _height_m(stage: Stage, body: Agent, settings: Settings) -> float:
    """Of the lower sole in one state; 0 where it is as high as that of people who stand or sit."""
    height_m = floor_height_m(stage, body)
    if height_m <= settings.checks.off_floor_m:
        return height_m
    scene = stage.scene
    others = [geom for geom in range(scene.model.ngeom) if scene.owners[geom] not in scene.agents]
    ankles = [stage.body_position(body_index(scene.model, body, foot)) for foot in body.profile.legs.feet]
    ankle = min(ankles, key=lambda place: float(place[2]))
    met, away_m = stage.cast_at(others, ankle, np.array([DOWN]))
    beneath_m = float(away_m[0]) - (float(ankle[2]) - height_m) if met[0] >= 0 else height_m
    if posture_of(stage, body, settings.contact) == "sitting" and beneath_m < settings.checks.dangling_m:
        return 0.0
    return beneath_m
