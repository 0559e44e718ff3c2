"""Hours of flight in one process, with one simulated vehicle: what grows, drifts or gets lost?"""

from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
import yaml
from mcap.reader import make_reader
from pydantic import BaseModel, ConfigDict

from companion import clock
from companion.arrays import Times
from companion.autopilot import Autopilot, detect
from companion.errors import FlightError
from companion.experiments.backend import LOCAL, Backend
from companion.experiments.fingerprint import fingerprint
from companion.experiments.memory import resident_bytes
from companion.experiments.simulated_flights import Scenario
from companion.flight.flight import fly
from companion.flight.plan import After
from companion.flight.recorder import Recorder
from companion.flight.strategies import Strategy
from companion.learning.inverse_network import InverseNetwork
from companion.link import connect, start_telemetry
from companion.link.address import Simulated
from companion.link.connection import Connection
from companion.link.dialect import mavlink
from companion.link.telemetry import Telemetry
from companion.recording.flight_log import flight_log
from companion.recording.tlog_frames import stamped
from companion.recording.topics import REFERENCE
from companion.trajectory.limits import Limits
from companion.trajectory.training import training_sinusoids
from sitl.vehicle import load_vehicle

FLIGHT_S = 600.0
"""Of which each flight tracks a trajectory."""

_ENDLESS_AH = 1e4
_SETPOINT = mavlink.MAVLINK_MSG_ID_SET_POSITION_TARGET_LOCAL_NED.to_bytes(3, "little")
_SPEED_M_S = 1.5


@dataclass(frozen=True)
class Piece:
    """What one process flies.

    Attributes:
        vehicle: name in `config/vehicles`, or a YAML file; its battery does not run down.
        conditions: name in `config/conditions`, or a YAML file.
        network: of `dnn+gp`, in which most is computed.
        seed: of everything random.
        duration_s: simulated time (s); the flight that is under way then is the last.
        flight_s: of each trajectory (s).
    """

    vehicle: str
    conditions: str
    network: InverseNetwork
    seed: int
    duration_s: float
    flight_s: float = FLIGHT_S


class SoakRow(BaseModel):
    """What came of a piece.

    Attributes:
        flights: how many.
        simulated_s: how long they took (s).
        setpoints: how many were sent.
        lost: setpoints and frames that are missing in the files of the flights.
        warm_bytes: memory after the first flight.
        end_bytes: memory after the last.
        late_s: how late a setpoint was at most, in the first flight and in the last (s).
        drift_s: how much later the last setpoint was sent than the count of periods says, at most (s).
        worst_rms_m: tracking error of the worst flight (m).
        wall_s: what the piece took (s).
    """

    model_config = ConfigDict(frozen=True)

    flights: int
    simulated_s: float
    setpoints: int
    lost: int
    warm_bytes: int
    end_bytes: int
    late_s: tuple[float, float]
    drift_s: float
    worst_rms_m: float
    wall_s: float

    @property
    def grown(self) -> float:
        """Memory that was taken after the first flight, as a share of what there was."""
        return self.end_bytes / self.warm_bytes - 1.0


class _Flight(NamedTuple):
    """One flight of a piece, as in `SoakRow`."""

    setpoints: int
    lost: int
    resident_bytes: int
    late_s: float
    drift_s: float
    rms_m: float


@dataclass(eq=False)
class _Listener:
    """What passed on the link during a flight."""

    setpoints_s: list[float] = field(default_factory=list)
    frame_bytes: int = 0

    def hear(self, data: bytes) -> None:
        """A frame was sent or received."""
        self.frame_bytes += len(stamped(0.0, data))
        if data[7:10] == _SETPOINT:
            self.setpoints_s.append(clock.now())


def soak(piece: Piece) -> SoakRow:
    """Fly again and again, in virtual time.

    Raises:
        InputError: the vehicle, the conditions or the network cannot be used.
        FlightError: a flight failed.
    """
    begun_s = clock.stopwatch_s()
    with TemporaryDirectory() as folder:
        done, simulated_s = clock.run(_soak(piece, Path(folder)), virtual=True)
    return SoakRow(
        flights=len(done),
        simulated_s=simulated_s,
        setpoints=sum(flight.setpoints for flight in done),
        lost=sum(flight.lost for flight in done),
        warm_bytes=done[0].resident_bytes,
        end_bytes=done[-1].resident_bytes,
        late_s=(done[0].late_s, done[-1].late_s),
        drift_s=max(flight.drift_s for flight in done),
        worst_rms_m=max(flight.rms_m for flight in done),
        wall_s=clock.stopwatch_s() - begun_s,
    )


