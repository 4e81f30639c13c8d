"""World (level 4): bodies, agent profiles, scenes, states, rays, contacts, and fitting a body to tracked points."""

from taskgist.world.agent import Agent, ArmIndices
from taskgist.world.anthropometry import HumanSize
from taskgist.world.contacts import container_of, object_points, overlaps, support_of
from taskgist.world.fit import Fit, Fitter, landmarks
from taskgist.world.holding import Holding, hand_gap_m, hand_known, holding_of, rests_on
from taskgist.world.holding_watch import HoldingWatch
from taskgist.world.postures import posture_of, seat_position, with_posture
from taskgist.world.profile import AgentProfile, Arm, Eye, Hand, Posture, builtin_profiles
from taskgist.world.scene import Scene
from taskgist.world.stage import Pose, Stage
from taskgist.world.state import Hold, State
from taskgist.world.window import Around, SlidingWindow, velocity

__all__ = [
    "Agent",
    "AgentProfile",
    "Arm",
    "ArmIndices",
    "Around",
    "Eye",
    "Fit",
    "Fitter",
    "Hand",
    "Hold",
    "Holding",
    "HoldingWatch",
    "HumanSize",
    "Pose",
    "Posture",
    "Scene",
    "SlidingWindow",
    "Stage",
    "State",
    "builtin_profiles",
    "container_of",
    "hand_gap_m",
    "hand_known",
    "holding_of",
    "landmarks",
    "object_points",
    "overlaps",
    "posture_of",
    "rests_on",
    "seat_position",
    "support_of",
    "velocity",
    "with_posture",
]
