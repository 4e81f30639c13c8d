"""JSON schemas of the Foxglove messages that a recording carries for viewers, under their well-known names.

The same fields as in the published schemas (https://github.com/foxglove/foxglove-sdk/tree/main/schemas/jsonschema); a
test holds the messages to the official Protobuf definitions.
"""

from __future__ import annotations

from typing import Any

Schema = dict[str, Any]


def _message(title: str, **properties: Schema) -> Schema:
    return {"title": title, "type": "object", "properties": properties}


def _list(items: Schema) -> Schema:
    return {"type": "array", "items": items}


def _clock(title: str, seconds: Schema) -> Schema:
    nanoseconds = {"type": "integer", "minimum": 0, "maximum": 999_999_999}
    return _message(title, sec=seconds, nsec=nanoseconds)


NUMBER: Schema = {"type": "number"}
TEXT: Schema = {"type": "string"}
FLAG: Schema = {"type": "boolean"}
INDEX: Schema = {"type": "integer", "minimum": 0}

TIME = _clock("time", {"type": "integer", "minimum": 0})
DURATION = _clock("duration", {"type": "integer"})
VECTOR3 = _message("foxglove.Vector3", x=NUMBER, y=NUMBER, z=NUMBER)
POINT3 = _message("foxglove.Point3", x=NUMBER, y=NUMBER, z=NUMBER)
QUATERNION = _message("foxglove.Quaternion", x=NUMBER, y=NUMBER, z=NUMBER, w=NUMBER)
POSE = _message("foxglove.Pose", position=VECTOR3, orientation=QUATERNION)
COLOR = _message("foxglove.Color", r=NUMBER, g=NUMBER, b=NUMBER, a=NUMBER)
KEY_VALUE = _message("foxglove.KeyValuePair", key=TEXT, value=TEXT)

FRAME_TRANSFORM = _message(
    "foxglove.FrameTransform",
    timestamp=TIME,
    parent_frame_id=TEXT,
    child_frame_id=TEXT,
    translation=VECTOR3,
    rotation=QUATERNION,
)
FRAME_TRANSFORMS = _message("foxglove.FrameTransforms", transforms=_list(FRAME_TRANSFORM))

_ARROW = _message(
    "foxglove.ArrowPrimitive",
    pose=POSE,
    shaft_length=NUMBER,
    shaft_diameter=NUMBER,
    head_length=NUMBER,
    head_diameter=NUMBER,
    color=COLOR,
)
_CUBE = _message("foxglove.CubePrimitive", pose=POSE, size=VECTOR3, color=COLOR)
_SPHERE = _message("foxglove.SpherePrimitive", pose=POSE, size=VECTOR3, color=COLOR)
_CYLINDER = _message(
    "foxglove.CylinderPrimitive", pose=POSE, size=VECTOR3, bottom_scale=NUMBER, top_scale=NUMBER, color=COLOR
)
_LINE = _message(
    "foxglove.LinePrimitive",
    type={"title": "foxglove.LineType", "oneOf": [{"const": number} for number in range(3)]},
    pose=POSE,
    thickness=NUMBER,
    scale_invariant=FLAG,
    points=_list(POINT3),
    color=COLOR,
    colors=_list(COLOR),
    indices=_list(INDEX),
)
_TRIANGLES = _message(
    "foxglove.TriangleListPrimitive",
    pose=POSE,
    points=_list(POINT3),
    color=COLOR,
    colors=_list(COLOR),
    indices=_list(INDEX),
)
_TEXT = _message(
    "foxglove.TextPrimitive",
    pose=POSE,
    billboard=FLAG,
    font_size=NUMBER,
    scale_invariant=FLAG,
    color=COLOR,
    text=TEXT,
)
_MODEL = _message(
    "foxglove.ModelPrimitive",
    pose=POSE,
    scale=VECTOR3,
    color=COLOR,
    override_color=FLAG,
    url=TEXT,
    media_type=TEXT,
    data={"type": "string", "contentEncoding": "base64"},
)
_ENTITY = _message(
    "foxglove.SceneEntity",
    timestamp=TIME,
    frame_id=TEXT,
    id=TEXT,
    lifetime=DURATION,
    frame_locked=FLAG,
    metadata=_list(KEY_VALUE),
    arrows=_list(_ARROW),
    cubes=_list(_CUBE),
    spheres=_list(_SPHERE),
    cylinders=_list(_CYLINDER),
    lines=_list(_LINE),
    triangles=_list(_TRIANGLES),
    texts=_list(_TEXT),
    models=_list(_MODEL),
)
_DELETION = _message(
    "foxglove.SceneEntityDeletion",
    timestamp=TIME,
    type={"title": "foxglove.SceneEntityDeletionType", "oneOf": [{"const": number} for number in range(2)]},
    id=TEXT,
)
SCENE_UPDATE = _message("foxglove.SceneUpdate", deletions=_list(_DELETION), entities=_list(_ENTITY))
