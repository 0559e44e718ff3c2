"""All flights of the benchmark: every failure, in every phase, with several seeds."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from companion.experiments.backend import LOCAL, Backend
from companion.experiments.contenders import Model
from companion.experiments.faults.catalogue import Failure
from companion.experiments.faults.flight import FaultFlight, Phase, fly_with_fault
from companion.experiments.faults.verdict import FaultRow, judge
from companion.experiments.fingerprint import fingerprint
from companion.experiments.simulated_flights import Scenario, prepare_simulator
from companion.flight.strategies import Strategy
from companion.learning.online_settings import DEFAULT
from companion.trajectory.trajectory import Trajectory
from sitl.conditions import load_conditions
from sitl.vehicle import load_vehicle


@dataclass(frozen=True, eq=False)
class FaultJob:
    """What is flown: `dnn+gp`, the strategy in which most can fail.

    Attributes:
        trajectory: NED relative to the takeoff point (m).
        failures: what fails.
        phases: when.
        seeds: of every flight.
        models: the networks, by who flies with them: a name in `config/vehicles`, or a YAML file.
        conditions: name in `config/conditions`, or a YAML file.
    """

    trajectory: Trajectory
    failures: Sequence[Failure]
    phases: Sequence[Phase]
    seeds: Sequence[int]
    models: Mapping[str, Model]
    conditions: str

    def flights(self) -> list[FaultFlight]:
        """What is to be flown, always in the same order."""
        return [
            FaultFlight(self._scenario(vehicle, seed), failure, phase)
            for failure in self.failures
            for phase in self.phases
            for vehicle in self.models
            for seed in self.seeds
        ]

    def _scenario(self, vehicle: str, seed: int) -> Scenario:
        network = self.models[vehicle].network
        return Scenario(self.trajectory, Strategy.DNN_GP, vehicle, self.conditions, seed, network)

    def prepare(self) -> None:
        """Compile the simulator, once for all cores; InputError where a vehicle or conditions are wrong."""
        prepare_simulator(list(self.models), self.conditions)

    def fingerprint(self) -> str:
        """The same only for a job that gives the same rows."""
        return fingerprint(self._given())

    def _given(self) -> Iterator[bytes]:
        yield f"{DEFAULT.model_dump_json()} {list(self.phases)} {list(self.seeds)}".encode()
        yield from (failure.name.encode() for failure in self.failures)
        yield load_conditions(self.conditions).model_dump_json().encode()
        yield self.trajectory.coefficients.tobytes()
        for vehicle, model in self.models.items():
            yield load_vehicle(vehicle).model_dump_json().encode()
            yield model.network.card.model_dump_json().encode()
            yield from (layer.weight.tobytes() for layer in model.network.layers)


def fly_and_judge(flight: FaultFlight) -> FaultRow:
    """One flight, from takeoff to its row."""
    return judge(flight, fly_with_fault(flight))


def fly(flights: Sequence[FaultFlight], backend: Backend = LOCAL) -> Iterator[FaultRow]:
    """The rows of the flights, in their order, as they end."""
    return backend.each(fly_and_judge, flights)
