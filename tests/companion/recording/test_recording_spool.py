"""A file written in the background: always the beginning of what was taken, whatever the disk does."""

import io
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from small_disk import SmallDisk

from companion.recording.spool import Spool


@settings(max_examples=40)
@given(
    steps=st.lists(st.one_of(st.binary(min_size=1, max_size=40), st.integers(0, 60)), min_size=1, max_size=30)
)
def test_the_file_is_a_beginning_of_what_was_taken(
    steps: list[bytes | int], tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.getbasetemp() / "spool"
    disk = SmallDisk(path, room=0)
    spool = Spool(disk)
    taken = b""
    for step in steps:
        if isinstance(step, bytes):
            spool.write(step)
            taken += step
        else:
            disk.room += step
            if len(taken) - path.stat().st_size > disk.room:
                with pytest.raises(OSError, match="No space"):
                    spool.drain()
            else:
                spool.drain()
                assert path.read_bytes() == taken
        assert taken.startswith(path.read_bytes())
        assert spool.tell() == len(taken)
    spool.close()


def test_it_is_full_until_the_disk_has_taken_something(tmp_path: Path) -> None:
    with (tmp_path / "spool").open("wb", buffering=0) as file:
        spool = Spool(file, most_waiting=10)
        full = []
        for data in (b"123456789", b"0"):
            spool.write(data)
            full.append(spool.full)
        spool.drain()
        assert [*full, spool.full] == [False, True, False]


def test_what_waits_is_written_at_once(tmp_path: Path) -> None:
    """A frame of the link at a time would take a slow disk for ever."""
    blocks: list[bytes] = []

    class Counting(SmallDisk):
        def write(self, data: Any, /) -> int:
            blocks.append(bytes(data))
            return super().write(data)

    spool = Spool(Counting(tmp_path / "spool", room=100))
    for data in (b"frame", b"after", b"frame"):
        spool.write(data)
    spool.drain()
    spool.close()
    assert blocks == [b"frameafterframe"]


@pytest.mark.skipif(not Path("/dev/full").is_char_device(), reason="no /dev/full here")
def test_a_real_full_disk_is_an_error_that_can_be_told() -> None:
    spool = Spool(io.FileIO("/dev/full", "wb"))
    spool.write(b"kept")
    with pytest.raises(OSError, match="No space"):
        spool.drain()
    spool.close()
    assert spool.tell() == 4
