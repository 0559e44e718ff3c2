import numpy as np
import pytest
from sitl_flights import in_hover, simulation, stream

from sitl.arrays import Vec3
from sitl.errors import ParameterRefusedError
from sitl.firmware.interface import Mode, Result, Setpoint
from sitl.firmware.parameters import Stored
from sitl.simulation import Simulation
from sitl.vehicle import load_vehicle

ARDUCOPTER = load_vehicle("arducopter_sitl")


def ahead(sim: Simulation, metres: float) -> Vec3:
    place: Vec3 = sim.firmware.estimate.position + np.array((metres, 0.0, 0.0))
    return place


def test_a_takeoff_goes_to_the_altitude_that_was_set() -> None:
    sim = simulation()
    sim.firmware.set_parameter("MIS_TAKEOFF_ALT", 5.0)
    assert sim.firmware.takeoff() is Result.ACCEPTED
    assert sim.firmware.arm() is Result.ACCEPTED
    sim.advance(20.0)
    assert sim.truth.position[2] == pytest.approx(-5.0, abs=0.3)


@pytest.mark.parametrize("limit", [0.5, 2.0])
def test_px4_keeps_a_speed_limit_that_is_set_in_flight(limit: float) -> None:
    sim = in_hover()
    sim.firmware.set_parameter("MPC_XY_VEL_MAX", limit)
    stream(sim, Setpoint(position=ahead(sim, 20.0)), 3.0)
    assert sim.truth.velocity[0] == pytest.approx(limit, abs=0.15)


def test_gains_that_are_set_in_flight_act() -> None:
    soft, stiff = in_hover(), in_hover()
    soft.firmware.set_parameter("MPC_XY_P", 0.3)
    for sim in (soft, stiff):
        stream(sim, Setpoint(position=ahead(sim, 2.0)), 2.0)
    assert soft.truth.position[0] < 0.7 * stiff.truth.position[0]


def test_ardupilot_keeps_a_speed_limit_that_is_set_in_flight() -> None:
    sim = in_hover(ARDUCOPTER)
    sim.firmware.set_parameter("WPNAV_SPEED", 60.0)
    assert sim.firmware.set_mode(Mode.OFFBOARD) is Result.ACCEPTED
    sim.firmware.offboard_setpoint(Setpoint(position=ahead(sim, 20.0)))
    sim.advance(sim.time_s + 5.0)
    assert sim.truth.velocity[0] == pytest.approx(0.6, abs=0.05)


@pytest.mark.parametrize(
    ("name", "value"),
    [("NO_SUCH", 1.0), ("MPC_XY_P", -1.0), ("COM_OBL_RC_ACT", 9), ("MPC_XY_P", float("nan"))],
)
def test_a_refused_value_leaves_the_old_one(name: str, value: float) -> None:
    firmware = simulation().firmware
    before = firmware.parameters
    with pytest.raises(ParameterRefusedError, match=name):
        firmware.set_parameter(name, value)
    assert firmware.parameters == before


def test_ardupilots_whole_numbers_have_their_widths() -> None:
    parameters = simulation(ARDUCOPTER).firmware.parameters
    widths = {
        name: parameters.stored(name) for name in ("DISARM_DELAY", "ANGLE_MAX", "RTL_ALT", "WPNAV_SPEED")
    }
    assert widths == {
        "DISARM_DELAY": Stored.INT8,
        "ANGLE_MAX": Stored.INT16,
        "RTL_ALT": Stored.INT32,
        "WPNAV_SPEED": Stored.FLOAT,
    }
