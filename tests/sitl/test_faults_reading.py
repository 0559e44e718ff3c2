from pathlib import Path

import pytest

from sitl.errors import ConfigError
from sitl.faults.kinds import KINDS, Gust, MotorWeak, Phase
from sitl.faults.reading import describe_kinds, load_faults, parse_fault, write_fault

MINIMAL = {
    "motor_weak": "motor=1,effectiveness=0.5",
    "motor_dead": "motor=1",
    "battery_collapse": "remaining=0.1",
    "compass_error": "error_deg=20",
    "telemetry_late": "delay_s=0.3",
    "telemetry_lossy": "share=0.3",
    "telemetry_duplicated": "share=0.3",
    "telemetry_reordered": "share=0.3",
    "telemetry_corrupted": "share=0.3",
    "message_lost": "message=HEARTBEAT",
    "clock_jump": "step_s=2",
    "uplink_late": "delay_s=0.3",
    "uplink_lossy": "share=0.3",
}


def test_a_line_says_what_when_and_how_long() -> None:
    fault = parse_fault(" motor_weak: motor=2, effectiveness=0.6, after=takeoff, at_s=12, lasts_s=3 ")
    assert fault == MotorWeak(motor=2, effectiveness=0.6, after=Phase.TAKEOFF, at_s=12.0, lasts_s=3.0)


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_is_written_as_it_is_read(kind: str) -> None:
    fault = parse_fault(f"{kind}:after=landing,at_s=1.5,{MINIMAL.get(kind, '')}")
    assert parse_fault(write_fault(fault)) == fault
    assert fault.kind == kind


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("motor_wek:motor=2", "'motor_wek' is no kind of fault; there are motor_weak, motor_dead"),
        ("motor_weak:motor=2", "effectiveness: missing"),
        ("motor_weak:motor=0,effectiveness=1", "motor: Input should be greater than or equal to 1 (got '0')"),
        ("gust:north=2", "gust has no such key; it has after, at_s, lasts_s, north_m_s"),
        ("gust:north_m_s", "the form is KIND:KEY=VALUE"),
        ("gust:north_m_s=1,north_m_s=2", "'north_m_s=2' is wrong here"),
        ("gust:kind=reboot", "'kind=reboot' is wrong here"),
        ("gust:north_m_s=nan", "north_m_s: Input should be a finite number"),
        ("gust:after=lunch", "after: Input should be 'boot', 'takeoff', 'setpoints' or 'landing'"),
        ("", "'' is no kind of fault"),
    ],
)
def test_a_wrong_line_is_told_what_is_wrong(text: str, complaint: str) -> None:
    with pytest.raises(ConfigError) as refused:
        parse_fault(text)
    assert complaint in str(refused.value)


def test_a_file_has_several(tmp_path: Path) -> None:
    script = tmp_path / "storm.yaml"
    script.write_text(
        "description: Two gusts.\n"
        "faults:\n"
        "- {kind: gust, north_m_s: 6, after: setpoints, lasts_s: 2}\n"
        "- {kind: gust, east_m_s: -6, after: setpoints, at_s: 4}\n"
    )
    first, second = load_faults(script)
    assert first == Gust(north_m_s=6.0, after=Phase.SETPOINTS, lasts_s=2.0)
    assert second.at_s == 4.0


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        ("faults:\n- {kind: gist}\n", "faults.0"),
        ("faults:\n- {kind: gust, speed: 2}\n", "faults.0.gust.speed: unknown key"),
        ("fault: []\n", "missing"),
    ],
)
def test_a_wrong_file_is_told_where(tmp_path: Path, content: str, complaint: str) -> None:
    script = tmp_path / "wrong.yaml"
    script.write_text(content)
    with pytest.raises(ConfigError) as refused:
        load_faults(script)
    assert complaint in str(refused.value)
    assert "wrong.yaml" in str(refused.value)


def test_the_help_has_a_line_for_every_kind() -> None:
    lines = describe_kinds().splitlines()
    assert [line.partition("  ")[0].partition(":")[0] for line in lines] == list(KINDS)
    assert lines[0] == "motor_weak:motor,effectiveness  a rotor gives a part of its thrust"
