"""The command line: the one room that prints, exits and configures logging."""

import os

__all__ = ["main"]


def main() -> None:
    """Run the command line."""
    # Our matrices are small: threads of the linear algebra only get in each other's way. To be said before numpy is.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from taskgist.cli.app import app

    app()
