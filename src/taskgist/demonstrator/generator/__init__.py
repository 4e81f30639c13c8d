"""Demonstrations in any number: random rooms, people and things, and several means of each task.

A ``Way`` is one means of one task: it furnishes a room at random so that the means makes sense there, and says what
the performer does. ``simulate`` draws a way, a room and the natural variation, plays the demonstration, and looks at
the outcome as its performer would::

    recording = simulate("hide", seed=7, number=12)

What is drawn follows from the task, the seed and the number alone. Performers use their own geometry (places,
distances, straight lines of sight) and never ask what facts will follow.
"""

from taskgist.demonstrator.generator.files import Written, note, simulate_files
from taskgist.demonstrator.generator.setting import Setting
from taskgist.demonstrator.generator.simulation import Series, simulate, simulate_all
from taskgist.demonstrator.generator.way import Way
from taskgist.demonstrator.generator.ways import TASKS, WAYS

__all__ = [
    "TASKS",
    "WAYS",
    "Series",
    "Setting",
    "Way",
    "Written",
    "note",
    "simulate",
    "simulate_all",
    "simulate_files",
]
