"""Serves a simulated vehicle over UDP, in real time or at a multiple of it."""

import asyncio
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from socket import AF_INET
from typing import cast

from sitl.errors import ServeError
from sitl.mavlink.links import GROUND_STATION, OFFBOARD, TELEMETRY, Link
from sitl.mavlink.vehicle import Delivery, MavlinkVehicle
from sitl.plant import TICK_S

_LOOPBACK = "127.0.0.1"
_MAX_BEHIND_S = 0.25  # real time by which the simulation may lag before that time is given up
_WATCH_S = 10.0
_KEEPS_UP = 0.95  # share of the asked speed, over the time watched

Address = tuple[str, int]


@dataclass(frozen=True)
class Endpoint:
    """Where one link of the vehicle is on the network.

    Attributes:
        link: the link that it carries.
        port: the UDP port that the vehicle listens on; 0 takes a free one.
        peer: host and port that it sends to without having been spoken to.
        host: the address that it listens on.
    """

    link: Link
    port: int
    peer: Address
    host: str = _LOOPBACK


def px4_endpoints(system_id: int = 1, peer_host: str = _LOOPBACK) -> tuple[Endpoint, ...]:
    """The ports of PX4's simulator, instance `system_id` - 1 (px4-rc.mavlink).

    Listens on this machine only, unless the peer is on another one.
    """
    instance, host = system_id - 1, _listening_host(peer_host)
    return (
        Endpoint(OFFBOARD, 14580 + instance, (peer_host, 14540 + instance), host),
        Endpoint(GROUND_STATION, 18570 + instance, (peer_host, 14550), host),
    )


def ardupilot_endpoints(system_id: int = 1, peer_host: str = _LOOPBACK) -> tuple[Endpoint, ...]:
    """Where instance `system_id` - 1 of ArduPilot's sim_vehicle.py sends: 14550, and 10 more for each.

    Listens as `px4_endpoints` do, on a port that is free.
    """
    peer = (peer_host, 14550 + 10 * (system_id - 1))
    return (Endpoint(TELEMETRY, 0, peer, _listening_host(peer_host)),)


def _listening_host(peer_host: str) -> str:
    return _LOOPBACK if peer_host in (_LOOPBACK, "localhost") else "0.0.0.0"


ENDPOINTS: Mapping[str, Callable[[int, str], tuple[Endpoint, ...]]] = {
    "px4": px4_endpoints,
    "ardupilot": ardupilot_endpoints,
}
"""Where each firmware's simulator is found, by system id and the machine of its peers."""


async def serve(
    vehicle: MavlinkVehicle,
    endpoints: Sequence[Endpoint],
    *,
    speed: float = 1.0,
    say: Callable[[str], None] = print,
) -> None:
    """Let time run, and exchange datagrams, until cancelled.

    Args:
        vehicle: the vehicle; its links are those of `endpoints`.
        endpoints: where each link is.
        speed: simulated seconds a second. A machine that is too slow for it is told so, and gets what it
            can do.
        say: takes one line for the person who watches: modes, arming, status texts.

    Raises:
        ServeError: a port is in use, or a peer's name is unknown.
    """
    sockets: dict[Link, _Socket] = {}
    try:
        for endpoint in endpoints:
            sockets[endpoint.link] = await _open(vehicle, endpoint)
        await _run(vehicle, sockets, speed, say)
    finally:
        for socket in sockets.values():
            socket.close()


async def _run(
    vehicle: MavlinkVehicle, sockets: dict[Link, "_Socket"], speed: float, say: Callable[[str], None]
) -> None:
    pace = Pace(asyncio.get_running_loop().time, speed, say)
    journal = _Journal(vehicle, say)
    on_the_way: list[Delivery] = []
    while True:
        reached_s = vehicle.simulation.time_s
        # never more than a tick without a look at the sockets, however far behind
        now_s = min(pace.simulation_time(reached_s), reached_s + TICK_S)
        on_the_way = sorted(on_the_way + vehicle.advance(now_s), key=lambda delivery: delivery.time_s)
        while on_the_way and on_the_way[0].time_s <= now_s:
            delivery = on_the_way.pop(0)
            sockets[delivery.link].send(delivery.data)
        journal.write()
        next_tick_s = vehicle.simulation.time_s + TICK_S
        await pace.sleep_until(min(next_tick_s, on_the_way[0].time_s) if on_the_way else next_tick_s)


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

    def __init__(self, vehicle: MavlinkVehicle, say: Callable[[str], None]) -> None:
        self._vehicle = vehicle
        self._say = say
        self._last = self._now()

    def _now(self) -> tuple[str, bool]:
        return self._vehicle.mode_name, self._vehicle.simulation.firmware.armed

    def write(self) -> None:
        time = f"{self._vehicle.simulation.time_s:8.2f} s  "
        texts = self._vehicle.status_texts
        while texts:
            text = texts.popleft()
            self._say(f"{time}{text.severity.name.lower()}: {text.text}")
        mode, armed = self._now()
        if (mode, armed) != self._last:
            self._say(f"{time}mode {mode}, {'armed' if armed else 'disarmed'}")
            self._last = mode, armed


class _Socket(asyncio.DatagramProtocol):
    """One link's UDP port: takes what comes, sends to the peer and to whoever spoke last."""

    def __init__(self, vehicle: MavlinkVehicle, endpoint: Endpoint) -> None:
        self._vehicle = vehicle
        self._endpoint = endpoint
        self._last_speaker = endpoint.peer
        self._transport: asyncio.DatagramTransport | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._transport = cast("asyncio.DatagramTransport", transport)

    def datagram_received(self, data: bytes, address: Address) -> None:
        self._last_speaker = address
        self._vehicle.receive(data, self._endpoint.link)

    def send(self, data: bytes) -> None:
        if self._transport is None:
            return
        for address in {self._endpoint.peer, self._last_speaker}:
            self._transport.sendto(data, address)

    def close(self) -> None:
        if self._transport is not None:
            self._transport.close()


async def _open(vehicle: MavlinkVehicle, endpoint: Endpoint) -> _Socket:
    loop = asyncio.get_running_loop()
    try:
        found = await loop.getaddrinfo(*endpoint.peer, family=AF_INET)
    except OSError as error:
        raise ServeError(f"no machine named {endpoint.peer[0]} ({error.strerror})") from None
    socket = _Socket(vehicle, replace(endpoint, peer=cast("Address", found[0][4])))
    try:
        await loop.create_datagram_endpoint(lambda: socket, local_addr=(endpoint.host, endpoint.port))
    except OSError as error:
        raise ServeError(
            f"UDP port {endpoint.port} for the {endpoint.link.name} link cannot be had ({error.strerror}); "
            f"stop what uses it, or take another --system-id"
        ) from None
    return socket
