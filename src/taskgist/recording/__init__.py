"""Recordings: demonstrations on disk, their labels (7.2), and what brings them in.

``read`` and ``write`` know MCAP; ``load_mapping`` and ``read_tracks`` turn someone's tables into tracked motion, and
``import_recording`` that into a recording.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
