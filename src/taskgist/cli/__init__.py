"""The command line: the one room that prints, exits and configures logging."""

import io
import os
import sys

__all__ = ["main"]


def main() -> None:
    """Run the command line."""
    # Our matrices are small: threads of the linear algebra only get in each other's way. To be said before numpy is.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without our signs shows "?" rather than an error
    from taskgist.cli.app import app, take_debug_option, unexpected

    take_debug_option()
    try:
        app()
    except Exception as error:  # no command may end in a traceback
        sys.exit(unexpected(error))
