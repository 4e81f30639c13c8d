"""Language: explanations, reasons and questions in plain English."""

from taskgist.language.phrases import listed, phrase, topic
from taskgist.language.sentences import asked, indifference, meaning, why

__all__ = ["asked", "indifference", "listed", "meaning", "phrase", "topic", "why"]
