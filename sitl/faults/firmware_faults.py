"""What faults do to the autopilot itself: satellites, the pilot's hands, the kill switch."""

from collections.abc import Sequence

from sitl.faults import kinds
from sitl.faults.schedule import Active, Change
from sitl.firmware.interface import Autopilot, Mode
from sitl.firmware.pilot import Sticks


def begin_faults(autopilot: Autopilot, change: Change) -> None:
    """Do what happens once, as a fault begins."""
    for each in change.begun:
        match each.fault:
            case kinds.RotorsStopped():
                autopilot.terminate()
            case kinds.PilotMode(mode=mode):
                autopilot.move_sticks(Sticks())
                autopilot.set_mode(Mode[mode])


def keep_faults(autopilot: Autopilot, active: Sequence[Active]) -> None:
    """Do what goes on while a fault is there: a pilot is heard until that ends."""
    autopilot.hear_satellites(heard=not any(isinstance(each.fault, kinds.GpsLost) for each in active))
    for each in active:
        match each.fault:
            case kinds.PilotMode():
                autopilot.move_sticks(Sticks())
            case kinds.PilotSticks(roll=roll, pitch=pitch, climb=climb, yaw=yaw):
                autopilot.move_sticks(Sticks(roll, pitch, climb, yaw))
