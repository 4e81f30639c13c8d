"""Perspective: what an agent sees, reaches and grasps, now and after virtual actions, with what effort (5.1)."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
