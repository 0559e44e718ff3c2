from typing import cast

import pytest
from mavlink_fakes import FakeFirmware

from sitl.faults.kinds import Fault, Gust, Phase, Reboot
from sitl.faults.schedule import Schedule
from sitl.firmware.interface import Autopilot, Landed, Mode

GROUND = FakeFirmware(landed=Landed.ON_GROUND)
CLIMBING = FakeFirmware(landed=Landed.TAKING_OFF, mode=Mode.TAKEOFF)
FOLLOWING = FakeFirmware(landed=Landed.IN_AIR, mode=Mode.OFFBOARD)
LANDING = FakeFirmware(landed=Landed.LANDING, mode=Mode.LAND)


def update(schedule: Schedule, time_s: float, firmware: FakeFirmware) -> tuple[list[Fault], list[Fault]]:
    change = schedule.update(time_s, cast(Autopilot, firmware))
    return [each.fault for each in change.begun], [each.fault for each in change.ended]


def test_a_fault_begins_and_ends_in_time() -> None:
    gust = Gust(at_s=1.0, lasts_s=2.0)
    schedule = Schedule([gust])
    assert update(schedule, 0.99, GROUND) == ([], [])
    assert update(schedule, 1.0, GROUND) == ([gust], [])
    assert update(schedule, 2.99, GROUND) == ([], [])
    assert [each.since_s for each in schedule.active] == [1.0]
    assert update(schedule, 3.0, GROUND) == ([], [gust])
    assert schedule.active == ()
    assert schedule.is_idle


@pytest.mark.parametrize(
    ("phase", "firmware"),
    [(Phase.TAKEOFF, CLIMBING), (Phase.SETPOINTS, FOLLOWING), (Phase.LANDING, LANDING)],
)
def test_a_fault_waits_for_its_phase(phase: Phase, firmware: FakeFirmware) -> None:
    fault = Reboot(after=phase, at_s=0.5)
    schedule = Schedule([fault])
    assert update(schedule, 10.0, GROUND) == ([], [])
    assert update(schedule, 20.0, firmware) == ([], [])
    assert update(schedule, 20.4, GROUND) == ([], [])
    assert update(schedule, 20.5, GROUND) == ([fault], [])


def test_a_phase_begins_once() -> None:
    schedule = Schedule([Gust(after=Phase.SETPOINTS, at_s=5.0)])
    update(schedule, 1.0, FOLLOWING)
    update(schedule, 3.0, LANDING)
    assert update(schedule, 5.0, FOLLOWING)[0] == []
    assert len(update(schedule, 6.0, FOLLOWING)[0]) == 1


def test_an_injected_fault_begins_at_once_and_is_cleared_by_kind() -> None:
    schedule = Schedule()
    gust, reboot = Gust(at_s=100.0), Reboot()
    schedule.inject(gust)
    schedule.inject(reboot)
    assert update(schedule, 2.0, GROUND) == ([gust, reboot], [])
    schedule.clear(lambda fault: isinstance(fault, Gust))
    assert not schedule.is_idle
    assert update(schedule, 2.1, GROUND) == ([], [gust])
    assert [each.fault for each in schedule.active] == [reboot]
