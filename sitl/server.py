"""Serves simulated vehicles over the network, in real time or at a multiple of it."""

import asyncio
import heapq
import math
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from itertools import count

from sitl.endpoints import Endpoint, TcpEndpoint
from sitl.mavlink.links import Link
from sitl.mavlink.vehicle import MavlinkVehicle
from sitl.plant import TICK_S
from sitl.sockets import Socket, open_socket

_MAX_BEHIND_S = 0.25  # real time by which the simulation may lag before that time is given up
_WATCH_S = 10.0
_KEEPS_UP = 0.95  # share of the asked speed, over the time watched


@dataclass(frozen=True, eq=False)
class Served:
    """A vehicle, and where each of its links is."""

    vehicle: MavlinkVehicle
    endpoints: Sequence[Endpoint | TcpEndpoint]


async def serve(fleet: Sequence[Served], *, speed: float = 1.0, say: Callable[[str], None] = print) -> None:
    """Let time run for all vehicles, and exchange their frames, until cancelled.

    Args:
        fleet: the vehicles, all at the same time.
        speed: simulated seconds a second. A machine that is too slow for it is told so, and gets what it
            can do.
        say: takes one line for the person who watches: modes, arming, status texts.

    Raises:
        ServeError: a port is in use, or a peer's name is unknown.
    """
    with ExitStack() as open_sockets:
        aircraft = []
        for served in fleet:
            named = f"vehicle {served.vehicle.system_id}  " if len(fleet) > 1 else ""
            each = _Aircraft(served.vehicle, _Journal(served.vehicle, named, say))
            for endpoint in served.endpoints:
                open_sockets.callback((await each.open(endpoint)).close)
            aircraft.append(each)
        await _run(aircraft, Pace(asyncio.get_running_loop().time, speed, say))


async def _run(aircraft: Sequence["_Aircraft"], pace: "Pace") -> None:
    reached_s = aircraft[0].vehicle.simulation.time_s
    while True:
        # never more than a tick without a look at the sockets, however far behind
        now_s = min(pace.simulation_time(reached_s), reached_s + TICK_S)
        for each in aircraft:
            each.advance(now_s)
        reached_s = aircraft[0].vehicle.simulation.time_s
        next_tick_s = reached_s + TICK_S
        await pace.sleep_until(min(next_tick_s, *(each.next_delivery_s for each in aircraft)))


class _Aircraft:
    """A vehicle with its sockets, and its frames that are on the way."""

    def __init__(self, vehicle: MavlinkVehicle, journal: "_Journal") -> None:
        self.vehicle = vehicle
        self._sockets: dict[Link, Socket] = {}
        self._journal = journal
        self._order = count()
        self._on_the_way: list[tuple[float, int, Link, bytes]] = []

    @property
    def next_delivery_s(self) -> float:
        """When the next frame is to leave (s); never when none is on the way."""
        return self._on_the_way[0][0] if self._on_the_way else math.inf

    async def open(self, endpoint: Endpoint | TcpEndpoint) -> Socket:
        """Open the socket of one link."""
        socket = await open_socket(endpoint, partial(self._receive, endpoint.link))
        self._sockets[endpoint.link] = socket
        return socket

    def _receive(self, link: Link, data: bytes) -> None:
        """Answer at once: whoever brings a thousand items one by one must not wait a tick for each."""
        self.vehicle.receive(data, link)
        if link in self._sockets:
            self.advance(self.vehicle.simulation.time_s)

    def advance(self, now_s: float) -> None:
        """Let time run up to `now_s` (s), send what is due, and tell what happened."""
        for delivery in self.vehicle.advance(now_s):
            entry = (delivery.time_s, next(self._order), delivery.link, delivery.data)
            heapq.heappush(self._on_the_way, entry)
        while self.next_delivery_s <= now_s:
            _, _, link, data = heapq.heappop(self._on_the_way)
            self._sockets[link].send(data)
        self._journal.write()


class Pace:
    """Simulation time as the clock on the wall has it: the one place where that clock is read.

    Args:
        clock: a monotonic clock (s), that of the event loop.
        speed: simulated seconds a second.
        say: told when the machine is too slow for that.
    """

    def __init__(self, clock: Callable[[], float], speed: float, say: Callable[[str], None]) -> None:
        self._clock = clock
        self._speed = speed
        self._say = say
        self._start_s = clock()
        self._lost_s = 0.0
        self._watched_from_s = self._start_s

    def simulation_time(self, reached_s: float) -> float:
        """How far the simulation should be, which has come to `reached_s` (s); a long lag is given up."""
        now_s = self._clock()
        given_up_s = (now_s - self._start_s) - reached_s / self._speed - _MAX_BEHIND_S
        if given_up_s > 0.0:
            self._start_s += given_up_s
            self._lost_s += given_up_s
        watched_s = now_s - self._watched_from_s
        if watched_s >= _WATCH_S:
            done = 1.0 - self._lost_s / watched_s
            if done < _KEEPS_UP:
                self._say(f"this machine cannot keep up: runs at {done * self._speed:.1f} times real time")
            self._lost_s, self._watched_from_s = 0.0, now_s
        return (now_s - self._start_s) * self._speed

    async def sleep_until(self, simulation_time_s: float) -> None:
        """Wait until the simulation is due at that time (s)."""
        await asyncio.sleep(self._start_s + simulation_time_s / self._speed - self._clock())


class _Journal:
    """Tells what changed since the last line."""

    def __init__(self, vehicle: MavlinkVehicle, named: str, say: Callable[[str], None]) -> None:
        self._vehicle = vehicle
        self._named = named
        self._say = say
        self._last = self._now()

    def _now(self) -> tuple[str, bool]:
        return self._vehicle.mode_name, self._vehicle.simulation.firmware.armed

    def write(self) -> None:
        time = f"{self._vehicle.simulation.time_s:8.2f} s  {self._named}"
        texts = self._vehicle.status_texts
        while texts:
            text = texts.popleft()
            self._say(f"{time}{text.severity.name.lower()}: {text.text}")
        mode, armed = self._now()
        if (mode, armed) != self._last:
            self._say(f"{time}mode {mode}, {'armed' if armed else 'disarmed'}")
            self._last = mode, armed
