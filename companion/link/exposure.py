"""Who may speak to us: whether an address listens to other machines, where anybody could be the vehicle."""

from collections.abc import Iterable
from ipaddress import ip_address

from companion.link.address import Address, TcpIn, UdpIn


def exposed(addresses: Iterable[Address]) -> list[str]:
    """Those of the addresses that listen to more than this machine, as host and port."""
    return [
        f"{address.host}:{address.port}"
        for address in addresses
        if isinstance(address, UdpIn | TcpIn) and not _is_loopback(address.host)
    ]


def warning(addresses: Iterable[Address], *, signed: bool) -> str | None:
    """What to tell a user of links that believe anybody on the network; None where they do not."""
    places = [] if signed else exposed(addresses)
    if not places:
        return None
    return (
        f"{', '.join(places)} listens to other machines and believes whoever speaks: give --signing-key, "
        "or listen at 127.0.0.1"
    )


def _is_loopback(host: str) -> bool:
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"
