"""A private PostgreSQL for tests: in a temporary folder, on a socket there, gone afterwards; shared by all workers."""

from __future__ import annotations

import fcntl
import os
import pwd
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from urllib.parse import quote

import psycopg

FAST = "-c fsync=off -c synchronous_commit=off -c full_page_writes=off -c shared_buffers=16MB -c max_connections=60"
"""What is tested is what others see, not what outlasts a power failure."""
USERS = ("postgres", "nobody")
"""Whom the server runs as where root runs the tests: it refuses root."""


def missing() -> str | None:
    """Why there is no server on this machine; None if there is."""
    absent = [name for name in ("initdb", "pg_ctl", "postgres") if _program(name) is None]
    if absent:
        return f"no {', '.join(absent)} on PATH or in /usr/lib/postgresql (Debian: apt-get install postgresql)"
    if os.geteuid() == 0 and _user() is None:
        return f"PostgreSQL does not run as root, and there is no user {' or '.join(USERS)}"
    return None


@contextmanager
def running(folder: Path) -> Iterator[str]:
    """The URL of a server in a folder that other processes may share; the last that leaves stops it."""
    folder.mkdir(exist_ok=True)
    folder.chmod(0o711)
    with (folder / "starting").open("w") as starting, (folder / "using").open("w") as using:
        fcntl.flock(starting, fcntl.LOCK_EX)
        fcntl.flock(using, fcntl.LOCK_SH)
        server = Server(folder / "server")
        server.start()
        fcntl.flock(starting, fcntl.LOCK_UN)
        try:
            yield server.url
        finally:
            fcntl.flock(starting, fcntl.LOCK_EX)
            fcntl.flock(using, fcntl.LOCK_UN)
            try:
                fcntl.flock(using, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                pass
            else:
                server.stop()
                shutil.rmtree(folder)


class Server:
    """A server whose data lie in a folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.data = folder / "data"
        self.url = f"postgresql://postgres@/postgres?host={quote(str(folder))}"

    def start(self) -> None:
        """Start it, unless it runs."""
        if not self.data.exists():
            self.folder.mkdir()
            if (user := _user()) is not None:
                shutil.chown(self.folder, user)
            _run("initdb", "-D", self.data, "-U", "postgres", "-A", "trust", "-N", "-E", "UTF8", "--locale=C")
        if _run("pg_ctl", "-D", self.data, "status", check=False):
            options = f"-k {self.folder} -c listen_addresses='' {FAST}"
            _run("pg_ctl", "-D", self.data, "-l", self.folder / "log", "-o", options, "-w", "start")

    def stop(self) -> None:
        """Stop it; who is connected is thrown out."""
        _run("pg_ctl", "-D", self.data, "-m", "immediate", "stop")


def database(server: str, name: str) -> str:
    """The URL of a new, empty database of a server."""
    with psycopg.connect(server, autocommit=True) as connection:
        connection.execute(f'CREATE DATABASE "{name}"'.encode())
    return server.replace("/postgres?", f"/{name}?")


def _run(program: str, *arguments: str | Path, check: bool = True) -> int:
    """Exit code of a program of the server, run by whom the server runs as."""
    words = [str(_program(program)), *map(str, arguments)]
    done = subprocess.run(
        words, check=check, user=_user(), group=_group(), cwd="/", stdout=subprocess.DEVNULL, stdin=subprocess.DEVNULL
    )
    return done.returncode


def _program(name: str) -> Path | None:
    found = shutil.which(name)
    debian = sorted(Path("/usr/lib/postgresql").glob(f"*/bin/{name}"))
    return Path(found) if found else debian[-1] if debian else None


def _user() -> str | None:
    """Whom the server is to run as; None: who runs the tests."""
    return next((name for name in USERS if _exists(name)), None) if os.geteuid() == 0 else None


def _group() -> int | None:
    user = _user()
    return None if user is None else pwd.getpwnam(user).pw_gid


def _exists(user: str) -> bool:
    return any(each.pw_name == user for each in pwd.getpwall())
