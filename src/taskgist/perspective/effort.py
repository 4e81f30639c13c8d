"""Effort: what it takes an agent to see, reach or grasp an object, as a value with its evidence (5.1.5, Fig. 6).

Everything here is a plain, frozen value, and this module needs neither numpy nor MuJoCo: efforts can be read, compared,
told and stored wherever Python runs. How efforts are found is told in ``search``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, astuple, dataclass, field, fields
from enum import Enum
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, get_args

if TYPE_CHECKING:
    from taskgist.world.bodies.profile import Posture

Ability = Literal["see", "reach", "grasp"]
ABILITIES: tuple[Ability, ...] = get_args(Ability)
NO_KNOWN_LEVEL = 5
"""Level of what no known action achieves."""

_LIMBS: Mapping[Ability, str] = {"see": "Head", "reach": "Arm", "grasp": "Arm"}
EFFORT_NAMES: Mapping[Ability, tuple[str, ...]] = {
    ability: (
        "No_Effort_Required",
        f"{limb}_Effort",
        f"{limb}_Torso_Effort",
        "Whole_Body_Effort",
        "Displacement_Effort",
        "No_Possible_Known_Effort",
    )
    for ability, limb in _LIMBS.items()
}
"""Effort types by level, 0 to 5 (Fig. 6)."""

# --- Virtual actions: what an agent might do, by the paper's names (Eq. 1-6), and how much of it.

PAN, TILT = "Pan_Head", "Tilt_Head"
LOOK = "Turn_Eyes"
"""Where eyes are turned aside, and look where the head does again (ours): the least that is done to see."""
TURN, LEAN = "Turn_Torso", "Lean_Torso"
STAND, SIT = "Make_Standing", "Make_Sitting"
BEND, CROUCH, LIFT = "Bend_Hips", "Crouch", "Lift_Torso"
"""Of the whole body, as standing up is (ours): the paper's bodies reach nothing that is lower than an arm is long."""
PUSH, SIDLE = "Push_Seat_Back", "Move_Along_Seat"
"""What whoever sits at a table does before standing up (ours): on a chair, or on a bench or sofa."""
MOVE = "Move_To"
NO_ACTION = "No_Action_Required"
"""What level 0 takes (5.1.5)."""
NO_KNOWN_ACTION = "No_Possible_Known_Action"
"""What level 5 takes."""


def stretch(side: str) -> str:
    """Name of stretching out the arm of a side (Eq. 3)."""
    return f"Stretch_Out_Arm({side})"


@dataclass(frozen=True, order=True)
class Amount:
    """How much of an effort: compared in this order, so that a step weighs more than any turn (5.1.6).

    Attributes:
        lowered_m: How far the hips are lowered, or the torso lifted or lowered, metres: people rather take a step.
        bent_rad: How far the pelvis is pitched over the legs, radians.
        moved_m: Length of the way over the floor, metres.
        turned_rad: Turn of the whole body on the spot, radians.
        torso_rad: Turn and lean of the torso together, radians.
        head_rad: Pan and tilt of the head together, radians.
    """

    lowered_m: float = 0.0
    bent_rad: float = 0.0
    moved_m: float = 0.0
    turned_rad: float = 0.0
    torso_rad: float = 0.0
    head_rad: float = 0.0

    @property
    def key(self) -> tuple[float, ...]:
        """For comparing: rounded, so that equal amounts stay equal wherever the scene stands."""
        return tuple(round(amount, 6) for amount in astuple(self))


# --- Evidence that an ability holds: what was found in the attained state.

Vector = tuple[float, float, float]
"""A point in metres, or a direction, in the world."""


@dataclass(frozen=True)
class Visibility:
    """How much of an object is visible, from one state (5.1.1).

    Attributes:
        visible_px: Pixels of the object in the image of the whole field of view; parts of a pixel count as such, and
            what is too small to be made out as nothing (setting ``vision.least_visible_arcmin2``).
        image_px: Pixels of that image.
        unoccluded_px: Pixels that the object would have if nothing stood in the way.
        gaze_px: Those of the visible pixels that lie in the gaze cone; none if they are too few to be made out.
        occluders: What covers the object's pixels, and how many of them, most first.
        nearest_m: Distance from the eye to the nearest point seen, in metres; None where nothing is seen.
        off_gaze_rad: Angle between the gaze and the object's middle.
        eyes_rad: How far the eyes were assumed to be turned in the head, radians.
        eyes_towards: The thing that they were assumed to look at; None where nothing was assumed of them.
    """

    visible_px: float
    image_px: int
    unoccluded_px: float
    gaze_px: float
    occluders: tuple[tuple[str, float], ...]
    nearest_m: float | None
    off_gaze_rad: float
    eyes_rad: float = 0.0
    eyes_towards: str | None = None

    @property
    def score(self) -> float:
        """ViS: pixels of the object / pixels of the image (5.1.1)."""
        return self.visible_px / self.image_px

    @property
    def visible_share(self) -> float:
        """Occlusion ratio: visible pixels / pixels if nothing stood in the way; 0 out of the field of view."""
        return self.visible_px / self.unoccluded_px if self.unoccluded_px else 0.0

    @property
    def in_gaze_cone(self) -> bool:
        """Whether something of the object is seen in the gaze cone."""
        return self.gaze_px > 0


