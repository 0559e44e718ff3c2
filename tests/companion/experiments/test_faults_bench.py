"""A fixed slice of `companion bench faults`."""

import pytest

from companion.experiments.contenders import find_model
from companion.experiments.faults.catalogue import of_companion, of_vehicle
from companion.experiments.faults.flight import FaultFlight, Phase
from companion.experiments.faults.job import fly_and_judge
from companion.experiments.faults.sabotage import Sabotage
from companion.experiments.faults.verdict import FaultRow
from companion.experiments.simulated_flights import Scenario
from companion.experiments.trajectories import limits_within, named_trajectories
from companion.flight.strategies import Strategy
from companion.learning.online_settings import DEFAULT
from companion.trajectory.placement import Placement

CLEF = named_trajectories(["clef"], Placement(size_m=1.0), limits_within(["bebop2"], None))[0]
NETWORK = find_model("ardrone2", DEFAULT).network


def flown(fault: str | tuple[Sabotage, float], phase: Phase = Phase.TRACKING) -> FaultRow:
    failure = of_vehicle(fault) if isinstance(fault, str) else of_companion(*fault)
    scenario = Scenario(CLEF, Strategy.DNN_GP, conditions="realistic", seed=0, network=NETWORK)
    return fly_and_judge(FaultFlight(scenario, failure, phase))


@pytest.mark.parametrize(
    "fault",
    [
        "motor_weak:motor=2,effectiveness=0.8",
        "estimator_jump:north_m=1",
        "setpoints_ignored",
        "telemetry_lost",
        (Sabotage.LOOP_STALLED, 1.5),
        (Sabotage.MODEL_NAN, 0.0),
    ],
)
def test_a_fault_on_the_trajectory_is_survived(fault: str | tuple[Sabotage, float]) -> None:
    row = flown(fault)
    assert row.struck
    assert row.survivable
    assert not row.lost


def test_a_pilot_who_takes_over_is_left_alone() -> None:
    row = flown("pilot_mode:mode=POSCTL")
    assert row.action == "yields (hold)"
    assert not row.lost


def test_a_companion_that_dies_leaves_the_vehicle_to_its_failsafe() -> None:
    row = flown((Sabotage.PROCESS_KILLED, 0.0))
    assert row.action == "autopilot: hold"
    assert row.detected_by == "autopilot"
    assert row.detected_s == pytest.approx(1.0, abs=0.1)
    assert not row.lost


@pytest.mark.parametrize("phase", [Phase.TAKEOFF, Phase.LANDING])
def test_a_gust_in_the_climb_or_in_the_landing_is_survived(phase: Phase) -> None:
    row = flown("gust:north_m_s=6,lasts_s=2", phase)
    assert row.struck
    assert not row.lost
    assert row.touchdown_m_s is not None


def test_what_cannot_be_survived_is_a_crash() -> None:
    row = flown("rotors_stopped")
    assert not row.survivable
    assert row.crash


def test_the_same_flight_gives_the_same_row() -> None:
    assert flown("telemetry_lossy:share=0.3") == flown("telemetry_lossy:share=0.3")
