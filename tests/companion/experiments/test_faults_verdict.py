"""What is made of a flight with a fault, from courses that are written down."""

import math

import numpy as np
import pytest

from companion.arrays import Vec3s
from companion.errors import TakenError, TrackingError
from companion.experiments.faults.catalogue import (
    catalogue,
    criterion,
    held_wind_m_s,
    kinds_among,
    of_companion,
    of_vehicle,
)
from companion.experiments.faults.flight import Course, FaultFlight, KilledError, Phase
from companion.experiments.faults.sabotage import Sabotage
from companion.experiments.faults.table import figures, lines, markdown
from companion.experiments.faults.verdict import FaultRow, judge
from companion.experiments.simulated_flights import Scenario
from companion.flight.approach import rest_to_rest
from companion.flight.fence import Fence
from companion.flight.strategies import Strategy
from companion.flight.watchdogs import Action, WatchdogError
from sitl.firmware.interface import Mode
from sitl.vehicle import load_vehicle

LINE = rest_to_rest(np.array([0.0, 0.0, -2.0]), np.array([2.0, 0.0, -2.0]), "line")
FLIGHT = FaultFlight(Scenario(LINE, Strategy.DNN_GP), of_vehicle("gust:north_m_s=5"), Phase.TRACKING)
TIMES_S = np.arange(0.0, 10.0, 0.01)


def course(
    position: Vec3s,
    error: Exception | None = None,
    *,
    events: tuple[tuple[float, str], ...] = (),
    warnings: tuple[tuple[float, str], ...] = (),
    modes: tuple[tuple[float, Mode], ...] = ((0.0, Mode.OFFBOARD),),
    desired_until_s: float = 5.0,
) -> Course:
    """Struck after 2 s; until 5 s the vehicle was wanted 2 m above where it took off."""
    desired_s = np.arange(0.0, desired_until_s, 0.02)
    return Course(
        struck_s=2.0,
        error=error,
        events=list(events),
        warnings=list(warnings),
        modes=list(modes),
        desired_s=desired_s,
        desired=np.tile([0.0, 0.0, -2.0], (len(desired_s), 1)),
        time_s=TIMES_S,
        position=position,
        velocity=np.gradient(position, 0.01, axis=0),
        fence=Fence(north_m=(-5.0, 5.0), east_m=(-5.0, 5.0), altitude_m=(0.5, 7.0)),
    )


def hovering(north: float = 0.0, down: float = -2.0) -> Vec3s:
    return np.tile([north, 0.0, down], (len(TIMES_S), 1))


def judged(flown: Course) -> FaultRow:
    return judge(FLIGHT, flown)


def test_a_flight_that_goes_on() -> None:
    row = judged(course(hovering(0.3)))
    assert (row.action, row.detected_s, row.detected_by) == ("flies on", None, "")
    assert row.deviation_m == pytest.approx(0.3)
    assert row.touchdown_m_s is None
    assert not row.lost


def test_routine_words_are_no_detection() -> None:
    said = ((2.1, "holding"), (2.2, "landing"), (2.7, "guard: setpoint kept near the vehicle"))
    row = judged(course(hovering(), events=said, warnings=((3.0, "Failsafe"),)))
    assert row.detected_s == pytest.approx(0.7)
    assert row.detected_by == "companion"
    assert judged(course(hovering(), warnings=((3.0, "Failsafe"),))).detected_by == "autopilot"


def test_a_descent_is_no_deviation_and_its_end_a_touch_down() -> None:
    down = hovering()
    down[:, 2] = np.minimum(-2.0 + 0.7 * np.maximum(TIMES_S - 6.0, 0.0), 0.0)
    row = judged(course(down, modes=((0.0, Mode.OFFBOARD), (6.0, Mode.LAND))))
    assert row.deviation_m == pytest.approx(0.0)
    assert row.touchdown_m_s == pytest.approx(0.7, abs=0.01)
    assert not row.lost


def test_a_fall_is_a_crash() -> None:
    fall = hovering()
    fall[:, 2] = np.minimum(-2.0 + 0.5 * 9.8 * np.maximum(TIMES_S - 3.0, 0.0) ** 2, 0.0)
    row = judged(course(fall))
    assert row.crash
    assert row.touchdown_m_s == pytest.approx(math.sqrt(2.0 * 9.8 * 2.0), rel=0.1)


def test_beyond_the_fence_and_away() -> None:
    row = judged(course(hovering() + np.outer(np.maximum(TIMES_S - 2.0, 0.0), [1.5, 0.0, 0.0])))
    assert row.breach
    assert row.fly_away
    assert row.deviation_m == pytest.approx(12.0, abs=0.1)


def test_what_was_before_the_fault_does_not_count() -> None:
    before = hovering()
    before[:100, 0] = 9.0
    assert not judged(course(before)).lost


