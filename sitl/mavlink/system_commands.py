"""Commands about the autopilot itself: its checks, its storage, its end and its next beginning."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from pymavlink.dialects.v20 import common as mavlink

from sitl.mavlink import failures
from sitl.mavlink.commands import Command, whole
from sitl.mavlink.flavour import Execute

if TYPE_CHECKING:
    from sitl.mavlink.session import Session

_NOTHING = 0
_REBOOT = (1, 3)
"""Reboot, or reboot into the boot loader, which there is none of."""


def _terminate(session: "Session", command: Command) -> int:
    if not command.params[0] > 0.5:
        return mavlink.MAV_RESULT_DENIED
    return session.result(session.firmware.terminate())


def _run_checks(session: "Session", command: Command) -> int:
    return session.result(session.firmware.check())


def _store(session: "Session", command: Command) -> int:
    """Parameters are kept without being asked; only in flight is that refused."""
    if session.firmware.armed:
        return mavlink.MAV_RESULT_TEMPORARILY_REJECTED
    return mavlink.MAV_RESULT_ACCEPTED


def _reboot(refused: int) -> Execute:
    def execute(session: "Session", command: Command) -> int:
        wanted = whole(command.params[0])
        if wanted in _REBOOT and not session.firmware.armed:
            session.reboot()
            return mavlink.MAV_RESULT_ACCEPTED
        return mavlink.MAV_RESULT_ACCEPTED if wanted == _NOTHING else refused

    return execute


_COMMANDS: Mapping[int, Execute] = {
    mavlink.MAV_CMD_DO_FLIGHTTERMINATION: _terminate,
    mavlink.MAV_CMD_RUN_PREARM_CHECKS: _run_checks,
}
PX4_COMMANDS: Mapping[int, Execute] = {
    **_COMMANDS,
    mavlink.MAV_CMD_INJECT_FAILURE: failures.inject,
    mavlink.MAV_CMD_PREFLIGHT_STORAGE: _store,
    mavlink.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN: _reboot(mavlink.MAV_RESULT_DENIED),
}
ARDUPILOT_COMMANDS: Mapping[int, Execute] = {
    **_COMMANDS,
    mavlink.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN: _reboot(mavlink.MAV_RESULT_FAILED),
}
