"""Flights of simulated vehicles in virtual time, one or many: the whole companion, through the bytes."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np

from companion import __version__, clock
from companion.arrays import Times, Vec3s
from companion.autopilot import detect
from companion.errors import FlightError, InputError
from companion.experiments.backend import LOCAL, Backend
from companion.experiments.flights import Flight
from companion.experiments.recovery import recovery_s
from companion.flight.flight import FlightOutcome, FlightPlan, fly
from companion.flight.guard import Clip
from companion.flight.online_correction import OnlineCorrection
from companion.flight.strategies import Strategy, reference_law
from companion.flight.supervision import supervision_of
from companion.learning.inverse_network import InverseNetwork
from companion.learning.library import Library
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

_LEAST_SHARE = 0.02
"""Of a network, that counts as active."""


@dataclass(frozen=True, eq=False)
class Scenario:
    """One flight to be simulated: what is flown, how, by whom and in what air.

    Attributes:
        trajectory: NED relative to the takeoff point (m).
        strategy: how it is flown.
        vehicle: name in `config/vehicles`, or a YAML file.
        conditions: name in `config/conditions`, or a YAML file.
        seed: of wind, estimator errors and link.
        network: for the strategies that need one; `dnn+gp` takes a library, too.
        lookahead_s: for the strategy that needs it (s).
        online: settings of the online correction.
    """

    trajectory: Trajectory
    strategy: Strategy
    vehicle: str = "bebop2"
    conditions: str = "ideal"
    seed: int = 0
    network: InverseNetwork | Library | None = None
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
        event_s: when the vehicle took or dropped its payload, on the trajectory (s).
        recovery_s: time from then until it tracked as before (s).
    """

    scenario: Scenario
    accuracy: TrackingAccuracy
    estimated_accuracy: TrackingAccuracy
    flight: Flight
    clips: Mapping[Clip, int]
    active_share: float
    event_s: float | None = None
    recovery_s: float | None = None


@dataclass(frozen=True, eq=False)
class Failed:
    """A simulated flight that did not come to its end, and why."""

    scenario: Scenario
    reason: str


Result: TypeAlias = Flown | Failed


class _Simulated(NamedTuple):
    """A flight as its simulation saw it: times on the companion's clock (s), positions NED (m)."""

    outcome: FlightOutcome
    time_s: Times
    position: Vec3s
    load_changed_s: float | None


def simulate(scenario: Scenario) -> tuple[FlightOutcome, Times, Vec3s]:
    """Fly one scenario in virtual time.

    Returns:
        What came of it; the times (companion clock, s) and positions (NED, m) where the vehicle truly was,
        every 10 ms from boot on.

    Raises:
        InputError: vehicle, conditions or strategy cannot be used.
        FlightError: the flight failed.
    """
    flown = clock.run(_simulate(scenario), virtual=True)
    return flown.outcome, flown.time_s, flown.position


async def _simulate(scenario: Scenario) -> _Simulated:
    address = Simulated(scenario.vehicle, scenario.conditions, scenario.seed, record_truth=True)
    async with connect(address) as connection:
        telemetry = await start_telemetry(connection)
        autopilot = await detect(connection, telemetry)
        outcome = await fly(scenario.plan(), autopilot, telemetry, provenance=scenario.provenance())
        transport = connection.transport
        assert isinstance(transport, SimulatedTransport)
        simulation, epoch_s = transport.vehicle.simulation, transport.epoch_s
        return _Simulated(
            outcome,
            np.array([epoch_s + truth.time_s for truth in simulation.truth_log]),
            np.array([truth.position for truth in simulation.truth_log]),
            None if simulation.load_changed_s is None else epoch_s + simulation.load_changed_s,
        )


def evaluate(scenario: Scenario) -> Result:
    """Fly one scenario and measure how far the vehicle was from its trajectory: truly, or as it believes.

    Which, the conditions say (`errors_against`).

    Raises:
        InputError: vehicle, conditions or strategy cannot be used.
    """
    try:
        simulated = clock.run(_simulate(scenario), virtual=True)
    except FlightError as error:
        return Failed(scenario, str(error))
    outcome, time_s, position, load_changed_s = simulated
    if load_conditions(scenario.conditions).errors_against == "estimate":
        states = outcome.recording.states
        time_s, position = states.time_s, states.position
    trajectory, start_s = outcome.trajectory, outcome.start_s
    end_s = start_s + trajectory.duration_s

    def desired(time_s: Times) -> Vec3s:
        return trajectory.sample(time_s - start_s).position

    accuracy = tracking_accuracy(desired, time_s, position, start_s, end_s)
    along = (time_s >= start_s) & (time_s <= end_s)
    flight = Flight(
        trajectory.name,
        scenario.strategy,
        time_s[along] - start_s,
        desired(time_s[along]),
        position[along],
        accuracy.rms_m,
    )
    event_s = None
    if load_changed_s is not None and start_s < load_changed_s < end_s:
        event_s = load_changed_s - start_s
    return Flown(
        scenario,
        accuracy,
        outcome.accuracy,
        flight,
        outcome.clips,
        active_share=0.0 if scenario.network is None else _active_share(outcome),
        event_s=event_s,
        recovery_s=None if event_s is None else recovery_s(flight, event_s),
    )


def _active_share(outcome: FlightOutcome) -> float:
    """Of the steps along the trajectory; where nobody judged the network it was active all the time."""
    tracking = outcome.recording.tracking
    assert tracking is not None
    begun_s = tracking.time_s - outcome.start_s
    along = (begun_s >= 0.0) & (begun_s <= outcome.trajectory.duration_s)
    share = tracking.network_share[along]
    return float(np.mean(np.isnan(share) | (share > _LEAST_SHARE)))


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
