"""A flight's recording cut at random bytes, as a crash or a power cut would: what is left of it?"""

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from mcap.reader import make_reader

from companion import clock
from companion.autopilot import detect
from companion.errors import InputError
from companion.experiments.simulated_flights import Scenario
from companion.flight.flight import fly
from companion.flight.recorder import Recorder
from companion.link import connect, start_telemetry
from companion.link.address import Simulated
from companion.recording.flight_log import flight_log
from companion.recording.mcap_file import read_mcap


def record(scenario: Scenario, path: Path) -> float:
    """Fly in virtual time, and write `path` (MCAP) and the `.tlog` beside it meanwhile.

    Returns:
        The date (Unix time, s) of the zero of the recording's clock.

    Raises:
        FlightError: the flight failed.
        InputError: a file cannot be written.
    """
    return clock.run(_record(scenario, path), virtual=True)


async def _record(scenario: Scenario, path: Path) -> float:
    def fail(trouble: str) -> None:
        raise InputError(f"{path}: {trouble}")

    address = Simulated(scenario.vehicle, scenario.conditions, scenario.seed)
    about = scenario.provenance()
    async with connect(address) as connection, flight_log(path, about, fail) as log:
        connection.overhear(log.frame)
        telemetry = await start_telemetry(connection)
        autopilot = await detect(connection, telemetry)
        recorder = Recorder(log, log.epoch_s)
        await fly(scenario.plan(), autopilot, telemetry, provenance=about, recorder=recorder)
        return log.epoch_s


def losses_s(path: Path, epoch_s: float, cuts: int, seed: int) -> Iterator[float]:
    """Cut a copy of the recording in `path` at random bytes behind its header, and read what is left.

    Yields:
        For each cut, from the newest state that was read to what was being written there, at most (s);
        infinite where what was left could not be read. The copy, `cut.mcap`, is beside the recording.
    """
    content = path.read_bytes()
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None, "a flight that came to its end has an index"
    starts = np.array([chunk.chunk_start_offset for chunk in summary.chunk_indexes])
    ends_ns = np.maximum.accumulate([chunk.message_end_time for chunk in summary.chunk_indexes])
    first_s = float(read_mcap(path).states.time_s[0])
    for place in np.random.default_rng(seed).integers(starts[0], len(content), cuts).tolist():
        written_s = ends_ns[np.searchsorted(starts, place, side="right") - 1] * 1e-9 - epoch_s
        left_s = _newest_state_s(content[:place], path.with_name("cut.mcap"), first_s)
        yield max(0.0, written_s - left_s)


def _newest_state_s(content: bytes, path: Path, first_s: float) -> float:
    """When the newest state in a file was (s); `first_s` where it has none yet, −∞ where unreadable."""
    path.write_bytes(content)
    try:
        return float(read_mcap(path).states.time_s.max(initial=first_s))
    except InputError:
        return -math.inf
