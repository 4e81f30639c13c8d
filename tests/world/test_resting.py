"""What objects rest on and lie in is remembered as long as nothing can have changed it, and no longer."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from taskgist.settings import DEFAULT
from taskgist.world import Fitter, Scene, Stage, State
from taskgist.world.contacts import Rest, RestingMemory, rest_of
from tests.scenes import TABLE, agent, box, cylinder, scene
from tests.shipped import recording

TOP = 0.72
CUP = (-0.25, -0.15, TOP + 0.05)
COIN_HALF_M = 0.004
BIN = """<body name="bin" pos="0.2 0.3 0.72"><freejoint/>
<geom type="box" size="0.1 0.1 0.005" pos="0 0 0.005"/>
<geom type="box" size="0.1 0.005 0.1" pos="0 0.1 0.1"/><geom type="box" size="0.1 0.005 0.1" pos="0 -0.1 0.1"/>
<geom type="box" size="0.005 0.1 0.1" pos="0.1 0 0.1"/><geom type="box" size="0.005 0.1 0.1" pos="-0.1 0 0.1"/>
</body>"""


@pytest.fixture(scope="module")
def room() -> Scene:
    """A cup, a coin and a box on the table, a tape in a bin."""
    return scene(
        TABLE,
        BIN,
        cylinder("cup", *CUP),
        cylinder("tape", 0.2, 0.3, TOP + 0.04, half=0.03),
        cylinder("coin", 0.2, 0.0, TOP + COIN_HALF_M, radius=0.005, half=COIN_HALF_M),
        box("box", 0.2, -0.2, TOP + 0.05, (0.05, 0.05, 0.05)),
        agents=agent("P1", -0.8, 0),
    )


@pytest.fixture(scope="module")
def flat_hand(room: Scene) -> State:
    """A hand lies flat on the table beside the cup."""
    fitter = Fitter(room, "P1", moving="upper_body", weights={"right_wrist": 10.0})
    flat = {"right_hand": (1, 0, 0), "right_palm": (0, 0, -1)}
    return fitter.fit(room.initial, points={"right_wrist": (CUP[0] - 0.12, CUP[1], TOP + 0.02)}, directions=flat).state


def agrees(memory: RestingMemory, stage: Stage) -> dict[str, Rest]:
    """What the memory says of all objects; it is what is found at once."""
    found = {name: memory(stage, name) for name in stage.scene.objects}
    assert found == {name: rest_of(stage, name, DEFAULT.contact) for name in stage.scene.objects}
    return found


STEPS = st.tuples(
    st.sampled_from(["P1", "P1", "P1", "cup", "tape", "bin", "box"]),
    st.sampled_from([0.0, 0.05, -0.05, 0.2, -0.2]),
    st.sampled_from([0.0, 0.0, 0.1]),
    st.sampled_from([frozenset[str](), frozenset[str](), frozenset({"bin"}), frozenset({"box"}), frozenset({"P1"})]),
)


@settings(max_examples=30)
@given(st.lists(STEPS, min_size=1, max_size=12))
def test_the_memory_says_what_is_found_at_once(
    room: Scene, flat_hand: State, steps: list[tuple[str, float, float, frozenset[str]]]
) -> None:
    memory, stage, qpos = RestingMemory(room, DEFAULT.contact), Stage(room), np.array(flat_hand.qpos)
    for name, along_m, up_m, lost in steps:
        at = room.base_slice(name) if name == "P1" else room.object_slice(name)
        qpos[at.start] += along_m
        qpos[at.start + 2] += up_m
        agrees(memory, stage.show(State(qpos, 0.0, lost)))


def test_a_hand_that_comes_between_is_noticed_and_so_is_that_it_left(room: Scene, flat_hand: State) -> None:
    """The cup's points are lifted into a hand, whose underside they meet instead of the box."""
    stage = Stage(room, flat_hand)
    palm = stage.site(room.agent("P1").arm("right").palm_site).position
    below = palm - (0.0, 0.0, 0.5)
    geoms, distances = stage.cast(below, [(0.0, 0.0, 1.0)], only=room.agent("P1").arm("right").hand_geoms)
    assert geoms[0] >= 0
    underside = below + (0.0, 0.0, distances[0])
    state = flat_hand
    for name, middle_m in (("coin", COIN_HALF_M - 0.002), ("box", -0.05 - 0.003)):
        state = state.replace(at=room.object_slice(name), to=(*underside + (0.0, 0.0, middle_m), 1, 0, 0, 0))
    away = state.replace({room.base_slice("P1").start: -3.0})
    memory = RestingMemory(room, DEFAULT.contact)
    found = [agrees(memory, stage.show(each))["coin"].support for each in (away, state, state, away)]
    assert found == ["box", None, None, "box"]


def test_what_lies_in_a_bin_lies_there_as_long_as_neither_moves(room: Scene) -> None:
    memory, stage = RestingMemory(room, DEFAULT.contact), Stage(room)
    assert agrees(memory, stage)["tape"] == Rest("bin", "bin")
    away = room.initial.replace({room.object_slice("bin").start: 3.0})
    assert agrees(memory, stage.show(away))["tape"].container is None


def test_little_is_measured_while_only_people_move(room: Scene) -> None:
    memory, stage, state = RestingMemory(room, DEFAULT.contact), Stage(room), room.initial
    spent = []
    for frame in range(3):
        state = state.replace({room.base_slice("P1").start: -0.8 - 0.01 * frame})
        before = stage.show(state).counts["rays"]
        memory(stage, "tape")
        spent.append(stage.counts["rays"] - before)
    assert spent[0] > 0
    assert spent[1:] == [0, 0]


def test_nothing_is_measured_anew_while_something_else_moves_far_away(room: Scene) -> None:
    """Only what the box comes near to is decided anew, and what is carried."""
    memory, stage, column = RestingMemory(room, DEFAULT.contact), Stage(room), room.object_slice("box").start
    agrees(memory, stage)
    for along_m, anew in ((0.05, {"box"}), (0.1, {"box"}), (-0.45, {"box", "cup"}), (-1.5, {"box", "cup"})):
        stage.show(room.initial.replace({column: 0.2 + along_m}))
        spent = {}
        for name in room.objects:
            before = stage.counts["rays"]
            memory(stage, name)
            spent[name] = stage.counts["rays"] - before
        assert {name for name, rays in spent.items() if rays} == anew
        agrees(memory, stage)


@pytest.mark.parametrize("name", ["handover_4", "hide_b"])
def test_in_recordings(name: str) -> None:
    whole = recording(name)
    memory, stage = RestingMemory(whole.scene, DEFAULT.contact), Stage(whole.scene)
    for index in range(0, len(whole), 5):
        agrees(memory, stage.show(whole.state(index)))
