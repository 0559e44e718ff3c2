"""How regular setpoints are in real time, over UDP, while other programs keep every core busy."""

import multiprocessing
import os
import socket
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from multiprocessing.process import BaseProcess
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from companion import clock
from companion.arrays import Times
from companion.autopilot import detect
from companion.errors import FlightError
from companion.experiments.simulated_flights import Scenario, prepare_simulator
from companion.flight.flight import fly
from companion.flight.recorder import Recorder
from companion.link import connect, start_telemetry
from companion.link.dialect import mavlink
from companion.priority import Priority, prioritised
from companion.recording.flight_log import flight_log

_SPAWN = multiprocessing.get_context("spawn")
_LONGEST = 1.2
_CONNECTS_WITHIN_S = 60.0
_SETPOINT = mavlink.MAVLINK_MSG_ID_SET_POSITION_TARGET_LOCAL_NED.to_bytes(3, "little")


@dataclass(frozen=True)
class Regularity:
    """How regular the setpoints of a flight were.

    Attributes:
        nominal_s: the period that they should have (s).
        setpoints: how many were sent.
        p50_s, p99_s, max_s: of the periods (s).
        failsafe: why the flight ended before its time; empty where it did not.
        rms_m: tracking error (m); NaN where the flight did not come to its end.
        busy: how many processes did other work.
        priority: what this one was granted.
    """

    nominal_s: float
    setpoints: int
    p50_s: float
    p99_s: float
    max_s: float
    failsafe: str
    rms_m: float
    busy: int
    priority: Priority

    @property
    def holds(self) -> bool:
        """Whether 99 in 100 periods are within 20 % of what they should be, and the flight was not ended."""
        return self.p99_s <= _LONGEST * self.nominal_s and not self.failsafe


def fly_loaded(scenario: Scenario, busy: int, *, with_priority: bool) -> Regularity:
    """Fly the scenario in real time over UDP on loopback, its vehicle in a process of its own.

    The vehicle takes priority where it may, for a real one has a computer of its own.

    Args:
        scenario: what is flown.
        busy: how many processes do nothing but work meanwhile.
        with_priority: take as much priority as this user may have.
    """
    prepare_simulator([scenario.vehicle], scenario.conditions)
    port = _free_port()
    with ExitStack() as running, TemporaryDirectory() as folder:
        serving = (port, scenario.vehicle, scenario.conditions, scenario.seed)
        running.enter_context(_process(_serve, *serving))
        for _ in range(busy):
            running.enter_context(_process(_work))
        priority = running.enter_context(prioritised()) if with_priority else Priority.NORMAL
        sent_s: list[float] = []
        rms_m, failsafe = float("nan"), ""
        try:
            rms_m = clock.run(_fly(scenario, port, Path(folder) / "flight.mcap", sent_s))
        except FlightError as error:
            failsafe = str(error)
    nominal_s = scenario.plan().period_s
    p50_s, p99_s, max_s = _spread(np.diff(sent_s))
    return Regularity(nominal_s, len(sent_s), p50_s, p99_s, max_s, failsafe, rms_m, busy, priority)


async def _fly(scenario: Scenario, port: int, path: Path, sent_s: list[float]) -> float:
    """The flight's tracking error (m); appends when each setpoint was sent to `sent_s`."""

    def hear(data: bytes) -> None:
        if data[7:10] == _SETPOINT:
            sent_s.append(clock.now())

    about = scenario.provenance()
    async with (
        connect(f"udpin://127.0.0.1:{port}", timeout_s=_CONNECTS_WITHIN_S) as connection,
        flight_log(path, about, lambda trouble: None) as log,
    ):
        connection.overhear(log.frame)
        connection.overhear(hear)
        telemetry = await start_telemetry(connection)
        autopilot = await detect(connection, telemetry)
        recorder = Recorder(log, log.epoch_s)
        outcome = await fly(scenario.plan(), autopilot, telemetry, provenance=about, recorder=recorder)
        return outcome.accuracy.rms_m


def _spread(periods_s: Times) -> tuple[float, float, float]:
    if not len(periods_s):
        return (float("nan"),) * 3
    p50_s, p99_s = np.percentile(periods_s, [50.0, 99.0]).tolist()
    return p50_s, p99_s, float(periods_s.max())


@contextmanager
def _process(work: Any, *arguments: object) -> Iterator[BaseProcess]:
    """Another process that does `work` until the block ends."""
    process = _SPAWN.Process(target=work, args=arguments, daemon=True)
    process.start()
    try:
        yield process
    finally:
        process.kill()
        process.join()


def _work() -> None:
    number = 1
    while True:
        number = number * 3 % 1_000_003


def _serve(port: int, vehicle: str, conditions: str, seed: int) -> None:
    from sitl.endpoints import Endpoint
    from sitl.mavlink import OFFBOARD, open_vehicle
    from sitl.plant import TICK_S
    from sitl.server import Served, serve

    flying = open_vehicle(vehicle, conditions, seed=seed, links=[OFFBOARD])
    flying.advance(TICK_S)
    served = Served(flying, [Endpoint(OFFBOARD, 0, ("127.0.0.1", port))])
    with prioritised():
        clock.run(serve([served], say=lambda line: None))


def _free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        return int(free.getsockname()[1])


def cores() -> int:
    """How many there are for this process."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
