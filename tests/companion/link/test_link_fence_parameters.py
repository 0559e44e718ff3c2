"""The parameters of a fence, asked for over a link."""

import math

import pytest
from fake_vehicle import FakeVehicle
from parameter_vehicle import ROUGH, ParameterVehicle

from companion import clock
from companion.link.connection import connect_over
from companion.link.dialect import mavlink
from companion.link.parameter_encoding import Encoding, Number, ParameterType
from companion.mission.fence_parameters import fence_parameters

INT8, INT32, REAL32 = ParameterType.INT8, ParameterType.INT32, ParameterType.REAL32
PX4 = {"GF_ACTION": (2, INT32), "GF_MAX_HOR_DIST": (30.0, REAL32), "GF_MAX_VER_DIST": (10.0, REAL32)}
COPTER = {
    "FENCE_ENABLE": (1, INT8),
    "FENCE_TYPE": (15, INT8),
    "FENCE_ALT_MAX": (100.0, REAL32),
    "FENCE_ALT_MIN": (-10.0, REAL32),
    "FENCE_RADIUS": (300.0, REAL32),
    "FENCE_MARGIN": (2.0, REAL32),
}
NEWER = COPTER | {"FENCE_AUTOENABLE": (3, INT8), "FENCE_OPTIONS": (2, ParameterType.INT16)}


def asked(vehicle: FakeVehicle | ParameterVehicle) -> tuple[dict[str, Number], list[str], float]:
    """What the vehicle told, what was announced, and how long that took (s)."""
    said: list[str] = []

    async def scenario() -> tuple[dict[str, Number], float]:
        async with connect_over(vehicle.open) as connection:
            began_s = clock.now()
            return await fence_parameters(connection, said.append), clock.now() - began_s

    told, lasted_s = clock.run(scenario(), virtual=True)
    return told, said, lasted_s


@pytest.mark.parametrize(
    ("values", "encoding"),
    [(PX4, Encoding.BYTEWISE), (COPTER, Encoding.CAST), (NEWER, Encoding.CAST)],
    ids=["PX4", "ArduPilot", "ArduPilot 4.6"],
)
def test_they_come_over_a_rough_link(
    values: dict[str, tuple[Number, ParameterType]], encoding: Encoding
) -> None:
    told, said, _ = asked(ParameterVehicle(dict(values), encoding, ROUGH))
    assert told == {name: value for name, (value, _) in values.items()}
    assert said == []


@pytest.mark.parametrize(
    ("autopilot", "first"),
    [(mavlink.MAV_AUTOPILOT_PX4, "GF_ACTION"), (mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA, "FENCE_ENABLE")],
)
def test_a_vehicle_that_tells_none_is_not_waited_for_long_and_that_is_said_once(
    autopilot: int, first: str
) -> None:
    told, (said,), lasted_s = asked(FakeVehicle(autopilot=autopilot))
    assert told == {}
    assert said.startswith(f"the vehicle does not tell {first}, ")
    assert said.endswith("what they limit is not kept to")
    assert lasted_s < 2.0


def test_a_copter_before_4_6_is_not_said_to_tell_too_little() -> None:
    told, said, lasted_s = asked(ParameterVehicle(dict(COPTER), Encoding.CAST))
    assert (set(told), said) == (set(COPTER), [])
    assert lasted_s < 1.0


def test_a_value_that_is_none_counts_as_not_told() -> None:
    broken = PX4 | {"GF_MAX_HOR_DIST": (math.nan, REAL32)}
    told, (said,), _ = asked(ParameterVehicle(broken, Encoding.BYTEWISE))
    assert "GF_MAX_HOR_DIST" not in told
    assert "GF_MAX_HOR_DIST" in said
