"""The flight as a 3D scene: messages of the schemas that Foxglove draws without being told how.

Foxglove's world has z up; `WORLD` is one with x north, y west, z up, in which `NED` is turned upside down.
Schemas: https://docs.foxglove.dev/docs/sdk/schemas, by name; of `SceneUpdate` only what is used.
"""

import math
from typing import Any, TypeAlias

from companion.arrays import Vec3, Vec3s

Json: TypeAlias = dict[str, Any]

POSE, PATH = "/pose", "/path"
WORLD, NED, VEHICLE = "world", "ned", "vehicle"

NUMBER: Json = {"type": "number"}
INTEGER: Json = {"type": "integer"}
TEXT: Json = {"type": "string"}
_BLUE = {"r": 0.34, "g": 0.71, "b": 0.91, "a": 1.0}


def record(properties: Json) -> Json:
    """The schema of an object with these properties."""
    return {"type": "object", "properties": properties}


def _list(items: Json) -> Json:
    return {"type": "array", "items": items}


def timestamp(unix_ns: int) -> Json:
    """An instant (ns since 1970) as Foxglove's schemas have it."""
    sec, nsec = divmod(unix_ns, 1_000_000_000)
    return {"sec": sec, "nsec": nsec}


TIMESTAMP = record({"sec": INTEGER, "nsec": INTEGER})
_VECTOR = record(dict.fromkeys("xyz", NUMBER))
_QUATERNION = record(dict.fromkeys("xyzw", NUMBER))
_TRANSFORM = record(
    {
        "timestamp": TIMESTAMP,
        "parent_frame_id": TEXT,
        "child_frame_id": TEXT,
        "translation": _VECTOR,
        "rotation": _QUATERNION,
    }
)
_LINE = record(
    {
        "type": INTEGER,
        "pose": record({"position": _VECTOR, "orientation": _QUATERNION}),
        "thickness": NUMBER,
        "scale_invariant": {"type": "boolean"},
        "points": _list(_VECTOR),
        "color": record(dict.fromkeys("rgba", NUMBER)),
    }
)
_ENTITY = record({"timestamp": TIMESTAMP, "frame_id": TEXT, "id": TEXT, "lines": _list(_LINE)})

SCHEMA_NAMES = {POSE: "foxglove.FrameTransforms", PATH: "foxglove.SceneUpdate"}
PROPERTIES = {POSE: {"transforms": _list(_TRANSFORM)}, PATH: {"entities": _list(_ENTITY)}}


def pose(unix_ns: int, position: Vec3, attitude: Vec3) -> Json:
    """Where the vehicle is (NED, m) and how it is turned (roll, pitch, yaw, rad)."""
    upside_down = {"x": 1.0, "y": 0.0, "z": 0.0, "w": 0.0}
    origin = dict.fromkeys("xyz", 0.0)
    return {
        "transforms": [
            _placed(unix_ns, WORLD, NED, origin, upside_down),
            _placed(unix_ns, NED, VEHICLE, _point(position), _quaternion(attitude)),
        ]
    }


def path(unix_ns: int, positions: Vec3s) -> Json:
    """The desired path (NED, m) as a line, which takes the place of an earlier one."""
    line = {
        "type": 0,  # a strip
        "pose": {
            "position": dict.fromkeys("xyz", 0.0),
            "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0},
        },
        "thickness": 0.02,
        "scale_invariant": False,
        "points": [_point(position) for position in positions],
        "color": _BLUE,
    }
    return {
        "entities": [{"timestamp": timestamp(unix_ns), "frame_id": NED, "id": "desired", "lines": [line]}]
    }


def _placed(unix_ns: int, parent: str, child: str, translation: Json, rotation: Json) -> Json:
    return {
        "timestamp": timestamp(unix_ns),
        "parent_frame_id": parent,
        "child_frame_id": child,
        "translation": translation,
        "rotation": rotation,
    }


def _point(position: Vec3) -> Json:
    return dict(zip("xyz", position.tolist(), strict=True))


def _quaternion(attitude: Vec3) -> Json:
    """Roll, pitch and yaw (rad), turned about in the order yaw, pitch, roll."""
    (cr, sr), (cp, sp), (cy, sy) = (
        (math.cos(0.5 * angle), math.sin(0.5 * angle)) for angle in attitude.tolist()
    )
    return {
        "x": sr * cp * cy - cr * sp * sy,
        "y": cr * sp * cy + sr * cp * sy,
        "z": cr * cp * sy - sr * sp * cy,
        "w": cr * cp * cy + sr * sp * sy,
    }