async def _soak(piece: Piece, folder: Path) -> tuple[list[_Flight], float]:
    """The flights, and how long they took (s)."""
    trajectory = training_sinusoids(piece.flight_s, limits=Limits(speed_m_s=_SPEED_M_S), seed=piece.seed)
    vehicle = _tireless(piece.vehicle, folder)
    flights = []
    async with connect(Simulated(vehicle, piece.conditions, piece.seed)) as connection:
        telemetry = await start_telemetry(connection)
        autopilot = await detect(connection, telemetry)
        begun_s = clock.now()
        while clock.now() < begun_s + piece.duration_s:
            scenario = Scenario(
                trajectory, Strategy.DNN_GP, vehicle, piece.conditions, piece.seed, piece.network
            )
            flights.append(await _flight(scenario, connection, telemetry, autopilot, folder / "flight.mcap"))
        return flights, clock.now() - begun_s


async def _flight(
    scenario: Scenario, connection: Connection, telemetry: Telemetry, autopilot: Autopilot, path: Path
) -> _Flight:
    """One flight, recorded in `path` (MCAP) and the `.tlog` beside it."""
    listener, about = _Listener(), scenario.provenance()
    plan = replace(scenario.plan(), after=After.LAND)
    with ExitStack() as listening:
        async with flight_log(path, about, _fail) as log:
            listening.callback(connection.overhear(log.frame))
            listening.callback(connection.overhear(listener.hear))
            recorder = Recorder(log, log.epoch_s)
            outcome = await fly(plan, autopilot, telemetry, provenance=about, recorder=recorder)
            listening.close()
    late_s, drift_s = _lateness(np.array(listener.setpoints_s), plan.period_s)
    sent, sent_bytes = len(listener.setpoints_s), listener.frame_bytes
    lost = abs(sent - _recorded(path)) + abs(sent_bytes - path.with_suffix(".tlog").stat().st_size)
    return _Flight(sent, lost, resident_bytes(), late_s, drift_s, outcome.accuracy.rms_m)


def _lateness(sent_s: Times, period_s: float) -> tuple[float, float]:
    """How late a setpoint was at most after the one before it, and how late the last one was in all (s)."""
    late_s = np.diff(sent_s) - period_s
    return float(late_s.max()), abs(float(late_s.sum()))


def _recorded(path: Path) -> int:
    """How many setpoints are in a recording."""
    with path.open("rb") as file:
        return sum(1 for _ in make_reader(file).iter_messages(topics=[REFERENCE]))


def _fail(trouble: str) -> None:
    raise FlightError(trouble)


def _tireless(vehicle: str, folder: Path) -> str:
    """The file of the same vehicle with a battery that does not run down."""
    model = load_vehicle(vehicle)
    values = model.model_dump(mode="json") | {
        "battery": model.battery.model_dump() | {"capacity_ah": _ENDLESS_AH}
    }
    path = folder / f"{model.name}.yaml"
    path.write_text(yaml.safe_dump(values), encoding="utf-8")
    return str(path)


def pieces(first: Piece, count: int) -> list[Piece]:
    """So many of the same duration, which together take that of `first`."""
    return [
        replace(first, seed=first.seed + number, duration_s=first.duration_s / count)
        for number in range(count)
    ]


def belongs_to(todo: Sequence[Piece]) -> str:
    """The same only for pieces that give the same flights."""
    return fingerprint(
        f"{piece.vehicle} {piece.conditions} {piece.seed} {piece.duration_s} {piece.flight_s} "
        f"{piece.network.card.model_dump_json()}".encode()
        for piece in todo
    )


def run(todo: Sequence[Piece], backend: Backend = LOCAL) -> Iterator[SoakRow]:
    """The rows of the pieces, each flown in a process of its own, in their order."""
    return backend.each(soak, todo)
