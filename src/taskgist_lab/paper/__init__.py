"""The paper's study: every published result beside ours, with a verdict (7.3-8.4)."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
