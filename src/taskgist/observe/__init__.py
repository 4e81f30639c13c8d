"""Observe: the bridge from world states to the attributes of the tree (level 4 → 3)."""

from taskgist.observe.abilities import ability_observations, state_symbol
from taskgist.observe.attributes import Snapshot, snapshot, status_observations
from taskgist.observe.confirmation import Confirmation, Interval
from taskgist.observe.history import Confirmed, History
from taskgist.observe.lazy_observer import LazyObserver
from taskgist.observe.lookup import Lookup
from taskgist.observe.motion import MotionLookup, MotionWatch
from taskgist.observe.observer import Observer
from taskgist.observe.status import HandUse, Placed, Statuses, statuses_of

__all__ = [
    "Confirmation",
    "Confirmed",
    "HandUse",
    "History",
    "Interval",
    "LazyObserver",
    "Lookup",
    "MotionLookup",
    "MotionWatch",
    "Observer",
    "Placed",
    "Snapshot",
    "Statuses",
    "ability_observations",
    "snapshot",
    "state_symbol",
    "status_observations",
    "statuses_of",
]
