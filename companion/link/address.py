"""Connection strings, read into what they mean: where the vehicle is, and how to reach it.

They follow MAVSDK, with `sitl://` added for the built-in vehicle.
"""

import re
from dataclasses import dataclass
from typing import TypeAlias
from urllib.parse import parse_qsl, urlsplit

from companion.errors import InputError

FORMS = (
    "udpin://0.0.0.0:14540, udpout://HOST:PORT, tcpout://HOST:5760, tcpin://0.0.0.0:PORT, "
    "serial:///dev/ttyAMA0:921600, sitl://bebop2 or sitl://bebop2?conditions=realistic&seed=1"
)
"""The right forms, for messages and help."""


@dataclass(frozen=True, slots=True)
class UdpIn:
    """Listen on a UDP port, and answer whoever the vehicle turns out to be."""

    host: str
    port: int


@dataclass(frozen=True, slots=True)
class UdpOut:
    """Send to a UDP port, and listen to what comes back."""

    host: str
    port: int


@dataclass(frozen=True, slots=True)
class TcpOut:
    """Connect to a TCP server."""

    host: str
    port: int


@dataclass(frozen=True, slots=True)
class TcpIn:
    """Serve TCP, one client at a time."""

    host: str
    port: int


@dataclass(frozen=True, slots=True)
class Serial:
    """A serial port, such as a flight controller's TELEM2."""

    path: str
    baud_rate: int


@dataclass(frozen=True, slots=True)
class Simulated:
    """The built-in vehicle, in this process.

    Attributes:
        vehicle: a name in `config/vehicles/`, or the path of a vehicle file.
        conditions: a name in `config/conditions/`, or the path of a conditions file.
        seed: of everything random.
        record_truth: whether the vehicle keeps its true states, for experiments.
        faults: what goes wrong with it, each as a line of text; `sitl.faults.reading` reads them.
    """

    vehicle: str
    conditions: str = "ideal"
    seed: int = 0
    record_truth: bool = False
    faults: tuple[str, ...] = ()


Address: TypeAlias = UdpIn | UdpOut | TcpOut | TcpIn | Serial | Simulated

_NETWORKS: dict[str, type[UdpIn | UdpOut | TcpOut | TcpIn]] = {
    "udpin": UdpIn,
    "udpout": UdpOut,
    "tcpout": TcpOut,
    "tcpin": TcpIn,
}
_HINTS = {
    "udp": "say which way: udpin:// to listen on a port, udpout:// to send to one",
    "udpcl": "say udpout://HOST:PORT",
    "udpbcast": "broadcast is not offered: say udpout://HOST:PORT",
    "tcp": "say which way: tcpout:// to connect to a server, tcpin:// to be one",
    "/dev/": "a serial port is serial:///dev/ttyAMA0:921600, with the baud rate behind the device",
}


def parse_address(text: str) -> Address:
    """What the connection string `text` means.

    Raises:
        InputError: it means nothing; the message shows the forms that do.
    """
    scheme, separator, rest = text.strip().partition("://")
    if separator and scheme in _NETWORKS:
        return _network(text, scheme, rest)
    if separator and scheme == "serial":
        return _serial(text, rest)
    if separator and scheme == "sitl":
        return _simulated(text, rest)
    raise _wrong(text, _hint(text.strip()))


def _network(text: str, scheme: str, rest: str) -> Address:
    try:
        parts = urlsplit(f"//{rest}")
        host, port = parts.hostname, parts.port
    except ValueError:
        raise _wrong(text, "the port is a number from 1 to 65535, behind the host and a colon") from None
    if not host:
        raise _wrong(text, f"the host is missing, as in {scheme}://{_usual_host(scheme)}:14540")
    if not port:
        raise _wrong(text, f"the port is missing, as in {scheme}://{host}:14540")
    if rest != parts.netloc or parts.username is not None:
        raise _wrong(text, "nothing belongs behind the port or before the host")
    return _NETWORKS[scheme](host, port)


def _serial(text: str, rest: str) -> Serial:
    path, separator, baud_rate = rest.rpartition(":")
    if not separator or not path:
        raise _wrong(text, "the baud rate is missing, as in serial:///dev/ttyAMA0:921600")
    if not (baud_rate.isascii() and baud_rate.isdecimal()) or int(baud_rate) == 0:
        raise _wrong(text, f"the baud rate {baud_rate!r} is not a number")
    return Serial(path, int(baud_rate))


def _simulated(text: str, rest: str) -> Simulated:
    vehicle, separator, query = rest.partition("?")
    if not vehicle:
        raise _wrong(text, "the vehicle is missing, as in sitl://bebop2")
    try:
        pairs = parse_qsl(query, keep_blank_values=True, strict_parsing=bool(separator))
    except ValueError:
        raise _wrong(text, "behind the ? come conditions=NAME and seed=NUMBER, with & between them") from None
    faults = tuple(value for key, value in pairs if key == "fault")
    settings = {key: value for key, value in pairs if key != "fault"}
    unknown = settings.keys() - {"conditions", "seed"}
    if unknown:
        known = "conditions, seed and fault are"
        raise _wrong(text, f"{min(unknown)!r} is no setting of the built-in vehicle: {known}")
    seed = settings.get("seed", "0")
    if not (seed.isascii() and seed.isdecimal()):
        raise _wrong(text, f"the seed {seed!r} is not a whole number")
    return Simulated(vehicle, settings.get("conditions") or "ideal", int(seed), faults=faults)


def _hint(text: str) -> str:
    scheme = re.match(r"/dev/|\w+(?=:)", text)
    if scheme is None:
        return "it does not say how to connect"
    if scheme[0] in _HINTS:
        return _HINTS[scheme[0]]
    if scheme[0] in {*_NETWORKS, "serial", "sitl"}:
        return f"two slashes are missing: {scheme[0]}://"
    return f"{scheme[0]!r} is no way to connect"


def _usual_host(scheme: str) -> str:
    return "0.0.0.0" if scheme.endswith("in") else "127.0.0.1"


def _wrong(text: str, why: str) -> InputError:
    return InputError(f"connection string {text!r}: {why}. Right forms: {FORMS}")
