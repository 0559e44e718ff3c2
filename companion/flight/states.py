"""The states of a flight, and what leads from one to another: a table, and nothing that runs.

From every state in which the vehicle is in the air and ours, `HOLD` and `LAND` lead where they say at once;
from any other, some way leads there.
"""

from collections.abc import Mapping
from enum import StrEnum


class FlightState(StrEnum):
    """Where a flight is."""

    DISCONNECTED = "disconnected"
    """The vehicle is not heard, or was not yet."""
    STANDBY = "standby"
    """On the ground, or not yet known to be in the air."""
    TAKING_OFF = "taking off"
    """Arming and climbing, by the autopilot's own takeoff."""
    APPROACHING = "approaching"
    """Our setpoints bring it to the start, and settle it there."""
    TRACKING = "tracking"
    HOLDING = "holding"
    """The autopilot's own hold, without setpoints."""
    LANDING = "landing"
    """The autopilot's own landing or return."""
    YIELDED = "yielded to the pilot"
    """Somebody else changed its mode; nothing more is sent until asked."""
    FAILED = "failed"
    """The flight ended, and the vehicle was not seen in a hold: without setpoints its failsafe acts."""


class Event(StrEnum):
    """What happens to a flight."""

    CONNECT = "connected"
    FIND_FLYING = "found in the air"
    TAKE_OFF = "takeoff began"
    GUIDE = "it follows our setpoints"
    TRACK = "the trajectory began"
    HOLD = "it holds"
    LAND = "it was told to land"
    GROUND = "it is on the ground"
    TAKE = "its mode was changed unasked"
    RECLAIM = "asked to take it over again"
    FAIL = "something failed"
    LOSE = "it fell silent"


_OURS = (
    FlightState.TAKING_OFF,
    FlightState.APPROACHING,
    FlightState.TRACKING,
    FlightState.HOLDING,
    FlightState.LANDING,
    FlightState.FAILED,
)

TRANSITIONS: Mapping[tuple[FlightState, Event], FlightState] = {
    (FlightState.DISCONNECTED, Event.CONNECT): FlightState.STANDBY,
    (FlightState.STANDBY, Event.TAKE_OFF): FlightState.TAKING_OFF,
    (FlightState.STANDBY, Event.FIND_FLYING): FlightState.HOLDING,
    (FlightState.TAKING_OFF, Event.GUIDE): FlightState.APPROACHING,
    (FlightState.HOLDING, Event.GUIDE): FlightState.APPROACHING,
    (FlightState.APPROACHING, Event.TRACK): FlightState.TRACKING,
    (FlightState.YIELDED, Event.RECLAIM): FlightState.HOLDING,
    (FlightState.YIELDED, Event.GROUND): FlightState.STANDBY,
    **{(state, Event.HOLD): FlightState.HOLDING for state in _OURS},
    **{(state, Event.LAND): FlightState.LANDING for state in _OURS},
    **{(state, Event.GROUND): FlightState.STANDBY for state in _OURS},
    **{(state, Event.TAKE): FlightState.YIELDED for state in _OURS},
    **{(state, Event.FAIL): FlightState.FAILED for state in _OURS},
    **{(state, Event.LOSE): FlightState.DISCONNECTED for state in FlightState},
}
"""All that may happen."""


def next_state(state: FlightState, event: Event) -> FlightState:
    """The state after `event`; the same where the table has no such event for it."""
    return TRANSITIONS.get((state, event), state)
