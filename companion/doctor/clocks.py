"""Round trips of TIMESYNC: how long they take, and how the vehicle's clock goes beside ours.

Source: https://mavlink.io/en/services/timesync.html
"""

import asyncio
from dataclasses import dataclass

import numpy as np

from companion import clock
from companion.doctor.observation import RoundTrips
from companion.link.connection import Connection
from companion.link.dialect import mavlink

_INTERVAL_S = 0.1
_LAST_ANSWER_S = 0.5
_FOR_DRIFT_S = 4.0
_DRIFT_WITHIN_PPM = 500.0
"""Over less than the first, or with a greater standard error than the second, jitter looks like drift."""


@dataclass(frozen=True, slots=True)
class Trip:
    """One question and its answer: companion clock before and after, vehicle clock between (s)."""

    asked_s: float
    vehicle_s: float
    answered_s: float


async def measure_round_trips(connection: Connection, seconds: float) -> RoundTrips | None:
    """Ask for the vehicle's time for `seconds` (s); None when it never answers."""
    trips: list[Trip] = []
    asked: dict[int, float] = {}

    def take(message: mavlink.MAVLink_timesync_message) -> None:
        if message.tc1 != 0 and message.ts1 in asked:
            trips.append(Trip(asked.pop(message.ts1), message.tc1 * 1e-9, clock.now()))

    unsubscribe = connection.subscribe(mavlink.MAVLink_timesync_message, take)
    questions, until_s = 0, clock.now() + seconds
    try:
        while clock.now() < until_s:
            now_s = clock.now()
            asked[round(now_s * 1e9)] = now_s
            connection.send(mavlink.MAVLink_timesync_message(tc1=0, ts1=round(now_s * 1e9)))
            questions += 1
            await asyncio.sleep(_INTERVAL_S)
        if asked:
            await asyncio.sleep(_LAST_ANSWER_S)
    finally:
        unsubscribe()
    return round_trips(questions, trips)


def round_trips(asked: int, trips: list[Trip]) -> RoundTrips | None:
    """What the answers tell; None without any.

    Of the trips the faster half bracket the vehicle's clock best; the drift is the slope of a line through
    their offsets.
    """
    if not trips:
        return None
    times = np.array([(trip.asked_s, trip.vehicle_s, trip.answered_s) for trip in trips])
    duration_s = times[:, 2] - times[:, 0]
    middle_s = 0.5 * (times[:, 0] + times[:, 2])
    fast = duration_s <= np.median(duration_s)
    offset_s = middle_s - times[:, 1]
    drift_ppm = None
    if np.ptp(middle_s[fast]) >= _FOR_DRIFT_S:
        from scipy.stats import linregress  # takes half a second, and the doctor alone needs it

        line = linregress(middle_s[fast], offset_s[fast] - offset_s[0])
        if 1e6 * line.stderr <= _DRIFT_WITHIN_PPM:
            drift_ppm = 1e6 * float(line.slope)
    return RoundTrips(
        asked=asked,
        answered=len(trips),
        median_s=float(np.median(duration_s)),
        p95_s=float(np.percentile(duration_s, 95.0)),
        offset_s=float(offset_s[fast][-1]),
        drift_ppm=drift_ppm,
    )
