import numpy as np
import pytest
from sitl_flights import in_hover, simulation, stream, texts

from sitl.firmware.interface import Landed, Mode, Result, Setpoint
from sitl.firmware.pilot import Sticks
from sitl.simulation import Simulation
from sitl.vehicle import Vehicle, load_vehicle

ARDUCOPTER = load_vehicle("arducopter_sitl")


def lose_offboard(action: int) -> Simulation:
    sim = in_hover()
    sim.firmware.set_parameter("COM_OBL_RC_ACT", action)
    stream(sim, Setpoint(position=np.array((0.0, 0.0, -2.5))), 0.5)
    sim.advance(sim.time_s + 1.2)
    return sim


def with_ground_station(sim: Simulation, **parameters: float) -> Simulation:
    """Heard now, and never again."""
    sim.firmware.hear_ground_station(255)
    for name, value in parameters.items():
        sim.firmware.set_parameter(name, value)
    return sim


@pytest.mark.parametrize(
    ("action", "mode"),
    [(0, "POSCTL"), (1, "ALTCTL"), (2, "STABILIZE"), (3, "RTL"), (4, "LAND"), (5, "HOLD")],
)
def test_px4_goes_to_the_mode_that_the_loss_of_setpoints_asks_for(action: int, mode: str) -> None:
    firmware = lose_offboard(action).firmware
    assert firmware.mode.name == mode
    assert firmware.failsafe


@pytest.mark.parametrize("action", [6, 7])
def test_px4_ends_the_flight_when_that_is_asked_for(action: int) -> None:
    sim = lose_offboard(action)
    assert not sim.firmware.armed
    sim.advance(sim.time_s + 3.0)
    assert sim.firmware.set_mode(Mode.HOLD) is Result.ACCEPTED
    rearmed = sim.firmware.arm()
    assert rearmed is (Result.TEMPORARILY_REJECTED if action == 6 else Result.ACCEPTED)


def test_px4_comes_back_to_offboard_by_itself() -> None:
    sim = lose_offboard(0)
    sim.firmware.offboard_setpoint(Setpoint(position=np.array((0.0, 0.0, -2.5))))
    sim.advance(sim.time_s + 0.1)
    assert sim.firmware.mode is Mode.OFFBOARD


def test_px4_holds_and_then_returns_without_its_ground_station() -> None:
    sim = with_ground_station(in_hover(), NAV_DLL_ACT=2, COM_DL_LOSS_T=5, COM_FAIL_ACT_T=3.0)
    start_s = sim.time_s
    sim.advance(start_s + 4.9)
    assert not sim.firmware.failsafe
    sim.advance(start_s + 5.1)
    assert (sim.firmware.mode, sim.firmware.failsafe) == (Mode.HOLD, True)
    sim.advance(start_s + 8.2)
    assert sim.firmware.mode is Mode.RTL
    assert "ground station lost" in texts(sim)


def test_a_mode_that_is_chosen_ends_the_failsafe_of_px4() -> None:
    sim = with_ground_station(in_hover(), NAV_DLL_ACT=3, COM_DL_LOSS_T=5, COM_FAIL_ACT_T=1.0)
    sim.advance(sim.time_s + 5.5)
    assert sim.firmware.set_mode(Mode.POSCTL) is Result.ACCEPTED
    sim.advance(sim.time_s + 3.0)
    assert (sim.firmware.mode, sim.firmware.failsafe) == (Mode.POSCTL, False)


def test_px4_does_not_arm_without_a_ground_station_that_it_must_hear() -> None:
    sim = simulation()
    sim.firmware.set_parameter("NAV_DLL_ACT", 2)
    assert sim.firmware.arm() is Result.TEMPORARILY_REJECTED
    sim.firmware.hear_ground_station(255)
    assert sim.firmware.arm() is Result.ACCEPTED


def lose_pilot(sim: Simulation, **parameters: float) -> None:
    """Sticks in their middle, and then none."""
    for name, value in parameters.items():
        sim.firmware.set_parameter(name, value)
    sim.firmware.move_sticks(Sticks())
    sim.advance(sim.time_s + 1.0)


@pytest.mark.parametrize(("action", "mode"), [(1, Mode.HOLD), (2, Mode.RTL), (3, Mode.LAND)])
def test_px4_misses_a_pilot_who_was_there(action: int, mode: Mode) -> None:
    sim = in_hover()
    lose_pilot(sim, NAV_RCL_ACT=action, COM_FAIL_ACT_T=2.0, RTL_RETURN_ALT=4.0)
    assert (sim.firmware.mode, sim.firmware.failsafe) == (Mode.HOLD, True)
    sim.advance(sim.time_s + 2.0)
    assert sim.firmware.mode is mode
    assert "manual control lost" in texts(sim)


@pytest.mark.parametrize(
    "parameters", [{"COM_RCL_EXCEPT": 2}, {"COM_RC_IN_MODE": 4}, {"COM_RC_LOSS_T": 30.0}]
)
def test_px4_goes_on_without_a_pilot_where_it_may(parameters: dict[str, float]) -> None:
    sim = in_hover()
    lose_pilot(sim, NAV_RCL_ACT=3, COM_FAIL_ACT_T=0.0, **parameters)
    assert (sim.firmware.mode, sim.firmware.failsafe) == (Mode.HOLD, False)


