from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.errors import InputError
from companion.link.parameter_changes import Difference, changes_to, differences
from companion.link.parameter_encoding import Parameter, ParameterType
from companion.link.parameter_file import read_parameter_file, write_parameter_file, written

INT32, REAL32 = ParameterType.INT32, ParameterType.REAL32
QGC = """# Onboard parameters for Vehicle 1
#
# Stack: PX4 Pro
#
# Vehicle-Id Component-Id Name Value Type
1\t1\tBAT_LOW_THR\t0.300000011920928955\t9
1\t1\tSYS_AUTOSTART\t4001\t6
1\t154\tMNT_MODE\t2\t6
"""
VEHICLE = {
    "SYS_AUTOSTART": Parameter("SYS_AUTOSTART", 4001, INT32),
    "BAT_LOW_THR": Parameter("BAT_LOW_THR", 0.15, REAL32),
    "FLAG": Parameter("FLAG", 1, ParameterType.INT8),
}


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "some.params"


def test_what_qgroundcontrol_writes_is_read(file: Path) -> None:
    file.write_text(QGC)
    low, start, mount = read_parameter_file(file)
    assert (low.name, low.type, low.component) == ("BAT_LOW_THR", REAL32, 1)
    assert low.value == pytest.approx(0.3)
    assert (start.value, start.type, start.line) == (4001.0, INT32, 7)
    assert start.is_of_autopilot
    assert not mount.is_of_autopilot


@pytest.mark.parametrize(
    "line",
    ["RTL_ALT,1500", "RTL_ALT 1500", "RTL_ALT          1500.000000", "RTL_ALT\t1500", "RTL_ALT=1500  # cm"],
)
def test_names_and_values_are_read_as_others_write_them(file: Path, line: str) -> None:
    file.write_text(f"#NOTE: a note\r\n\r\n{line}\r\n")
    (only,) = read_parameter_file(file)
    assert (only.name, only.value, only.type, only.component) == ("RTL_ALT", 1500.0, None, None)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("RTL_ALT", "line 1: 'RTL_ALT' is no name and value"),
        ("A 1\nRTL_ALT,high", "line 2: value"),
        ("RTL-ALT,1", "line 1: name"),
        ("A_NAME_OF_SEVENTEEN_, 1", "line 1: name"),
        ("1\t1\tA\t2\t77", "line 1: type"),
        ("A,1\nB,2\nA,3", "line 3: A is in line 1 too"),
        ("# nothing", "no parameters in it"),
    ],
)
def test_a_file_that_is_wrong_is_told_with_its_line(file: Path, text: str, told: str) -> None:
    file.write_text(text)
    with pytest.raises(InputError, match=told):
        read_parameter_file(file)


def test_a_file_that_is_no_text_or_not_there_is_told(file: Path) -> None:
    with pytest.raises(InputError, match="No such file"):
        read_parameter_file(file)
    file.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="not a text file"):
        read_parameter_file(file)


def test_what_is_written_is_what_qgroundcontrol_reads(file: Path) -> None:
    write_parameter_file(file, VEHICLE.values(), system_id=3, about=["Stack: PX4 Pro"])
    assert file.read_text().splitlines() == [
        "# Onboard parameters for Vehicle 3",
        "#",
        "# Stack: PX4 Pro",
        "#",
        "# Vehicle-Id Component-Id Name Value Type",
        "3\t1\tBAT_LOW_THR\t0.15\t9",
        "3\t1\tFLAG\t1\t2",
        "3\t1\tSYS_AUTOSTART\t4001\t6",
    ]
    assert changes_to(VEHICLE, read_parameter_file(file), file) == []


@given(st.floats(width=32, allow_nan=False, allow_infinity=False))
def test_a_float_is_written_with_all_its_digits(value: float) -> None:
    import numpy as np

    assert np.float32(written(value)) == np.float32(value)


def test_only_what_differs_is_set_and_in_the_vehicles_types(file: Path) -> None:
    file.write_text("SYS_AUTOSTART 4001\nBAT_LOW_THR 0.2\nFLAG 0.0\n")
    changes = changes_to(VEHICLE, read_parameter_file(file), file)
    assert changes == [Parameter("BAT_LOW_THR", 0.2, REAL32), Parameter("FLAG", 0, ParameterType.INT8)]
    assert isinstance(changes[1].value, int)


def test_what_a_vehicle_cannot_take_is_refused_all_at_once(file: Path) -> None:
    file.write_text("NONE 1\nFLAG 0.5\n1\t1\tSYS_AUTOSTART\t1\t9\n")
    with pytest.raises(InputError) as refusal:
        changes_to(VEHICLE, read_parameter_file(file), file)
    told = str(refusal.value)
    assert "line 1: the vehicle has no parameter NONE" in told
    assert "line 2: FLAG is INT8, which 0.5 is not" in told
    assert "line 3: SYS_AUTOSTART is INT32 on the vehicle, not REAL32" in told


def test_differences_are_those_that_a_vehicle_would_notice() -> None:
    found = differences({"A": 0.3, "B": 1, "C": 2}, {"A": 0.30000001, "B": 2, "D": 5.0})
    assert found == [Difference("B", 1, 2), Difference("C", 2, None), Difference("D", None, 5.0)]
