"""Store: knowledge that lasts, in a SQLite file or a shared database."""

from taskgist.store.address import Address, file_of
from taskgist.store.database import load, save, update

__all__ = ["Address", "file_of", "load", "save", "update"]
