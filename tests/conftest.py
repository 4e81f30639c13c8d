"""Property tests draw the same examples in every run, and are never judged by the clock of a busy machine."""

from hypothesis import HealthCheck, settings

slow = [HealthCheck.too_slow]
settings.register_profile("seeded", derandomize=True, deadline=None, database=None, suppress_health_check=slow)
settings.load_profile("seeded")
