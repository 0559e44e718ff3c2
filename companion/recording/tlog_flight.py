"""One flight of one vehicle out of a telemetry log, which may hold several of each."""

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import chain
from typing import TypeAlias

import numpy as np

from companion.arrays import Times
from companion.errors import InputError
from companion.link.dialect import Message, mavlink
from companion.link.timesync import REBOOT_S
from companion.recording.clock_map import ClockMap, fit_clock
from companion.recording.tlog_frames import Frames, Stamped, columns, stamped_frames, times

Source: TypeAlias = tuple[int, int]
"""System and component."""
Heard: TypeAlias = Mapping[type[Message], Mapping[Source, Frames]]
"""The frames of each kind from each source, in the order of the log."""

POSITION = mavlink.MAVLink_local_position_ned_message
ATTITUDE = mavlink.MAVLink_attitude_message
QUATERNION = mavlink.MAVLink_attitude_quaternion_message
SETPOINT = mavlink.MAVLink_set_position_target_local_ned_message
HEARTBEAT = mavlink.MAVLink_heartbeat_message
STATUSTEXT = mavlink.MAVLink_statustext_message
COMMAND_ACK = mavlink.MAVLink_command_ack_message

TIMED = (POSITION, ATTITUDE, QUATERNION)
"""What carries the vehicle's time, often."""
WANTED = {kind.id: kind for kind in (*TIMED, SETPOINT, HEARTBEAT, STATUSTEXT, COMMAND_ACK)}


@dataclass(frozen=True, eq=False)
class LoggedFlight:
    """What one vehicle said from one start of its clock to the next, and what it was sent meanwhile.

    Attributes:
        system_id: the vehicle.
        said: frames of its autopilot, by kind.
        setpoints: SET_POSITION_TARGET_LOCAL_NED of all senders to all receivers.
        start_s, end_s: from its first frame to its last (Unix time, s).
        clock: from Unix time to the vehicle's.
        restarts: how often the vehicle's clock began anew in the log.
    """

    system_id: int
    said: Mapping[type[Message], Frames]
    setpoints: Frames
    start_s: float
    end_s: float
    clock: ClockMap
    restarts: int


def find_flight(log: bytes, system_id: int | None) -> LoggedFlight:
    """The longest flight of the vehicle with this MAVLink id, or of the only one in the log.

    Raises:
        InputError: there is no frame in the log, no position of that vehicle, or no telling which is meant.
    """
    heard = _heard(log)
    vehicle = _vehicle(heard, system_id)
    said = {kind: sources[vehicle] for kind, sources in heard.items() if vehicle in sources}
    received_s, vehicle_s = _stamps(said)
    start, end, restarts = _longest_stretch(vehicle_s)
    start_s, end_s = received_s[start], received_s[end - 1]

    def within(frames: Frames) -> Frames:
        return [stamped for stamped in frames if start_s <= stamped.time_s <= end_s]

    setpoints = sorted(chain.from_iterable(heard.get(SETPOINT, {}).values()), key=lambda each: each.time_s)
    return LoggedFlight(
        system_id=vehicle[0],
        said={kind: within(frames) for kind, frames in said.items()},
        setpoints=within(setpoints),
        start_s=start_s,
        end_s=end_s,
        clock=fit_clock(received_s[start:end], vehicle_s[start:end]),
        restarts=restarts,
    )


def _heard(log: bytes) -> Heard:
    heard: dict[type[Message], dict[Source, list[Stamped]]] = defaultdict(lambda: defaultdict(list))
    foreign = True
    for stamped in stamped_frames(log):
        foreign = False
        frame = stamped.frame
        if (kind := WANTED.get(frame.message_id)) is not None:
            heard[kind][frame.system_id, frame.component_id].append(stamped)
    if foreign:
        raise InputError("no telemetry log: frames of MAVLink, a time stamp before each, were expected")
    return heard


def _vehicle(heard: Heard, system_id: int | None) -> Source:
    """The source of the positions that are meant: of the system, the component that sent most."""
    sources = heard.get(POSITION, {})
    systems = sorted({system for system, _ in sources})
    listed = ", ".join(map(str, systems)) or "none"
    if system_id is None and len(systems) > 1:
        raise InputError(
            f"positions of several vehicles, systems {listed}: name one, "
            "by --system-id or as system_id in a JSON file beside the log"
        )
    meant = [source for source in sources if system_id in (None, source[0])]
    if not meant:
        whose = "" if system_id is None else f" of system {system_id}"
        raise InputError(
            f"no LOCAL_POSITION_NED{whose} (systems with one: {listed}): have the vehicle send it, "
            "or name another system"
        )
    return max(meant, key=lambda source: len(sources[source]))


def _stamps(said: Mapping[type[Message], Frames]) -> tuple[Times, Times]:
    """When each frame that carries the vehicle's time came (Unix, s), and that time (s), as they came."""
    timed = [(kind, said[kind]) for kind in TIMED if kind in said]
    received_s = np.concatenate([times(frames) for _, frames in timed])
    vehicle_s = np.concatenate([boot_times(kind, frames) for kind, frames in timed])
    order = np.argsort(received_s, kind="stable")
    return received_s[order], vehicle_s[order]


def boot_times(kind: type[Message], frames: Frames) -> Times:
    """The vehicle's time in each message (s)."""
    return columns(kind, frames, "time_boot_ms")[:, 0] * 1e-3


def _longest_stretch(vehicle_s: Times) -> tuple[int, int, int]:
    """Start and end of the longest run without a restart of the vehicle, and the number of restarts."""
    restarts = np.flatnonzero(np.diff(vehicle_s) < -REBOOT_S) + 1
    edges = np.concatenate(([0], restarts, [len(vehicle_s)]))
    longest = int(np.argmax(np.diff(edges)))
    return int(edges[longest]), int(edges[longest + 1]), len(restarts)
