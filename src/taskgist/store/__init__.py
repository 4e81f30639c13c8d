"""Store: knowledge that lasts, in a SQLite file or a shared database."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