def test_the_way_home_is_where_a_return_should_be() -> None:
    back = hovering()
    back[:, 0] = np.interp(TIMES_S, [5.0, 10.0], [4.0, 0.0])
    back[:, 2] = -6.0
    flown = course(back, TrackingError("too far"), modes=((0.0, Mode.RTL),))
    assert judged(flown).deviation_m == pytest.approx(4.0)  # the last desired position is over home
    flown.desired[:, 0] = 4.0
    assert judged(flown).deviation_m == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize(
    ("error", "events", "mode", "action"),
    [
        (TakenError("taken"), (), Mode.POSCTL, "yields (hold)"),
        (TrackingError("far"), ((3.0, "telling the vehicle to hold"),), Mode.HOLD, "hold"),
        (TrackingError("far"), (), Mode.LAND, "autopilot: land"),
        (TrackingError("far"), ((3.0, "telling the vehicle to hold"),), Mode.LAND, "autopilot: land"),
        (WatchdogError("astray", Action.LAND), ((3.0, "landing"),), Mode.LAND, "land"),
        (WatchdogError("astray", Action.LAND), (), Mode.HOLD, "autopilot: hold"),
        (
            TrackingError("far"),
            ((3.0, "telling the vehicle to hold"),),
            Mode.OFFBOARD,
            "autopilot: stays guided",
        ),
        (KilledError("killed"), (), Mode.POSCTL, "autopilot: hold"),
        (None, ((3.0, "guard: not finite: baseline sent"),), Mode.LAND, "falls back"),
    ],
)
def test_what_was_done(
    error: Exception | None, events: tuple[tuple[float, str], ...], mode: Mode, action: str
) -> None:
    flown = course(hovering(), error, events=events, modes=((0.0, Mode.OFFBOARD), (3.0, mode)))
    assert judged(flown).action == action


def test_what_the_pilot_does_is_the_pilots_business() -> None:
    away = hovering() + np.outer(np.maximum(TIMES_S - 3.0, 0.0), [3.0, 0.0, 0.0])
    modes = ((0.0, Mode.OFFBOARD), (3.0, Mode.POSCTL))
    assert not judged(course(away, TakenError("taken"), modes=modes)).fly_away


@pytest.mark.parametrize(
    ("fault", "survivable"),
    [
        ("motor_weak:motor=1,effectiveness=0.9", True),
        ("motor_weak:motor=1,effectiveness=0.5", False),
        ("motor_dead:motor=1", False),
        ("reboot", False),
        ("gust:north_m_s=11", True),
        ("gust:north_m_s=9,east_m_s=9", False),
        ("compass_error:error_deg=-30", True),
        ("compass_error:error_deg=-90", False),
        ("battery_collapse:remaining=0", True),
        ("telemetry_lost", True),
    ],
)
def test_the_criterion_is_there_before_the_flight(fault: str, survivable: bool) -> None:
    written = criterion(of_vehicle(fault), load_vehicle("bebop2"))
    assert written.survivable is survivable
    assert written.text


@pytest.mark.parametrize("name", ["bebop2", "arducopter_sitl", "px4_sih"])
def test_held_against_the_wind_is_drag_as_large_as_the_lean_gives(name: str) -> None:
    vehicle = load_vehicle(name)
    wind_m_s = held_wind_m_s(vehicle)
    rotors = len(vehicle.rotors.layout) * vehicle.rotor_drag_n_s2_per_m * vehicle.hover_speed_rad_s
    linear, quadratic = vehicle.body_drag.linear_n_s_per_m[0], vehicle.body_drag.quadratic_n_s2_per_m2[0]
    drag_n = (linear + rotors + quadratic * wind_m_s) * wind_m_s
    lean = math.radians(30.0 if name == "arducopter_sitl" else 45.0)
    assert drag_n == pytest.approx(vehicle.mass_kg * 9.80665 * math.tan(lean))


def test_what_lands_slowly_bears_less_drift() -> None:
    drift = of_vehicle("estimator_drift:east_m_s=0.5")
    assert criterion(drift, load_vehicle("bebop2")).survivable
    assert not criterion(drift, load_vehicle("arducopter_sitl")).survivable


def test_what_leans_less_bears_less_wind() -> None:
    gust = of_vehicle("gust:north_m_s=6,east_m_s=8")
    assert criterion(gust, load_vehicle("bebop2")).survivable
    assert not criterion(gust, load_vehicle("arducopter_sitl")).survivable


def test_whatever_fails_in_the_companion_must_be_survived() -> None:
    vehicle = load_vehicle("bebop2")
    assert all(criterion(of_companion(what, 1.0), vehicle).survivable for what in Sabotage)


def test_there_are_enough_faults() -> None:
    every = list(catalogue())
    assert len({failure.name for failure in every}) == len(every) >= 40
    assert len(kinds_among(every)) >= 20


def test_the_table_has_the_worst_of_each_line() -> None:
    rows = [judged(course(hovering(deviation))) for deviation in (0.1, 0.4, 6.0)]
    (line,) = lines(rows)
    assert (line.flights, line.lost) == (3, 1)
    assert line.deviation_m == pytest.approx(6.0)
    summary = figures(rows)["summary"]
    assert summary["survivable_breaches"] == 1
    page = markdown(rows)
    assert page.index("## What can be survived") < page.index("## What became of it")
    assert "| `gust:north_m_s=5` | tracking | bebop2 | – | – | flies on | 6.00 | – | 1 of 3 |" in page


def test_each_vehicle_has_its_own_lines_and_criteria() -> None:
    row = judged(course(hovering()))
    other = row.model_copy(update={"vehicle": "arducopter_sitl"})
    weak = other.model_copy(update={"criterion": "never", "survivable": False})
    assert [line.vehicle for line in lines([row, other])] == ["bebop2", "arducopter_sitl"]
    page = markdown([row, other])
    assert "| `gust:north_m_s=5` | bebop2, arducopter_sitl | yes | up to 12.0 m/s: its largest lean" in page
    assert "| `gust:north_m_s=5` | arducopter_sitl | no | never |" in markdown([row, weak])
