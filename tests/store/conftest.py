"""Addresses of knowledge: a file, and a database of a private server."""

from __future__ import annotations

import os
import secrets
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.store import postgres


@pytest.fixture(scope="session")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """URL of a private PostgreSQL, one for all workers of a run."""
    reason = postgres.missing()
    if reason:
        pytest.skip(reason)
    run = tmp_path_factory.getbasetemp()
    if os.environ.get("PYTEST_XDIST_WORKER"):
        run = run.parent  # which all workers of a run share
    # Not inside of it: the server's user may not go there, and its socket's path would be too long.
    with postgres.running(Path(tempfile.gettempdir()) / f"taskgist-postgres-{run.stat().st_ino}") as url:
        yield url


@pytest.fixture
def database(server: str) -> str:
    """URL of an empty database."""
    return postgres.database(server, f"test_{secrets.token_hex(6)}")


@pytest.fixture(params=["sqlite", "postgresql"])
def address(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """Where knowledge may be kept: a file that does not exist yet, an empty database."""
    if request.param == "sqlite":
        return str(tmp_path / "knowledge.db")
    found: str = request.getfixturevalue("database")
    return found
