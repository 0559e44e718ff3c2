import numpy as np
import pytest
from sitl_flights import BEBOP2, IDEAL, in_hover, simulation, stream, tilt_deg

from sitl.arrays import Array
from sitl.conditions import Conditions, load_conditions
from sitl.files import known_names
from sitl.firmware.interface import Mode, Setpoint
from sitl.plant import TICK_S
from sitl.simulation import Simulation
from sitl.vehicle import Vehicle, load_vehicle

HOVER_POINT = np.array((0.0, 0.0, -2.5))
REALISTIC = load_conditions("realistic")


def flown(seed: int, conditions: Conditions = REALISTIC) -> Array:
    sim = in_hover(conditions=conditions, seed=seed)
    stream(sim, Setpoint(position=np.array((1.0, 1.0, -3.0)), yaw=0.5), 2.0)
    return np.array([np.concatenate((t.position, t.attitude, t.wind)) for t in sim.truth_log])


def test_the_same_seed_gives_the_same_bits() -> None:
    assert flown(7).tobytes() == flown(7).tobytes()
    assert flown(7).tobytes() != flown(8).tobytes()


def test_ideal_conditions_need_no_seed() -> None:
    assert flown(7, IDEAL).tobytes() == flown(8, IDEAL).tobytes()


def test_wind_does_not_depend_on_the_estimator() -> None:
    """Separate random streams: what happens to one leaves the other's numbers alone."""
    blind = Simulation(BEBOP2, REALISTIC.model_copy(update={"estimator": IDEAL.estimator}), seed=3)
    noisy = Simulation(BEBOP2, REALISTIC, seed=3)
    for sim in (blind, noisy):
        sim.advance(1.0)
    assert (blind.truth.wind == noisy.truth.wind).all()
    assert (blind.firmware.estimate.position != noisy.firmware.estimate.position).any()


def test_advance_runs_whole_ticks() -> None:
    sim = simulation()
    sim.advance(0.0349)
    assert sim.time_s == pytest.approx(3 * TICK_S)
    assert sim.firmware.estimate.time_s == sim.time_s
    assert len(sim.truth_log) == 3
    sim.advance(0.01)
    assert sim.time_s == pytest.approx(3 * TICK_S)


def test_time_is_exact_after_many_ticks() -> None:
    sim = simulation()
    for tick in range(1, 1001):
        sim.advance(tick * TICK_S)
    assert sim.time_s == 10.0


def test_firmware_sees_the_estimate_never_the_truth() -> None:
    sim = in_hover(conditions=REALISTIC)
    errors = []
    for _ in range(200):
        sim.advance(sim.time_s + 0.5)
        errors.append(sim.firmware.estimate.position - sim.truth.position)
    assert np.std(errors) == pytest.approx(0.01, rel=0.25)


def step_responses(vehicle: Vehicle) -> list[tuple[Array, float]]:
    """Each way: positions flown, and the largest body rate of the last second."""
    out = []
    for step in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0)):
        sim = in_hover(vehicle)
        stream(sim, Setpoint(position=HOVER_POINT + step, yaw=0.0), 8.0)
        log = sim.truth_log[1500:]
        out.append((np.array([t.position for t in log]), max(np.abs(t.rates).max() for t in log[-100:])))
    return out


@pytest.mark.parametrize("name", known_names("vehicles"))
def test_every_vehicle_hovers_and_takes_steps(name: str) -> None:
    for axis, (positions, restlessness) in enumerate(step_responses(load_vehicle(name))):
        wanted = HOVER_POINT.copy()
        wanted[axis] += -1.0 if axis == 2 else 1.0
        assert positions[0] == pytest.approx(HOVER_POINT, abs=0.15)
        assert positions[-1] == pytest.approx(wanted, abs=0.08)
        assert np.abs(positions - positions[0]).max() < 1.4
        assert restlessness < 0.02


@pytest.mark.parametrize("name", known_names("vehicles"))
def test_every_vehicle_holds_in_realistic_conditions(name: str) -> None:
    sim = in_hover(load_vehicle(name), REALISTIC)
    sim.advance(40.0)
    log = sim.truth_log[1500:]
    assert sim.firmware.mode is Mode.HOLD
    assert np.abs([t.position - HOVER_POINT for t in log]).max() < 1.5
    assert max(tilt_deg(t.attitude) for t in log) < 30.0


def airframe_of(mass: float, arm: float, thrust_coefficient: float, lag_s: float, rotors: int) -> Vehicle:
    angles = np.pi / rotors + 2.0 * np.pi * np.arange(rotors) / rotors
    inertia = 0.35 * mass * arm**2
    return Vehicle.model_validate(
        {
            "name": "drawn",
            "mass_kg": mass,
            "inertia_kg_m2": [inertia, 1.2 * inertia, 1.7 * inertia],
            "rotors": {
                "layout": [
                    {
                        "x_m": arm * np.cos(angle),
                        "y_m": arm * np.sin(angle),
                        "direction": ("ccw", "cw")[i % 2],
                    }
                    for i, angle in enumerate(angles)
                ],
                "thrust_coefficient_n_s2": thrust_coefficient,
                "moment_coefficient_nm_s2": 0.015 * thrust_coefficient,
                "time_constant_s": lag_s,
            },
        }
    )


@pytest.mark.parametrize(
    "vehicle",
    [
        airframe_of(0.027, 0.04, 3e-8, 0.03, 4),
        airframe_of(0.6, 0.12, 2e-6, 0.08, 4),
        airframe_of(2.5, 0.3, 1e-5, 0.01, 6),
        airframe_of(5.0, 0.45, 4e-5, 0.05, 8),
    ],
    ids=["27 g", "slow motors", "hexarotor", "5 kg octorotor"],
)
def test_an_untuned_airframe_flies(vehicle: Vehicle) -> None:
    for axis, (positions, restlessness) in enumerate(step_responses(vehicle)):
        wanted = HOVER_POINT.copy()
        wanted[axis] += -1.0 if axis == 2 else 1.0
        assert positions[-1] == pytest.approx(wanted, abs=0.08)
        assert restlessness < 0.02


def test_step_of_a_symmetric_vehicle_is_the_same_north_and_east() -> None:
    (north, _), (east, _), _ = step_responses(load_vehicle("x500"))
    assert north[:, 0] == pytest.approx(east[:, 1], abs=1e-3)
    assert north[:, 2] == pytest.approx(east[:, 2], abs=1e-3)
