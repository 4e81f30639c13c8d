"""Performing: plans carried out, audited frame by frame, and judged by the facts that explain demonstrations."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
