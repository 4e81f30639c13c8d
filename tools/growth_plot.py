"""Draw how time and memory grow, from benchmarks.json: ``python -m tools.growth_plot`` makes the docs' picture."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.axes import Axes

SOURCE, TARGET = Path("benchmarks.json"), Path("docs/pictures/growth.png")
LABELS = {"agents": "agents", "objects": "objects", "pixels": "pixels of an image"}
TIME, MEMORY, LINEAR = "#1f5fa8", "#b5651d", "#9a9a9a"


def main() -> None:
    """Draw the picture."""
    points = json.loads(SOURCE.read_text(encoding="utf-8"))["growth"]
    figure, axes = plt.subplots(1, 3, figsize=(12, 3.6), layout="constrained")
    for axis, along in zip(axes, LABELS, strict=True):
        panel(axis, along, [point for point in points if point["size"]["along"] == along])
    axes[0].set_ylabel("all efforts of a scene, seconds", color=TIME)
    axes[0].legend(loc="upper left", frameon=False, fontsize=8)
    TARGET.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(TARGET, dpi=120)


def panel(axis: Axes, along: str, points: list[dict[str, Any]]) -> None:
    """Time on the left axis, memory on the right one, and what is linear from the first point on."""
    sizes = [amount(along, point["size"]) for point in points]
    times = [float(point["seconds"]) for point in points]
    axis.loglog(sizes, times, "o-", color=TIME, label="time")
    axis.loglog(sizes, [times[0] * size / sizes[0] for size in sizes], ":", color=LINEAR, label="linear growth")
    memory = axis.twinx()
    memory.plot(sizes, [float(point["memory_mib"]) for point in points], "s--", color=MEMORY, markersize=4)
    memory.set_ylim(bottom=0)
    memory.set_ylabel("memory, MiB", color=MEMORY)
    axis.set_xlabel(LABELS[along])
    axis.set_title(others(along, points[0]["size"]), fontsize=9)
    axis.grid(visible=True, which="both", alpha=0.2)


def amount(along: str, size: dict[str, Any]) -> int:
    """The size along one dimension."""
    width, height = size["image_px"]
    return int(width * height if along == "pixels" else size[along])


def others(along: str, size: dict[str, Any]) -> str:
    """The sizes along the other dimensions."""
    texts = {
        "agents": f"{size['agents']} agents",
        "objects": f"{size['objects']} objects",
        "pixels": "{} × {} pixels".format(*size["image_px"]),
    }
    return ", ".join(text for name, text in texts.items() if name != along)


if __name__ == "__main__":
    main()
