"""Flights that several tests start from."""

import math

import numpy as np

from sitl.conditions import Conditions, load_conditions
from sitl.firmware.interface import Mode, Result, Setpoint
from sitl.simulation import Simulation
from sitl.vehicle import Vehicle, load_vehicle

BEBOP2 = load_vehicle("bebop2")
IDEAL = load_conditions("ideal")


def simulation(vehicle: Vehicle = BEBOP2, conditions: Conditions = IDEAL, seed: int = 1) -> Simulation:
    return Simulation(vehicle, conditions, seed=seed, record_truth=True)


def with_parameters(**parameters: float) -> Vehicle:
    data = BEBOP2.model_dump(exclude_unset=True)
    return Vehicle.model_validate(data | {"px4_parameters": parameters})


def in_hover(vehicle: Vehicle = BEBOP2, conditions: Conditions = IDEAL, seed: int = 1) -> Simulation:
    """In HOLD, 2.5 m above the ground."""
    return hover(simulation(vehicle, conditions, seed))


def hover(sim: Simulation) -> Simulation:
    """Take off, and hold 2.5 m above the ground."""
    if sim.vehicle.firmware == "ardupilot":
        return guided_into_hover(sim)
    assert sim.firmware.takeoff() is Result.ACCEPTED
    assert sim.firmware.arm() is Result.ACCEPTED
    sim.advance(15.0)
    return sim


def guided_into_hover(sim: Simulation) -> Simulation:
    """ArduPilot's way: take off in GUIDED, then hold in LOITER."""
    assert sim.firmware.set_mode(Mode.OFFBOARD) is Result.ACCEPTED
    assert sim.firmware.arm() is Result.ACCEPTED
    assert sim.firmware.takeoff(2.5) is Result.ACCEPTED
    sim.advance(14.0)
    assert sim.firmware.set_mode(Mode.HOLD) is Result.ACCEPTED
    sim.advance(15.0)
    return sim


def stream(sim: Simulation, setpoint: Setpoint, seconds: float) -> None:
    """Send `setpoint` at 50 Hz, switching to OFFBOARD with the first."""
    end_s = sim.time_s + seconds
    while sim.time_s < end_s - 1e-6:
        sim.firmware.offboard_setpoint(setpoint)
        if sim.firmware.mode is not Mode.OFFBOARD:
            assert sim.firmware.set_mode(Mode.OFFBOARD) is Result.ACCEPTED
        sim.advance(sim.time_s + 0.02)


def texts(sim: Simulation) -> str:
    return "\n".join(text.text for text in sim.firmware.take_status_texts())


def tilt_deg(attitude: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> float:
    return math.degrees(2.0 * math.asin(min(1.0, math.hypot(attitude[1], attitude[2]))))
