"""Make the capability maps that come with the package: those of people, who would wait for them otherwise.

    python -m tools.arm_maps

One map serves all people of usual proportions, left and right. It is named by a digest of the arm and of how it is
sampled; older ones are taken away. Other bodies' maps are made when they are first met, in seconds.
"""

from __future__ import annotations

from taskgist.world.bodies.capability import SAMPLES, SHIPPED, CapabilityMap, keep, usual_arm


def main() -> None:
    """Make them anew."""
    SHIPPED.mkdir(exist_ok=True)
    for file in SHIPPED.glob("*.npz"):
        file.unlink()
    file = keep(CapabilityMap.of(usual_arm(), SAMPLES), SHIPPED)
    print(f"{file.name}: {file.stat().st_size:,} bytes")


if __name__ == "__main__":
    main()
