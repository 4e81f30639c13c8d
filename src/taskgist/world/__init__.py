"""World (level 4): bodies, agent profiles, scenes, states, rays, contacts, and fitting a body to tracked points."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
