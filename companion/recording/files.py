"""Recordings from files of any kind that we know."""

from pathlib import Path

from companion.recording.mcap_file import read_mcap
from companion.recording.series import Recording


def read_recording(path: Path, *, system_id: int | None = None) -> Recording:
    """Read a flight log or a data set: `.tlog`, `.tlog.xz`, `.ulg`; anything else is read as MCAP.

    Args:
        path: the file.
        system_id: MAVLink id of the vehicle, for a telemetry log that holds several; the card's otherwise.

    Raises:
        InputError: the file cannot be read, is damaged or too large, or has not what a recording needs.
    """
    # What reads logs takes a while to import, and a flight does not need it.
    name = path.name.lower()
    if name.endswith((".tlog", ".tlog.xz")):
        from companion.recording.tlog_file import read_tlog

        return read_tlog(path, system_id)
    if name.endswith(".ulg"):
        from companion.recording.ulog_file import read_ulog

        return read_ulog(path)
    return read_mcap(path)
