"""Lines of sight: what a performer knows of what another can see, by straight lines from the other's eye."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taskgist.demonstrator.means import Means, Roles
from taskgist.demonstrator.script import Script
from taskgist.demonstrator.supports import POINT_SPACING_M
from taskgist.errors import SceneError
from taskgist.world import Scene, Stage, object_points
from taskgist.world.geometry.rotations import normalized

Array = NDArray[np.float64]

HEAD_MOVES_M = 0.05 * np.array([(0, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)])
"""Nobody keeps the head quite still: what is hidden is hidden from these places around the eye, too."""
INWARD = 0.03
"""How much nearer to its middle than its surface a thing is looked at: lines to its very edges would miss it."""
SHOWN_SHARE = 0.4
"""What is shown is in view to so much, at least: fingers may cover the rest."""


def share_in_view(stage: Stage, target: str, thing: str) -> float:
    """Share of the lines from somebody's eye to a thing that nothing else is on, as the stage shows them."""
    agent = stage.scene.agent(target)
    eye = stage.eye(agent).position
    points = object_points(stage, thing, POINT_SPACING_M)
    lines = points + INWARD * (points.mean(axis=0) - points) - eye
    geoms, _ = stage.cast(eye, normalized(lines), exclude_body=agent.eye_exclude_body)
    return float(np.isin(geoms, stage.scene.seen_geoms(thing)).mean())


def would_be_hidden(stage: Stage, target: str, thing: str, points: Array, *, but: tuple[str, ...] = ()) -> bool:
    """Whether something is on every line from around somebody's eye to where a thing's points (n, 3) would be.

    Args:
        stage: The scene.
        target: Who looks.
        thing: The thing; where it is now does not count.
        points: Where points of its surface would be.
        but: Owners that do not count, because they will not stay where they are.
    """
    agent, owners = stage.scene.agent(target), stage.scene.owners
    head, passing = stage.eye(agent), {thing, *but}
    for move in HEAD_MOVES_M:
        eye = head.to_world(move)
        lines = points - eye
        geoms, distances = stage.cast(eye, normalized(lines), exclude_body=agent.eye_exclude_body)
        blocked = (geoms >= 0) & (distances < np.linalg.norm(lines, axis=1) - 0.001)
        if not all(blocked) or any(owners[geom] in passing for geom in geoms):
            return False
    return True


def seen_first(roles: Roles, means: Means) -> Means:
    """Means of a performer who takes something out of view, and finds no sense in that if it is not in view."""

    def script(scene: Scene) -> Script:
        share = share_in_view(Stage(scene), roles.target, roles.thing)
        if share < SHOWN_SHARE:
            raise SceneError(
                f"{roles.thing!r} is not in view in the beginning",
                where=scene.name,
                value=round(share, 2),
                hint="draw another room",
            )
        return means(scene)

    return script
