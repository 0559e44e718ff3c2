"""PX4's own logs (`.ulg`) as recordings.

Format: https://docs.px4.io/main/en/dev_log/ulog_file_format.html
Topics are those of PX4 1.14 to 1.16: `vehicle_local_position`, `vehicle_attitude`, `trajectory_setpoint` and,
where the log has them, `vehicle_angular_velocity` and `vehicle_status`. All times are the autopilot's own.
"""

import contextlib
import io
import struct
from pathlib import Path

import numpy as np
from pyulog import ULog
from pyulog.exceptions import ULogException

from companion.errors import InputError
from companion.recording.bounded_file import read_bytes
from companion.recording.card import log_name, read_card
from companion.recording.clock_map import rising
from companion.recording.series import Provenance, Recording, ReferenceSeries, StateSeries, rows
from companion.recording.states import Sampled, body_rates, joined_states, roll_pitch_yaw

POSITION, ATTITUDE, SETPOINT = "vehicle_local_position", "vehicle_attitude", "trajectory_setpoint"
RATES, STATUS = "vehicle_angular_velocity", "vehicle_status"
OFFBOARD = 14
"""`vehicle_status.nav_state` while setpoints come from a companion; in other modes PX4 makes its own."""

UNREADABLE = (ULogException, struct.error, ValueError, KeyError, IndexError, TypeError, OverflowError)
"""What pyulog raises on bytes that are no ULog, or half of one."""


def read_ulog(path: Path) -> Recording:
    """The flight in a PX4 log, on the autopilot's clock; references are those of OFFBOARD flight.

    Raises:
        InputError: the file cannot be read, is no ULog, or lacks a topic.
    """
    content = read_bytes(path)
    try:
        log = _parsed(content)
        states, references = _states(log), _references(log)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
    return Recording(
        provenance=Provenance(vehicle=read_card(path).vehicle or log_name(path), strategy=""),
        states=states,
        references=references,
        events=tuple((line.timestamp * 1e-6, f"vehicle: {line.message}") for line in log.logged_messages),
    )


class _File(io.BytesIO):
    """The bytes of a log, such that going back by what was asked for undoes a read that came up short.

    pyulog goes back so over what it takes for damage, and would read the end of a cut file for ever.
    """

    _missing = 0

    def read(self, size: int | None = -1, /) -> bytes:
        content = super().read(size)
        self._missing = max(0, (size or 0) - len(content))
        return content

    def seek(self, offset: int, whence: int = io.SEEK_SET, /) -> int:
        return super().seek(offset + self._missing if whence == io.SEEK_CUR else offset, whence)


def _parsed(content: bytes) -> ULog:
    topics = [POSITION, ATTITUDE, SETPOINT, RATES, STATUS]
    try:
        with contextlib.redirect_stdout(io.StringIO()):  # pyulog prints what it thinks of a damaged file
            return ULog(_File(content), topics)
    except UNREADABLE as error:
        raise InputError(f"damaged, or no ULog of PX4 ({error})") from error


def _logged(log: ULog, topic: str) -> bool:
    return any(one.name == topic and one.multi_id == 0 for one in log.data_list)


def _sampled(log: ULog, topic: str, *names: str) -> Sampled:
    """The fields called `names` of a topic, and their times (s)."""
    if not _logged(log, topic):
        raise InputError(f"the log has no topic {topic}: have PX4 log it (SDLOG_PROFILE)")
    data = log.get_dataset(topic).data
    missing = [name for name in ("timestamp", *names) if name not in data]
    if missing:
        raise InputError(f"topic {topic} has no field {missing[0]}: logs of PX4 1.14 to 1.16 are read")
    with np.errstate(invalid="ignore"):  # of a damaged log, a field may hold anything
        columns = [np.asarray(data[name], dtype=np.float64) for name in names]
    return np.asarray(data["timestamp"] * 1e-6), np.column_stack(columns)


def _vector(name: str, length: int = 3) -> list[str]:
    return [f"{name}[{place}]" for place in range(length)]


def _states(log: ULog) -> StateSeries:
    motion = _sampled(log, POSITION, "x", "y", "z", "vx", "vy", "vz")
    time_s, quaternion = _sampled(log, ATTITUDE, *_vector("q", 4))
    if _logged(log, RATES):
        rates = _sampled(log, RATES, *_vector("xyz"))
    else:
        rates = time_s, body_rates(time_s, quaternion)
    return joined_states(motion, (time_s, roll_pitch_yaw(quaternion)), rates)


def _references(log: ULog) -> ReferenceSeries:
    names = (*_vector("position"), *_vector("velocity"), *_vector("acceleration"), "yaw")
    time_s, sent = _sampled(log, SETPOINT, *names)
    series = ReferenceSeries(time_s, sent[:, 0:3], sent[:, 3:6], sent[:, 6:9], sent[:, 9])
    if _logged(log, STATUS):
        changed_s, nav_state = _sampled(log, STATUS, "nav_state")
        before = np.searchsorted(changed_s, time_s, side="right") - 1
        series = rows(series, np.flatnonzero((before >= 0) & (nav_state[before, 0] == OFFBOARD)))
    return rows(series, rising(series.time_s))
