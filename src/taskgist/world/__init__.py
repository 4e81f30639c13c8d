"""World (level 4): bodies, agent profiles, scenes, states, rays, contacts, and fitting a body to tracked points."""

from taskgist.world.body.agent import Agent, ArmIndices
from taskgist.world.body.anthropometry import HumanSize
from taskgist.world.body.hands import HAND_KINDS, Hand, HandBox, HandKind, hand_boxes
from taskgist.world.body.postures import posture_of, seat_position, with_posture
from taskgist.world.body.profile import AgentProfile, Arm, Eye, Posture, builtin_profiles
from taskgist.world.contacts import container_of, object_points, overlaps, support_of
from taskgist.world.dynamics import FreeMotion, free_motion
from taskgist.world.fit import Fit, Fitter
from taskgist.world.fit_words import landmarks
from taskgist.world.geometry.between import Shapes
from taskgist.world.geometry.compiled import when_compiling
from taskgist.world.geometry.linkage import Linkage
from taskgist.world.geometry.pose import Pose
from taskgist.world.geometry.shapes import inner_points
from taskgist.world.geometry.solids import distances_outside_m, spans_m
from taskgist.world.holding import Holding, hand_gap_m, hand_known, holding_of, objects_near, rests_on
from taskgist.world.holding_watch import HoldingWatch
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist.world.state import Hold, State
from taskgist.world.window import Around, SlidingWindow, velocity

__all__ = [
    "HAND_KINDS",
    "Agent",
    "AgentProfile",
    "Arm",
    "ArmIndices",
    "Around",
    "Eye",
    "Fit",
    "Fitter",
    "FreeMotion",
    "Hand",
    "HandBox",
    "HandKind",
    "Hold",
    "Holding",
    "HoldingWatch",
    "HumanSize",
    "Linkage",
    "Pose",
    "Posture",
    "Scene",
    "Shapes",
    "SlidingWindow",
    "Stage",
    "State",
    "builtin_profiles",
    "container_of",
    "distances_outside_m",
    "free_motion",
    "hand_boxes",
    "hand_gap_m",
    "hand_known",
    "holding_of",
    "inner_points",
    "landmarks",
    "object_points",
    "objects_near",
    "overlaps",
    "posture_of",
    "rests_on",
    "seat_position",
    "spans_m",
    "support_of",
    "velocity",
    "when_compiling",
    "with_posture",
]
