"""Files that mean more than they hold, or hold more than they may."""

from collections.abc import Callable
from pathlib import Path

import pytest

from companion.bounded_file import read_bounded
from companion.errors import InputError
from companion.flight.guard_file import read_guard_limits
from companion.link.parameter_file import read_parameter_file
from companion.recording.bounded_file import read_bytes
from sitl.conditions import load_conditions
from sitl.errors import ConfigError

BOMB = "a: &a [x, x]\nb: &b [*a, *a]\nc: [*b, *b]\n"


def test_a_file_of_the_largest_size_is_read_and_no_larger_one(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_bytes(b"12345")
    assert read_bounded(file, 5) == b"12345"
    with pytest.raises(InputError, match="larger than"):
        read_bounded(file, 4)


def test_what_is_no_file_is_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        read_bounded(tmp_path, 5)


def test_a_device_without_an_end_is_not_read_for_ever() -> None:
    with pytest.raises(InputError, match="larger than 1 MB"):
        read_bounded(Path("/dev/zero"), 1_000_000)
    assert read_bytes(Path("/dev/zero")) == b""


@pytest.mark.parametrize("read", [load_conditions, read_guard_limits])
@pytest.mark.parametrize(
    ("text", "told"),
    [
        (BOMB, "aliases"),
        ("[" * 3000, "too deep"),
        ("a: 2001-99-99", "month"),
        ("a: 0b_", "YAML"),
        ("a: " + "9" * 5000, "digits"),
        ("#" + "x" * 100_000, "larger than"),
    ],
)
def test_yaml_that_would_break_or_hold_up_a_reader_is_refused(
    tmp_path: Path, read: Callable[[Path], object], text: str, told: str
) -> None:
    file = tmp_path / "hostile.yaml"
    file.write_text(text)
    with pytest.raises((InputError, ConfigError), match=told):
        read(file)


def test_a_parameter_type_of_a_thousand_digits_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "hostile.params"
    file.write_text("1\t1\tMPC_XY_P\t0.95\t" + "9" * 5000)
    with pytest.raises(InputError, match="line 1: type"):
        read_parameter_file(file)
