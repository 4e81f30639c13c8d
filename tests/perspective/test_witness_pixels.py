"""Other renderers of the same rooms count the same pixels of every object: within 2 %, or three pixels of an outline.

What has few pixels is counted in parts of them; so do they, in an image that is twice as fine: within 5 %, or
three of its pixels.

Rooms in which somebody's eye is inside of a thing are left out: rasterisers do not draw the back of a surface.
"""

from collections.abc import Callable, Iterator
from functools import cache, partial
from typing import Protocol

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.peers.bullet import TinyRenderer
from benchmarks.peers.embree import Embree
from benchmarks.peers.eye_view import EyeView
from benchmarks.peers.gl import SegmentationRenderer
from taskgist.perspective import view_of, visibility
from taskgist.perspective.image import look
from taskgist.perspective.target import Target
from taskgist.settings import DEFAULT
from tests.perspective.random_rooms import Case, random_case


class Witness(Protocol):
    def image(self) -> NDArray[np.int32]: ...

    def close(self) -> None: ...


def segmentation(view: EyeView) -> Witness:
    return SegmentationRenderer(view, slices=64)


WITNESSES: dict[str, Callable[[EyeView], Witness]] = {"gl": segmentation, "bullet": TinyRenderer, "embree": Embree}
SHARE, FINE_SHARE, OUTLINE_PX = 0.02, 0.05, 3
FINER = 2
WHOLE = 0.998


@pytest.fixture(params=WITNESSES)
def witness(request: pytest.FixtureRequest) -> Iterator[Callable[[EyeView], Witness]]:
    """Makes a renderer of an eye's view; skips where there is none."""
    made: list[Witness] = []

    def make(view: EyeView) -> Witness:
        try:
            made.append(WITNESSES[request.param](view))
        except (ImportError, RuntimeError) as error:
            pytest.skip(f"no such renderer here: {error}")
        return made[-1]

    yield make
    for each in made:
        each.close()


@cache
def room(seed: int, finer: int = 1) -> Case:
    """A room, the same for all witnesses."""
    return random_case(seed, image_px=(320 * finer, 240 * finer), untracked=False, large=False)


@pytest.mark.parametrize("seed", range(300, 308))
def test_other_renderers_count_the_same_pixels(seed: int, witness: Callable[[EyeView], Witness]) -> None:
    case, finer = room(seed), partial(room, seed, FINER)
    stage = case.stage()
    for agent in case.scene.agents[:2]:
        theirs = witness(EyeView.of(case.scene, case.state, agent)).image()
        assert np.mean(view_of(stage, agent).geoms == theirs) > WHOLE
        fine = cache(lambda agent=agent: witness(EyeView.of(finer().scene, finer().state, agent)).image())
        for name in case.scene.objects:
            seen = visibility(stage, agent, name)
            assert seen is not None
            is_small = look(stage, case.scene.agent(agent), Target(stage, name, DEFAULT)).ray_px < 1
            image, share, scale = (fine(), FINE_SHARE, FINER**2) if is_small else (theirs, SHARE, 1)
            count = int(np.isin(image, case.scene.object_geoms(name)).sum())
            assert abs(scale * seen.visible_px - count) <= max(share * count, OUTLINE_PX), (agent, name)


def test_the_rooms_show_objects_of_all_sizes() -> None:
    """Else the test above would compare nothing with nothing."""
    counts = []
    for seed in range(300, 308):
        case = room(seed)
        pixels = view_of(case.stage(), "P1").pixels()
        counts += [pixels.get(name, 0) for name in case.scene.objects]
    assert sum(count > 50 for count in counts) > 10
    assert sum(count > 500 for count in counts) > 3
