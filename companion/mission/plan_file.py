"""QGroundControl's plan files: https://docs.qgroundcontrol.com/master/en/qgc-dev-guide/file_formats/plan.html.

Surveys, corridor scans and whatever else QGroundControl makes of a pattern are read as the items that it
stored for them, and written as such.
"""

import json
from collections.abc import Sequence
from dataclasses import astuple, replace
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationError

from companion.errors import InputError
from companion.geodesy import Place
from companion.link.dialect import mavlink
from companion.mission.items import (
    Fence,
    FenceCircle,
    FencePolygon,
    Frame,
    MissionItem,
    Plan,
    frame_from_number,
    naming,
)

Number: TypeAlias = FiniteFloat | None
LatLon: TypeAlias = tuple[FiniteFloat, FiniteFloat]
LatLonAlt: TypeAlias = tuple[FiniteFloat, FiniteFloat, FiniteFloat]
_ALTITUDE_MODES = {Frame.ABOVE_HOME: 1, Frame.GLOBAL: 2, Frame.ABOVE_TERRAIN: 4}
"""QGroundControl's AltitudeMode of an item in a frame."""
_NOWHERE = (0.0, 0.0, 0.0)
"""The home of a plan that has none: QGroundControl wants one."""
_MIXED_ALTITUDES = 0
"""QGroundControl's globalPlanAltitudeMode of a plan whose items have altitude modes of their own."""


class _Part(BaseModel):
    """Keys that are not known are passed over: newer versions of QGroundControl add some."""

    model_config = ConfigDict(frozen=True)


class _SimpleItem(_Part):
    type: Literal["SimpleItem"]
    command: int
    frame: int
    params: tuple[Number, Number, Number, Number, Number, Number, Number]
    autoContinue: bool = True  # noqa: N815
    doJumpId: int | None = None  # noqa: N815


class _Transects(_Part):
    items: tuple[_SimpleItem, ...] = Field(alias="Items")


class _ComplexItem(_Part):
    type: Literal["ComplexItem"]
    complexItemType: str  # noqa: N815
    transects: _Transects | None = Field(None, alias="TransectStyleComplexItem")


class _Mission(_Part):
    version: Literal[2]
    items: tuple[Annotated[_SimpleItem | _ComplexItem, Field(discriminator="type")], ...]
    plannedHomePosition: LatLonAlt | None = None  # noqa: N815
    cruiseSpeed: FiniteFloat = 15.0  # noqa: N815
    hoverSpeed: FiniteFloat = 5.0  # noqa: N815
    firmwareType: int = mavlink.MAV_AUTOPILOT_PX4  # noqa: N815


class _Polygon(_Part):
    polygon: tuple[LatLon, ...]
    inclusion: bool
    version: Literal[1] = 1


class _Centre(_Part):
    center: LatLon
    radius: FiniteFloat


class _Circle(_Part):
    circle: _Centre
    inclusion: bool
    version: Literal[1] = 1


class _GeoFence(_Part):
    version: Literal[2] = 2
    polygons: tuple[_Polygon, ...] = ()
    circles: tuple[_Circle, ...] = ()
    breachReturn: LatLonAlt | None = None  # noqa: N815


class _RallyPoints(_Part):
    version: Literal[2] = 2
    points: tuple[LatLonAlt, ...] = ()


class _PlanFile(_Part):
    fileType: Literal["Plan"]  # noqa: N815
    version: Literal[1]
    mission: _Mission
    geoFence: _GeoFence = _GeoFence()  # noqa: N815
    rallyPoints: _RallyPoints = _RallyPoints()  # noqa: N815


def parse_plan(content: bytes) -> Plan:
    """The plan in the content of a `.plan` file.

    Raises:
        InputError: it is no JSON, of another version, or a value is wrong; names the key.
    """
    try:
        file = _PlanFile.model_validate_json(content)
    except ValidationError as error:
        raise InputError(_first_fault(error)) from error
    home = file.mission.plannedHomePosition
    return Plan(
        mission=_mission(file.mission.items),
        fence=_fence(file.geoFence),
        rally=tuple(Place(*point) for point in file.rallyPoints.points),
        home=None if home is None or home[:2] == _NOWHERE[:2] else Place(*home),
        cruise_speed_m_s=file.mission.cruiseSpeed,
        hover_speed_m_s=file.mission.hoverSpeed,
        firmware=file.mission.firmwareType,
    )


