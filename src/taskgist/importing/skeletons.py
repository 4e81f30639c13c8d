"""Skeletons that trackers deliver: which of their points are which landmarks, and where on our body each lies.

A tracker's elbow is an elbow, but its *head* may be a mouth, and a marker stands on the skin. Fitted as if they were
our landmarks, such points would bend the body until they agree. So each point says beside which landmark it lies and by
how much, and the fit compares like with like. Points that only repeat others (a neck that is the middle of the
shoulders, a spine of equal thirds) or whose place nobody says are left out: they would tell nothing, and misfit for
ever.

Offsets are centimetres on a body of the stature that stands beside them, and scale with stature: x forward, y outward
(sided points) or left, z up, on a body that stands with hanging arms and the palms at the thighs. *Ours* are read off
our own body and [Winter 2009]; the others name their source.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from taskgist.errors import UnknownNameError
from taskgist.importing.mapping import Vector
from taskgist.world.fit import Marker


@dataclass(frozen=True)
class Beside:
    """Points of a skeleton whose middle lies beside a landmark.

    Attributes:
        points: Their names in the skeleton; with "{side}" as ``Skeleton.sides`` has it.
        landmark: The landmark; of a sided point without its side. Empty: the one that the point is mapped to.
        offset_cm: From the landmark to the point, on a body of the skeleton's stature.
        axes: Landmark with whose body the offset turns, where that is another one.
    """

    points: tuple[str, ...]
    landmark: str = ""
    offset_cm: Vector = (0.0, 0.0, 0.0)
    axes: str = ""


Given = str | Beside
"""A point that is the landmark, or lies beside one."""


@dataclass(frozen=True)
class Skeleton:
    """One tracker's skeleton.

    Attributes:
        title: What people call it.
        source: Where its points are defined.
        names: All its points in their order; empty where points have no order.
        sides: What stands for left and right in its names.
        middle: Landmarks without a side.
        sided: Landmarks of both sides, without the side: "elbow" for ``left_elbow`` and ``right_elbow``.
        stature_m: Of the body on which the offsets were taken.
        axes_by_up: Local axes of parts, by the source's axis that points up, where its bodies have orientations: part,
            what of it ("forward", "up", "palm", "thumb"), axis.
    """

    title: str
    source: str
    names: tuple[str, ...]
    sides: tuple[str, str]
    middle: Mapping[str, Given]
    sided: Mapping[str, Given]
    stature_m: float = 1.75
    axes_by_up: Mapping[str, Mapping[str, Mapping[str, str]]] = field(default_factory=lambda: MappingProxyType({}))

    def points(self) -> dict[str, Beside]:
        """What each landmark is, by landmark, sides filled in."""
        found = {name: _beside(given) for name, given in self.middle.items()}
        for side, theirs, outward in (("left", self.sides[0], 1.0), ("right", self.sides[1], -1.0)):
            for name, given in self.sided.items():
                at = _beside(given)
                x, y, z = at.offset_cm
                found[f"{side}_{name}"] = Beside(
                    tuple(point.replace("{side}", theirs) for point in at.points),
                    f"{side}_{at.landmark}" if at.landmark else "",
                    (x, outward * y, z),
                    at.axes.replace("{side}", side),
                )
        return found

    def markers(self) -> dict[str, Marker]:
        """Points that are no landmarks of ours, by the landmark that they are mapped to; offsets in statures."""
        return {
            name: Marker(at.landmark or name, _shares(at.offset_cm, self.stature_m), at.axes)
            for name, at in self.points().items()
            if at.landmark or any(at.offset_cm)
        }


def _beside(given: Given) -> Beside:
    return Beside((given,)) if isinstance(given, str) else given


def _shares(offset_cm: Vector, stature_m: float) -> Vector:
    x, y, z = (value / 100.0 / stature_m for value in offset_cm)
    return x, y, z


_JOINTS = ("shoulder", "elbow", "wrist", "hip", "knee", "ankle")


def _joints(template: str) -> dict[str, Given]:
    """The six joints of each side, in a skeleton that calls them so."""
    return {
        joint: template.replace("{JOINT}", joint.upper()).replace("{joint}", joint).replace("{Joint}", joint.title())
        for joint in _JOINTS
    }


# --- ZED (Stereolabs) and Azure Kinect (Microsoft): skeletons of a depth camera.
#
# Spine and neck of both are equal parts of the trunk; collar bones lie between neck and shoulder.

_ARM_34 = ("CLAVICLE", "SHOULDER", "ELBOW", "WRIST", "HAND", "HANDTIP", "THUMB")
_LEG_34 = ("HIP", "KNEE", "ANKLE", "FOOT")

# Where the points of BODY_34 lie on a person of 1.70 m, measured on recordings of it (ours). The palms face inward, and
# so do the thumbs.
_HEAD_34 = Beside(("HEAD",), "head_base", (10.7, 0.0, 3.2))  # a point of the mouth
_MOUTH = {"head": _HEAD_34}
_HAND_34: dict[str, tuple[str, Vector]] = {
    "hand": ("wrist", (0.0, 0.0, -6.2)),  # 0.34 of the hand's length: the middle of the palm
    "thumb": ("wrist", (5.7, -2.5, -10.4)),
    "toe": ("ankle", (13.1, 0.0, -5.1)),
    "heel": ("ankle", (-0.4, 0.0, -9.3)),
}


def _hand_34(names: Mapping[str, str]) -> dict[str, Given]:
    return {key: Beside((names[key],), *_HAND_34[key]) for key in names}


ZED_BODY_34 = Skeleton(
    title="ZED BODY_34",
    source="https://www.stereolabs.com/docs/body-tracking (BODY_34_PARTS)",
    names=(
        *("PELVIS", "NAVAL_SPINE", "CHEST_SPINE", "NECK"),
        *(f"{side}_{part}" for parts in (_ARM_34, _LEG_34) for side in ("LEFT", "RIGHT") for part in parts),
        *("HEAD", "NOSE", "LEFT_EYE", "LEFT_EAR", "RIGHT_EYE", "RIGHT_EAR", "LEFT_HEEL", "RIGHT_HEEL"),
    ),
    sides=("LEFT", "RIGHT"),
    middle={"pelvis": "PELVIS", "nose": "NOSE", **_MOUTH},
    sided={
        **_joints("{side}_{JOINT}"),
        "eye": "{side}_EYE",
        "ear": "{side}_EAR",
        "fingertip": "{side}_HANDTIP",
        **_hand_34({"hand": "{side}_HAND", "thumb": "{side}_THUMB", "toe": "{side}_FOOT", "heel": "{side}_HEEL"}),
    },
    stature_m=1.70,
)

_PAIRS_38 = (
    *("EYE", "EAR", "CLAVICLE", "SHOULDER", "ELBOW", "WRIST", "HIP", "KNEE", "ANKLE", "BIG_TOE", "SMALL_TOE", "HEEL"),
    *("HAND_THUMB_4", "HAND_INDEX_1", "HAND_MIDDLE_4", "HAND_PINKY_1"),
)
_TOES_CM: Vector = (-2.5, 0.0, 0.0)  # the middle of big and small toe, behind the tip of the foot (ours)

ZED_BODY_38 = Skeleton(
    title="ZED BODY_38",
    source="https://www.stereolabs.com/docs/body-tracking (BODY_38_PARTS)",
    names=(
        *("PELVIS", "SPINE_1", "SPINE_2", "SPINE_3", "NECK", "NOSE"),
        *(f"{side}_{part}" for part in _PAIRS_38 for side in ("LEFT", "RIGHT")),
    ),
    sides=("LEFT", "RIGHT"),
    middle={"pelvis": "PELVIS", "nose": "NOSE"},
    sided={
        **_joints("{side}_{JOINT}"),
        "eye": "{side}_EYE",
        "ear": "{side}_EAR",
        "heel": "{side}_HEEL",
        "fingertip": "{side}_HAND_MIDDLE_4",
        "thumb": "{side}_HAND_THUMB_4",
        "hand": Beside(("{side}_HAND_INDEX_1", "{side}_HAND_PINKY_1")),
        "toe": Beside(("{side}_BIG_TOE", "{side}_SMALL_TOE"), "toe", _TOES_CM),
    },
)

KINECT_AZURE = Skeleton(
    title="Azure Kinect",
    source="https://learn.microsoft.com/azure/kinect-dk/body-joints (k4abt_joint_id_t)",
    names=(
        *("PELVIS", "SPINE_NAVEL", "SPINE_CHEST", "NECK"),
        *(f"{part}_{side}" for parts in (_ARM_34, _LEG_34) for side in ("LEFT", "RIGHT") for part in parts),
        *("HEAD", "NOSE", "EYE_LEFT", "EAR_LEFT", "EYE_RIGHT", "EAR_RIGHT"),
    ),
    sides=("LEFT", "RIGHT"),
    middle={"nose": "NOSE"},
    sided={
        **_joints("{JOINT}_{side}"),
        "eye": "EYE_{side}",
        "ear": "EAR_{side}",
        "fingertip": "HANDTIP_{side}",
        # as in BODY_34, which has the same points (ours)
        **_hand_34({"hand": "HAND_{side}", "thumb": "THUMB_{side}", "toe": "FOOT_{side}"}),
    },
    stature_m=1.70,
)

KINECT_V2 = Skeleton(
    title="Kinect for Windows v2",
    source="https://learn.microsoft.com/previous-versions/windows/kinect/dn758663(v=ieb.10) (JointType)",
    names=(
        *("SpineBase", "SpineMid", "Neck", "Head"),
        *(f"{part}{side}" for side in ("Left", "Right") for part in ("Shoulder", "Elbow", "Wrist", "Hand")),
        *(f"{part}{side}" for side in ("Left", "Right") for part in ("Hip", "Knee", "Ankle", "Foot")),
        *("SpineShoulder", "HandTipLeft", "ThumbLeft", "HandTipRight", "ThumbRight"),
    ),
    sides=("Left", "Right"),
    middle={"head": "Head"},
    sided={
        **{joint: f"{joint.capitalize()}{{side}}" for joint in _JOINTS},
        "fingertip": "HandTip{side}",
        **_hand_34({"hand": "Hand{side}", "thumb": "Thumb{side}", "toe": "Foot{side}"}),  # as in BODY_34 (ours)
    },
    stature_m=1.70,
)


# --- Skeletons of images: MediaPipe (Google), OpenPose (CMU).

_KNUCKLES_MEDIAPIPE = Beside(("{side}_index", "{side}_pinky"))

MEDIAPIPE_POSE = Skeleton(
    title="MediaPipe Pose (BlazePose)",
    source="https://ai.google.dev/edge/mediapipe/solutions/vision/pose_landmarker; Bazarevsky et al. 2020, BlazePose",
    names=(
        *("nose", "left_eye_inner", "left_eye", "left_eye_outer", "right_eye_inner", "right_eye", "right_eye_outer"),
        *("left_ear", "right_ear", "mouth_left", "mouth_right"),
        *(
            f"{side}_{part}"
            for part in ("shoulder", "elbow", "wrist", "pinky", "index", "thumb", "hip", "knee", "ankle", "heel")
            for side in ("left", "right")
        ),
        *("left_foot_index", "right_foot_index"),
    ),
    sides=("left", "right"),
    middle={"nose": "nose"},
    sided={
        **_joints("{side}_{joint}"),
        "eye": "{side}_eye",
        "ear": "{side}_ear",
        "heel": "{side}_heel",
        "toe": "{side}_foot_index",
        "hand": _KNUCKLES_MEDIAPIPE,
        "thumb": Beside(("{side}_thumb",), "thumb", (0.0, 0.0, 3.5)),  # its knuckle, not its tip; how far: ours
    },
)

OPENPOSE_BODY_25 = Skeleton(
    title="OpenPose BODY_25",
    source="https://github.com/CMU-Perceptual-Computing-Lab/openpose, doc/02_output.md; Cao et al. 2019, OpenPose",
    names=(
        *("Nose", "Neck", "RShoulder", "RElbow", "RWrist", "LShoulder", "LElbow", "LWrist"),
        *("MidHip", "RHip", "RKnee", "RAnkle", "LHip", "LKnee", "LAnkle", "REye", "LEye", "REar", "LEar"),
        *("LBigToe", "LSmallToe", "LHeel", "RBigToe", "RSmallToe", "RHeel"),
    ),
    sides=("L", "R"),
    middle={"nose": "Nose"},
    sided={
        **{joint: f"{{side}}{joint.capitalize()}" for joint in _JOINTS},
        "eye": "{side}Eye",
        "ear": "{side}Ear",
        "heel": "{side}Heel",
        "toe": Beside(("{side}BigToe", "{side}SmallToe"), "toe", _TOES_CM),
    },
)


# --- Motion capture: a body model, markers on the skin, bones.

_UP_Y = {"head": {"forward": "z", "up": "y"}, "chest": {"forward": "z"}, "pelvis": {"forward": "z", "up": "y"}}
_UP_Z = {"head": {"forward": "-y", "up": "z"}, "chest": {"forward": "-y"}, "pelvis": {"forward": "-y", "up": "z"}}
_T_POSE = {
    "head": _UP_Y["head"],
    "left_hand": {"forward": "x", "palm": "-y", "thumb": "z"},
    "right_hand": {"forward": "-x", "palm": "-y", "thumb": "z"},
}
"""Joints whose own axes are those of a rest pose that stands along y, faces z and stretches out its arms."""

SMPL_X = Skeleton(
    title="SMPL-X, its 22 body joints",
    source="Pavlakos et al. 2019, Expressive Body Capture: the first 22 joints, those of SMPL, too",
    names=(
        *("pelvis", "left_hip", "right_hip", "spine1", "left_knee", "right_knee", "spine2", "left_ankle"),
        *("right_ankle", "spine3", "left_foot", "right_foot", "neck", "left_collar", "right_collar", "head"),
        *("left_shoulder", "right_shoulder", "left_elbow", "right_elbow", "left_wrist", "right_wrist"),
    ),
    sides=("left", "right"),
    # of the mean body, to the centimetre (ours); its pelvis lies 9 to 10 cm over the hips, which are there themselves
    middle={"head": Beside(("head",), "head", (0.0, 0.0, -4.0))},
    sided={
        **_joints("{side}_{joint}"),
        "toe": Beside(("{side}_foot",), "ankle", (11.9, 4.3, -5.9)),  # the ball of the foot
    },
    stature_m=1.72,
    axes_by_up={"y": _T_POSE, "z": _T_POSE},
)

# Markers stand 0.7 cm off the skin; breadths of joints and depths of bodies are ours.
PLUG_IN_GAIT = Skeleton(
    title="Plug-in Gait (Vicon), full body",
    source="Vicon Plug-in Gait Reference Guide, marker sets; pelvis: Bell et al. 1990, hip joint centres",
    names=(),
    sides=("L", "R"),
    middle={
        # hips lie 30 % of the breadth between the spines below the front ones and 19 % behind them [Bell 1990]
        "pelvis": Beside(("LASI", "RASI", "LPSI", "RPSI"), "pelvis", (-2.5, 0.0, 8.0)),
    },
    sided={
        "eye": Beside(("{side}FHD",), "eye", (-1.0, 3.5, 3.0)),  # over the temple
        "ear": Beside(("{side}BHD",), "ear", (-8.0, -2.0, 5.0)),  # at the back of the head, as high
        "shoulder": Beside(("{side}SHO",), "shoulder", (0.0, 0.0, 5.0), "chest"),  # where collar bone and blade meet
        "elbow": Beside(("{side}ELB",), "elbow", (0.0, 4.0, 0.0), "{side}_shoulder"),
        "wrist": Beside(("{side}WRA", "{side}WRB")),
        "hand": Beside(("{side}FIN",), "hand", (1.5, 2.0, 1.0)),  # on the back of the second knuckle
        "knee": Beside(("{side}KNE",), "knee", (0.0, 5.6, 0.0)),
        "ankle": Beside(("{side}ANK",), "ankle", (0.0, 4.3, 0.0)),
        "heel": Beside(("{side}HEE",), "heel", (-1.0, 0.0, 1.6)),
        "toe": Beside(("{side}TOE",), "toe", (-6.9, 0.0, 1.6)),  # on the second metatarsal
    },
)

OPTITRACK = Skeleton(
    title="OptiTrack Motive, bones of a skeleton",
    source="https://docs.optitrack.com/motive (skeleton bones); axes: the KTH handovers, whose bones have these names",
    names=(
        *("Hip", "Ab", "Chest", "Neck", "Head"),
        *(f"{side}{bone}" for side in "LR" for bone in ("Shoulder", "UArm", "FArm", "Hand")),
        *(f"{side}{bone}" for side in "LR" for bone in ("Thigh", "Shin", "Foot", "Toe")),
    ),
    sides=("L", "R"),
    middle={"pelvis": "Hip", "head_base": "Head"},
    sided={
        "shoulder": "{side}UArm",
        "elbow": "{side}FArm",
        "wrist": "{side}Hand",
        "hip": "{side}Thigh",
        "knee": "{side}Shin",
        "ankle": "{side}Foot",
        "toe": Beside(("{side}Toe",), "toe", (-6.9, 0.0, 0.0)),  # the ball of the foot (ours)
    },
    axes_by_up={
        "y": {
            **_UP_Y,
            "left_hand": {"forward": "x", "palm": "-y", "thumb": "z"},
            "right_hand": {"forward": "-x", "palm": "-y", "thumb": "z"},
        },
        "z": {
            **_UP_Z,
            "left_hand": {"forward": "x", "palm": "-z", "thumb": "-y"},
            "right_hand": {"forward": "-x", "palm": "-z", "thumb": "-y"},
        },
    },
)

HUMANIK = Skeleton(
    title="HumanIK (MotionBuilder, Motive's FBX names, Qualisys, Mixamo, Rokoko), joints of BVH files",
    source="Autodesk MotionBuilder Help, HumanIK character structure; axes: y up, facing z, in the rest pose of a BVH",
    names=(),
    sides=("Left", "Right"),
    # its Hips lie over the hips, which are there themselves; Head begins where the neck ends
    middle={"head_base": "Head"},
    sided={
        "shoulder": "{side}Arm",
        "elbow": "{side}ForeArm",
        "wrist": "{side}Hand",
        "hip": "{side}UpLeg",
        "knee": "{side}Leg",
        "ankle": "{side}Foot",
        "toe": Beside(("{side}ToeBase",), "toe", (-6.9, 0.0, 0.0)),  # the ball of the foot (ours)
    },
    axes_by_up={"y": _T_POSE},
)

BIOVISION = Skeleton(
    title="joints of BVH files as Biovision named them (Xsens, Poser)",
    source="Meredith & Maddock 2001, Motion Capture File Formats Explained; Xsens MVN, BVH export",
    names=(),
    sides=("Left", "Right"),
    middle={"head_base": "Head"},
    sided={
        **_joints("{side}{Joint}"),
        "toe": Beside(("{side}Toe",), "toe", (-6.9, 0.0, 0.0)),  # the ball of the foot (ours)
    },
    axes_by_up=HUMANIK.axes_by_up,
)

ROS4HRI = Skeleton(
    title="people of ROS4HRI (REP-155), frames of tf",
    source="REP-155, Human-Robot Interaction; frames of github.com/ros4hri/human_description; axes: REP-103",
    names=(),
    sides=("l", "r"),
    middle={"head": "head"},  # taken for the middle of the head (ours)
    sided=_joints("{side}_{joint}"),
    axes_by_up={"z": {"head": {"forward": "x", "up": "z"}}},
)

SKELETONS: Mapping[str, Skeleton] = {
    "zed_body_34": ZED_BODY_34,
    "zed_body_38": ZED_BODY_38,
    "kinect_azure": KINECT_AZURE,
    "kinect_v2": KINECT_V2,
    "mediapipe_pose": MEDIAPIPE_POSE,
    "openpose_body_25": OPENPOSE_BODY_25,
    "smplx": SMPL_X,
    "plug_in_gait": PLUG_IN_GAIT,
    "optitrack": OPTITRACK,
    "humanik": HUMANIK,
    "biovision": BIOVISION,
    "ros4hri": ROS4HRI,
}
"""By the name that a mapping gives."""


def skeleton_named(name: str, where: str) -> Skeleton:
    """A skeleton by its name in a mapping.

    Raises:
        UnknownNameError: There is no such skeleton; the nearest names are offered.
    """
    if name not in SKELETONS:
        raise UnknownNameError("skeleton", name, SKELETONS, where=where)
    return SKELETONS[name]
