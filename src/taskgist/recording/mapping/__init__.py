"""Import mappings: TOML files that say what the numbers in someone's tables mean (docs/import.md)."""

from taskgist.recording.mapping.loading import load_mapping
from taskgist.recording.mapping.model import Mapping

__all__ = ["Mapping", "load_mapping"]
