"""Property tests draw the same examples in every run, and are never judged by the clock of a busy machine."""

from hypothesis import settings

settings.register_profile("seeded", derandomize=True, deadline=None, database=None)
settings.load_profile("seeded")
