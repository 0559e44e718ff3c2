"""Telemetry logs (`.tlog`, `.tlog.xz`) as recordings."""

from pathlib import Path

from companion.errors import InputError
from companion.recording.series import Recording


def read_tlog(path: Path, system_id: int | None = None) -> Recording:
    """Not there yet."""
    raise InputError(f"{path}: .tlog cannot be read yet")
