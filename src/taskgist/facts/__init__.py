"""Facts: attributes, their values and evidence, comparisons, natures, and the hypothesis tree (sections 4 and 5)."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
