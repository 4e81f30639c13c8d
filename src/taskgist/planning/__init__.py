"""Planning: from a learned clause to a goal in a scene, and to what brings it about (9.1-9.7)."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
