"""PX4's parameters that matter where a companion flies.

Source: https://docs.px4.io/main/en/advanced_config/parameter_reference.html
"""

from collections.abc import Mapping
from typing import TypeAlias

from companion.doctor.finding import Finding, fine, stops, warns
from companion.doctor.observation import Observation
from companion.doctor.rule import Rule, at_least, one_of
from companion.link.dialect import mavlink
from companion.link.parameter_encoding import Number

_Names: TypeAlias = Mapping[int, str]

_OFFBOARD_LOSS: _Names = {
    0: "Position",
    1: "Altitude",
    2: "Manual",
    3: "Return",
    4: "Land",
    5: "Hold",
    6: "Terminate",
    7: "Disarm",
}
_ALTITUDE, _POSITION = 1, 0
_FALLS = (2, 6, 7)
_LINK_LOSS: _Names = {0: "nothing", 1: "Hold", 2: "Return", 3: "Land", 5: "Terminate", 6: "Disarm"}
_MOTORS_OFF = (5, 6)
_GEOFENCE: _Names = {0: "nothing", 1: "Warning", 2: "Hold", 3: "Return", 4: "Terminate", 5: "Land"}
_IN_OFFBOARD = 4
_RC_ONLY = 0
_RC_OPTIONAL = (1, 14)
"""From this release on a remote control that was absent at arming is not missed."""
_LONG_S, _TOO_LONG_S, _SHORT_S = 2.0, 5.0, 0.25


def _loss_time(name: str, value: Number, seen: Observation) -> Finding:
    told = f"when setpoints stop, PX4 acts after {value:g} s"
    if value > _TOO_LONG_S:
        return stops(name, f"{told}: too late", f"set {name} 1.0")
    if value > _LONG_S:
        return warns(name, told, f"set {name} 1.0")
    if value < _SHORT_S:
        return warns(name, f"{told}: a short gap in the link ends the flight", f"set {name} 1.0")
    return fine(name, told)


def _loss_action(name: str, value: Number, seen: Observation) -> Finding:
    action = _OFFBOARD_LOSS.get(int(value), f"action {value:g}")
    told = f"when setpoints stop, PX4 goes to {action}"
    safe = f"set {name} 5 (Hold), 4 (Land) or 3 (Return)"
    if value in _FALLS:
        return stops(name, f"{told}: the vehicle may fall", safe)
    if value not in _OFFBOARD_LOSS:
        return stops(name, f"{told}, which nobody knows", safe)
    if not seen.health.has_remote_control and value == _ALTITUDE:
        return stops(name, f"{told}: it then drifts, and no remote control is received", safe)
    if not seen.health.has_remote_control and value == _POSITION:
        return warns(name, f"{told}, which waits for a pilot; no remote control is received", safe)
    return fine(name, told)


def _rc_exceptions(name: str, value: Number, seen: Observation) -> Finding:
    if int(value) & _IN_OFFBOARD:
        return fine(name, "losing the remote control does not end OFFBOARD")
    if seen.health.has_remote_control:
        return fine(name, "losing the remote control ends OFFBOARD, as NAV_RCL_ACT says")
    if seen.version is None or seen.version < _RC_OPTIONAL:
        told = "no remote control is received, and this PX4 ends OFFBOARD for that"
        return warns(name, told, f"set {name} {int(value) | _IN_OFFBOARD}")
    return fine(name, "no remote control is received, and this PX4 does not miss one")


def _rc_source(name: str, value: Number, seen: Observation) -> Finding:
    if value == _RC_ONLY and not seen.health.has_remote_control:
        told = "sticks come from a remote control only, and none is received: PX4 may not arm"
        return warns(name, told, f"switch it on, or set {name} 4 (sticks disabled)")
    return fine(name, f"source of sticks {value:g}")


def _rc_loss(name: str, value: Number, seen: Observation) -> Finding:
    told = f"when the remote control is lost: {_LINK_LOSS.get(int(value), f'action {value:g}')}"
    if value in _MOTORS_OFF:
        return warns(name, f"{told}: the vehicle falls", f"set {name} 2 (Return) or 3 (Land)")
    return fine(name, told)


def _ground_loss(name: str, value: Number, seen: Observation) -> Finding:
    told = f"when the ground station is lost: {_LINK_LOSS.get(int(value), f'action {value:g}')}"
    if value in _MOTORS_OFF:
        return warns(name, f"{told}: the vehicle falls", f"set {name} 0 (nothing) or 2 (Return)")
    if value and not any(peer.type == mavlink.MAV_TYPE_GCS for peer in seen.peers):
        told += "; none is heard on this link, and without one PX4 does not arm"
        return warns(name, told, f"connect a ground station, or set {name} 0")
    return fine(name, told)


RULES: Mapping[str, Rule] = {
    "COM_OF_LOSS_T": _loss_time,
    "COM_OBL_RC_ACT": _loss_action,
    "COM_RCL_EXCEPT": _rc_exceptions,
    "COM_RC_IN_MODE": _rc_source,
    "NAV_RCL_ACT": _rc_loss,
    "NAV_DLL_ACT": _ground_loss,
    "GF_ACTION": one_of(_GEOFENCE, "beyond the fence", unsafe=(4,), instead="2 (Hold) or 3 (Return)"),
    "MPC_XY_VEL_MAX": at_least(2.0, "m/s", "horizontal speed limit", instead="12"),
    "MPC_Z_VEL_MAX_UP": at_least(0.5, "m/s", "climb limit", instead="3"),
    "MPC_Z_VEL_MAX_DN": at_least(0.5, "m/s", "descent limit", instead="1.5"),
    "MPC_TILTMAX_AIR": at_least(20.0, "deg", "tilt limit", instead="45"),
    "SDLOG_MODE": one_of(
        {-1: "no log", 0: "log while armed", 1: "log from boot to disarming", 2: "log always"},
        "the vehicle's own record",
        unsafe=(-1,),
        instead="0 (while armed)",
    ),
}
"""What to make of each."""
