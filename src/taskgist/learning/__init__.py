"""Learning: from explanations of demonstrations to what a task means (section 6)."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
