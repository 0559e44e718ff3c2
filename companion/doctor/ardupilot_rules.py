"""ArduPilot Copter's parameters that matter where a companion flies, by their names before and since 4.7.

Source: https://ardupilot.org/copter/docs/parameters.html
"""

from collections.abc import Mapping

from companion.doctor.finding import Finding, fine, stops, warns
from companion.doctor.observation import Observation
from companion.doctor.rule import Rule, at_least, one_of
from companion.link.parameter_encoding import Number

_LONGEST_S, _SHORT_S = 3.0, 0.3
_LOOSE = 1 << 4 | 1 << 5
"""GUID_OPTIONS: do not stabilize PositionXY, do not stabilize VelocityXY."""
_CONTINUE_IN_GUIDED = 1 << 2
_ALL_CHECKS = 1
_GROUND_LOSS = {
    0: "nothing",
    1: "RTL",
    2: "RTL, or on with the mission",
    3: "SmartRTL or RTL",
    4: "SmartRTL or Land",
    5: "Land",
    6: "landing sequence or RTL",
    7: "Brake or Land",
}
_PROTOCOLS = {-1: "nothing", 1: "MAVLink 1", 2: "MAVLink 2"}


def _timeout(name: str, value: Number, seen: Observation) -> Finding:
    told = f"when setpoints stop, the vehicle flies on for {value:g} s"
    if value > _LONGEST_S:
        return stops(name, f"{told}: too long", f"set {name} 3, or 1")
    if value < _SHORT_S:
        return warns(name, f"{told}: a short gap in the link stops it", f"set {name} 1")
    return fine(name, told)


def _guided_options(name: str, value: Number, seen: Observation) -> Finding:
    if int(value) & _LOOSE:
        told = f"{value:g}: position or velocity is not stabilized in GUIDED"
        return stops(name, told, f"set {name} {int(value) & ~_LOOSE}")
    return fine(name, f"{value:g}")


def _failsafe_options(name: str, value: Number, seen: Observation) -> Finding:
    if int(value) & _CONTINUE_IN_GUIDED:
        return fine(name, "losing the remote control does not end GUIDED")
    return fine(name, "losing the remote control ends GUIDED, as FS_THR_ENABLE says")


def _checks(name: str, value: Number, seen: Observation) -> Finding:
    if value == _ALL_CHECKS:
        return fine(name, "all checks before arming")
    told = "no checks before arming: it arms without knowing where it is" if not value else "some checks only"
    return warns(name, told, f"set {name} 1")


def _skipped_checks(name: str, value: Number, seen: Observation) -> Finding:
    if not value:
        return fine(name, "all checks before arming")
    return warns(name, "checks before arming are skipped", f"set {name} 0")


def _ground_station(name: str, value: Number, seen: Observation) -> Finding:
    if value == seen.system_id:
        return fine(name, "this program counts as the ground station, whose loss FS_GCS_ENABLE is about")
    return fine(name, f"system {value:g} is the ground station")


def _baud(name: str, value: Number, seen: Observation) -> Finding:
    return fine(name, f"{value:g} (thousands of baud)")


_GROUND = one_of(_GROUND_LOSS, "when the ground station is lost")
_PROTOCOL = one_of(_PROTOCOLS, "speaks", unsafe=(1,), instead="2")

RULES: Mapping[str, Rule] = {
    "GUID_TIMEOUT": _timeout,
    "GUID_OPTIONS": _guided_options,
    "FS_GCS_ENABLE": _GROUND,
    "FS_OPTIONS": _failsafe_options,
    "ARMING_CHECK": _checks,
    "ARMING_SKIPCHK": _skipped_checks,
    "SYSID_MYGCS": _ground_station,
    "MAV_GCS_SYSID": _ground_station,
    "WPNAV_SPEED": at_least(200.0, "cm/s", "horizontal speed limit", instead="1000"),
    "WPNAV_SPEED_UP": at_least(50.0, "cm/s", "climb limit", instead="250"),
    "WPNAV_SPEED_DN": at_least(50.0, "cm/s", "descent limit", instead="150"),
    "WPNAV_ACCEL": at_least(100.0, "cm/s²", "horizontal acceleration limit", instead="250"),
    "WPNAV_ACCEL_Z": at_least(50.0, "cm/s²", "vertical acceleration limit", instead="100"),
    "WP_SPD": at_least(2.0, "m/s", "horizontal speed limit", instead="10"),
    "WP_SPD_UP": at_least(0.5, "m/s", "climb limit", instead="2.5"),
    "WP_SPD_DN": at_least(0.5, "m/s", "descent limit", instead="1.5"),
    "WP_ACC": at_least(1.0, "m/s²", "horizontal acceleration limit", instead="2.5"),
    "WP_ACC_Z": at_least(0.5, "m/s²", "vertical acceleration limit", instead="1"),
    "SERIAL1_PROTOCOL": _PROTOCOL,
    "SERIAL1_BAUD": _baud,
    "SERIAL2_PROTOCOL": _PROTOCOL,
    "SERIAL2_BAUD": _baud,
}
"""What to make of each."""
