"""What one control step costs: from the states of a flight to its setpoints, on one core, with its record."""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from companion import clock
from companion.arrays import Times, Vec3
from companion.errors import FlightError
from companion.experiments.simulated_flights import Scenario, simulate
from companion.flight.control import Control, ControlSettings, Triple
from companion.flight.flight import FlightOutcome
from companion.flight.heading import YawMode
from companion.flight.recorder import FlightRecorder
from companion.flight.tracker import Tracker
from companion.state import VehicleState


@dataclass(frozen=True)
class Spread:
    """Of many steps (ms): the median, what one in a hundred exceeds, and the longest."""

    p50: float
    p99: float
    max: float


@dataclass(frozen=True)
class StepCost:
    """What the control steps of one flight cost.

    Attributes:
        steps: how many were measured.
        elapsed_ms: on the wall's clock, in which whatever else runs on the machine has a part.
        processor_ms: time of the processor.
    """

    steps: int
    elapsed_ms: Spread
    processor_ms: Spread


def step_cost(scenario: Scenario) -> StepCost:
    """Fly the scenario, then feed its states to the control loop again, and measure each of its steps.

    A step is all that is done for one setpoint: taking in the states since the one before, strategy, online
    correction, guard, and making its records. Measured along the trajectory, from when the window is full.

    Raises:
        InputError: vehicle, conditions or strategy cannot be used.
        FlightError: the flight failed, or was over before the window was full.
    """
    outcome, _, _ = simulate(scenario)
    with threadpool_limits(1):
        costs = np.array(list(_costs(scenario, outcome))).reshape(-1, 2)
    window_s = scenario.online.window * scenario.online.sample_time_s + scenario.online.preview.longest_s
    measured = costs[int(np.ceil(window_s / scenario.plan().period_s)) :]
    if not len(measured):
        raise FlightError(
            f"{scenario.trajectory.name} takes {scenario.trajectory.duration_s:.1f} s, and the window of the "
            f"online model {window_s:.1f} s: fly longer"
        )
    return StepCost(len(measured), _spread(measured[:, 0]), _spread(measured[:, 1]))


def _costs(scenario: Scenario, outcome: FlightOutcome) -> Iterator[tuple[float, float]]:
    """Elapsed and processor time (s) of each step along the trajectory."""
    plan = scenario.plan()
    tracker = Tracker(outcome.trajectory, outcome.start_s, plan.law, plan.correction, plan.supervision)
    settings = ControlSettings(
        home=_triple(outcome.trajectory.at(0.0).position - plan.trajectory.at(0.0).position),
        yaw=0.0,
        yaw_mode=YawMode.HOLD,
        period_s=plan.period_s,
        limits=plan.limits,
    )
    control = Control(settings, tracker, FlightRecorder())
    states = deque(state for state in _states(outcome) if state.time_s >= outcome.start_s)
    control.begin(outcome.start_s, states[0])
    for now_s in np.arange(outcome.start_s, tracker.end_s, plan.period_s):
        began, began_processor = clock.stopwatch_s(), clock.processor_s()
        while states and states[0].time_s <= now_s:
            control.observe(states.popleft())
        assert control.newest is not None
        control.setpoint(now_s, control.newest.at(now_s))
        yield clock.stopwatch_s() - began, clock.processor_s() - began_processor


def _states(outcome: FlightOutcome) -> Iterator[VehicleState]:
    """The states of the flight, as if each had come at once."""
    states = outcome.recording.states
    columns = states.time_s, states.position, states.velocity, states.attitude, states.rates
    for time_s, *motion in zip(*columns, strict=True):
        yield VehicleState(time_s, time_s, *motion)


def _spread(seconds: Times) -> Spread:
    return Spread(*(1e3 * float(each) for each in np.quantile(seconds, (0.5, 0.99, 1.0))))


def _triple(vector: Vec3) -> Triple:
    north, east, down = vector.tolist()
    return north, east, down
