"""PX4's own logs (`.ulg`) as recordings."""

from pathlib import Path

from companion.errors import InputError
from companion.recording.series import Recording


def read_ulog(path: Path) -> Recording:
    """Not there yet."""
    raise InputError(f"{path}: .ulg cannot be read yet")
