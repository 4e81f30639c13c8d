"""Scripted demonstrators: simulated recordings of people who do something for each other (3.1, 7.2-7.8).

A ``Room`` becomes a scene, a ``Script`` is played in it (``demonstrate``), and what comes out is a recording like any
other, marked as simulated. Demonstrators act by their own geometry and never ask what facts will follow.
"""

from taskgist.demonstrator.demonstration import demonstrate
from taskgist.demonstrator.furniture import Table, Thing
from taskgist.demonstrator.means import Roles, hold_up, put_behind, put_on_top
from taskgist.demonstrator.room import Person, Room
from taskgist.demonstrator.script import Script, Step
from taskgist.demonstrator.steps import HoldUp, PutDown, Take, Wait, Withdraw
from taskgist.demonstrator.study import STUDY, Demonstration

__all__ = [
    "STUDY",
    "Demonstration",
    "HoldUp",
    "Person",
    "PutDown",
    "Roles",
    "Room",
    "Script",
    "Step",
    "Table",
    "Take",
    "Thing",
    "Wait",
    "Withdraw",
    "demonstrate",
    "hold_up",
    "put_behind",
    "put_on_top",
]
