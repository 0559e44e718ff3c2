"""Flights of simulated vehicles in virtual time, one or many: the whole companion, through the bytes."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from companion import __version__, clock
from companion.arrays import Times, Vec3s
from companion.autopilot import detect
from companion.errors import FlightError, InputError
from companion.experiments.backend import LOCAL, Backend
from companion.experiments.flights import Flight
from companion.flight.flight import FlightOutcome, FlightPlan, fly
from companion.flight.guard import Clip
from companion.flight.online_correction import OnlineCorrection
from companion.flight.strategies import Strategy, reference_law
from companion.flight.supervision import supervision_of
from companion.learning.inverse_network import InverseNetwork
from companion.learning.online_settings import DEFAULT, OnlineSettings
from companion.link import connect, start_telemetry
from companion.link.address import Simulated
from companion.link.simulated import SimulatedTransport
from companion.recording.metrics import TrackingAccuracy, tracking_accuracy
from companion.recording.series import Provenance
from companion.trajectory.trajectory import Trajectory
from sitl.conditions import load_conditions
from sitl.errors import ConfigError
from sitl.mavlink import open_vehicle
from sitl.plant import TICK_S


@dataclass(frozen=True, eq=False)
class Scenario:
    """One flight to be simulated: what is flown, how, by whom and in what air.

    Attributes:
        trajectory: NED relative to the takeoff point (m).
        strategy: how it is flown.
        vehicle: name in `config/vehicles`, or a YAML file.
        conditions: name in `config/conditions`, or a YAML file.
        seed: of wind, estimator errors and link.
        network: for the strategies that need one.
        lookahead_s: for the strategy that needs it (s).
        online: settings of the online correction.
    """

    trajectory: Trajectory
    strategy: Strategy
    vehicle: str = "bebop2"
    conditions: str = "ideal"
    seed: int = 0
    network: InverseNetwork | None = None
    lookahead_s: float | None = None
    online: OnlineSettings = DEFAULT

    def plan(self) -> FlightPlan:
        """What the companion is told to fly.

        Raises:
            InputError: the strategy needs a network or a lookahead time that is not there.
        """
        return FlightPlan(
            self.trajectory,
            reference_law(
                self.strategy,
                network=self.network,
                lookahead_s=self.lookahead_s,
                online=self.online,
            ),
            OnlineCorrection(self.online) if self.strategy.learns_online else None,
            supervision_of(self.strategy, self.network, self.online),
            period_s=self.strategy.period_s(self.online),
        )

    def provenance(self) -> Provenance:
        """What its recording says of itself."""
        return Provenance(
            vehicle=self.vehicle,
            trajectory=self.trajectory.name,
            strategy=self.strategy,
            software=__version__,
            conditions=self.conditions,
            seed=self.seed,
        )


@dataclass(frozen=True, eq=False)
class Flown:
    """A simulated flight that came to its end.

    Attributes:
        scenario: what it was to be.
        accuracy: against the truth, or against the estimate where the conditions say so.
        estimated_accuracy: against the vehicle's own estimate.
        flight: desired positions and those measured, for pictures.
        clips: how often the guard changed what.
        active_share: share of the time in which the network was active.
    """

    scenario: Scenario
    accuracy: TrackingAccuracy
    estimated_accuracy: TrackingAccuracy
    flight: Flight
    clips: Mapping[Clip, int]
    active_share: float


@dataclass(frozen=True, eq=False)
class Failed:
    """A simulated flight that did not come to its end, and why."""

    scenario: Scenario
    reason: str


Result: TypeAlias = Flown | Failed


def simulate(scenario: Scenario) -> tuple[FlightOutcome, Times, Vec3s]:
    """Fly one scenario in virtual time.

    Returns:
        What came of it; the times (companion clock, s) and positions (NED, m) where the vehicle truly was,
        every 10 ms from boot on.

    Raises:
        InputError: vehicle, conditions or strategy cannot be used.
        FlightError: the flight failed.
    """
    return clock.run(_simulate(scenario), virtual=True)


async def _simulate(scenario: Scenario) -> tuple[FlightOutcome, Times, Vec3s]:
    address = Simulated(scenario.vehicle, scenario.conditions, scenario.seed, record_truth=True)
    async with connect(address) as connection:
        telemetry = await start_telemetry(connection)
        autopilot = await detect(connection, telemetry)
        outcome = await fly(scenario.plan(), autopilot, telemetry, provenance=scenario.provenance())
        transport = connection.transport
        assert isinstance(transport, SimulatedTransport)
        truths = transport.vehicle.simulation.truth_log
        time_s = np.array([transport.epoch_s + truth.time_s for truth in truths])
        return outcome, time_s, np.array([truth.position for truth in truths])


def evaluate(scenario: Scenario) -> Result:
    """Fly one scenario and measure how far the vehicle was from its trajectory: truly, or as it believes.

    Which, the conditions say (`errors_against`).

    Raises:
        InputError: vehicle, conditions or strategy cannot be used.
    """
    try:
        outcome, time_s, position = simulate(scenario)
    except FlightError as error:
        return Failed(scenario, str(error))
    if load_conditions(scenario.conditions).errors_against == "estimate":
        states = outcome.recording.states
        time_s, position = states.time_s, states.position
    trajectory, start_s = outcome.trajectory, outcome.start_s
    end_s = start_s + trajectory.duration_s

    def desired(time_s: Times) -> Vec3s:
        return trajectory.sample(time_s - start_s).position

    accuracy = tracking_accuracy(desired, time_s, position, start_s, end_s)
    along = (time_s >= start_s) & (time_s <= end_s)
    return Flown(
        scenario,
        accuracy,
        outcome.accuracy,
        Flight(
            trajectory.name,
            scenario.strategy,
            time_s[along] - start_s,
            desired(time_s[along]),
            position[along],
            accuracy.rms_m,
        ),
        outcome.clips,
        active_share=0.0 if scenario.network is None else 1.0,
    )


def evaluate_all(scenarios: Sequence[Scenario], backend: Backend = LOCAL) -> Iterator[Result]:
    """`evaluate` each, one a core; results come in the order of the scenarios."""
    return backend.each(evaluate, scenarios)


def prepare_simulator(vehicles: Sequence[str], conditions: str) -> None:
    """Make sure that these vehicles and conditions are there, and compile the simulator once for all cores.

    Raises:
        InputError: a vehicle or the conditions are missing or wrong.
    """
    try:
        for vehicle in vehicles:
            open_vehicle(vehicle, conditions).advance(TICK_S)
    except ConfigError as error:
        raise InputError(str(error)) from error
