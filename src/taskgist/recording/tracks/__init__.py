"""Tracked motion of people and objects: from a mapping's tables to the frames of a recording."""

from taskgist.recording.tracks.model import ObjectTrack, PersonTrack, Tracks
from taskgist.recording.tracks.reading import read_tracks

__all__ = ["ObjectTrack", "PersonTrack", "Tracks", "read_tracks"]
