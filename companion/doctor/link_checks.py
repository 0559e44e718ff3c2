"""Checks of the link: is what arrives enough to fly by?"""

from collections.abc import Iterator

from companion.doctor.finding import Finding, fine, stops, warns
from companion.doctor.observation import Observation, Peer
from companion.link.dialect import mavlink

_SLOWEST_HZ, _SLOW_HZ = 10.0, 30.0
"""Of position and attitude: below the first there is no tracking, below the second it suffers."""
_GAP_S = 0.5  # half of PX4's COM_OF_LOSS_T, as setpoints likely get lost where telemetry does
_HEAVY_LOSS, _SOME_LOSS = 0.2, 0.02
_LATE_S, _LATE_P95_S = 0.5, 0.2
_DRIFT_PPM = 5000.0  # 5 ms a second; crystals keep to a fiftieth of that, simulators do not
_FEW_FRAMES = 20


def rates(seen: Observation) -> Iterator[Finding]:
    """Position and attitude come often and evenly enough."""
    for name in ("LOCAL_POSITION_NED", "ATTITUDE"):
        stream = seen.streams.get(name)
        if stream is None:
            yield stops(name, "it does not come", f"{_no_stream(name)}; {_faster(seen)}")
            continue
        told = f"{stream.rate_hz:.0f} Hz, jitter {stream.jitter_s * 1e3:.0f} ms"
        if stream.rate_hz < _SLOWEST_HZ:
            yield stops(name, f"{told}: too slow to track by", _faster(seen))
        elif stream.longest_gap_s > _GAP_S:
            gap = f"{told}, once nothing for {stream.longest_gap_s:.1f} s"
            yield warns(name, gap, "look for a busy computer or a weak radio")
        elif stream.rate_hz < _SLOW_HZ:
            yield warns(name, f"{told}: tracking is best from 50 Hz on", _faster(seen))
        else:
            yield fine(name, told)


def loss(seen: Observation) -> Iterator[Finding]:
    """The autopilot's frames arrive."""
    lost = seen.losses.get((seen.system_id, mavlink.MAV_COMP_ID_AUTOPILOT1))
    if lost is None:
        return
    told = (
        f"{lost.share:.1%} of {lost.frames + lost.lost} frames lost, {lost.duplicated} came twice, "
        f"{lost.reordered} late"
    )
    advice = "shorten the cable or better the radio, lower the message rates, or raise the baud rate"
    if lost.share > _HEAVY_LOSS:
        yield stops("loss", told, advice)
    elif lost.share > _SOME_LOSS:
        yield warns("loss", told, advice)
    else:
        yield fine("loss", told)
    if seen.bad_checksums > max(_FEW_FRAMES, _SOME_LOSS * lost.frames):
        spoilt = f"{seen.bad_checksums} frames with a wrong checksum, {seen.stray_bytes} stray bytes"
        yield warns("noise", spoilt, "check the baud rate, the wiring and that nobody else uses the port")


def latency(seen: Observation) -> Iterator[Finding]:
    """Answers come soon, and the vehicle's clock can be followed."""
    trips = seen.round_trips
    if trips is None:
        yield warns(
            "latency",
            "the vehicle does not answer TIMESYNC: how old its states are is only guessed",
            "on PX4 keep TIMESYNC in the link's mode (MAV_n_MODE 2, Onboard); ArduPilot answers by itself",
        )
        return
    told = (
        f"round trip {trips.median_s * 1e3:.1f} ms (median), {trips.p95_s * 1e3:.1f} ms (95 %), "
        f"{trips.answered} of {trips.asked} answered"
    )
    if trips.median_s > _LATE_S:
        yield stops("latency", told, "use a direct link: a position this old cannot be tracked by")
    elif trips.p95_s > _LATE_P95_S:
        yield warns("latency", told, "use a faster link, or fly slowly")
    else:
        yield fine("latency", told)
    if trips.drift_ppm is None:
        return
    drift = f"offset {trips.offset_s:.3f} s, drift {round(trips.drift_ppm):+d} ppm"
    if abs(trips.drift_ppm) > _DRIFT_PPM:
        yield warns(
            "clock", f"{drift}: the vehicle's clock does not run as ours", "usual in a simulator that lags"
        )
    else:
        yield fine("clock", drift)


def signing(seen: Observation) -> Iterator[Finding]:
    """Both sides sign, or neither does."""
    if seen.we_sign:
        yield fine("signing", "both sides sign, with the same key")
    elif seen.vehicle_signs:
        told = "the vehicle signs its frames, and may take none but signed ones"
        yield warns("signing", told, "give its key: --signing-key FILE")


def others(seen: Observation) -> Iterator[Finding]:
    """Nobody else on the link is in the way."""
    vehicles = sorted({peer.system_id for peer in seen.peers if _is_vehicle(peer)})
    if len(vehicles) > 1 and not seen.chosen:
        listed = ", ".join(map(str, vehicles))
        yield warns("vehicles", f"systems {listed} speak here", f"say which: --system-id {seen.system_id}")
    same = (seen.system_id, mavlink.MAV_COMP_ID_ONBOARD_COMPUTER)
    if any((peer.system_id, peer.component_id) == same for peer in seen.peers):
        yield warns(
            "companions",
            "another onboard computer has the ids that this one uses",
            "end the other program, or give it another component id",
        )


def _is_vehicle(peer: Peer) -> bool:
    """Whether it could be flown: ground stations, too, may heartbeat as MAV_AUTOPILOT_GENERIC."""
    is_autopilot = peer.component_id == mavlink.MAV_COMP_ID_AUTOPILOT1
    return is_autopilot and peer.autopilot != mavlink.MAV_AUTOPILOT_INVALID


def _no_stream(name: str) -> str:
    if name == "LOCAL_POSITION_NED":
        return (
            "it comes once the estimator has a position: give the vehicle GPS or another source of position"
        )
    return "it was asked for and should come at once"


def _faster(seen: Observation) -> str:
    if seen.identity.autopilot == "PX4":
        return "on a serial port set SER_TEL2_BAUD 921600, MAV_1_MODE 2 (Onboard) and MAV_1_RATE 0"
    return "on a serial port set SERIAL2_BAUD 921 and SERIAL2_PROTOCOL 2"
