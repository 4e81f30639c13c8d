"""Recordings: demonstrations on disk, their labels (7.2), and what brings them in.

``read`` and ``write`` know MCAP; ``load_mapping`` and ``read_tracks`` turn someone's tables into tracked motion, and
``import_recording`` that into a recording.
"""

from taskgist.recording.build import Progress, import_recording, silent
from taskgist.recording.label import Label
from taskgist.recording.mapping import Mapping, load_mapping
from taskgist.recording.mcap_file import read, write
from taskgist.recording.provenance import Provenance
from taskgist.recording.recording import Recording
from taskgist.recording.signals import Signal
from taskgist.recording.tracks import ObjectTrack, PersonTrack, Tracks, read_tracks

__all__ = [
    "Label",
    "Mapping",
    "ObjectTrack",
    "PersonTrack",
    "Progress",
    "Provenance",
    "Recording",
    "Signal",
    "Tracks",
    "import_recording",
    "load_mapping",
    "read",
    "read_tracks",
    "silent",
    "write",
]
