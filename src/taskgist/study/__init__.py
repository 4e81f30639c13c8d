"""Study: whole runs over recordings, from geometry to knowledge."""

from taskgist.study.checkup import Checkup, Finding, check
from taskgist.study.episodes import episode_of, explain_recording, label_of, observe_recording
from taskgist.study.grip_forces import GripCheck, check_grips
from taskgist.study.learn import explain_all, learn
from taskgist.study.proposal import Grip, grips_of, propose_label
from taskgist.study.shipped import shipped_recordings, shipped_study
from taskgist.study.timeline import Timeline, attribute_nodes, timeline

__all__ = [
    "Checkup",
    "Finding",
    "Grip",
    "GripCheck",
    "Timeline",
    "attribute_nodes",
    "check",
    "check_grips",
    "episode_of",
    "explain_all",
    "explain_recording",
    "grips_of",
    "label_of",
    "learn",
    "observe_recording",
    "propose_label",
    "shipped_recordings",
    "shipped_study",
    "timeline",
]
