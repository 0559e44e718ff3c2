"""The files of one flight, written while it is flown: `FLIGHT.mcap`, and the raw link in `FLIGHT.tlog`.

Twice a second a task ends the chunk and has a thread write it, down to the disk. So a crash or a power cut
loses at most the last second, and a slow disk does not hold up the control loop. What a full disk does not
take waits in memory; when that is full, too, records are left out, and the flight goes on.
"""

import asyncio
import fcntl
import io
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from itertools import chain, count
from pathlib import Path
from typing import Any, TypeAlias

from companion import clock
from companion.errors import InputError
from companion.link.tasks import background_tasks
from companion.recording.mcap_writer import McapWriter
from companion.recording.series import Provenance
from companion.recording.spool import Spool
from companion.recording.tlog_frames import stamped
from companion.recording.topics import Fields

_PERIOD_S = 0.5
_LINK = ".tlog"
Tell: TypeAlias = Callable[[str], None]


@asynccontextmanager
async def flight_log(path: Path, provenance: Provenance, tell: Tell) -> AsyncIterator["FlightLog"]:
    """Write the files of a flight until the block ends.

    Args:
        path: of the MCAP file; the `.tlog` is beside it, by the same name. What another flight is writing
            is left to it: then it is `FLIGHT-2.mcap`.
        provenance: what the flight is.
        tell: told once when the files cannot be written as they should, and once when they can again.

    Raises:
        InputError: a file cannot be opened.
    """
    path, *files = await asyncio.to_thread(_opened, path)
    mcap, tlog = map(Spool, files)
    log = FlightLog(path, mcap, tlog, provenance, tell)
    try:
        async with background_tasks() as spawn:
            spawn(log.keep_writing())
            yield log
    finally:
        try:
            await asyncio.to_thread(log.close)
        except OSError as error:
            tell(f"the end of the recording is lost ({error.strerror})")


def _opened(path: Path) -> tuple[Path, io.FileIO, io.FileIO]:
    """Both files, empty, and the path of the MCAP file."""
    if path.suffix == _LINK:
        raise InputError(f"{path}: that is where the raw link goes: name the recording {path.stem}.mcap")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        mcap = _claimed(path)
        path = Path(mcap.name)
        return path, mcap, path.with_suffix(_LINK).open("wb", buffering=0)
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror})") from error


def _claimed(path: Path) -> io.FileIO:
    """The file at `path`, or at the next name that nobody is writing to: empty, and ours until closed."""
    names = chain((path,), (path.with_stem(f"{path.stem}-{number}") for number in count(2)))
    while True:
        file = next(names).open("ab", buffering=0)
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            file.close()
            continue
        except OSError:
            pass  # a file system without locks
        file.truncate(0)
        return file


class FlightLog:
    """A `Sink` that is written to two files; none of its methods but `close` waits for the disk.

    Attributes:
        path: of the MCAP file.
        lost: how many messages and frames were left out.
        epoch_s: date (Unix time, s) of the zero of the companion clock.
    """

    def __init__(self, path: Path, mcap: Spool, tlog: Spool, provenance: Provenance, tell: Tell) -> None:
        self.path = path
        self.lost = 0
        self._mcap, self._tlog = mcap, tlog
        self._tell = tell
        self._troubled = False
        self.epoch_s = clock.epoch_s()
        self._writer = McapWriter(mcap, provenance, self.epoch_s)

    def add(self, topic: str, time_s: float, fields: Fields) -> None:
        """Take in a message."""
        if self._takes(self._mcap):
            self._writer.add(topic, time_s, fields)

    def add_metadata(self, name: str, values: dict[str, Any]) -> None:
        """Take in what is known once."""
        if self._takes(self._mcap):
            self._writer.add_metadata(name, values)

    def attach(self, name: str, data: bytes) -> None:
        """Take in bytes that messages refer to."""
        if self._takes(self._mcap):
            self._writer.attach(name, data)

    def frame(self, data: bytes) -> None:
        """Take in a frame of the link, as it was sent or received just now."""
        if self._takes(self._tlog):
            self._tlog.write(stamped(self.epoch_s + clock.now(), data))

    async def keep_writing(self) -> None:
        """Write what has come, again and again, until cancelled."""
        while True:
            await asyncio.sleep(_PERIOD_S)
            self._writer.end_chunk()
            try:
                await asyncio.to_thread(self._drain)
            except OSError as error:
                self._in_trouble(error.strerror or str(error))
            else:
                self._out_of_trouble()

    def close(self) -> None:
        """Write what is left, and the index; waits for the disk.

        Raises:
            OSError: not all could be written; the files are closed all the same.
        """
        self._writer.finish()
        try:
            self._drain()
        finally:
            self._mcap.close()
            self._tlog.close()

    def _drain(self) -> None:
        """Write both files, the one whatever becomes of the other."""
        try:
            self._mcap.drain()
        finally:
            self._tlog.drain()

    def _takes(self, spool: Spool) -> bool:
        if spool.full:
            self.lost += 1
            self._in_trouble("the disk is too slow")
        return not spool.full

    def _in_trouble(self, why: str) -> None:
        if not self._troubled:
            self._troubled = True
            self._tell(f"the recording cannot be written ({why}): the flight goes on without, if need be")

    def _out_of_trouble(self) -> None:
        if self._troubled:
            self._troubled = False
            self._tell(f"the recording is written again; {self.lost} records are missing")
