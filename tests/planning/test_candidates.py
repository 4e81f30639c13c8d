"""Candidates: they rest where physics leaves them, on everything that can carry them, and where the facts say."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from itertools import islice

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from taskgist.errors import InputError, UnknownNameError
from taskgist.perspective.search import least_effort
from taskgist.pipeline import shipped_room
from taskgist.planning.candidates import NEAR_M, Candidate, Means, candidates
from taskgist.planning.resting import TIP_RAD, level_faces, sides_of
from taskgist.settings import DEFAULT
from taskgist.world import Scene, Stage, container_of, holding_of, support_of
from taskgist.world.dynamics import free_motion
from taskgist.world.scene_file import AgentEntry
from taskgist.world.state import Hold, State
from taskgist_lab.ordinary.furnishing import furnished
from taskgist_lab.ordinary.furniture import chair, drawer, table
from taskgist_lab.ordinary.rooms import scene_of
from taskgist_lab.ordinary.things import KINDS, thing_of
from taskgist_lab.simulator.room import Thing
from tests.meshes import body, bowl, mesh_scene, mug, shelf, shell_bin
from tests.ordinary import a, ball, pen, stands

Array = NDArray[np.float64]
CONTACT = DEFAULT.contact
PEOPLE = "[agents.P1]\nprofile = 'human'\n[agents.P2]\nprofile = 'human'\nposition_m = [2.2, 0.0]\nyaw_deg = 180"


def first(scene: Scene, thing: str, count: int, **asked: object) -> list[Candidate]:
    return list(islice(candidates(Stage(scene), thing, *scene.agents[:2], **asked), count))  # type: ignore[arg-type]


def settled(scene: Scene, candidate: Candidate) -> tuple[float, float]:
    """How far a thing moves, in metres and degrees, when it is let go there."""
    end = free_motion(scene, candidate.state, candidate.thing, longest_s=0.8).end
    cosine = min(1.0, abs(float(end[3:] @ candidate.pose[3:])))
    return float(np.linalg.norm(end[:3] - candidate.pose[:3])), math.degrees(2 * math.acos(cosine))


def sample(found: list[Candidate], count: int, seed: int) -> Iterator[Candidate]:
    rng = np.random.default_rng(seed)
    for index in rng.choice(len(found), min(count, len(found)), replace=False):
        yield found[index]


@pytest.fixture(scope="module")
def room() -> Scene:
    return furnished(7, 0).scene()


@pytest.fixture(scope="module")
def meshes() -> Scene:
    """A bin, a bowl and a shelf of meshes; a mug with a handle."""
    fixed = body("bin", "bin", (0.7, -0.5, 0.0), free=False) + body("shelf", "shelf", (1.0, 0.3, -0.5), free=False)
    free = body("bowl", "bowl", (1.6, -0.6, 0.08)) + body("mug", "mug", (0.6, 0.8, 0.0))
    return mesh_scene(fixed + free, PEOPLE, bin=shell_bin(), shelf=shelf(), bowl=bowl(), mug=mug())


@pytest.mark.parametrize(("number", "thing"), [(0, "pen 0"), (0, "bottle 1"), (3, "book 0"), (5, "pot 0")])
def test_what_is_let_go_there_stays(number: int, thing: str) -> None:
    scene = furnished(7, number).scene()
    for candidate in sample(first(scene, thing, 400), 8, number):
        moved_m, turned_deg = settled(scene, candidate)
        assert moved_m < 0.01, candidate
        assert turned_deg < 5.0, candidate


def test_what_is_let_go_in_and_on_meshes_stays(meshes: Scene) -> None:
    found = first(meshes, "mug", 100, allow=("bin", "shelf"))
    assert {each.carrier for each in found} >= {"bin", "shelf"}
    for candidate in sample(found, 8, 0):
        moved_m, turned_deg = settled(meshes, candidate)
        assert moved_m < 0.01, candidate
        assert turned_deg < 5.0, candidate


@pytest.mark.parametrize("thing", ["glass 2", "pen 0"])
def test_they_are_where_the_facts_say_and_meet_nothing(room: Scene, thing: str) -> None:
    stage = Stage(room)
    own = room.solid_geoms_of(thing)
    others = np.setdiff1d(stage.solid_geoms(), own)
    for candidate in first(room, thing, 300):
        stage.show(candidate.state)
        container = container_of(stage, thing, CONTACT)
        assert candidate.means == ("put_on" if container is None else "put_in")
        assert candidate.carrier == (container or support_of(stage, thing, CONTACT))
        assert -2e-4 <= stage.closest(own, others, limit_m=0.05)[0] <= 1e-3
        unmoved = np.delete(candidate.state.qpos, np.r_[room.object_slice(thing)])
        assert np.array_equal(unmoved, np.delete(room.initial.qpos, np.r_[room.object_slice(thing)]))


def test_the_same_question_has_the_same_answers(room: Scene) -> None:
    once, twice, other = (first(room, "bottle 1", 60, seed=seed) for seed in (3, 3, 4))
    assert np.array_equal([each.pose for each in once], [each.pose for each in twice])
    assert not np.array_equal([each.pose for each in once], [each.pose for each in other])
    stage = Stage(room)
    next(candidates(stage, "bottle 1", room.agents[0], room.agents[1]))
    assert stage.state is room.initial, "the stage of who asks is left as it is"


def test_the_first_are_spread_over_all_supports_sides_and_headings(room: Scene) -> None:
    many = first(room, "keys 17", 1000)
    some = many[:200]
    often = Counter(each.carrier for each in many)
    assert {each.carrier for each in some} >= {carrier for carrier, times in often.items() if times >= 5}
    assert {each.means for each in some} == {"put_on", "put_in"}
    turns = matrices(some)
    assert len(np.unique(np.round(turns[:, 2], 2), axis=0)) == 6, "a book lies on two sides and stands on four"
    on_table = np.array([each.pose[:2] for each in many if each.carrier == "dining table"])
    (face,) = (
        face for face in level_faces(Stage(room), "keys 17") if face.owner == "dining table" and face.area_m2 > 1
    )
    shares = np.linalg.lstsq(face.edges[:, :2].T, (on_table - face.corner[:2]).T, rcond=None)[0].T
    quarters = {(x > 0.5, y > 0.5) for x, y in shares}
    assert len(quarters) == 4
    assert len({each.pose.tobytes() for each in many}) == len(many)


def matrices(found: list[Candidate]) -> Array:
    turns = np.empty((len(found), 9))
    for turn, each in zip(turns, found, strict=True):
        mujoco.mju_quat2Mat(turn, np.array(each.pose[3:]))
    return turns.reshape(-1, 3, 3)


# --- Which supports, and in which order.


@pytest.fixture(scope="module")
def plain() -> Scene:
    """A table with a book and a tin on it, a chair, an open drawer; somebody on either side."""
    pieces = (
        table("table", (0.9, 0.0)),
        chair("chair", (0.9, 1.4)),
        drawer("drawer", (0.3, -1.2), math.pi / 2, height_m=0.7, out_m=0.3),
    )
    things = (
        thing_of("cup", "cup", (0.75, 0.2, 0.74)),
        thing_of("book", "book", (0.9, -0.3, 0.74)),
        thing_of("tin", "tin", (0.95, 0.3, 0.74)),
    )
    return scene_of("plain", pieces, things, (stands(), replace(stands(1.8, 0.0, 180.0), name="Q")))


def test_floors_seats_and_ledges_come_last(plain: Scene) -> None:
    """A chair's back and a drawer's rim carry a cup as well, but nobody would put it there."""
    found = first(plain, "cup", 1500)
    carriers = [each.carrier for each in found]
    assert set(carriers[:1000]) == {"table", "book", "tin", "drawer"}
    assert set(carriers[1000:1200]) == {"chair", "drawer"}
    assert set(carriers[1200:1400]) == {"floor"}
    assert set(carriers[1400:]) <= {"table", "book", "tin", "drawer"}, "and then the others again"


def test_what_is_low_around_a_robots_wheels_is_floor_and_the_bottom_of_a_bin_is_not() -> None:
    room = Scene.load(shipped_room())
    for turned_rad in (0.0, -math.pi / 2):
        scene, state = room.joined_by(AgentEntry("PR2", "pr2", (-0.9, 0.9), turned_rad))
        found = candidates(Stage(scene, state), "cup", "PR2", "P2")
        assert {each.carrier for each in islice(found, 200)} == {"table", "sideboard", "bin", "box", "book", "bottle"}


def test_only_what_is_allowed_and_first_what_is_preferred(plain: Scene) -> None:
    assert {each.carrier for each in first(plain, "cup", 100, allow=["floor"])} == {"floor"}
    both = first(plain, "cup", 60, allow=["floor", "tin"])
    assert {each.carrier for each in both} == {"floor", "tin"}
    assert {each.carrier for each in first(plain, "cup", 50, prefer=["chair"])} == {"chair"}
    with pytest.raises(UnknownNameError, match=r"no support 'tabel'; did you mean 'table'\? \(known: book, "):
        first(plain, "cup", 1, allow=["tabel"])
    with pytest.raises(UnknownNameError, match="no support 'cup'"):
        first(plain, "cup", 1, prefer=["cup"])


def test_questions_that_cannot_be_asked(plain: Scene) -> None:
    for thing, performer, target in (("spoon", "P", "Q"), ("cup", "R", "Q"), ("cup", "P", "R")):
        with pytest.raises(UnknownNameError):
            candidates(Stage(plain), thing, performer, target)
    with pytest.raises(InputError, match="no such means"):
        candidates(Stage(plain), "cup", "P", "Q", means=["throw"])  # type: ignore[list-item]
    lost = State(plain.initial.qpos, untracked=frozenset({"cup"}))
    with pytest.raises(InputError, match="nobody knows where it is"):
        candidates(Stage(plain, lost), "cup", "P", "Q")


def test_where_it_is_now_is_no_candidate(plain: Scene) -> None:
    start = plain.initial.qpos[plain.object_slice("cup")]
    found = np.array([each.pose[:3] for each in first(plain, "cup", 1500, allow=["table"])])
    away_m = np.linalg.norm(found[np.abs(found[:, 2] - start[2]) < 0.01] - start[:3], axis=1)
    assert NEAR_M <= away_m.min() + 1e-9 < 0.1, "but close by there are some"


def test_a_thing_rests_on_smaller_ones_only_in_balance(plain: Scene) -> None:
    found = first(plain, "book", 80, allow=["tin", "cup"])
    flat = [each for each in found if abs(each.pose[2] - 0.74 - 0.08 - 0.015) < 0.03]
    assert {each.carrier for each in flat} >= {"tin"}, "a book of 15 by 22 cm lies on a tin of 8.5 cm"
    for candidate in sample(found, 6, 1):
        assert max(settled(plain, candidate)) < 5.0
        middle = candidate.pose[:2] - plain.initial.qpos[plain.object_slice(candidate.carrier)][:2]
        assert np.linalg.norm(middle) < KINDS[candidate.carrier].radius_m, "its middle is over what carries it"


# --- Which side is down.


def sides(thing: Thing) -> list[float]:
    stage = Stage(scene_of("a thing", [], [thing], [stands()]))
    return [side.tip_rad for side in sides_of(stage, "thing", CONTACT)]


def test_sides_on_which_things_lie_firmly() -> None:
    packet = sides(a("packet", 1.0, 0.0))
    assert packet == pytest.approx([math.atan(w / h) for w, h in PACKET], abs=0.01), "the one that is down first"
    assert len(sides(a("cup", 1.0, 0.0))) == 2, "on its foot and on its rim, but not on its round wall"
    assert len(sides(a("phone", 1.0, 0.0))) == 4, "a phone stands on no edge of 7.5 cm by 8 mm"
    assert min(sides(a("phone", 1.0, 0.0))) > TIP_RAD


PACKET = [(0.03, 0.075), (0.045, 0.03), (0.045, 0.03), (0.03, 0.045), (0.03, 0.045), (0.03, 0.075)]
"""Half of the shorter edge of each side, and how high the middle is above it."""


@pytest.mark.parametrize("thing", [pen(1.0, 0.0), ball(0.1, 1.0, 0.0)])
def test_what_is_round_keeps_its_side(thing: Thing) -> None:
    stage = Stage(scene_of("a thing", [], [thing], [stands()]))
    (side,) = sides_of(stage, "thing", CONTACT)
    assert side.lowest_m == pytest.approx(-thing.size_m[-1] / 2, abs=1e-4)
    assert side.tip_rad < TIP_RAD


def test_the_mass_decides_on_which_side_a_thing_stays() -> None:
    """A beam lies on its long sides, unless a heavy head beyond its end pulls it over."""
    beam = '<geom type="box" size="0.05 0.05 0.1" mass="0.01"/><geom type="box" size="0.03 0.03 0.01" pos="0 0 0.11"'
    lying = {}
    for mass in (1e-4, 1.0):
        scene = mesh_scene(f'<body name="beam" pos="1 0 0.1"><freejoint/>{beam} mass="{mass}"/></body>', PEOPLE)
        found = sides_of(Stage(scene), "beam", CONTACT)
        lying[mass] = [side for side in found if side.center[2] - side.lowest_m == pytest.approx(0.05, abs=1e-3)]
    assert [len(each) for each in lying.values()] == [4, 0]


# --- In hands.


def test_held_up_before_the_face(plain: Scene) -> None:
    stage, found = Stage(plain), first(plain, "cup", 40, means=["hold_up"])
    eye = stage.eye(plain.agent("Q"))
    assert len(found) == 40
    for candidate in found:
        assert (candidate.means, candidate.carrier) == ("hold_up", "P")
        held = holding_of(stage.show(candidate.state), "cup", CONTACT)
        assert held is not None
        assert [agent for agent, _ in held.hands] == ["P"]
        middle = candidate.pose[:3]
        assert 0.3 < np.linalg.norm(middle - eye.position) < 1.2
        to_performer = stage.eye(plain.agent("P")).position - eye.position
        assert (middle - eye.position)[:2] @ to_performer[:2] > 0
        own = plain.solid_geoms_of("cup")
        rest = np.setdiff1d(stage.solid_geoms(), [*own, *np.concatenate([arm.geoms for arm in plain.agent("P").arms])])
        assert stage.closest(own, rest, limit_m=0.02)[0] >= 0.02


def test_handed_over_where_the_taker_reaches(plain: Scene) -> None:
    found = first(plain, "cup", 20, means=["hand_over"])
    assert len(found) == 20
    for candidate in found:
        assert (candidate.means, candidate.carrier) == ("hand_over", "Q")
        held = holding_of(Stage(plain, candidate.state), "cup", CONTACT)
        assert held is not None
        assert [agent for agent, _ in held.hands] == ["Q"]
        before = Stage(plain, candidate.state.with_holding(()))
        assert least_effort(before, "Q", "cup", "reach").level in (1, 2)


def test_other_hands_keep_what_they_hold_and_means_take_turns(plain: Scene) -> None:
    holding = State(plain.initial.qpos, holding=frozenset({Hold("P", "left", "cup"), Hold("Q", "left", "book")}))
    asked: tuple[Means, ...] = ("put_on", "hold_up", "hand_over")
    found = list(islice(candidates(Stage(plain, holding), "cup", "P", "Q", means=asked), 30))
    assert [each.means for each in found] == list(asked) * 10
    for candidate in found:
        assert candidate.state.holding is not None
        assert Hold("Q", "left", "book") in candidate.state.holding
        assert len(candidate.state.holding) == (1 if candidate.means == "put_on" else 2)


# --- Containers.


def test_into_bins_and_drawers_alone(meshes: Scene) -> None:
    found = first(meshes, "mug", 12, means=["put_in"], allow=["bin"])
    assert {(each.means, each.carrier) for each in found} == {("put_in", "bin")}


def test_into_an_open_drawer(plain: Scene) -> None:
    found = first(plain, "cup", 40, means=["put_in"])
    assert {each.carrier for each in found} == {"drawer"}
    assert min(each.pose[2] for each in found) < 0.65, "beneath its rim"
    for candidate in sample(found, 4, 2):
        moved_m, turned_deg = settled(plain, candidate)
        assert moved_m < 0.01
        assert turned_deg < 5.0
