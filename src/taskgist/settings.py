"""Every threshold and default, named, with its unit and source, in one place.

Settings are immutable values that are passed down explicitly. The ``digest`` of those that shape facts travels with
every explanation, so that facts inferred with other settings are never counted together by accident.

Sources: "paper" is Pandey & Alami; "authors' code" their published C++ implementation; "ours" a choice of taskgist,
whose reason stands beside it.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
from dataclasses import dataclass, field
from typing import Literal


@dataclass(frozen=True)
class Vision:
    """How visibility is measured (5.1.1)."""

    least_visible_arcmin2: float = 5.0
    """Least visible area of an object that is seen, square minutes of arc: a coin of 2.2 cm at 30 m (people: a thing
    2.5' across; normal sight tells details of 1' apart [ISO 8596], and what is smaller than 2' across counts no longer
    by its shape and area, but by its light alone [Lamar 1947])."""
    transparent_alpha: float = 0.5
    """What has a colour of at most this alpha is looked through; it is seen by who looks for it (ours: panes, bottles
    and covers are drawn with 0.1 to 0.4)."""
    negligible_score: float = 1e-4 / 2**11
    """Fraction of the image below which a visibility score is "≈ 0" (ours: what a person just sees, 5 square minutes of
    arc in the middle of an image of 320 × 240; bins begin here)."""
    bins_per_doubling: float = 1.0
    """Logarithmic bins of the score per doubling (ours: one bin per factor of two)."""
    change_tolerance: float = 0.25
    """Relative change below which two scores are Almost_Same, Eq. 12 (ours)."""


ReachModel = Literal["capability", "sector"]


@dataclass(frozen=True)
class Reach:
    """When an object counts as reachable (5.1.2)."""

    cell_m: float = 0.05
    """Edge of a workspace cell; an object is reached by any of its cells (authors' code: 5 cm)."""
    model: ReachModel = "capability"
    """What an arm reaches: what its joints bring its palm to, where nothing solid is in the way of the arm
    ("capability", ours), or a sector about the shoulder, whatever is in the way ("sector", the paper's)."""
    touch_m: float = 0.045
    """Longest straight way from the palm to the point that it is to touch (ours: half the diagonal of a cell)."""


@dataclass(frozen=True)
class Grasp:
    """How grasps are sampled and tested (5.1.3)."""

    cell_m: float = 0.03
    """Spacing of the points of an object's surface at which grasps are tried (ours)."""
    approaches: int = 8
    """Directions tried around the closing axis of each pair of opposite points (ours)."""
    clearance_m: float = 0.005
    """Gap kept between fingers and object before closing (ours)."""
    facing: float = 0.0
    """Least cosine between the approach and the direction shoulder → grasp: none is approached from behind (ours)."""
    opposed_rad: float = math.radians(20.0)
    """Largest deviation of two faces from being opposite, for a hand to close on them (ours: friction about 0.36)."""
    upright_rad: float = math.radians(20.0)
    """Greatest angle with the vertical at which a hand closes from above and beneath (ours: as of opposite faces)."""
    flat_m: float = 0.05
    """Thickest thing that counts as flat: people tilt it with one hand; thicker ones they lift with both (ours)."""
    flat_ratio: float = 2.0
    """How many times as wide as thick a flat thing is, at least (ours: others are pinched from their sides)."""
    tilts_rad: tuple[float, ...] = (math.radians(25.0), math.radians(50.0))
    """Angles by which people tilt a flat thing about its far edge to get their fingers beneath (ours: a book of 16 cm
    is lifted by 7 cm then, a coaster of 5 cm by 4; fingers and their clearance take 2.3 cm)."""
    slide_m: float = 0.5
    """Farthest that a flat thing's front is from the edge over which it is slid (ours: most of an arm's length)."""
    asides_m: tuple[float, ...] = (0.03, 0.05)
    """How far people draw aside what lies against a wall (ours: a finger, its clearance, and a little; out of a corner,
    half the breadth of four fingers)."""
    overhang_m: float = 0.06
    """How far a flat thing is slid over an edge, at most; it is 0.4 of its depth where that is less, so that it stays
    lying (ours: fingers get two thirds of their length beneath)."""


@dataclass(frozen=True)
class Efforts:
    """Sampled virtual actions of each effort level (Eq. 1-6, Fig. 6)."""

    lean_step_rad: float = 0.25
    """Step of the torso's lean (authors' code)."""
    turn_step_rad: float = math.radians(15.0)
    """Step of the torso's turn (ours)."""
    head_steps: int = 6
    """Steps from the present head direction to the one aimed at the object (ours)."""
    move_radius_m: float = 8.0
    """Farthest displacement considered (ours: from end to end of a room; what is left untried is told)."""
    move_step_m: float = 0.25
    """Grid of floor positions, anchored at the agent (ours)."""
    collision_m: float = 0.01
    """A contact deeper than now by more than this blocks (ours: tracked bodies touch and overlap a little)."""
    passing_m: float = 0.05
    """A contact that is deeper than now by no more than this does not stop who walks by (ours: legs and clothes yield,
    feet are turned aside, as between a sofa and its table)."""
    seat_height_m: tuple[float, float] = (0.25, 0.70)
    """Heights of surfaces that people sit down onto (ours: from a child's stool to a low bar stool)."""
    bends: tuple[tuple[float, float], ...] = tuple(
        (share, math.radians(pitch))
        for share, pitch in (
            *((0.0, 15), (0.0, 30), (0.0, 45), (0.03, 60), (0.06, 75), (0.10, 30), (0.10, 60)),
            *((0.15, 15), (0.20, 45), (0.25, 30), (0.30, 30)),
        )
    )
    """Bends and crouches that are tried, the least first: how far the hips are lowered, as a share of the stature, and
    how far the pelvis is pitched (ours: with the torso's lean they reach down to the floor in about equal steps, and
    bring the eyes below a table)."""
    lift_step_m: float = 0.1
    """Step of a torso that is lifted (ours)."""
    sliding_seat_m: float = 0.8
    """A seat that is no larger than this either way slides (ours: chairs and stools; sofas and benches are longer)."""
    leaving_seat_m: float = 1.2
    """Farthest that a seat is pushed back, or that somebody moves along it, to stand up (ours: two seats)."""
    leaving_step_m: float = 0.05
    """Step of that (ours: who is hemmed in uses what room there is)."""
    state_bin_rad: float = math.radians(15.0)
    """Bin of the joint angles that make the symbol of an attained state S (ours)."""


@dataclass(frozen=True)
class Contact:
    """Holding, support and containment in one state (5.2.2, 5.3)."""

    grip_m: float = 0.03
    """Largest gap between hand and a held object in one state (ours: fit errors of tracked hands are of this
    order); over time see ``carrying``."""
    support_m: float = 0.015
    """Largest gap between an object and what it rests on (ours)."""
    lift_m: float = 0.05
    """Virtual lift with which the direction of a support is measured, robust to interpenetration (ours)."""
    support_slope_rad: float = math.radians(30.0)
    """Steepest contact that still supports (ours)."""
    container_walls: float = 0.9
    """Share of horizontal directions in which a container's own wall must stand (ours)."""
    container_m: float = 0.6
    """Farthest wall of a container from what is inside (ours)."""
    sitting_thigh_rad: float = math.radians(45.0)
    """Thighs inclined further than this from the vertical sit (ours)."""


@dataclass(frozen=True)
class Carrying:
    """Who carries a thing over time: how what is seen in each frame speaks for each answer, in natural logarithms.

    All are ours, found on noisy synthetic handovers and held against the grip forces of real ones
    (docs/research/holding.md).
    """

    near_m: float = 0.3
    """Farthest gap at which a hand may still hold a thing, trackers being as far off; also the mean gap of hands that
    pass by."""
    hands: int = 3
    """As many hands at once hold a thing at most."""
    window_s: float = 0.2
    """Window over which speeds, slips and falls are measured."""
    delay_s: float = 0.5
    """How long after a frame it is decided live."""
    independent_s: float = 0.15
    """Time after which what is seen is news, and not the error of the frames before."""
    gap_noise_m: tuple[float, float] = (0.012, 0.10)
    """Least and greatest error of gaps that is believed, estimated where a thing travels."""
    slip_noise_m_s: tuple[float, float] = (0.03, 0.4)
    """The same of slips: speeds of a palm in the thing's frame."""
    pressed_m: float = 0.02
    """How much deeper a hand is in a thing for it to be e times as likely the one that holds."""
    pressed_most_m: float = 0.06
    """Beyond that depth nothing is added."""
    slip_weight: float = 0.5
    """Weight of the slip beside the gap: fingers move before a hand lets go, and after it has closed."""
    idle_m_s: float = 0.1
    """Speed of hands that have nothing to do with a thing, where the thing stands still."""
    still_m_s: float = 0.05
    """Speed below which a thing stands still."""
    passes_m_s: float = 0.3
    """Slip above which a hand goes along a thing that stands still, and does not hold it (where slips have larger
    errors, three deviations)."""
    passes: float = 2.0
    """Against such a hand."""
    further_hand: float = 1.5
    """Against each hand beside the first of the same person."""
    further_person: float = 2.0
    """Against each person beside the first."""
    closing_s: float = 0.3
    """How long fingers are around a thing that another hand holds, before they press and after they have let go (grip
    forces of real handovers)."""
    nobody: float = 0.5
    """Against a thing that nobody carries and that stands still in the air."""
    nobody_travels: float = 2.0
    """Against a thing that nobody carries, faster than 0.1 m/s."""
    falls: float = 20.0
    """For nobody, where a thing falls freely."""
    fall_m_s2: float = 3.0
    """Largest difference from the acceleration of gravity in a free fall."""
    change_hand: float = 2.0
    """Against each hand that takes or lets go."""
    change_rest: float = 2.0
    """The same where the thing is taken from a support, or put onto one; or from or to a hand that is not seen."""
    change_nobody: float = 3.0
    """Against a thing that is thrown, dropped or caught, in addition."""


@dataclass(frozen=True)
class Timing:
    """Facts over time: minimum durations and hysteresis (ours; paper 5.3.2 leaves them open)."""

    minimum_s: float = 0.2
    """A placement, hand or motion fact is confirmed when it has lasted this long; it is backdated to its onset."""
    motion_window_s: float = 0.2
    """Window over which an object's speed is measured."""
    moving_m_s: float = 0.10
    """Speed above which a static object starts to move."""
    static_m_s: float = 0.05
    """Speed below which a moving object comes to rest."""
    turning_moves: bool = True
    """Whether turning in place is motion: then the speed is that of the thing's fastest point, not of its middle (ours:
    Eq. 22 speaks of position)."""


@dataclass(frozen=True)
class Gaze:
    """Where the eyes of people look in recordings that do not say it (docs/how/gaze.md)."""

    inferred: bool = True
    """Whether eyes turn towards what the hands take, hold and work on; otherwise the gaze is the head's direction."""
    range_rad: float = math.radians(35.0)
    """How far eyes turn in the head, at most (in healthy people 44 ± 7° to each side, 47 ± 8° down, 28 ± 8° up [Lee et
    al. 2019]: nine in ten get as far as 35° to the sides and down; that is where displays end, too [LaValle 2023])."""
    before_s: float = 0.5
    """How long before a hand holds or moves a thing the eyes are at it (0.56 s on average [Land et al. 1999])."""


@dataclass(frozen=True)
class Relations:
    """Relations that are asked for, beside the tree. They shape no fact of the tree and stay out of the digest."""

    free_share: float = 0.95
    """Least share of a thing that is in sight where the line of sight is *free* (ours: what covers a twentieth, such
    as the edge of a plate or the tip of a finger, nobody speaks of)."""
    gaze_rad: float = math.radians(15.0)
    """Greatest angle between the head's direction and what is looked at (ours: heads make about two thirds of a turn
    of the gaze, 69 % [Stiefelhagen & Zhu 2002]; who looks 45° aside turns the eyes by 14° of it)."""
    near_m: float = 1.2
    """Farthest that a thing is *near* to an agent (the end of the personal distance [Hall 1966]: with a step, or
    leaning, it is at hand)."""
    change_m: float = 0.2
    """Change of a distance below which it is the same (ours: people who stand sway, and who sits shifts, by less)."""
    beside_m: float = 0.3
    """Largest gap between two things that are near to each other (ours: a handspan or
    more, as between what stands together on a table)."""
    direction_rad: float = math.radians(67.5)
    """Half-angle of each of left, right, front and behind (ours: eight sectors of 45°; in every other one, two of
    them hold)."""
    overhead_m: float = 0.1
    """Level distance below which a thing is at no side, being above or beneath (ours: half the breadth of a head)."""
    facing_rad: float = math.radians(30.0)
    """Greatest angle between where the chest points and what is faced (ours: what lies farther aside people turn
    to)."""
    touching_m: float = 0.01
    """Largest gap between what touches (ours: tracked hands are some millimetres off)."""
    approach_window_s: float = 0.6
    """Window over which it is measured whether somebody approaches (ours: about a step; people sway within one)."""
    approach_start_m_s: float = 0.25
    """Speed towards a thing above which it is approached (ours: a slow walk has 0.5 m/s, who sways has 0.1)."""
    approach_stop_m_s: float = 0.1
    """Speed below which it no longer is (ours)."""


@dataclass(frozen=True)
class Following:
    """What counts as standing still where a tracker is followed (``world.steadied``).

    It shapes no facts of recordings, and stays out of the digest: explanations ask exact states.
    """

    place_m: float = 0.01
    """How far a body may move before it is taken for moved, at any of its shapes (ours: people who stand sway by as
    much, and trackers tremble by less)."""
    turn_rad: float = math.radians(1.0)
    """How far any part of it may turn (ours)."""
    frames: int = 12
    """Over how many frames at most its positions are averaged (ours: noise of 0.2° in each joint turns a hand by 1.7°
    from one frame to the next now and then; averaged so, by a third of that)."""
    motion: float = 3.0
    """So many tolerances away from the average is motion, not noise: averaging begins anew (ours)."""

    @property
    def exact(self) -> bool:
        """Whether every state is taken as it is."""
        return self.place_m == 0.0 and self.turn_rad == 0.0


@dataclass(frozen=True)
class Maps:
    """The grid of ability maps. It shapes no facts and stays out of the digest."""

    cell_m: float = 0.05
    """Edge of a cell (authors' code: 5 cm)."""
    half_width_m: float = 1.5
    """How far the grid extends ahead, behind and to each side of the agent (authors' code)."""
    height_m: float = 2.0
    """How far it extends above the floor (authors' code: 2 to 2.5 m)."""


@dataclass(frozen=True)
class Planning:
    """How fast robots move. These shape no facts and stay out of the digest (all ours: unhurried beside people)."""

    joint_rad_s: float = 1.0
    """Highest speed of an arm's joints that turn."""
    joint_rad_s2: float = 2.0
    """Their highest acceleration."""
    lift_m_s: float = 0.1
    """Highest speed of joints that slide."""
    lift_m_s2: float = 0.2
    """Their highest acceleration."""
    base_m_s: float = 0.5
    """Highest speed of a base along each axis of the floor."""
    base_m_s2: float = 0.5
    """Its highest acceleration."""
    base_rad_s: float = 0.8
    """Highest speed at which a base turns."""
    base_rad_s2: float = 0.8
    """Its highest acceleration."""
    closing_s: float = 0.7
    """How long a hand takes to close or open."""


@dataclass(frozen=True)
class Learning:
    """The m-estimate and its bands (Eq. 27, 33-35). These shape verdicts, not facts, and stay out of the digest."""

    m: int = 2
    """Equivalent sample size a + b (paper 6.3: 2)."""
    prior: tuple[int, int] = (1, 2)
    """Prior probability of a value as an exact fraction, a = m × prior (paper 6.3: a = 1)."""
    band: str = "narrow"
    """Named confusion band; see ``BANDS``."""


@dataclass(frozen=True)
class Limits:
    """What is refused before memory is taken for it. These shape no facts and stay out of the digest.

    All are ours: far above what rooms, robots and recordings hold, and together below 2 GiB.
    """

    document_bytes: int = 64 * 2**20
    """Largest text document that is read: scene, profile, mapping, model, facts."""
    bundle_bytes: int = 512 * 2**20
    """Scene files of a recording together: models, meshes, height fields."""
    toml_bytes: int = 4 * 2**20
    """Largest TOML document: scene, profile, mapping; a second or two are spent on a mebibyte."""
    model_elements: int = 30_000
    """Elements of a model's document, with what it includes and repeats."""
    model_bodies: int = 3_000
    """Bodies of a model: MuJoCo needs some seconds for these, half a minute for 10,000; rooms have hundreds."""
    model_depth: int = 200
    """How deep the elements of a document, or the links of a robot, hang one below the other."""
    mesh_bytes: int = 128 * 2**20
    """Largest mesh or height field in a file: one of 2.5 million triangles in STL."""
    mesh_faces: int = 1_000_000
    """Triangles of a mesh; scans for robots have up to 200,000."""
    mesh_parts: int = 1_000
    """Convex parts of a concave mesh; ordinary ones have up to 200. What has more collides as its convex hull."""
    cutting_s: float = 120.0
    """Time for cutting the concave meshes of a scene, once; most take 2 to 6 s each. The rest collide as hulls."""
    hfield_pixels: int = 150_000_000
    """Pixels of all height fields of a model together: nine of 4,096 × 4,096."""
    array_length: int = 1_000_000
    """Numbers that a model asks MuJoCo to make room for in one place."""
    arena_bytes: int = 2**30
    """Working memory that a model asks MuJoCo for."""
    chunk_bytes: int = 256 * 2**20
    """Largest chunk of a recording, unpacked; common writers make chunks of 1 to 16 MiB."""
    message_bytes: int = 4 * 2**20
    """One message, or one record of what is known of a recording; a state of two people and six objects has 2 kB."""
    frame_bytes: int = 512 * 2**20
    """States of a recording in memory: five hours of two people and six objects at 30 Hz."""
    table_bytes: int = 512 * 2**20
    """One table or array of tracked motion, unpacked."""
    image_pixels: int = 4_000_000
    """Pixels of an eye's image: a camera of 2,000 × 2,000."""
    object_extent_m: float = 10.0
    """Longest edge of the box around an object; what is longer is mostly given in millimetres."""
    body_shapes: int = 1_000
    """Shapes of one agent or object; the published robots that ship have up to 200."""
    knowledge_wait_s: float = 30.0
    """Longest that knowledge is waited for while others write it, which takes each of them milliseconds."""


@dataclass(frozen=True)
class Checks:
    """What ``check`` tells of a recording. These shape no facts and stay out of the digest."""

    fastest_m_s: float = 15.0
    """What moves faster from one tracked frame to the next has jumped (ours: people sprint at 10 m/s, and what they
    carry or hand over stays below that; a thing that trackers confuse with another is there at once)."""
    largest_m: float = 5.0
    """A shape of an object that is longer was mostly given in millimetres (ours: nobody hands over a longer thing)."""
    smallest_m: float = 0.001
    """An object whose shapes are all smaller was mostly shrunk a thousandfold (ours: nobody grasps a smaller)."""
    apart_m: float = 0.10
    """Gap to a hand that moves with a thing above which their trackers' frames are told to disagree (ours: bare wrists
    and noisy keypoints are 5 to 8 cm off)."""
    apart_most_m: float = 0.15
    """Above this, facts of who holds and reaches what are not to be trusted (ours: longer than a hand is wide)."""
    along: float = 0.35
    """A hand moves with a thing if their velocities differ by less than this share of the thing's (ours)."""
    travels_s: float = 0.5
    """A thing that travels for longer is held by somebody, unless it flies (ours: short gaps are the tracker's)."""
    off_floor_m: float = 0.10
    """Soles farther from the floor than this are told of (ours: shoes and fitted feet are some centimetres off)."""
    off_floor_most_m: float = 0.30
    """Farther than this, efforts of the whole body are not to be trusted (ours: higher than any step)."""
    dangling_m: float = 0.45
    """Feet of people who sit may be this far over the floor (ours: on a bar stool, thighs level)."""
    frozen_s: float = 0.5
    """People whose pose stays exactly the same for longer were not tracked (ours: who stands sways by millimetres)."""
    abrupt: float = 0.005
    """Least step, metres or radians, with which a lost tracker's pose stops or goes on (ours: 15 cm/s at 30 frames a
    second; who comes to rest slows down before)."""
    turned_rad: float = math.radians(20.0)
    """Nothing is turned by more from one frame to the next (ours: at 30 frames a second, more than a turn and a half
    in a second)."""
    least_confidence: float = 0.5
    """Confidence below which no label is proposed (ours: then more speaks against it than for it)."""
    begins_s: float = 0.2
    """A recording in which the thing is moved sooner begins too late (ours: so long a fact must last to count)."""


UNSHAPING = ("relations", "following", "maps", "planning", "learning", "limits", "checks")
"""Stages whose settings shape no facts: they stay out of the digest."""

BANDS: dict[str, tuple[tuple[int, int], tuple[int, int]]] = {
    "narrow": ((3, 10), (1, 10)),
    "wide": ((6, 10), (1, 10)),
    "sharp": ((3, 10), (3, 10)),
}
"""Named bands (l1, l2) as exact fractions: d1 = Q − l1·Q, d2 = Q − l2·Q. narrow: Eq. 34-35; wide: 7.3 (10-60 %);
sharp (ours): nothing is confusing, so that nothing is asked, and one error in seven demonstrations is forgiven
(docs/research/evaluation.md)."""


@dataclass(frozen=True)
class Settings:
    """All settings, by the stage that uses them."""

    vision: Vision = field(default_factory=Vision)
    reach: Reach = field(default_factory=Reach)
    grasp: Grasp = field(default_factory=Grasp)
    efforts: Efforts = field(default_factory=Efforts)
    contact: Contact = field(default_factory=Contact)
    carrying: Carrying = field(default_factory=Carrying)
    timing: Timing = field(default_factory=Timing)
    gaze: Gaze = field(default_factory=Gaze)
    relations: Relations = field(default_factory=Relations)
    following: Following = field(default_factory=Following)
    maps: Maps = field(default_factory=Maps)
    planning: Planning = field(default_factory=Planning)
    learning: Learning = field(default_factory=Learning)
    limits: Limits = field(default_factory=Limits)
    checks: Checks = field(default_factory=Checks)

    @property
    def digest(self) -> str:
        """Short digest of the settings that shape facts, 12 hexadecimal digits."""
        shaping = {name: value for name, value in dataclasses.asdict(self).items() if name not in UNSHAPING}
        text = json.dumps(shaping, sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:12]


DEFAULT = Settings()
"""The settings used where none are given."""
