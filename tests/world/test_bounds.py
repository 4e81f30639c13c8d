"""Many rays at once meet the same shapes as one ray after the other, also where a body shows more than collides."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from taskgist.world.bodies.agent import SEEN_MASK
from taskgist.world.geometry.distances import bound_all_shapes

SHOWN = 'contype="0" conaffinity="0" group="1"'
WORLD = """<mujoco><worldbody><geom type="plane" size="5 5 0.1"/>
<body name="it" pos="0.2 0 1" euler="10 20 30"><freejoint/>
 <geom type="{kind}" size="{size}" pos="0.1 0.3 0" euler="40 0 10" {shown}/>
 <geom type="box" size="0.05 0.1 0.02" pos="-0.1 0 0.2" euler="0 50 0" group="3"/>
</body></worldbody></mujoco>"""


@pytest.mark.parametrize(
    ("kind", "size"), [("box", "0.3 0.2 0.1"), ("ellipsoid", "0.2 0.1 0.4"), ("capsule", "0.1 0.3")]
)
@pytest.mark.parametrize("seed", range(4))
def test_what_only_shows_is_met_wherever_the_rays_start(kind: str, size: str, seed: int) -> None:
    model = mujoco.MjModel.from_xml_string(WORLD.format(kind=kind, size=size, shown=SHOWN))
    bound_all_shapes(model)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    rng = np.random.default_rng(seed)
    for origin in (data.geom_xpos[1], *(rng.uniform(-1, 1, (3, 3)) + (0, 0, 1.5))):
        rays = data.geom_xpos[1] + rng.uniform(-0.5, 0.5, (300, 3)) - origin
        rays /= np.linalg.norm(rays, axis=1, keepdims=True)
        met = np.full(len(rays), -1, dtype=np.int32)
        mujoco.mj_multiRay(
            model, data, origin, rays.ravel(), SEEN_MASK, True, -1, met, np.zeros(len(rays)), None, len(rays), 1e10
        )
        one = np.zeros(1, dtype=np.int32)
        single = []
        for ray in rays:
            mujoco.mj_ray(model, data, origin, ray, SEEN_MASK, True, -1, one)
            single.append(int(one[0]))
        assert met.tolist() == single
        assert 1 in single