def assumed_gaze(towards: str, turned_rad: float) -> str:
    """What was assumed of eyes, as a part of a sentence."""
    return f"the eyes assumed to turn {math.degrees(turned_rad):.0f}° towards the {towards}"


@dataclass(frozen=True)
class Held:
    """The object is in the agent's hand: reached and grasped without effort.

    ``arm`` is the hand's side.
    """

    arm: str


@dataclass(frozen=True)
class Reached:
    """An arm reaches a point of the object.

    Attributes:
        arm: Its side.
        point_m: The point that is nearest to the shoulder.
        distance_m: How far it is from there.
    """

    arm: str
    point_m: Vector
    distance_m: float


Prepared = Literal["", "tilted", "slid over the edge", "drawn aside"]
"""What a hand does to an object before it grasps it: nothing, mostly."""


@dataclass(frozen=True)
class Grasped:
    """A hand closes on the object, free of collisions.

    Attributes:
        arm: Its side.
        hand: Kind of the hand.
        point_m: Half-way between the two points that it closes on.
        distance_m: How far that is from the shoulder.
        width_m: How far the two points are apart.
        closing: Unit direction from the thumb's point to the fingers'.
        approach: Unit direction in which the palm comes.
        prepared: What is done to the object first; then the others tell of what it is afterwards.
    """

    arm: str
    hand: str
    point_m: Vector
    distance_m: float
    width_m: float
    closing: Vector
    approach: Vector
    prepared: Prepared = ""


@dataclass(frozen=True)
class GraspedByBoth:
    """Both hands of an agent press on the object from two sides, free of collisions.

    Attributes:
        arms: Their sides.
        hand: Kind of the hands.
        points_m: Where each of them presses.
        distances_m: How far that is from each shoulder.
        width_m: How far the two points are apart.
        closing: Unit direction from the first point to the second.
        approach: Unit direction in which both hands come.
    """

    arms: tuple[str, str]
    hand: str
    points_m: tuple[Vector, Vector]
    distances_m: tuple[float, float]
    width_m: float
    closing: Vector
    approach: Vector


Attained = Visibility | Held | Reached | Grasped | GraspedByBoth
"""What shows that an ability holds."""

# --- Evidence that an ability does not hold.


@dataclass(frozen=True)
class Occlusion:
    """Something else hides the object, or leaves less of it than is made out.

    Attributes:
        occluders: What hides it, and how many pixels, most first.
        unoccluded_px: Pixels that the object would have alone.
        eye_m: Where the eye is.
        hits_m: One point at which each of the occluders is met.
    """

    occluders: tuple[tuple[str, float], ...]
    unoccluded_px: float
    eye_m: Vector
    hits_m: tuple[tuple[str, Vector], ...]


@dataclass(frozen=True)
class OutOfReach:
    """The arm that misses the object least: its side, and by how much it is too short, None outside of its sector."""

    arm: str
    beyond_m: float | None = None


@dataclass(frozen=True)
class Blocking:
    """A contact that blocks.

    Attributes:
        part: The agent's own part.
        other: What it meets: an object, a piece of furniture or another agent.
        depth_m: How deep.
    """

    part: str
    other: str
    depth_m: float

    def __str__(self) -> str:
        return f"{self.part} against {self.other}, {self.depth_m:.2f} m deep"


@dataclass(frozen=True)
class BlockedArm:
    """What is in the way of an arm that would reach the object otherwise.

    Attributes:
        arm: Its side.
        counts: What is in the way, and of how many configurations of the arm, most first.
        shut_in: Whether no way at all leads from the object to where an arm could come from.
    """

    arm: str
    counts: tuple[tuple[str, int], ...]
    shut_in: bool = False


@dataclass(frozen=True)
class BlockedApproaches:
    """What is in the way of the grasps within reach, and of how many of them, most first."""

    counts: tuple[tuple[str, int], ...]


Hindrance = Occlusion | OutOfReach | Blocking | BlockedArm | BlockedApproaches
"""What shows that an ability does not hold."""


