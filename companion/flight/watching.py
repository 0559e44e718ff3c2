"""Watches over a flight: reads what there is, has watchdogs act, and leaves the vehicle to who takes it."""

import asyncio
import math
from collections.abc import Callable
from dataclasses import replace

from companion import clock
from companion.autopilot.interface import Autopilot
from companion.errors import TakenError
from companion.flight.stream import SetpointStream
from companion.flight.watchdogs import Action, Alarm, Readings, Since, WatchdogError, Watchdogs, watch
from companion.link.status import VehicleStatus

_LOOK_EVERY_S = 0.05


async def keep_watch(
    watchdogs: Watchdogs, read: Callable[[float], Readings], fall_back: Callable[[Alarm], None]
) -> None:
    """Watch until cancelled.

    Args:
        watchdogs: the table.
        read: what there is to be read at a time (companion clock, s).
        fall_back: called with each alarm that asks for no more than that.

    Raises:
        WatchdogError: one asks for more.
    """
    since: Since = {}
    acted: set[str] = set()
    while True:
        now_s = clock.now()
        since, alarms = watch(watchdogs, read(now_s), now_s, since)
        acted &= since.keys()
        for alarm in alarms:
            if alarm.watchdog.action is not Action.FALL_BACK:
                raise WatchdogError(str(alarm), alarm.watchdog.action)
            if alarm.name not in acted:
                acted.add(alarm.name)
                fall_back(alarm)
        await asyncio.sleep(_LOOK_EVERY_S)


async def leave_to_taker(autopilot: Autopilot) -> None:
    """Wait until the vehicle changes its mode unasked.

    Raises:
        TakenError: it has.
    """
    mode = await autopilot.until_taken()
    raise TakenError(f"the vehicle went to {mode} unasked: it was left to whoever did that")


def of_vehicle(status: VehicleStatus, temperature_c: float, now_s: float) -> Readings:
    """What is known of the vehicle and the computer at `now_s` (companion clock, s)."""
    return Readings(
        battery_used=math.nan if status.battery is None else 1.0 - status.battery,
        estimator=status.estimator,
        gps_lost_s=now_s - status.gps_lost_s,
        gps_apart_m=status.gps_apart_m,
        temperature_c=temperature_c,
    )


def with_stream(readings: Readings, stream: SetpointStream) -> Readings:
    """The same, and what is known of our setpoints."""
    return replace(
        readings,
        lateness_s=stream.take_lateness_s(),
        computing=stream.computing,
        unpredicted_m=stream.control.unpredicted_m,
        off_course_m=stream.control.error_m,
        foreign=stream.foreign,
    )
