"""Where the links of a vehicle are on the network, as the simulators of PX4 and ArduPilot have them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TypeAlias

from sitl.mavlink.links import GROUND_STATION, OFFBOARD, SERIAL_0, SERIAL_1, SERIAL_2, TELEMETRY, Link

_LOOPBACK = "127.0.0.1"

Address: TypeAlias = tuple[str, int]


@dataclass(frozen=True)
class Endpoint:
    """A link over UDP.

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

    def __str__(self) -> str:
        return f"{self.link.name} at udpin://0.0.0.0:{self.peer[1]}"


@dataclass(frozen=True)
class TcpEndpoint:
    """A link over TCP: the vehicle listens there, and sends to whoever is connected.

    Attributes:
        link: the link that it carries.
        port: the TCP port; 0 takes a free one.
        host: the address that it listens on.
    """

    link: Link
    port: int
    host: str = _LOOPBACK

    def __str__(self) -> str:
        return f"{self.link.name} at tcpout://127.0.0.1:{self.port}"


def px4_endpoints(system_id: int = 1, peer_host: str = _LOOPBACK) -> tuple[Endpoint, ...]:
    """The ports of PX4's simulator, instance `system_id` - 1 (px4-rc.mavlink).

    Listens on this machine only, unless the peer is on another one.
    """
    instance, host = system_id - 1, _listening_host(peer_host)
    return (
        Endpoint(OFFBOARD, 14580 + instance, (peer_host, 14540 + instance), host),
        Endpoint(GROUND_STATION, 18570 + instance, (peer_host, 14550), host),
    )


def ardupilot_endpoints(system_id: int = 1, peer_host: str = _LOOPBACK) -> tuple[Endpoint | TcpEndpoint, ...]:
    """Where instance `system_id` - 1 of ArduPilot's simulator is found; 10 ports further for each.

    sim_vehicle.py sends to UDP 14550, from a port that is free; the simulator itself listens on TCP 5760,
    5762 and 5763. Listens as `px4_endpoints` do.
    """
    offset, host = 10 * (system_id - 1), _listening_host(peer_host)
    return (
        Endpoint(TELEMETRY, 0, (peer_host, 14550 + offset), host),
        TcpEndpoint(SERIAL_0, 5760 + offset, host),
        TcpEndpoint(SERIAL_1, 5762 + offset, host),
        TcpEndpoint(SERIAL_2, 5763 + offset, host),
    )


def _listening_host(peer_host: str) -> str:
    return _LOOPBACK if peer_host in (_LOOPBACK, "localhost") else "0.0.0.0"


ENDPOINTS: Mapping[str, Callable[[int, str], tuple[Endpoint | TcpEndpoint, ...]]] = {
    "px4": px4_endpoints,
    "ardupilot": ardupilot_endpoints,
}
"""Where each firmware's simulator is found, by system id and the machine of its peers."""
