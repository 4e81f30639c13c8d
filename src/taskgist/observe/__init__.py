"""Observe: the bridge from world states to the attributes of the tree (level 4 → 3)."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