def test_px4_knows_a_mode_that_was_chosen_from_a_failsafes() -> None:
    sim = in_hover()
    assert (sim.firmware.mode, sim.firmware.intended_mode) == (Mode.HOLD, Mode.HOLD)
    assert sim.firmware.takeoff(3.0) is Result.ACCEPTED
    lose_pilot(sim, NAV_RCL_ACT=3, COM_FAIL_ACT_T=9.0)
    assert (sim.firmware.mode, sim.firmware.intended_mode) == (Mode.HOLD, Mode.TAKEOFF)
    assert sim.firmware.set_mode(Mode.HOLD) is Result.ACCEPTED
    assert sim.firmware.intended_mode is Mode.HOLD


def test_px4_does_not_miss_a_pilot_who_was_gone_before_it_was_armed() -> None:
    sim = simulation()
    lose_pilot(sim, NAV_RCL_ACT=3, COM_FAIL_ACT_T=0.0)
    sim.firmware.takeoff()
    sim.firmware.arm()
    sim.advance(15.0)
    assert sim.firmware.mode is Mode.HOLD


def in_mode(mode: Mode, **parameters: float) -> Simulation:
    """ArduPilot, hovering in `mode`."""
    sim = in_hover(ARDUCOPTER)
    for name, value in parameters.items():
        sim.firmware.set_parameter(name, value)
    assert sim.firmware.set_mode(mode) is Result.ACCEPTED
    return sim


@pytest.mark.parametrize(
    ("enabled", "heard", "mode"),
    [
        (1, 255, Mode.RTL),
        (5, 255, Mode.LAND),
        (7, 255, Mode.BRAKE),
        (1, 7, Mode.OFFBOARD),
        (0, 255, Mode.OFFBOARD),
    ],
)
def test_ardupilot_misses_its_own_ground_station_only(enabled: int, heard: int, mode: Mode) -> None:
    sim = in_mode(Mode.OFFBOARD, FS_GCS_ENABLE=enabled)
    sim.firmware.hear_ground_station(heard)
    sim.advance(sim.time_s + 5.2)
    assert sim.firmware.mode is mode
    assert sim.firmware.failsafe == (mode is not Mode.OFFBOARD)


@pytest.mark.parametrize(
    ("before", "options", "after"),
    [
        (Mode.HOLD, 16, Mode.HOLD),
        (Mode.HOLD, 0, Mode.RTL),
        (Mode.OFFBOARD, 4 | 16, Mode.RTL),
        (Mode.LAND, 8, Mode.LAND),
        (Mode.LAND, 16, Mode.RTL),
    ],
)
def test_ardupilot_may_go_on_without_ground_station(before: Mode, options: int, after: Mode) -> None:
    sim = with_ground_station(in_mode(before), FS_GCS_ENABLE=1, FS_GCS_TIMEOUT=2.0, FS_OPTIONS=options)
    sim.advance(sim.time_s + 2.2)
    assert sim.firmware.mode is after
    assert "GCS Failsafe" in texts(sim)


@pytest.mark.parametrize(("action", "mode"), [(1, Mode.RTL), (3, Mode.LAND), (7, Mode.BRAKE)])
def test_ardupilot_misses_a_radio_that_was_there(action: int, mode: Mode) -> None:
    sim = in_mode(Mode.OFFBOARD)
    lose_pilot(sim, FS_THR_ENABLE=action)
    assert not sim.firmware.failsafe
    sim.advance(sim.time_s + 0.1)
    assert (sim.firmware.mode, sim.firmware.failsafe) == (mode, True)
    assert "Radio Failsafe" in texts(sim)
    assert sim.firmware.set_mode(Mode.OFFBOARD) is Result.ACCEPTED
    sim.advance(sim.time_s + 2.0)
    assert sim.firmware.mode is Mode.OFFBOARD  # once for each loss


@pytest.mark.parametrize(
    "parameters", [{"FS_OPTIONS": 4}, {"FS_THR_ENABLE": 0}, {"RC_FS_TIMEOUT": 5.0}], ids=str
)
def test_ardupilot_goes_on_in_guided_without_radio_where_it_may(parameters: dict[str, float]) -> None:
    sim = in_mode(Mode.OFFBOARD)
    lose_pilot(sim, **parameters)
    sim.advance(sim.time_s + 0.5)
    assert (sim.firmware.mode, sim.firmware.failsafe) == (Mode.OFFBOARD, False)


@pytest.mark.parametrize("vehicle", [load_vehicle("bebop2"), ARDUCOPTER], ids=["px4", "ardupilot"])
def test_a_terminated_flight_falls_and_does_not_begin_again(vehicle: Vehicle) -> None:
    sim = in_hover(vehicle)
    assert sim.firmware.terminate() is Result.ACCEPTED
    sim.advance(sim.time_s + 3.0)
    assert sim.truth.position[2] == pytest.approx(0.0, abs=0.05)
    assert sim.firmware.landed is Landed.ON_GROUND
    assert sim.firmware.arm() is not Result.ACCEPTED
