from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from command_line import Run


def test_more_vehicles_than_there_are_system_ids_is_wrong_use(companion: "Run") -> None:
    ran = companion("sitl", "--system-id", 250, "--instances", 10)
    assert ran.status == 2
    assert "beyond 255" in ran.err


def test_an_autopilot_that_there_is_not_is_wrong_use(companion: "Run") -> None:
    ran = companion("sitl", "--autopilot", "betaflight")
    assert ran.status == 2
    assert "ardupilot" in ran.err


def test_the_kinds_of_fault_are_listed(companion: "Run") -> None:
    ran = companion("sitl", "--fault-kinds")
    assert ran.status == 0
    assert "motor_weak:motor,effectiveness  a rotor gives a part of its thrust" in ran.out


def test_a_fault_that_there_is_not_is_wrong_use(companion: "Run") -> None:
    ran = companion("sitl", "--fault", "motor_weak:motor=1")
    assert ran.status == 2
    assert "effectiveness: missing" in ran.err