class Reason(Enum):
    """Why an ability does not hold."""

    NO_HAND = "the agent has no hand that grasps"
    NO_OPPOSITE_FACES = "the object has no two faces to close a hand on"
    TOO_WIDE = "the hand does not open that wide"
    TOO_NARROW = "not all fingers meet the object"
    COLLISION = "head, torso or base would push into something"
    SHUT_IN = "no way leads from the object to an arm"
    ARM_BLOCKED = "something is in the way of every arm that would reach the object"
    NO_FREE_GRASP = "something is in the way of every grasp within reach"
    FROM_BEHIND = "grasps within reach would come from behind"
    ONE_HAND = "it takes both hands, and only one reaches it"
    OUT_OF_SECTOR = "the object is near enough, where the arm does not get to"
    TOO_FAR = "the object is farther away than the arm is long"
    OCCLUDED = "something hides all of the object"
    TOO_SMALL = "the object is too small to be made out"
    BESIDE_GAZE = "the object is in view, beside the gaze cone"
    OUT_OF_VIEW = "the object is out of the field of view"
    BEYOND_NECK = "the head does not turn far enough"
    NOT_HELD = "no hand of the agent holds the object"
    NO_ARM = "no arm may be stretched out"
    NO_SURFACE = "the object has no surface"
    NO_TORSO = "the torso does not move"
    NO_POSTURE = "there is no other posture to take"
    NO_STANDING = "standing up before walking is blocked"
    NO_WALKING = "the agent does not move about"
    UNTRACKED = "what would decide was not tracked"


TOLD_FIRST: tuple[frozenset[Reason], ...] = (
    frozenset({Reason.NO_HAND, Reason.NO_OPPOSITE_FACES, Reason.TOO_WIDE, Reason.TOO_NARROW}),  # nothing helps
    frozenset({Reason.SHUT_IN}),
    frozenset({Reason.COLLISION}),  # it would do but for that
    frozenset({Reason.NO_FREE_GRASP}),
    frozenset({Reason.ARM_BLOCKED}),
    frozenset({Reason.FROM_BEHIND}),
    frozenset({Reason.ONE_HAND}),
    frozenset({Reason.OUT_OF_SECTOR}),
    frozenset({Reason.TOO_FAR}),
    frozenset({Reason.OCCLUDED, Reason.TOO_SMALL, Reason.BESIDE_GAZE, Reason.OUT_OF_VIEW}),
    frozenset({Reason.BEYOND_NECK}),
    frozenset(
        {
            Reason.NOT_HELD,
            Reason.NO_ARM,
            Reason.NO_SURFACE,
            Reason.NO_TORSO,
            Reason.NO_POSTURE,
            Reason.NO_STANDING,
            Reason.NO_WALKING,
        }
    ),
    frozenset({Reason.UNTRACKED}),
)
"""Of several reasons why an ability does not hold, the first is told; those in one set are compared by quantity."""
_RANKS: Mapping[Reason, int] = {reason: rank for rank, reasons in enumerate(TOLD_FIRST) for reason in reasons}


@dataclass(frozen=True)
class Quantity:
    """How far an ability is from holding: a value and its unit, metres or radians. Reasons of one rank share one."""

    value: float
    unit: Literal["m", "rad"]


@dataclass(frozen=True)
class Miss:
    """Why an ability does not hold in a state, or by the candidates of an effort level.

    Attributes:
        reason: The kind.
        text: For people.
        quantity: How far the ability is, where that is a matter of degree.
        hindrance: What shows it.
    """

    reason: Reason
    text: str
    quantity: Quantity | None = None
    hindrance: Hindrance | None = None

    @property
    def order(self) -> tuple[int, float, str]:
        """The least of several is worth telling: by reason, then by quantity; equal ones by their text."""
        return (_RANKS[self.reason], self.quantity.value if self.quantity else 0.0, self.text)


def nearest_miss(misses: Sequence[Miss]) -> Miss:
    """The one of some misses, at least one, that is told."""
    return min(misses, key=lambda miss: miss.order)


@dataclass(frozen=True)
class Evidence:
    """What shows an effort.

    Attributes:
        reason: A short sentence: why this level.
        misses: Why not with less: one for each level that does not give the ability, from 0 on. Where the level is
            unknown, the last one says what was not tracked.
        told: The miss that ``reason`` tells; None where there was none.
        attained: What was found in the attained state; None at level 5 and if unknown.
        untried: What might be possible at level 5, and was left untried; None if nothing was.
    """

    reason: str
    misses: tuple[Miss, ...]
    told: Miss | None
    attained: Attained | None
    untried: str | None = None

    @property
    def prepared(self) -> Prepared:
        """What is done to the object before a hand grasps it."""
        return self.attained.prepared if isinstance(self.attained, Grasped) else ""


