"""Store: knowledge that lasts, in a SQLite file or a shared database."""

from taskgist.store.address import Address
from taskgist.store.database import load, save, update

__all__ = ["Address", "load", "save", "update"]
