"""What bodies cannot do, what is in the way, and what is unknown."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from taskgist.errors import UnknownNameError
from taskgist.perspective import (
    ABILITIES,
    Ability,
    Amount,
    Effort,
    Viewpoint,
    able,
    actions_of,
    least_effort,
    view_of,
    visibility,
)
from taskgist.perspective.candidates import Candidate, Candidates
from taskgist.perspective.effort import Held, Miss, Reason
from taskgist.perspective.floor import Floor, Place, moved
from taskgist.perspective.gaze import aimed
from taskgist.perspective.search import Solution, least
from taskgist.perspective.viewpoint import FindMiss, Hit
from taskgist.settings import DEFAULT
from taskgist.world import Scene, Stage
from tools.rooms import COARSE, Person, Room, Thing, chair, table, wall

CUP = Thing("cup", (0.03, 0.05), (0.9, 0.1, 0.77), "cylinder")
SITTING = Person("P1", (0.0, 0.0), 0.0, "sitting")
STANDING = Person("P1", (0.0, 0.0))
BEHIND = wall("wall", -0.26, half=(0.02, 3.0, 1.2))
"""Right behind a chair, which has no room to be pushed back."""
HEAD = frozenset({"Pan_Head", "Tilt_Head"})


def cup_at(x: float, y: float, z: float) -> Thing:
    return replace(CUP, place=(x, y, z))


def head_aimed(stage: Stage, target: np.ndarray) -> dict[int, float]:
    """Head angles by index into qpos with which P1, where it is, looks at a target."""
    (candidates,) = Viewpoint(stage, "P1", COARSE).candidates.of_level(1, target)
    head = candidates.torso.frames.usable(HEAD)
    return head.changes(aimed(candidates.frames(0), head.neck, target))


def all_candidates(here: Viewpoint, level: int, target: np.ndarray) -> list[Candidate]:
    return [batch[index] for batch in here.candidates.of_level(level, target) for index in range(len(batch))]


class WholeBody:
    """Where a whole body is free, never sure beforehand."""

    def __init__(self, here: Viewpoint) -> None:
        self._here = here

    def clear(self, offsets_m: np.ndarray) -> list[bool]:
        return [False] * len(offsets_m)

    def free(self, offset_m: tuple[float, float]) -> bool:
        here = self._here
        return here.collisions.blocking(moved(here.state, here.agent, offset_m)) is None


def floor_of(here: Viewpoint) -> list[Place]:
    """All places that can be got to, with collisions as of the whole body."""
    floor = Floor(here.state, here.agent, here.settings.efforts, WholeBody(here))
    return [place for batch in floor.batches() for place in batch]


def effort(room: Room, ability: Ability, name: str = "cup") -> Effort:
    return least_effort(room.stage(), "P1", name, ability, COARSE)


@pytest.mark.parametrize("angle_deg", range(-180, 180, 20))
def test_the_head_turns_no_further_than_its_range(angle_deg: int) -> None:
    stage = Room((), (STANDING,)).stage()
    agent = stage.scene.agent("P1")
    direction = math.radians(angle_deg)
    target = np.array((2 * math.cos(direction), 2 * math.sin(direction), 3.5 if angle_deg % 40 else 0.0))
    angles = head_aimed(stage, target)
    pan, tilt = (math.degrees(angles[agent.joints[joint]]) for joint in ("head_pan", "head_tilt"))
    assert abs(pan) <= 80 + 1e-9
    assert -50 - 1e-9 <= tilt <= 60 + 1e-9
    if abs(angle_deg) <= 50:
        assert pan == pytest.approx(angle_deg, abs=8)


def test_the_head_aims_within_a_degree() -> None:
    stage = Room((), (replace(STANDING, joints_deg=(("torso_turn", 20), ("torso_lean", 15))),)).stage()
    agent = stage.scene.agent("P1")
    for target in np.array([(1.0, 0.6, 1.3), (0.8, 0.2, 1.2), (2.0, -0.3, 1.5), (0.7, 0.1, 1.1)]):
        angles = head_aimed(stage, target)
        x, y, z = stage.show(stage.state.replace(angles)).eye(agent).to_local(target)
        assert math.degrees(math.atan2(math.hypot(y, z), x)) < 1.0
        stage.show(stage.scene.initial)


def test_an_angle_beyond_the_range_may_stay() -> None:
    turned = replace(STANDING, joints_deg=(("head_tilt", -55.0),))
    stage = Room((), (turned,)).stage()
    agent = stage.scene.agent("P1")
    angles = head_aimed(stage, np.array((0.2, 0.0, 0.0)))
    assert math.degrees(angles[agent.joints["head_tilt"]]) == pytest.approx(-55.0)


@pytest.mark.parametrize(
    ("level", "joints", "moves"),
    [
        (2, {"torso_turn", "torso_lean"}, False),
        (3, {"torso_turn", "torso_lean", "legs"}, True),
        (4, {"torso_lean", "legs"}, True),
    ],
)
def test_nothing_moves_but_the_joints_of_the_level(level: int, joints: set[str], moves: bool) -> None:
    room = Room((chair(0.0), table(1.2), CUP), (SITTING, Person("P2", (2.2, 0.0), math.pi)))
    stage = room.stage()
    agent = stage.scene.agent("P1")
    legs = (*agent.profile.legs.hips, *agent.profile.legs.knees, *agent.profile.legs.ankles)
    allowed = {agent.joints[j] for j in joints - {"legs"}} | {agent.joints[j] for j in legs if "legs" in joints}
    allowed |= set(range(agent.base.start, agent.base.stop)) if moves else set()
    changed: set[int] = set()
    for candidate in all_candidates(Viewpoint(stage, "P1", COARSE), level, np.array((0.9, 0.1, 0.8))):
        changed |= set(np.flatnonzero(candidate.state.qpos != stage.scene.initial.qpos).tolist())
    assert changed
    assert changed <= allowed


def test_who_walks_turns_the_chest_to_the_object() -> None:
    turned = replace(STANDING, yaw=0.3, joints_deg=(("torso_turn", 40),))
    stage = Room((), (turned,)).stage()
    agent = stage.scene.agent("P1")
    target = np.array((-1.0, 2.0, 1.0))
    candidates = all_candidates(Viewpoint(stage, "P1", COARSE), 4, target)
    assert len({candidate.amount.moved_m for candidate in candidates}) > 2
    for candidate in candidates:
        if "Bend_Hips" in candidate.actions:
            continue  # what the torso was turned by is pitched with the pelvis
        chest = stage.show(candidate.state).site(stage.scene.model.site("P1/chest").id)
        assert "Turn_Torso" not in candidate.actions
        ahead = target[:2] - candidate.state.qpos[agent.base][:2]
        np.testing.assert_allclose(
            chest.matrix[:2, 0] / np.linalg.norm(chest.matrix[:2, 0]), ahead / np.linalg.norm(ahead), atol=1e-9
        )


def test_of_equal_amounts_the_best_is_taken() -> None:
    stage = Room((CUP,), (STANDING,)).stage()
    here = Viewpoint(stage, "P1", COARSE)
    turn = here.agent.joints["torso_turn"]

    class LeftTurns:
        """Every candidate will do, the farther left the better."""

        brief = hopeless = False
        target = here.target("cup")

        def __init__(self, candidates: Candidates | None = None) -> None:
            self.candidates = candidates

        def unknown(self, level: int) -> str | None: ...

        def passes_over(self, level: int) -> bool:  # noqa: ARG002
            return False

        def without_effort(self) -> FindMiss:
            return self.miss

        def screen(self, candidates: Candidates) -> LeftTurns:
            return LeftTurns(candidates)

        def next(self, start: int, stop: int) -> int:
            return min(start, stop)

        def results(self, index: int) -> Iterator[Hit | FindMiss]:
            assert self.candidates is not None
            yield Hit(lambda: Held("left"), cost=-float(self.candidates[index].state.qpos[turn]))

        def miss(self) -> Miss:
            return Miss(Reason.NOT_HELD, "no")

    for level in (2, 4):
        found = least(here, LeftTurns(), level, np.array((1.0, 0.0, 1.0)))
        assert isinstance(found, Solution)
        assert found.amount == (Amount(torso_rad=0.5) if level == 2 else Amount())
    narrow = replace(COARSE, efforts=replace(COARSE.efforts, turn_step_rad=0.2))
    found = least(Viewpoint(stage, "P1", narrow), LeftTurns(), 2, np.zeros(3))
    assert isinstance(found, Solution)
    assert found.state.qpos[turn] == 0.2


def test_standing_up_is_free_without_a_table_and_blocked_by_one_over_the_thighs() -> None:
    high = cup_at(0.5, 0.2, 1.75)
    free = effort(Room((chair(0.0), high), (SITTING,)), "reach")
    assert (free.level, free.actions, free.posture) == (3, ("Make_Standing", "Stretch_Out_Arm(left)"), "standing")
    blocked = effort(Room((chair(0.0), BEHIND, table(0.55), high), (SITTING,)), "reach")
    assert blocked.level == 5
    assert "against table" in blocked.reason
    contact = {"part": "legs", "other": "table", "depth_m": pytest.approx(0.05, abs=0.05)}
    assert blocked.evidence_document["miss"] == {"blocking": contact}


def test_standing_up_is_blocked_by_a_lamp_above() -> None:
    lamp = Thing("lamp", (0.6, 0.6, 0.02), (0.4, 0.0, 1.6), free=False)
    blocked = effort(Room((chair(0.0), BEHIND, lamp, cup_at(0.5, 0.3, 1.75)), (SITTING,)), "reach")
    assert blocked.level == 5
    assert "head against lamp" in " ".join(map(str, blocked.evidence_document["not_with_less"]))  # type: ignore[call-overload]


def test_what_the_agent_holds_is_not_in_its_way() -> None:
    """A board in the hand before the chest would stop it from leaning."""
    board = Thing("board", (0.02, 0.15, 0.15), (0.22, -0.2, 1.2))
    room = Room((board, cup_at(1.0, 0.2, 1.1)), (STANDING,))
    stage = room.stage()
    hand = stage.site(stage.scene.agent("P1").arm("right").palm_site).position
    held = stage.state.replace(at=stage.scene.object_slice("board"), to=(*hand, 1, 0, 0, 0))
    assert "board" not in {stage.scene.owners[g] for g in Viewpoint(stage.show(held), "P1").collisions.obstacles}
    assert "board" in {
        stage.scene.owners[g] for g in Viewpoint(stage.show(stage.scene.initial), "P1").collisions.obstacles
    }


def test_a_present_contact_does_not_block_but_a_deeper_one_does() -> None:
    post = Thing("post", (0.05, 0.05, 0.3), (0.155, 0.0, 1.2), free=False)
    stage = Room((post,), (STANDING,)).stage()
    here = Viewpoint(stage, "P1")
    agent = here.agent
    assert any(stage.overlaps(agent.core_geoms, here.collisions.obstacles))
    assert here.collisions.blocking(stage.scene.initial) is None
    leaned = stage.scene.initial.replace({agent.joints["torso_lean"]: 0.5})
    blocking = here.collisions.blocking(leaned)
    assert blocking is not None
    assert (blocking.part, blocking.other) == ("torso", "post")


def test_sitting_down_needs_a_seat() -> None:
    low = cup_at(0.45, 0.2, 0.45)
    stage = Room((low, chair(-0.43)), (STANDING,)).stage()
    here = Viewpoint(stage, "P1", COARSE)
    assert here.candidates.other_posture is not None
    assert here.candidates.other_posture.actions == ("Make_Sitting",)
    for seat in ((), (chair(-0.43, height=0.2),), (chair(-0.43, height=0.8),), (chair(-0.43, y=0.6),)):
        assert Viewpoint(Room((low, *seat), (STANDING,)).stage(), "P1", COARSE).candidates.other_posture is None


def test_nobody_walks_through_a_thin_wall() -> None:
    room = Room((wall("wall", 0.4, half=(0.005, 20.0, 1.2)),), (replace(STANDING, stature=1.0),))
    here = Viewpoint(room.stage(), "P1", DEFAULT)
    floor = floor_of(here)
    assert len(floor) > 50
    assert max(place.offset_m[0] for place in floor) < 0.4
    at = {place.offset_m[0] for place in floor}
    assert here.collisions.blocking(moved(here.state, here.agent, (0.25, 0.0))) is None
    assert here.collisions.blocking(moved(here.state, here.agent, (0.5, 0.0))) is None
    assert 0.25 in at


def test_the_way_round_is_longer_than_the_straight_one() -> None:
    def ways(*things: Thing) -> dict[tuple[float, float], float]:
        here = Viewpoint(Room(things, (STANDING,)).stage(), "P1", DEFAULT)
        return {(round(p.offset_m[0], 6), round(p.offset_m[1], 6)): p.way_m for p in floor_of(here)}

    free, round_about = ways(), ways(wall("wall", 0.6, half=(0.02, 0.5, 1.2)))
    assert free[(1.5, 0.0)] == pytest.approx(1.5)
    assert round_about[(1.5, 0.0)] > 1.9
    assert list(free.values()) == sorted(free.values())


def test_untracked_object_is_unknown() -> None:
    stage = untracked(Room((CUP,), (STANDING,)).stage(), "cup")
    assert visibility(stage, "P1", "cup") is None
    for ability in ABILITIES:
        found = least_effort(stage, "P1", "cup", ability)
        assert (found.level, found.name, found.actions, found.amount) == (None, None, (), None)
        assert found.reason == "cup not tracked"
        assert able(stage, "P1", "cup", ability, max_level=4) is None


def test_untracked_head_leaves_sight_unknown_and_reach_known() -> None:
    stage = untracked(Room((cup_at(0.5, 0.2, 1.2),), (STANDING,)).stage(), "P1/head")
    assert visibility(stage, "P1", "cup") is None
    assert least_effort(stage, "P1", "cup", "see").level is None
    assert least_effort(stage, "P1", "cup", "reach").level == 1


def test_untracked_agent_is_unknown_to_the_end() -> None:
    stage = untracked(Room((cup_at(0.5, 0.2, 1.2),), (STANDING,)).stage(), "P1")
    assert [least_effort(stage, "P1", "cup", ability).level for ability in ABILITIES] == [None] * 3


def test_untracked_legs_leave_what_needs_them_unknown() -> None:
    near, far = Room((cup_at(0.5, 0.2, 1.2),), (STANDING,)), Room((cup_at(1.7, 0.2, 1.2),), (STANDING,))
    assert least_effort(untracked(near.stage(), "P1/legs"), "P1", "cup", "reach").level == 1
    stage = untracked(far.stage(), "P1/legs")
    found = least_effort(stage, "P1", "cup", "reach")
    assert found.level is None
    assert found.reason == "P1's legs not tracked"
    assert found.posture is None
    assert able(stage, "P1", "cup", "reach", max_level=2) is False
    assert able(stage, "P1", "cup", "reach", max_level=3) is None


def test_an_untracked_hand_might_hold_what_is_in_the_air_and_near() -> None:
    near, far = cup_at(0.5, 0.2, 1.2), cup_at(1.7, 0.2, 1.2)
    stage = untracked(Room((near,), (STANDING,)).stage(), "P1/left_arm")
    found = least_effort(stage, "P1", "cup", "reach")
    assert found.level is None
    assert "left hand not tracked" in found.reason
    assert able(stage, "P1", "cup", "reach", max_level=0) is None
    assert able(stage, "P1", "cup", "reach", max_level=1) is True
    away = untracked(Room((far,), (STANDING,)).stage(), "P1/left_arm")
    assert able(away, "P1", "cup", "reach", max_level=0) is False
    resting = untracked(Room((table(0.8), replace(CUP, place=(0.45, 0.2, 0.77))), (STANDING,)).stage(), "P1/left_arm")
    assert able(resting, "P1", "cup", "reach", max_level=0) is False


def untracked(stage: Stage, *names: str) -> Stage:
    state = stage.state
    return stage.show(type(state)(state.qpos, state.time_s, frozenset(names)))


@pytest.mark.parametrize(
    ("agent", "name", "ability"), [("P9", "cup", "see"), ("P1", "cap", "see"), ("P1", "cup", "taste")]
)
def test_unknown_names_are_refused_with_the_known_ones(agent: str, name: str, ability: str) -> None:
    with pytest.raises(UnknownNameError, match="known"):
        least_effort(Room((CUP,), (STANDING,)).stage(), agent, name, ability)  # type: ignore[arg-type]


def test_a_body_without_neck_torso_joints_legs_and_left_arm_is_judged_by_the_same_code() -> None:
    """A robot's profile may leave out whatever its body does not have."""
    room = Room((table(0.9), CUP, Thing("side", (0.05,), (1.0, 2.0, 1.5), "sphere")), (STANDING,))
    files = dict(room.scene().bundle)
    files["P1.profile.toml"] = without(files["P1.profile.toml"].decode()).encode()
    stage = Stage(Scene.from_bundle(files))
    agent = stage.scene.agent("P1")
    assert actions_of(agent) == ("Tilt_Head", "Move_To", "Stretch_Out_Arm(right)")
    assert view_of(stage, "P1").geoms.shape == (240, 320)
    aside = least_effort(stage, "P1", "side", "see", COARSE)
    assert (aside.level, aside.actions) == (4, ("Move_To",))
    for ability in ABILITIES:
        found = least_effort(stage, "P1", "cup", ability, COARSE)
        assert found.level is not None
        assert set(found.joints_rad) == {"head_tilt"}
        assert "left" not in " ".join(found.actions)


def without(profile: str) -> str:
    """The profile of a body that only tilts its head, moves about and has a right arm."""
    first, second = profile.index("[[arms]]"), profile.rindex("[[arms]]")
    profile = profile[:first] + profile[second:]
    for table_name in ("[torso]", "[posture]"):
        start = profile.index(table_name)
        profile = profile[:start] + profile[profile.index("\n\n", start) :]
    return "\n".join(line for line in profile.splitlines() if not line.startswith("pan ="))


def test_what_lies_in_the_cone_but_not_in_the_image_is_out_of_view() -> None:
    """The image of a camera may be lower than its gaze cone is wide."""
    files = dict(Room((Thing("cup", (0.05,), (1.0, 0.0, 1.25), "sphere"),), (STANDING,)).scene().bundle)
    files["P1.profile.toml"] = files["P1.profile.toml"].replace(b"fov_deg = [120, 105]", b"fov_deg = [120, 30]")
    found = least_effort(Stage(Scene.from_bundle(files)), "P1", "cup", "see")
    assert found.level == 1
    assert found.reason.startswith("out of view, 2")