def plan_text(plan: Plan) -> str:
    """The content of a `.plan` file, as QGroundControl reads it."""
    content = {
        "fileType": "Plan",
        "version": 1,
        "groundStation": "QGroundControl",
        "mission": {
            "version": 2,
            "firmwareType": plan.firmware,
            "vehicleType": mavlink.MAV_TYPE_QUADROTOR,
            "cruiseSpeed": plan.cruise_speed_m_s,
            "hoverSpeed": plan.hover_speed_m_s,
            "globalPlanAltitudeMode": _MIXED_ALTITUDES,
            "plannedHomePosition": _NOWHERE if plan.home is None else astuple(plan.home),
            "items": [_item_object(item, number) for number, item in enumerate(plan.mission, start=1)],
        },
        "geoFence": _fence_object(plan.fence),
        "rallyPoints": {"version": 2, "points": [astuple(place) for place in plan.rally]},
    }
    return json.dumps(content, indent=4, allow_nan=False) + "\n"


def _mission(objects: Sequence[_SimpleItem | _ComplexItem]) -> tuple[MissionItem, ...]:
    items: list[MissionItem] = []
    indices: dict[int, int] = {}
    for number, thing in enumerate(objects):
        key = f"mission.items.{number}"
        if isinstance(thing, _SimpleItem):
            if thing.doJumpId is not None:
                if thing.doJumpId in indices:
                    raise InputError(f"{key}.doJumpId: {thing.doJumpId} is taken by an item before it")
                indices[thing.doJumpId] = len(items)
            items.append(_item(thing, key))
        elif thing.transects is None:
            raise InputError(
                f"{key}: the {thing.complexItemType} has no TransectStyleComplexItem with its items stored; "
                "in QGroundControl, make single waypoints of it"
            )
        else:
            inner = f"{key}.TransectStyleComplexItem.Items"
            items.extend(_item(item, f"{inner}.{n}") for n, item in enumerate(thing.transects.items))
    return tuple(_with_target(item, indices) for item in items)


def _with_target(item: MissionItem, indices: dict[int, int]) -> MissionItem:
    """A jump's target as a position instead of the doJumpId that the file has."""
    if item.command != mavlink.MAV_CMD_DO_JUMP:
        return item
    target = indices.get(int(item.params[0] or 0))
    if target is None:
        raise InputError(f"mission.items: a jump goes to doJumpId {item.params[0]}, which no item has")
    return replace(item, params=(float(target), *item.params[1:]))


def _item(thing: _SimpleItem, key: str) -> MissionItem:
    with naming(key):
        return MissionItem(
            thing.command,
            frame_from_number(thing.frame),
            thing.params[:4],
            *thing.params[4:],
            autocontinue=thing.autoContinue,
        )


def _fence(file: _GeoFence) -> Fence:
    polygons, circles = [], []
    for number, polygon in enumerate(file.polygons):
        with naming(f"geoFence.polygons.{number}"):
            polygons.append(FencePolygon(polygon.polygon, polygon.inclusion))
    for number, circle in enumerate(file.circles):
        with naming(f"geoFence.circles.{number}"):
            circles.append(FenceCircle(*circle.circle.center, circle.circle.radius, circle.inclusion))
    back = file.breachReturn
    return Fence(tuple(polygons), tuple(circles), None if back is None else Place(*back))


def _item_object(item: MissionItem, number: int) -> dict[str, Any]:
    params: list[float | None] = [*item.params, item.x, item.y, item.z]
    if item.command == mavlink.MAV_CMD_DO_JUMP:
        params[0] = (item.params[0] or 0) + 1  # the doJumpId of its target
    common = {
        "type": "SimpleItem",
        "command": item.command,
        "frame": int(item.frame),
        "params": params,
        "autoContinue": item.autocontinue,
        "doJumpId": number,
    }
    if not item.has_place:
        return common
    return common | {
        "Altitude": item.z,
        "AltitudeMode": _ALTITUDE_MODES[item.frame],
        "AMSLAltAboveTerrain": None,
    }


def _fence_object(fence: Fence) -> dict[str, Any]:
    content: dict[str, Any] = {
        "version": 2,
        "polygons": [
            {"version": 1, "inclusion": area.inclusion, "polygon": area.vertices} for area in fence.polygons
        ],
        "circles": [
            {
                "version": 1,
                "inclusion": area.inclusion,
                "circle": {"center": (area.latitude_deg, area.longitude_deg), "radius": area.radius_m},
            }
            for area in fence.circles
        ],
    }
    if fence.breach_return is not None:
        content["breachReturn"] = astuple(fence.breach_return)
    return content


def _first_fault(error: ValidationError) -> str:
    """The first fault, with its key as the file has it."""
    fault = error.errors(include_url=False, include_context=False)[0]
    kinds = {"SimpleItem", "ComplexItem"}  # pydantic names the kind of an item as if it were a key
    key = ".".join(str(part) for part in fault["loc"] if part not in kinds)
    got = f", not {str(fault['input'])[:40]}" if isinstance(fault["input"], int | float | str) and key else ""
    return f"{key or 'the file'}: {fault['msg']}{got}"
