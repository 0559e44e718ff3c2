"""PX4's control chain on flying vehicles."""

import math

import numpy as np
import pytest
from sitl_flights import IDEAL, in_hover, simulation, stream, with_parameters

from sitl.conditions import Conditions
from sitl.estimator_errors import EstimatorErrors, PositionError, VelocityError
from sitl.firmware.interface import Setpoint
from sitl.firmware.px4_parameters import Px4Parameters
from sitl.firmware.px4_takeoff import Takeoff, TakeoffPhase
from sitl.firmware.px4_tuning import tuned_parameters
from sitl.plant import TICK_S
from sitl.simulation import Simulation
from sitl.vehicle import Vehicle, load_vehicle

ALOFT = np.array((0.0, 0.0, -100.0))


def begin(vehicle: Vehicle, conditions: Conditions = IDEAL) -> Simulation:
    motion = np.zeros(13)
    motion[:3] = ALOFT
    motion[6] = 1.0
    return Simulation(vehicle, conditions, seed=1, record_truth=True, motion=motion)


def sinking(sim: Simulation) -> float:
    return max(abs(float(truth.position[2] - ALOFT[2])) for truth in sim.truth_log)


@pytest.mark.parametrize("estimated", [0, 1])
def test_a_flight_begins_without_sinking_whatever_the_hover_thrust_is_set_to(estimated: int) -> None:
    sim = begin(with_parameters(MPC_THR_HOVER=0.4, MPC_USE_HTE=estimated))
    stream(sim, Setpoint(position=ALOFT, velocity=np.zeros(3)), 10.0)
    assert sinking(sim) < 0.1


def test_a_wrong_hover_thrust_is_corrected_in_flight() -> None:
    """Acceleration setpoints have no feedback: what comes of them depends on the hover thrust alone."""

    def climb_rate(**parameters: float) -> float:
        sih = load_vehicle("px4_sih")
        sim = begin(sih.model_copy(update={"px4_parameters": Px4Parameters.model_validate(parameters)}))
        stream(sim, Setpoint(position=ALOFT, velocity=np.zeros(3), yaw=0.0), 5.0)
        stream(sim, Setpoint(acceleration=np.array((0.0, 0.0, -1.0)), yaw=0.0), 1.0)
        return -float(sim.truth.velocity[2])

    right = climb_rate(MPC_THR_HOVER=0.49, MPC_USE_HTE=0)
    assert climb_rate(MPC_THR_HOVER=0.4, MPC_USE_HTE=1) == pytest.approx(right, rel=0.02)
    assert climb_rate(MPC_THR_HOVER=0.4, MPC_USE_HTE=0) < 0.85 * right


def test_taking_over_what_was_learnt_does_not_jerk() -> None:
    sim = in_hover(with_parameters(MPC_THR_HOVER=0.4))
    climb = np.array([truth.velocity[2] for truth in sim.truth_log if truth.time_s > 5.0])
    assert np.abs(np.diff(climb, n=2)).max() / TICK_S < 0.1


@pytest.mark.parametrize(("climb_m_s", "feed_forward"), [(-0.5, math.nan), (math.nan, -1.0)])
def test_takeoff_ramp_is_not_amended_by_acceleration_unless_nothing_else_climbs(
    climb_m_s: float, feed_forward: float
) -> None:
    sim = simulation()
    wanted = Setpoint(
        velocity=np.array((0.0, 0.0, climb_m_s)), acceleration=np.array((0.0, 0.0, -1.0)), yaw=0.0
    )
    stream(sim, wanted, 0.5)
    sim.firmware.arm()
    stream(sim, wanted, 2.0)
    assert sim.firmware.active_setpoint.acceleration[2] == pytest.approx(feed_forward, nan_ok=True)


def test_a_reset_of_the_estimate_is_neither_acceleration_nor_error() -> None:
    errors = EstimatorErrors(
        position=PositionError(wander_m=2.0, wander_time_s=1e4),
        velocity=VelocityError(wander_m_s=1.0, wander_time_s=1e4),
        resets_per_hour=3600.0,
    )
    sim = begin(load_vehicle("px4_sih"), Conditions(name="resets", estimator=errors))
    before = sim.firmware.estimate
    stay = Setpoint(position=before.position, velocity=before.velocity, yaw=0.0)
    while sim.firmware.estimate.resets == 0:
        before = sim.firmware.estimate
        sim.firmware.offboard_setpoint(stay)
        sim.advance(sim.time_s + 0.01)
    after = sim.firmware.estimate
    jump = after.position - before.position
    assert np.linalg.norm(jump) > 0.5
    assert sim.firmware.active_setpoint.position == pytest.approx(stay.position + jump, abs=0.05)
    assert after.acceleration == pytest.approx(before.acceleration, abs=0.1)


def test_tilt_limit_widens_slowly_after_a_takeoff() -> None:
    takeoff = Takeoff(Px4Parameters(COM_SPOOLUP_TIME=0.0, MPC_TKO_RAMP_T=0.0))
    while takeoff.phase is not TakeoffPhase.FLIGHT:
        takeoff.update(armed=True, landed=False, wanted=True, dt=0.01)
    assert takeoff.max_tilt == pytest.approx(math.radians(12.0), abs=0.01)
    for _ in range(100):
        takeoff.update(armed=True, landed=False, wanted=True, dt=0.01)
    assert takeoff.max_tilt == pytest.approx(math.radians(12.0) + 0.2, abs=0.01)
    takeoff.skip()
    assert takeoff.max_tilt == pytest.approx(math.radians(45.0))


@pytest.mark.parametrize(
    ("name", "changed"),
    [("px4_sih", {}), ("px4_sih_stiff", {"MPC_XY_P": 1.5, "MPC_XY_VEL_P_ACC": 3.0})],
)
def test_px4_s_own_simulator_flies_with_px4_s_defaults(name: str, changed: dict[str, float]) -> None:
    vehicle = load_vehicle(name)
    assert tuned_parameters(vehicle) == Px4Parameters().model_copy(update=changed)
    full_thrust_n = float(vehicle.rotor_effectiveness[3].sum())
    assert full_thrust_n == pytest.approx(20.0)
    assert vehicle.rotor_effectiveness[:3].max(axis=1) == pytest.approx((1.0, 1.0, 0.1))
