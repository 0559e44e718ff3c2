"""A file on a disk that has only so much room."""

import errno
import io
from pathlib import Path
from typing import Any


class SmallDisk(io.FileIO):
    """Takes `room` bytes, and then says what a full disk says; `room` may grow."""

    def __init__(self, path: Path, room: int) -> None:
        super().__init__(path, "wb")
        self.room = room

    def write(self, data: Any, /) -> int:
        part = bytes(data)[: self.room]
        if not part:
            raise OSError(errno.ENOSPC, "No space left on device")
        self.room -= len(part)
        return super().write(part)
