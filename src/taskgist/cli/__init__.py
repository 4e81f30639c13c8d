"""The command line: the one room that prints, exits and configures logging."""

from taskgist.cli.app import main

__all__ = ["main"]
