"""Tables on disk: text and NumPy arrays, read as one track per point in the room's axes."""

from taskgist.recording.tables.reader import Tables
from taskgist.recording.tables.track import Track

__all__ = ["Tables", "Track"]
