"""The computer that this runs on, in words."""

from __future__ import annotations

import os
import platform
from pathlib import Path

CPUINFO = Path("/proc/cpuinfo")


def machine() -> str:
    """Processor, cores, and system: "AMD EPYC 7571, 2 cores, Linux, Python 3.11.2"."""
    return f"{_processor()}, {os.cpu_count()} cores, {platform.system()}, Python {platform.python_version()}"


def _processor() -> str:
    if CPUINFO.exists():
        lines = (line.partition(":") for line in CPUINFO.read_text(encoding="utf-8").splitlines())
        for name, _, value in lines:
            if name.strip() == "model name":
                return value.strip()
    return platform.processor() or platform.machine()
