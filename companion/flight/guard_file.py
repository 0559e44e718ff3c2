"""The guard's limits from a YAML file, such as `config/guard.yaml`, which describes the keys."""

from pathlib import Path

from companion.flight.guard import GuardLimits
from companion.yaml_file import read_settings


def read_guard_limits(path: Path) -> GuardLimits:
    """The limits in `path`; keys that it leaves out keep their defaults.

    Raises:
        InputError: it cannot be read, or a value is wrong; names the file, the key and what is expected.
    """
    return read_settings(path, GuardLimits(), shown_in="config/guard.yaml")
