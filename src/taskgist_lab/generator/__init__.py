"""Demonstrations in any number: random rooms, people and things, and several means of each task.

A ``Way`` is one means of one task: it furnishes a room at random so that the means makes sense there, and says what
the performer does. ``simulate`` chooses a way, a room and the natural variation, plays the demonstration, and looks at
the outcome as its performer would::

    recording = simulate("hide", seed=7, number=12)

What is chosen follows from the task, the seed and the number alone. Performers use their own geometry (places,
distances, straight lines of sight) and never ask what facts will follow.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
