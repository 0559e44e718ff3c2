"""A look at a vehicle: ask for what matters, wait until it is ready, measure. Changes nothing of it."""

import asyncio
import contextlib
from collections.abc import Callable, Mapping
from typing import TypeAlias

from companion import clock
from companion.autopilot import identify
from companion.autopilot.ardupilot import mode_name as ardupilot_mode
from companion.autopilot.detect import MULTIROTORS
from companion.autopilot.px4 import mode_name as px4_mode
from companion.doctor.checks import RULES
from companion.doctor.clocks import measure_round_trips
from companion.doctor.health import HealthWatch, missing_for_flight
from companion.doctor.observation import Observation
from companion.doctor.traffic import Traffic
from companion.errors import NoReplyError, RefusedError
from companion.link.command import command, request_message
from companion.link.connection import Connection
from companion.link.dialect import mavlink
from companion.link.message_rates import MessageRates
from companion.link.parameter import read_parameters
from companion.link.parameter_encoding import parameter_encoding
from companion.link.status_text import StatusText

Announce: TypeAlias = Callable[[str], None]

_RATES_HZ: Mapping[int, float] = {
    mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED: 100.0,
    mavlink.MAVLINK_MSG_ID_ATTITUDE: 100.0,
    mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE: 5.0,
    mavlink.MAVLINK_MSG_ID_SYS_STATUS: 2.0,
    mavlink.MAVLINK_MSG_ID_GPS_RAW_INT: 2.0,
    mavlink.MAVLINK_MSG_ID_HOME_POSITION: 0.5,
    mavlink.MAVLINK_MSG_ID_BATTERY_STATUS: 0.5,
}
"""What is asked for, and left so: a flight asks for the same."""
_ESTIMATOR_STATUS = {
    mavlink.MAV_AUTOPILOT_PX4: mavlink.MAVLINK_MSG_ID_ESTIMATOR_STATUS,
    mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA: mavlink.MAVLINK_MSG_ID_EKF_STATUS_REPORT,
}
_ESTIMATOR_STATUS_HZ = 1.0
_MODE_NAMES = {
    mavlink.MAV_AUTOPILOT_PX4: px4_mode,
    mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA: ardupilot_mode,
}
_POLL_S = 0.1
_REASONS_S = 1.0
_REASON_SEVERITY = mavlink.MAV_SEVERITY_WARNING


async def examine(
    connection: Connection,
    traffic: Traffic,
    *,
    seconds: float,
    patience_s: float,
    announce: Announce,
    chosen: bool = False,
) -> Observation:
    """What there is to see of the connection's vehicle.

    Args:
        connection: to the vehicle.
        traffic: what watches the bytes of the same link.
        seconds: how long to measure (s).
        patience_s: how long to wait for the vehicle to be ready (s).
        announce: told what goes on.
        chosen: whether the user named this vehicle, or it was the first that was heard.
    """
    began_s = clock.now()
    watch = HealthWatch(connection)
    identity = await identify(connection)
    announce(
        f"connected to system {connection.system_id}, {identity.autopilot} {identity.version or ''}".rstrip()
    )
    await _ask_for_messages(connection)
    await _until_ready(connection, watch, began_s + patience_s, announce)
    waited_s = clock.now() - began_s
    complaints = await _complaints(connection)
    announce("reading parameters")
    encoding = await parameter_encoding(connection)
    parameters = await read_parameters(connection, RULES.get(identity.autopilot, {}), encoding)
    announce(f"measuring for {seconds:g} s")
    traffic.restart()
    round_trips = await measure_round_trips(connection, seconds)
    beat = connection.heartbeat
    mode = _MODE_NAMES.get(beat.autopilot, str)(beat.custom_mode)
    return Observation(
        system_id=connection.system_id,
        identity=identity,
        vehicle_type=_type_name(beat.type),
        is_multirotor=beat.type in MULTIROTORS,
        mode=mode,
        armed=_armed(connection),
        seconds=clock.now() - traffic.began_s,
        waited_s=waited_s,
        streams=traffic.streams(*connection.target),
        losses=traffic.losses,
        stray_bytes=traffic.counts.stray_bytes,
        bad_checksums=traffic.counts.bad_checksums,
        round_trips=round_trips,
        peers=tuple(traffic.peers.values()),
        health=watch.health,
        complaints=tuple(complaints),
        parameters={name: each.value for name, each in parameters.items()},
        vehicle_signs=connection.vehicle_signs,
        we_sign=connection.signer is not None,
        chosen=chosen,
    )


async def _until_ready(
    connection: Connection, watch: HealthWatch, until_s: float, announce: Announce
) -> None:
    """Wait until the vehicle is ready to fly, or flies; tells what is waited for when that changes."""
    told = ""
    while clock.now() < until_s and (missing := missing_for_flight(watch.health)):
        if _armed(connection) and watch.health.has_position:
            break
        wanted = " and ".join(missing)
        if wanted != told:
            told = wanted
            announce(f"waiting for {wanted}, {until_s - clock.now():.0f} s at most")
        await asyncio.sleep(_POLL_S)
    if not watch.health.has_home:
        with contextlib.suppress(NoReplyError):
            await request_message(connection, mavlink.MAVLink_home_position_message)


async def _ask_for_messages(connection: Connection) -> None:
    """Ask for all that is looked at, and go on asking for what does not come."""
    estimator = _ESTIMATOR_STATUS.get(connection.heartbeat.autopilot)
    also = {} if estimator is None else {estimator: _ESTIMATOR_STATUS_HZ}
    rates = MessageRates(connection, {**_RATES_HZ, **also})
    with contextlib.suppress(NoReplyError):  # a vehicle that still boots answers later
        await rates.ask()
    connection.spawn(rates.keep())


async def _complaints(connection: Connection) -> list[str]:
    """What the vehicle says when it is asked to run its checks: each line once, warnings and worse."""
    lines: list[StatusText] = []
    unsubscribe = connection.status_texts.subscribe(lines.append)
    try:
        if not _armed(connection):
            with contextlib.suppress(RefusedError, NoReplyError):
                await command(connection, mavlink.MAV_CMD_RUN_PREARM_CHECKS)
        await asyncio.sleep(_REASONS_S)
    finally:
        unsubscribe()
    return list(dict.fromkeys(line.text for line in lines if line.severity <= _REASON_SEVERITY))


def _armed(connection: Connection) -> bool:
    return bool(connection.heartbeat.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED)


def _type_name(vehicle_type: int) -> str:
    entry = mavlink.enums["MAV_TYPE"].get(vehicle_type)
    return entry.name.removeprefix("MAV_TYPE_").lower() if entry else f"MAV_TYPE {vehicle_type}"
