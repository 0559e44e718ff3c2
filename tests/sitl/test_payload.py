"""What changes in the course of a flight: a payload taken or dropped, and a battery that sags."""

from typing import Any

import numpy as np
import pytest
from sitl_flights import BEBOP2, in_hover

from sitl.conditions import Conditions, PayloadConditions
from sitl.errors import ConfigError
from sitl.payload import with_payload
from sitl.rigid_body import airframe
from sitl.simulation import Simulation
from sitl.vehicle import load_vehicle

FRAME = airframe(BEBOP2)
ARM_M = float(np.hypot(0.088, 0.115))
HOVER_TICKS = 100


def conditions(**sections: Any) -> Conditions:
    return Conditions.model_validate({"name": "changing"} | sections)


def thrust_to_hover(sim: Simulation) -> float:
    """Thrust that carries the vehicle, on the average over a second (N)."""
    thrusts = []
    for _ in range(HOVER_TICKS):
        sim.advance(sim.time_s + 0.01)
        thrusts.append(FRAME.thrust_coefficient * float((sim._plant.body.rotor_speed**2).sum()))
    return float(np.mean(thrusts))


def test_a_load_below_makes_heavier_and_slower_to_tilt_and_moves_the_centre() -> None:
    frame = with_payload(FRAME, PayloadConditions(mass_fraction=0.25, place_arms=(0.0, 0.0, 1.0)))
    assert frame.mass == pytest.approx(1.25 * FRAME.mass)
    np.testing.assert_allclose(frame.position - FRAME.position, [[0.0, 0.0, -0.2 * ARM_M]] * 4, atol=1e-12)
    added = 0.2 * FRAME.mass * ARM_M**2
    np.testing.assert_allclose(frame.inertia - FRAME.inertia, [added, added, 0.0], atol=1e-12)


def test_the_moments_about_the_common_centre_balance() -> None:
    payload = PayloadConditions(mass_fraction=0.4, place_arms=(0.3, -0.2, 0.5))
    frame = with_payload(FRAME, payload)
    vehicle = (frame.position - FRAME.position)[0]
    load = ARM_M * np.array(payload.place_arms) + vehicle
    np.testing.assert_allclose(FRAME.mass * vehicle + 0.4 * FRAME.mass * load, 0.0, atol=1e-12)


@pytest.mark.parametrize(
    ("payload", "before", "after"),
    [({"taken_at_s": 20.0}, 1.0, 1.3), ({"dropped_at_s": 20.0}, 1.3, 1.0)],
    ids=["taken", "dropped"],
)
def test_it_is_carried_from_its_time_to_its_time(payload: Any, before: float, after: float) -> None:
    sim = in_hover(conditions=conditions(payload={"mass_fraction": 0.3} | payload))
    weight = FRAME.mass * 9.80665
    sim.advance(17.0)
    assert thrust_to_hover(sim) == pytest.approx(before * weight, rel=0.02)
    sim.advance(35.0)
    assert thrust_to_hover(sim) == pytest.approx(after * weight, rel=0.02)
    lifted_s = next(truth.time_s for truth in sim.truth_log if truth.position[2] < 0.0)
    assert sim.load_changed_s == pytest.approx(lifted_s + 20.0, abs=0.02)
    np.testing.assert_allclose(sim.truth.position, sim.truth_log[1500].position, atol=0.1)


def test_nothing_happens_on_the_ground() -> None:
    sim = Simulation(BEBOP2, conditions(payload={"mass_fraction": 0.3, "taken_at_s": 1.0}), seed=1)
    sim.advance(5.0)
    assert sim.load_changed_s is None


def test_what_a_vehicle_cannot_carry_is_refused() -> None:
    x500 = load_vehicle("x500")
    with pytest.raises(ConfigError, match=r"payload\.mass_fraction: x500 would hover at 1\d\d%"):
        Simulation(x500, conditions(payload={"mass_fraction": 0.9}), seed=1)


def test_a_sagging_battery_costs_voltage_and_the_vehicle_stays_up() -> None:
    fresh, sagging = (
        in_hover(conditions=conditions(battery={"sag_fraction": sag, "sag_over_s": 20.0}))
        for sag in (0.0, 0.2)
    )
    for sim in (fresh, sagging):
        sim.advance(30.0)
    ratio = sagging.firmware.battery.voltage_v / fresh.firmware.battery.voltage_v
    assert ratio == pytest.approx(0.8, abs=0.01)
    np.testing.assert_allclose(sagging.truth.position, fresh.truth.position, atol=0.1)
    assert thrust_to_hover(sagging) == pytest.approx(thrust_to_hover(fresh), rel=0.01)
