"""A simulated vehicle and a client of another maker, each in a process of its own, over UDP."""

import math
import os
import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from http.client import HTTPConnection
from pathlib import Path
from typing import TypeVar, cast
from xmlrpc.client import ServerProxy, Transport

import pytest
from peer_client import Client, Place

ROOT = Path(__file__).parents[2]
SPEED = 4  # as fast as the clients' own clocks allow: MAVSDK sends setpoints at 20 Hz, PX4 wants 2 Hz
PATIENCE_S = 30.0
_POLL_S = 0.05
_M_PER_DEG = 111_319.5
_PORTS_UDP = {"px4": (14540, 14580, 18570), "ardupilot": (14550,)}
_STEPS = {"px4": 1, "ardupilot": 10}

T = TypeVar("T")


@dataclass(frozen=True, order=True)
class Pair:
    """A client and the autopilot that it is to fly."""

    client: str
    autopilot: str

    def __str__(self) -> str:
        return f"{self.client}-{self.autopilot}"


def _pairs(client: str, *autopilots: str) -> frozenset[Pair]:
    return frozenset(Pair(client, autopilot) for autopilot in autopilots or ("px4", "ardupilot"))


MAVSDK = _pairs("mavsdk")
PYMAVLINK = _pairs("pymavlink")
MAVPROXY = _pairs("mavproxy")
DRONEKIT = _pairs("dronekit")
PX4 = frozenset(pair for pair in MAVSDK | PYMAVLINK | MAVPROXY | DRONEKIT if pair.autopilot == "px4")
ARDUPILOT = (MAVSDK | PYMAVLINK | MAVPROXY | DRONEKIT) - PX4


def offered_by(pairs: frozenset[Pair]) -> pytest.MarkDecorator:
    """The test is for these clients; the others have no means for it."""
    return pytest.mark.parametrize("peer", sorted(pairs), ids=str, indirect=True, scope="session")


@contextmanager
def running(name: str, command: Sequence[str | Path], folder: Path, says: str) -> Iterator[re.Match[str]]:
    """A process, with whatever it starts, until leaving; entered when it has said what is looked for."""
    log = folder / f"{name}.log"
    with log.open("w") as output:
        process = subprocess.Popen(
            command,
            cwd=folder,
            stdin=subprocess.PIPE,
            stdout=output,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            env=os.environ | {"OMP_NUM_THREADS": "1", "PYTHONUNBUFFERED": "1"},
        )
    try:
        said = until(
            lambda: re.search(says, log.read_text()) or process.poll() is not None,
            bool,
            f"{says!r} in {log}",
        )
        if said is True:
            pytest.fail(f"{name} ended at once: {log.read_text()}")
        yield cast("re.Match[str]", said)
    finally:
        with suppress(ProcessLookupError):  # it had ended, and been waited for
            os.killpg(process.pid, signal.SIGKILL)
        process.communicate()


def free_system_id(autopilot: str) -> int:
    """A system id whose ports nobody has."""
    for candidate in range(20 + os.getpid() % 100, 220):
        offset = _STEPS[autopilot] * (candidate - 1)
        if all(_is_free(port + offset) for port in _PORTS_UDP[autopilot]):
            return candidate
    pytest.fail("no ports free for a simulated vehicle")


def _is_free(port: int) -> bool:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind(("127.0.0.1", port))
        except OSError:
            return False
        return True


def port_of(autopilot: str, system_id: int) -> int:
    """Where a companion finds the vehicle."""
    return _PORTS_UDP[autopilot][0] + _STEPS[autopilot] * (system_id - 1)


@contextmanager
def vehicle(
    autopilot: str, system_id: int, folder: Path, *, conditions: str = "ideal", speed: float = SPEED
) -> Iterator[None]:
    """`companion sitl`, serving."""
    companion = Path(sys.executable).with_name("companion")
    options = {
        "--autopilot": autopilot,
        "--system-id": str(system_id),
        "--speed": str(speed),
        "--conditions": conditions,
    }
    words = (word for option in options.items() for word in option)
    command: list[str | Path] = [companion, "--debug", "sitl", *words]
    with running("sitl", command, folder, f"system {system_id}"):
        yield


class _Patient(Transport):
    def make_connection(self, host: object) -> HTTPConnection:
        connection = super().make_connection(cast("str", host))
        connection.timeout = PATIENCE_S
        return connection


@contextmanager
def client(name: str, port: int, folder: Path) -> Iterator[Client]:
    """A client that has found a vehicle on a UDP port."""
    own = ROOT / ".venv-peers" / name
    if (Path(__file__).parent / f"{name}.txt").exists() and not (own / "installed").exists():
        pytest.fail(f"{own} is missing: run scripts/test or scripts/peers-table, which install {name} there")
    python = own / "bin/python" if name == "dronekit" else Path(sys.executable)
    script = Path(__file__).parent / f"{name}_client.py"
    with (
        running(name, [python, script, str(port)], folder, r"serving at (\d+)\n") as said,
        ServerProxy(f"http://127.0.0.1:{said[1]}", _Patient(), allow_none=True) as proxy,
    ):
        yield cast("Client", proxy)


def until(read: Callable[[], T], holds: Callable[[T], object], what: str) -> T:
    """The first value that holds; an assertion says which was the last that did not."""
    give_up_s = time.monotonic() + PATIENCE_S
    while not holds(value := read()):
        assert time.monotonic() < give_up_s, f"not within {PATIENCE_S:g} s: {what}; last {value}"
        time.sleep(_POLL_S)
    return value


def moved(place: Place, north_m: float = 0.0, east_m: float = 0.0, up_m: float = 0.0) -> Place:
    """A place some metres away from another."""
    latitude_deg, longitude_deg, height_m = place
    parallel = _M_PER_DEG * math.cos(math.radians(latitude_deg))
    return latitude_deg + north_m / _M_PER_DEG, longitude_deg + east_m / parallel, height_m + up_m


def distance_m(a: Place, b: Place) -> float:
    """From one place to another."""
    parallel = _M_PER_DEG * math.cos(math.radians(a[0]))
    return math.hypot((b[0] - a[0]) * _M_PER_DEG, (b[1] - a[1]) * parallel, b[2] - a[2])
