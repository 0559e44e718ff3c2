"""Why no vehicle is heard: likely causes, by what was heard instead and how the link was opened."""

from collections.abc import Iterator, Mapping

from companion.doctor.observation import Peer
from companion.link.address import Address, Serial, Simulated, TcpIn, TcpOut, UdpIn, UdpOut
from companion.link.dialect import mavlink
from companion.link.framing import FrameCounts

_PX4_OFFBOARD, _PX4_GROUND, _ARDUPILOT_TCP = 14540, 14550, 5760
_USUAL_BAUD = (57600, 115200, 921600)


def likely_causes(
    address: Address, peers: Mapping[tuple[int, int], Peer], counts: FrameCounts, system_id: int | None
) -> list[str]:
    """What to look at, the likeliest first."""
    if peers:
        return [*_wrong_peers(peers, system_id)]
    if counts.frames:
        return ["frames arrive, but no heartbeat: a router may filter them"]
    if counts.stray_bytes:
        return [*_no_mavlink(address)]
    return [*_nothing(address)]


def _wrong_peers(peers: Mapping[tuple[int, int], Peer], system_id: int | None) -> Iterator[str]:
    autopilots = sorted(
        {peer.system_id for peer in peers.values() if peer.autopilot != mavlink.MAV_AUTOPILOT_INVALID}
    )
    others = sorted(set(peers) - {(system, mavlink.MAV_COMP_ID_AUTOPILOT1) for system in autopilots})
    if autopilots:
        yield f"autopilots heard: systems {', '.join(map(str, autopilots))}; asked for {system_id or 'any'}"
    for system, component in others:
        yield f"system {system} component {component} heartbeats, but is no autopilot"
    if not autopilots:
        yield "the vehicle's own link is not forwarded here: check the router between"


def _no_mavlink(address: Address) -> Iterator[str]:
    if isinstance(address, Serial):
        rates = ", ".join(str(rate) for rate in _USUAL_BAUD if rate != address.baud_rate)
        yield f"the baud rate may be another than {address.baud_rate}: try {rates}"
        yield "the port may speak another protocol: PX4 MAV_n_CONFIG, ArduPilot SERIALn_PROTOCOL 2"
    else:
        yield "something else than MAVLink sends to this port"


def _nothing(address: Address) -> Iterator[str]:
    match address:
        case UdpIn():
            yield f"the vehicle may send to another port than {address.port}"
            yield f"PX4 sends to {_PX4_OFFBOARD} (companions) and {_PX4_GROUND}, plus its instance"
            yield "ArduPilot's simulator sends where --out says, usually 14550"
            yield "another program may take the packets: end ground stations and routers bound to this port"
        case UdpOut():
            yield f"nothing at {address.host}:{address.port} answers: a firewall, or a wrong address"
            yield "listen instead where the vehicle sends by itself: udpin://0.0.0.0:14540"
        case TcpOut():
            yield "the server takes connections, but sends nothing: another client may hold the link"
            yield f"ArduPilot's simulator listens at {_ARDUPILOT_TCP}, plus ten times its instance"
        case TcpIn():
            yield f"no client has connected to port {address.port}"
        case Serial():
            yield f"nothing arrives at {address.path}: check TX and RX, power, and that telemetry is on there"
            yield "PX4: MAV_1_CONFIG 102 (TELEM2); ArduPilot: SERIAL2_PROTOCOL 2"
        case Simulated():
            yield "the built-in vehicle has another system id"
