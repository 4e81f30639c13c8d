"""Moving: bodies that move as people do: smooth motions, gaze, holding and handing over. It asks no perspective."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
