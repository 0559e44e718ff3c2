"""Checks of the vehicle itself: what it is, where it believes to be, whether it would arm."""

from collections.abc import Iterator

from companion.doctor.finding import Finding, fine, stops, warns
from companion.doctor.observation import Observation

_FLOWN = ("PX4", "ArduPilot")
_FOLLOWING = ("OFFBOARD", "GUIDED")
_EMPTY, _LOW = 0.1, 0.3
_FIX_3D = 3
_NEAR_REJECTION = 0.8


def identity(seen: Observation) -> Iterator[Finding]:
    """It is a multirotor that this program flies."""
    told = f"{seen.identity.autopilot} {seen.identity.version or 'of unknown version'}, {seen.vehicle_type}"
    told += f", system {seen.system_id}" + (f", uid {seen.identity.uid}" if seen.identity.uid else "")
    if seen.identity.autopilot not in _FLOWN:
        yield stops("vehicle", told, f"connect to one of {' or '.join(_FLOWN)}")
    elif not seen.is_multirotor:
        yield stops("vehicle", told, "only multirotors are flown: check the airframe or frame class")
    elif seen.identity.takes_setpoints is False:
        yield stops("vehicle", f"{told}: takes no position setpoints", "install a build that does")
    elif seen.identity.version is None:
        yield warns("vehicle", told, "it did not answer for AUTOPILOT_VERSION: check that it hears us")
    else:
        yield fine("vehicle", told)


def mode(seen: Observation) -> Iterator[Finding]:
    """Who has the vehicle now."""
    if not seen.armed:
        yield fine("mode", f"{seen.mode}, disarmed")
    elif seen.mode in _FOLLOWING:
        yield warns("mode", f"{seen.mode}, armed: another program may steer it", "end that program first")
    else:
        yield fine("mode", f"{seen.mode}, armed")


def estimator(seen: Observation) -> Iterator[Finding]:
    """It knows where it is."""
    wait = "wait for it, under open sky and at rest; indoors give it another source of position"
    own = seen.health.estimator
    if own is not None and own.missing:
        yield stops("estimator", f"has no {', '.join(own.missing)}", wait)
    elif not seen.health.has_position:
        yield stops("estimator", "tells no position", wait)
    elif own is None:
        yield fine("estimator", "tells a position (and nothing of its health)")
    elif own.gps_glitch:
        yield warns("estimator", "GPS contradicts the rest", "wait, or move away from what disturbs it")
    elif own.worst_ratio > _NEAR_REJECTION:
        told = f"innovation test ratio {own.worst_ratio:.2f}; from 1 on, a measurement is rejected"
        yield warns("estimator", told, "calibrate compass and accelerometers, away from steel")
    else:
        yield fine("estimator", f"position and velocity valid, innovation test ratio {own.worst_ratio:.2f}")


def position_sources(seen: Observation) -> Iterator[Finding]:
    """GPS and home, where they matter."""
    if seen.health.gps_fix is not None:
        told = f"fix type {seen.health.gps_fix}, {seen.health.satellites} satellites"
        if seen.health.gps_fix >= _FIX_3D:
            yield fine("GPS", told)
        else:
            yield warns("GPS", told, "fine indoors with another source of position; else wait for a 3-D fix")
    if seen.health.has_home:
        yield fine("home", "set")
    else:
        yield warns(
            "home", "not set: there is nowhere to return to", "wait for a GPS fix; arming sets it too"
        )


def arming(seen: Observation) -> Iterator[Finding]:
    """It would arm."""
    said = "; ".join(seen.complaints)
    if seen.armed:
        yield fine("arming", "armed already")
        if said:
            yield warns("said", said, "see to it: these are the vehicle's own words")
    elif seen.health.ready_to_arm is None:
        yield warns("arming", "it does not tell whether it would arm", "check that SYS_STATUS is sent")
    elif not seen.health.ready_to_arm:
        yield stops(
            "arming",
            f"its checks before arming fail: {said or 'it gives no reason in words'}",
            "see to what it names; a ground station shows the checks one by one",
        )
    else:
        yield fine("arming", "its checks before arming pass")
        if said:
            yield warns("said", said, "see to it: these are the vehicle's own words")


def battery(seen: Observation) -> Iterator[Finding]:
    """There is charge for a flight."""
    if seen.health.battery is None:
        yield warns(
            "battery", "it does not tell its charge", "calibrate the power module, and watch the time"
        )
    elif seen.health.battery < _EMPTY:
        yield stops("battery", f"{seen.health.battery:.0%}", "charge it")
    elif seen.health.battery < _LOW:
        yield warns("battery", f"{seen.health.battery:.0%}", "charge it, or fly a short trajectory")
    else:
        yield fine("battery", f"{seen.health.battery:.0%}")
