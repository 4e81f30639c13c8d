"""Scripted demonstrators: simulated recordings of people who do something for each other (3.1, 7.2-7.8).

A ``Room`` becomes a scene, a ``Script`` is played in it (``demonstrate``), and what comes out is a recording like any
other, marked as simulated. Demonstrators act by their own geometry and never ask what facts will follow.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