def evidence_document(evidence: Attained | Hindrance | None) -> dict[str, object]:
    """What shows that an ability holds or not, as plain data, fit for JSON."""
    match evidence:
        case None:
            return {}
        case Visibility():
            return _visibility_document(evidence)
        case Held():
            return {"arm": evidence.arm, "held": True}
        case Occlusion():
            return {
                "occluders": [[owner, count] for owner, count in evidence.occluders],
                "unoccluded_px": evidence.unoccluded_px,
                "eye_m": list(evidence.eye_m),
                "hits_m": {owner: list(point) for owner, point in evidence.hits_m},
            }
        case Blocking():
            return {"blocking": asdict(evidence)}
        case BlockedApproaches():
            return {"approaches": dict(evidence.counts)}
        case BlockedArm():
            return {"arm": evidence.arm, "in_the_way": dict(evidence.counts), "shut_in": evidence.shut_in}
        case OutOfReach():
            return {name: value for name, value in asdict(evidence).items() if value is not None}
        case Reached() | Grasped() | GraspedByBoth():
            told = {name: value for name, value in vars(evidence).items() if value != ""}
            return {name: _listed(value) for name, value in told.items()}


def _visibility_document(seen: Visibility) -> dict[str, object]:
    told = {"score": seen.score, **asdict(seen), "occluders": [[owner, count] for owner, count in seen.occluders]}
    if seen.eyes_towards is None:  # nothing was assumed
        del told["eyes_rad"], told["eyes_towards"]
    return told


def _listed(value: object) -> object:
    """Tuples as lists."""
    return [_listed(each) for each in value] if isinstance(value, tuple) else value


@dataclass(frozen=True)
class Effort:
    """The least effort of one ability of one agent towards one object.

    Attributes:
        ability: ``see``, ``reach`` or ``grasp``.
        agent: Whose.
        target: The object.
        level: 0 to 5, or None where it is unknown: what would decide was not tracked.
        actions: Virtual actions A_v in order; ``No_Action_Required`` at level 0, ``No_Possible_Known_Action`` at 5,
            none if unknown.
        amount: How much of it; None at level 5 and if unknown.
        joints_rad: Angles in radians of the head's and the torso's joints in the attained state S, by name (an
            arm has many ways to be stretched out: its joints are not told). At level 5 and if unknown, those of the
            current state.
        posture: Posture in that state; None if unknown.
        turns_rad: By how much each of the actions turns its joint of head or torso, signed, radians.
        find_evidence: Finds the evidence; asked at most once, and only if somebody wants to know.
    """

    ability: Ability
    agent: str
    target: str
    level: int | None
    actions: tuple[str, ...]
    amount: Amount | None
    joints_rad: Mapping[str, float] = field(hash=False)
    posture: Posture | None
    turns_rad: Mapping[str, float] = field(hash=False)
    find_evidence: Callable[[], Evidence] = field(compare=False, repr=False)

    @cached_property
    def evidence(self) -> Evidence:
        """What was found in the attained state, and why not with less."""
        return self.find_evidence()

    @property
    def reason(self) -> str:
        """A short sentence: why this level."""
        return self.evidence.reason

    @property
    def is_known_to_do(self) -> bool:
        """Whether it is known that some effort does: not unknown, and not level 5."""
        return self.level is not None and self.level < NO_KNOWN_LEVEL

    @property
    def name(self) -> str | None:
        """Type of the effort, by its name in Fig. 6; None if unknown."""
        return None if self.level is None else EFFORT_NAMES[self.ability][self.level]

    @property
    def evidence_document(self) -> dict[str, object]:
        """The evidence as plain data, fit for JSON."""
        evidence, told = self.evidence, self.evidence.told
        amount = {} if self.amount is None else {"amount": asdict(self.amount)}
        untried = {} if evidence.untried is None else {"untried": evidence.untried}
        return {
            "reason": evidence.reason,
            "not_with_less": [miss.text for miss in evidence.misses],
            "miss": evidence_document(told.hindrance if told else None),
            **amount,
            **untried,
            **evidence_document(evidence.attained),
        }

    @property
    def document(self) -> dict[str, object]:
        """All of it as plain data, fit for JSON."""
        return {
            "ability": self.ability,
            "agent": self.agent,
            "target": self.target,
            "level": self.level,
            "actions": self.actions,
            "amount": None if self.amount is None else asdict(self.amount),
            "joints_rad": self.joints_rad,
            "posture": self.posture,
            "effort": self.name,
            "evidence": self.evidence_document,
            "reason": self.reason,
        }

    def __reduce__(self) -> tuple[object, ...]:
        """To another process goes the evidence, not who finds it."""
        values = {each.name: getattr(self, each.name) for each in fields(self) if each.name != "find_evidence"}
        return _with_evidence, (values, self.evidence)


def _with_evidence(values: dict[str, Any], evidence: Evidence) -> Effort:
    """An effort whose evidence is known."""
    return Effort(**values, find_evidence=lambda: evidence)
