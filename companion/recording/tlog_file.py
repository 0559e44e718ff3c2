"""Telemetry logs of real vehicles (`.tlog`, also packed: `.tlog.xz`) as recordings.

States are the LOCAL_POSITION_NED of an autopilot with its attitude, references the
SET_POSITION_TARGET_LOCAL_NED that were sent to it. A setpoint acts when it arrives, so its arrival is put on
the vehicle's clock, which is the recording's.
"""

from operator import itemgetter
from pathlib import Path

import numpy as np

from companion.errors import InputError
from companion.link.dialect import Message, mavlink
from companion.recording.bounded_file import read_bytes
from companion.recording.card import CardWindow, log_name, read_card
from companion.recording.clock_map import rising
from companion.recording.segments import Segment, Window
from companion.recording.series import Indices, Provenance, Recording, ReferenceSeries, StateSeries, rows
from companion.recording.states import Sampled, joined_states, roll_pitch_yaw
from companion.recording.tlog_events import Event, answers, modes, texts
from companion.recording.tlog_flight import (
    ATTITUDE,
    COMMAND_ACK,
    HEARTBEAT,
    POSITION,
    QUATERNION,
    SETPOINT,
    STATUSTEXT,
    LoggedFlight,
    boot_times,
    find_flight,
)
from companion.recording.tlog_frames import columns, times

SETPOINT_FIELDS = ("x", "y", "z", "vx", "vy", "vz", "afx", "afy", "afz", "yaw")
IGNORE_BITS = (
    mavlink.POSITION_TARGET_TYPEMASK_X_IGNORE,
    mavlink.POSITION_TARGET_TYPEMASK_Y_IGNORE,
    mavlink.POSITION_TARGET_TYPEMASK_Z_IGNORE,
    mavlink.POSITION_TARGET_TYPEMASK_VX_IGNORE,
    mavlink.POSITION_TARGET_TYPEMASK_VY_IGNORE,
    mavlink.POSITION_TARGET_TYPEMASK_VZ_IGNORE,
    mavlink.POSITION_TARGET_TYPEMASK_AX_IGNORE,
    mavlink.POSITION_TARGET_TYPEMASK_AY_IGNORE,
    mavlink.POSITION_TARGET_TYPEMASK_AZ_IGNORE,
    mavlink.POSITION_TARGET_TYPEMASK_YAW_IGNORE,
)
"""The mask bit of each of `SETPOINT_FIELDS`."""
_TO_ALL = 0


def read_tlog(path: Path, system_id: int | None = None) -> Recording:
    """The flight of one vehicle, on that vehicle's clock (its time_boot_ms), with what its card says.

    Of a vehicle that was restarted while the log ran, the longest stretch in between.

    Args:
        path: `.tlog` or `.tlog.xz`.
        system_id: MAVLink id of the vehicle; without it the card's, or the only one in the log.

    Raises:
        InputError: the file cannot be read, is no telemetry log, or holds no flight of that vehicle.
    """
    card = read_card(path)
    log = read_bytes(path)
    try:
        flight = find_flight(log, card.system_id if system_id is None else system_id)
        states = _states(flight)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
    hover = card.hover if card.hover and _covers(flight, card.hover) else None
    return Recording(
        provenance=Provenance(vehicle=card.vehicle or log_name(path), strategy=""),
        states=states,
        references=_references(flight),
        events=_events(flight),
        segments=tuple(
            Segment(segment.id, _window(flight, segment), segment.setpoints, segment.rms_m)
            for segment in card.segments
            if _covers(flight, segment)
        ),
        hover=None if hover is None else _window(flight, hover),
    )


def _states(flight: LoggedFlight) -> StateSeries:
    def said(kind: type[Message], *names: str) -> Sampled:
        frames = flight.said.get(kind, ())
        return boot_times(kind, frames), columns(kind, frames, *names)

    rates = ("rollspeed", "pitchspeed", "yawspeed")
    if ATTITUDE in flight.said:
        attitude, turning = said(ATTITUDE, "roll", "pitch", "yaw"), said(ATTITUDE, *rates)
    else:
        time_s, quaternion = said(QUATERNION, "q1", "q2", "q3", "q4")
        attitude, turning = (time_s, roll_pitch_yaw(quaternion)), said(QUATERNION, *rates)
    return joined_states(said(POSITION, "x", "y", "z", "vx", "vy", "vz"), attitude, turning)


def _references(flight: LoggedFlight) -> ReferenceSeries:
    local, _ = _addressed(flight)
    time_s = flight.clock(times(flight.setpoints))
    values = columns(SETPOINT, flight.setpoints, *SETPOINT_FIELDS)
    mask = columns(SETPOINT, flight.setpoints, "type_mask").astype(int)
    values[(mask & IGNORE_BITS).astype(bool) | ~np.isfinite(values)] = np.nan
    force = (mask & mavlink.POSITION_TARGET_TYPEMASK_FORCE_SET).astype(bool)
    acceleration = np.where(force, np.nan, values[:, 6:9])
    sent = ReferenceSeries(time_s, values[:, 0:3], values[:, 3:6], acceleration, values[:, 9])
    sent = rows(sent, local)
    return rows(sent, rising(sent.time_s))


def _addressed(flight: LoggedFlight) -> tuple[Indices, Indices]:
    """Which setpoints were sent to the vehicle: those in LOCAL_NED, and those in other frames."""
    target, frame = columns(SETPOINT, flight.setpoints, "target_system", "coordinate_frame").T
    ours = (target == flight.system_id) | (target == _TO_ALL)
    local = frame == mavlink.MAV_FRAME_LOCAL_NED
    return np.flatnonzero(ours & local), np.flatnonzero(ours & ~local)


def _events(flight: LoggedFlight) -> tuple[Event, ...]:
    """What the vehicle said in words or by its state when it came, and what of the log was left out."""
    events = [
        *modes(flight.said.get(HEARTBEAT, ())),
        *texts(flight.said.get(STATUSTEXT, ())),
        *answers(flight.said.get(COMMAND_ACK, ())),
    ]
    _, others = _addressed(flight)
    if len(others):
        first_s = flight.setpoints[others[0]].time_s
        events.append((first_s, f"left out: {len(others)} setpoints in other frames than LOCAL_NED"))
    if flight.restarts:
        events.append((flight.start_s, f"left out: what lies before or behind {flight.restarts} restarts"))
    events.sort(key=itemgetter(0))
    time_s = flight.clock(np.array([unix_s for unix_s, _ in events]))
    return tuple(zip(time_s.tolist(), (text for _, text in events), strict=True))


def _covers(flight: LoggedFlight, window: CardWindow) -> bool:
    return flight.start_s <= window.start_unix_s and window.end_unix_s <= flight.end_s


def _window(flight: LoggedFlight, window: CardWindow) -> Window:
    start_s, end_s = flight.clock(np.array([window.start_unix_s, window.end_unix_s])).tolist()
    return Window(start_s, end_s)
