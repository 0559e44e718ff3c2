"""Plans for tests: any that can be written, and one that QGroundControl might have."""

from typing import Any

from hypothesis import strategies as st

from companion.geodesy import Place
from companion.mission.items import Fence, FenceCircle, FencePolygon, Frame, MissionItem, Plan

numbers = st.floats(-1e6, 1e6)
latitudes = st.floats(-89.0, 89.0).filter(bool)
longitudes = st.floats(-180.0, 180.0)
altitudes = st.floats(-500.0, 9000.0)
places = st.builds(Place, latitudes, longitudes, altitudes)
parameters = st.tuples(*[st.none() | numbers] * 4)
waypoints = st.builds(
    MissionItem,
    command=st.just(16),
    frame=st.sampled_from([Frame.GLOBAL, Frame.ABOVE_HOME, Frame.ABOVE_TERRAIN]),
    params=parameters,
    x=latitudes,
    y=longitudes,
    z=altitudes,
    autocontinue=st.booleans(),
)
actions = st.builds(
    MissionItem,
    command=st.sampled_from([20, 112, 178, 206]),
    params=parameters,
    x=st.none() | numbers,
    y=st.none() | numbers,
    z=st.none() | numbers,
)
jumps = st.builds(
    lambda repeats: MissionItem(177, params=(0.0, float(repeats), 0.0, 0.0)), st.integers(0, 10)
)
missions = st.lists(waypoints | actions | jumps, max_size=8).map(tuple)
vertices = st.lists(st.tuples(latitudes, longitudes), min_size=3, max_size=6).map(tuple)
fences = st.builds(
    Fence,
    st.lists(st.builds(FencePolygon, vertices, st.booleans()), max_size=2).map(tuple),
    st.lists(
        st.builds(FenceCircle, latitudes, longitudes, st.floats(1.0, 1e4), st.booleans()), max_size=2
    ).map(tuple),
    st.none() | places,
)
plans = st.builds(
    Plan,
    mission=missions,
    fence=fences,
    rally=st.lists(places, max_size=3).map(tuple),
    home=st.none() | places,
    cruise_speed_m_s=st.floats(0.1, 50.0),
    hover_speed_m_s=st.floats(0.1, 50.0),
    firmware=st.sampled_from([3, 12]),
)


def waypoint(
    latitude_deg: float = 47.398, longitude_deg: float = 8.546, altitude_m: float = 10.0
) -> MissionItem:
    return MissionItem(16, Frame.ABOVE_HOME, x=latitude_deg, y=longitude_deg, z=altitude_m)


def simple(number: int, command: int = 16, frame: int = 3, **changes: Any) -> dict[str, Any]:
    """An item as QGroundControl writes it."""
    params = [0, 0, 0, None, 47.398, 8.546, 10] if frame != 2 else [1, 0, 0, 0, 0, 0, 0]
    item = {"type": "SimpleItem", "command": command, "frame": frame, "params": params, "autoContinue": True}
    return item | {"doJumpId": number} | changes


def plan_object(*items: dict[str, Any]) -> dict[str, Any]:
    return {
        "fileType": "Plan",
        "version": 1,
        "groundStation": "QGroundControl",
        "mission": {
            "version": 2,
            "cruiseSpeed": 15,
            "hoverSpeed": 5,
            "firmwareType": 12,
            "vehicleType": 2,
            "globalPlanAltitudeMode": 1,
            "plannedHomePosition": [47.397742, 8.545594, 488],
            "items": list(items),
        },
        "geoFence": {"version": 2, "polygons": [], "circles": []},
        "rallyPoints": {"version": 2, "points": []},
    }
