"""Pipeline: whole runs over recordings, from geometry to knowledge; check-ups."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
