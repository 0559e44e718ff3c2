"""Before a flight: what the autopilot would do if the companion stalled, and whether that is safe."""

import pytest
from tampered_link import TamperedLink, connected, virtually, without

from companion.autopilot import Identity, identify
from companion.doctor.failsafe import failsafe_findings, judge_failsafe, require_safe
from companion.doctor.finding import Finding, Severity
from companion.errors import FlightError
from companion.link.dialect import mavlink

PX4 = Identity("PX4", "1.16.1", takes_setpoints=True)
ARDUPILOT = Identity("ArduPilot", "4.6.0", takes_setpoints=True)


def findings_of(link: TamperedLink, **parameters: float) -> list[Finding]:
    async def scenario() -> list[Finding]:
        async with connected(link) as pilot:
            for name, value in parameters.items():
                link.firmware.set_parameter(name, value)
            return await failsafe_findings(pilot.connection, await identify(pilot.connection))

    return virtually(scenario())


@pytest.mark.parametrize("action", [2, 6, 7, 1])
def test_a_px4_that_would_fall_or_drift_is_not_flown(action: int) -> None:
    with pytest.raises(FlightError, match=rf"^COM_OBL_RC_ACT is {action}: .* First set COM_OBL_RC_ACT 5"):
        require_safe(findings_of(TamperedLink(), COM_OBL_RC_ACT=action))


@pytest.mark.parametrize(
    ("action", "severity"),
    [(0, Severity.WARNS), (3, Severity.FINE), (4, Severity.FINE), (5, Severity.FINE)],
)
def test_a_stock_px4_and_a_better_one_are_flown(action: int, severity: Severity) -> None:
    findings = findings_of(TamperedLink(), COM_OBL_RC_ACT=action)
    require_safe(findings)
    assert [finding.severity for finding in findings] == [Severity.FINE, severity]


def test_with_a_remote_control_its_pilot_catches_what_drifts() -> None:
    require_safe(judge_failsafe(PX4, {"COM_OBL_RC_ACT": 1}, has_remote_control=True))
    with pytest.raises(FlightError):
        require_safe(judge_failsafe(PX4, {"COM_OBL_RC_ACT": 2}, has_remote_control=True))


def test_an_ardupilot_that_flies_on_for_long_is_not_flown() -> None:
    require_safe(findings_of(TamperedLink(vehicle="arducopter_sitl")))
    require_safe(judge_failsafe(ARDUPILOT, {"GUID_TIMEOUT": 3.0}, has_remote_control=False))
    with pytest.raises(FlightError, match=r"^GUID_TIMEOUT is 5: .* First set GUID_TIMEOUT 3"):
        require_safe(findings_of(TamperedLink(vehicle="arducopter_sitl"), GUID_TIMEOUT=5.0))


def test_a_vehicle_that_tells_no_parameters_is_flown_with_a_warning() -> None:
    link = TamperedLink()
    link.incoming = without(mavlink.MAVLink_param_value_message)
    findings = findings_of(link)
    require_safe(findings)
    assert [finding.severity for finding in findings] == [Severity.WARNS, Severity.WARNS]


def test_an_autopilot_of_another_kind_is_not_asked() -> None:
    assert (
        judge_failsafe(Identity("Crazyflie", None, takes_setpoints=None), {}, has_remote_control=False) == []
    )
