"""A vehicle whose failsafe is none is not flown, unless one insists."""

import pytest
from command_line import Run

from companion.cli import flying
from companion.doctor.finding import Finding, stops


async def _unsafe(*_: object) -> list[Finding]:
    return [stops("COM_OBL_RC_ACT is 7", "it falls", "set COM_OBL_RC_ACT 5")]


def test_an_unsafe_failsafe_is_refused_before_arming(companion: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(flying, "failsafe_findings", _unsafe)
    ran = companion("fly", "star", "--connect", "sitl://bebop2", "--strategy", "baseline")
    assert ran.status == 1
    assert "COM_OBL_RC_ACT is 7: it falls. First set COM_OBL_RC_ACT 5" in ran.err
    assert "--accept-failsafe" in ran.err
    assert "arming" not in ran.out


def test_who_insists_flies(companion: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(flying, "failsafe_findings", _unsafe)
    ran = companion(
        "fly", "star", "--connect", "sitl://bebop2", "--strategy", "baseline", "--accept-failsafe"
    )
    assert ran.status == 0
    assert "COM_OBL_RC_ACT is 7: it falls" in ran.out
