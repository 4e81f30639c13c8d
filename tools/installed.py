"""Build the wheel, and use it as a user would who may not write where it is installed.

    python -m tools.installed

Nothing is downloaded: setuptools and all that taskgist needs are those of this environment. The wheel must hold every
file of the packages. It is installed elsewhere, in a folder with blanks in its name; from another folder the command
must run ``demo`` and ``paper`` and load nothing of this tree. (Inner loops are compiled anew: about a minute.)
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parent.parent
SOURCE = ROOT / "src"
PACKAGES = ("taskgist", "taskgist_lab")
MADE = {".pyc", ".nbi", ".nbc"}
"""Suffixes of files that Python and Numba leave beside the sources."""
COMMANDS = ("--version", "demo -o demo", "paper", "simulate --list")
WHERE = "import taskgist, taskgist_lab; print(taskgist.__file__, taskgist_lab.__file__)"


def main() -> None:
    """Build, install, run.

    Raises:
        SystemExit: The wheel lacks a file, or a command fails.
    """
    with tempfile.TemporaryDirectory(prefix="taskgist installed ") as name:
        folder = Path(name)
        wheel = build(folder)
        site = folder / "site packages"
        pip("install", "--no-deps", "--target", str(site), str(wheel))
        home = folder / "home"
        home.mkdir()
        user = User.without_rights(folder, home)
        environment = {**os.environ, "PYTHONPATH": str(site), "PYTHONSAFEPATH": "1", "HOME": str(home)}
        environment.pop("NUMBA_CACHE_DIR", None)
        found = user.run([sys.executable, "-c", WHERE], environment)
        if str(SOURCE) in found:
            raise SystemExit(f"this tree was used instead of the installed package: {found}")
        user.run([sys.executable, "-c", f"import pathlib; pathlib.Path({str(site)!r}, 'x').touch()"], environment, 1)
        for line in COMMANDS:
            user.run([sys.executable, str(site / "bin" / "taskgist"), *line.split()], environment)
            print(f"installed: taskgist {line}: done", flush=True)
        for path in folder.rglob("*"):
            path.chmod(0o755)  # so that it can be removed


def build(folder: Path) -> Path:
    """A wheel of a clean copy of the sources, which holds every file of the packages.

    Raises:
        SystemExit: It lacks some.
    """
    copy = folder / "source"
    left_out = shutil.ignore_patterns("*.egg-info", "__pycache__", *(f"*{suffix}" for suffix in MADE))
    shutil.copytree(SOURCE, copy / "src", ignore=left_out)
    for path in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / path, copy)
    pip("wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", str(folder), str(copy))
    (wheel,) = folder.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        missing = wanted() - set(archive.namelist())
    if missing:
        raise SystemExit(f"the wheel lacks {', '.join(sorted(missing))}: see package-data in pyproject.toml")
    return wheel


def wanted() -> set[str]:
    """Every file of the packages, by its path in a wheel."""
    files = (path for package in PACKAGES for path in (SOURCE / package).rglob("*") if path.is_file())
    return {path.relative_to(SOURCE).as_posix() for path in files if path.suffix not in MADE}


def pip(*words: str) -> None:
    """Run pip, quietly."""
    command = [sys.executable, "-m", "pip", words[0], "--quiet", "--disable-pip-version-check", *words[1:]]
    subprocess.run(command, check=True)


@dataclass(frozen=True)
class User:
    """Somebody who owns nothing but a home: a name, or None for oneself, and what a command must begin with."""

    home: Path
    name: str | None = None
    prefix: tuple[str, ...] = ()

    @classmethod
    def without_rights(cls, folder: Path, home: Path) -> User:
        """Make a folder read-only, but for the home, and find a user for whom that holds.

        For root it does not hold: then it is nobody, or, where nobody may run this Python, root without capabilities.
        """
        for path in (folder, *folder.rglob("*")):
            path.chmod(0o555 if path.is_dir() else 0o444)
        home.chmod(0o755)
        if os.geteuid():
            return cls(home)
        try:
            subprocess.run([sys.executable, "-c", "import numpy"], user="nobody", check=True, capture_output=True)
        except (OSError, subprocess.CalledProcessError):
            return cls(home, prefix=("setpriv", "--bounding-set=-all", "--inh-caps=-all"))
        shutil.chown(home, "nobody")
        return cls(home, "nobody")

    def run(self, command: list[str], environment: Mapping[str, str], exit_code: int = 0) -> str:
        """Standard output of a command.

        Raises:
            SystemExit: It ends with another exit code.
        """
        words = [*self.prefix, *command]
        done = subprocess.run(
            words, cwd=self.home, env=environment, user=self.name, capture_output=True, text=True, check=False
        )
        if done.returncode != exit_code:
            said = f"{done.stdout[-2000:]}{done.stderr[-4000:]}"
            raise SystemExit(f"{' '.join(words)}: exit code {done.returncode}\n{said}")
        return done.stdout


if __name__ == "__main__":
    main()
