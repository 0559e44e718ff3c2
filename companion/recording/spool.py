"""A file that is written in the background, however slow the disk is, and whatever becomes of it."""

import errno
import io
import os
import threading
from collections import deque

MOST_WAITING = 16 * 2**20
"""Bytes that may wait for the disk: minutes of a flight."""


class Spool:
    """Takes bytes at once, and writes them when it is told to.

    At every instant the file is the beginning of what was taken, without a gap: what a full disk did not take
    waits. So somebody has to see that not too much does (`full`), and leave out as a whole what would be cut.

    Args:
        file: to be written, without a buffer of its own.
        most_waiting: from so many waiting bytes on it is full.
    """

    def __init__(self, file: io.RawIOBase, most_waiting: int = MOST_WAITING) -> None:
        self._file = file
        self._most_waiting = most_waiting
        self._waiting: deque[bytes] = deque()
        self._block = b""
        self._taken = self._written = 0
        self._writing = threading.Lock()

    @property
    def full(self) -> bool:
        """Whether as much is waiting as may."""
        return self._taken - self._written >= self._most_waiting

    def write(self, data: bytes, /) -> int:
        """Take `data`; returns its length."""
        if data:
            self._waiting.append(data)
        self._taken += len(data)
        return len(data)

    def tell(self) -> int:
        """How many bytes were taken."""
        return self._taken

    def flush(self) -> None:
        """Nothing: `drain` writes."""

    def drain(self) -> None:
        """Write all that waits, and have the disk keep it; may take long, and be called from any thread.

        Raises:
            OSError: it cannot be written now, and what was not written waits on; or it was removed meanwhile.
        """
        with self._writing:
            while self._block or self._waiting:
                if not self._block:  # the other thread appends only
                    self._block = b"".join([self._waiting.popleft() for _ in range(len(self._waiting))])
                count = self._file.write(self._block) or 0
                self._written += count
                self._block = self._block[count:]
            os.fsync(self._file.fileno())
            if not os.fstat(self._file.fileno()).st_nlink:
                raise OSError(errno.ENOENT, "the file was removed")

    def close(self) -> None:
        """Close the file; what waits is lost."""
        with self._writing:
            self._file.close()
