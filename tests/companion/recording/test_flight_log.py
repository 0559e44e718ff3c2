"""The files of a flight while it is flown: nothing lost but the last second, and no disk in the way."""

import asyncio
import shutil
import struct
import threading
from collections.abc import Callable, Coroutine
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from pymavlink import mavutil
from small_disk import SmallDisk

from companion import clock
from companion.errors import InputError
from companion.link.dialect import mavlink
from companion.recording import flight_log as module
from companion.recording import topics
from companion.recording.flight_log import FlightLog, flight_log
from companion.recording.mcap_file import read_mcap
from companion.recording.series import Provenance
from companion.recording.spool import Spool

PROVENANCE = Provenance(vehicle="bebop2")
HEARTBEAT = mavlink.MAVLink_heartbeat_message(2, 12, 81, 0, 4, 3).pack(mavlink.MAVLink(None, 1, 1))
T = TypeVar("T")


def virtually(main: Coroutine[Any, Any, T]) -> T:
    return clock.run(main, virtual=True)


def add_state(log: FlightLog) -> None:
    values = dict.fromkeys(
        ("position", "velocity", "attitude", "rates"), np.sin(clock.now() * np.arange(1, 4))
    )
    log.add(topics.STATE, clock.now(), topics.row(topics.STATE, values))


async def fly(path: Path, duration_s: float = 4.99, tell: Callable[[str], None] = pytest.fail) -> None:
    async with flight_log(path, PROVENANCE, tell) as log:
        while clock.now() < duration_s:
            add_state(log)
            log.frame(HEARTBEAT)
            await asyncio.sleep(0.02)


def test_all_of_a_flight_is_in_its_files(tmp_path: Path) -> None:
    path = tmp_path / "flights" / "one.mcap"
    virtually(fly(path))
    assert len(read_mcap(path).states.time_s) == 250
    assert read_mcap(path).events == ()
    stamps = [message._timestamp for message in telemetry_log(path.with_suffix(".tlog"))]
    assert len(stamps) == 250
    assert stamps[-1] == pytest.approx(clock_epoch() + 4.98)
    with path.open("rb") as file:
        first = next(make_reader(file).iter_messages())[2]
    assert first.log_time == round(clock_epoch() * 1e9)


def telemetry_log(path: Path) -> list[Any]:
    """As MAVProxy reads it."""
    log = mavutil.mavlink_connection(str(path))
    messages = []
    while (message := log.recv_match(type="HEARTBEAT")) is not None:
        messages.append(message)
    log.close()
    return messages


def clock_epoch() -> float:
    async def epoch_s() -> float:
        return clock.epoch_s()

    return virtually(epoch_s())


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("flown") / "flight.mcap"
    virtually(fly(path))
    return path


def summary_start(content: bytes) -> int:
    """Where the messages have ended: the footer's first number."""
    (start,) = struct.unpack_from("<Q", content, len(content) - 8 - 20)
    return int(start)


@settings(max_examples=60)
@given(share=st.floats(0.0, 1.0))
def test_a_cut_at_any_byte_loses_at_most_the_last_second(share: float, flown: Path) -> None:
    content = flown.read_bytes()
    with flown.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    chunks = sorted(summary.chunk_indexes, key=lambda chunk: chunk.chunk_start_offset)
    cut_at = chunks[0].chunk_start_offset + int(share * (len(content) - chunks[0].chunk_start_offset))
    begun_ns = max(chunk.message_end_time for chunk in chunks if chunk.chunk_start_offset <= cut_at)
    cut = flown.with_name("cut.mcap")
    cut.write_bytes(content[:cut_at])
    left = read_mcap(cut)
    last_s = left.states.time_s.max(initial=0.0)
    assert last_s >= begun_ns * 1e-9 - clock_epoch() - 1.0
    if cut_at < summary_start(content):
        assert any("cut short" in text for _, text in left.events)


def test_what_a_crash_leaves_is_at_most_a_second_old(tmp_path: Path) -> None:
    async def crash(path: Path, at_s: float) -> float:
        async with flight_log(path, PROVENANCE, pytest.fail) as log:
            while clock.now() < at_s:
                add_state(log)
                await asyncio.sleep(0.02)
            shutil.copy(path, tmp_path / "left.mcap")
            return clock.now()

    for at_s in (0.7, 1.11, 1.99, 2.51):
        crashed_s = virtually(crash(tmp_path / "flight.mcap", at_s))
        assert read_mcap(tmp_path / "left.mcap").states.time_s[-1] >= crashed_s - 1.0


def test_a_full_disk_is_said_once_and_the_flight_goes_on(tmp_path: Path) -> None:
    said: list[str] = []
    path, tlog = tmp_path / "flight.mcap", (tmp_path / "flight.tlog").open("wb", buffering=0)

    async def fly_on() -> int:
        disk = SmallDisk(path, room=20_000)
        log = FlightLog(path, Spool(disk, most_waiting=30_000), Spool(tlog), PROVENANCE, said.append)
        writing = asyncio.create_task(log.keep_writing())
        while clock.now() < 59.99:
            disk.room += 1_000_000 if clock.now() == pytest.approx(40.0) else 0
            add_state(log)
            await asyncio.sleep(0.02)
        writing.cancel()
        log.close()
        return log.lost

    lost = virtually(fly_on())
    assert lost > 100
    assert said[0] == (
        "the recording cannot be written (No space left on device): the flight goes on without, if need be"
    )
    assert said[1] == f"the recording is written again; {lost} records are missing"
    assert len(said) == 2
    left = read_mcap(path)
    assert len(left.states.time_s) == 3000 - lost
    assert left.states.time_s[-1] > 59.9


@pytest.mark.parametrize("virtual", [True, False])
def test_a_disk_that_stays_full_loses_the_end_and_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, virtual: bool
) -> None:
    """It is said where a clock can be read, whoever found it out."""
    monkeypatch.setattr(module, "_claimed", lambda path: SmallDisk(path, room=2_000))
    said: list[tuple[bool, str]] = []
    path = tmp_path / "flight.mcap"

    async def fly_on() -> None:
        async with flight_log(path, PROVENANCE, lambda text: said.append((clock.now() >= 0.0, text))) as log:
            for _ in range(500):
                add_state(log)
                log.frame(HEARTBEAT)

    clock.run(fly_on(), virtual=virtual)
    assert said == [(True, "the end of the recording is lost (No space left on device)")]
    assert read_mcap(path).provenance == PROVENANCE
    assert len(telemetry_log(path.with_suffix(".tlog"))) == 500, "the one file does not keep back the other"


async def test_a_disk_that_hangs_does_not_hold_up_the_loop(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "_PERIOD_S", 0.001)
    hanging = threading.Event()

    class Hanging(SmallDisk):
        def write(self, data: Any, /) -> int:
            hanging.wait()
            return super().write(data)

    said: list[str] = []
    path, tlog = tmp_path / "flight.mcap", (tmp_path / "flight.tlog").open("wb", buffering=0)
    spool = Spool(Hanging(path, room=10**9), most_waiting=200_000)
    log = FlightLog(path, spool, Spool(tlog), PROVENANCE, said.append)
    writing = asyncio.create_task(log.keep_writing())
    for _ in range(10_000):
        add_state(log)
        await asyncio.sleep(0.0)
        if log.lost:
            break
    assert said == [
        "the recording cannot be written (the disk is too slow): the flight goes on without, if need be"
    ]
    assert spool.tell() < 400_000
    hanging.set()
    writing.cancel()
    with pytest.raises(asyncio.CancelledError):
        await writing
    await asyncio.to_thread(log.close)
    assert len(read_mcap(path).states.time_s) > 100


def test_two_flights_at_once_have_files_of_their_own(tmp_path: Path) -> None:
    path = tmp_path / "flight.mcap"

    async def fly_both() -> list[Path]:
        async with (
            flight_log(path, PROVENANCE, pytest.fail) as one,
            flight_log(path, Provenance(vehicle="ardrone2"), pytest.fail) as other,
        ):
            add_state(one)
            add_state(other)
            return [one.path, other.path]

    paths = virtually(fly_both())
    assert paths == [path, tmp_path / "flight-2.mcap"]
    assert [read_mcap(each).provenance.vehicle for each in paths] == ["bebop2", "ardrone2"]
    assert len(list(tmp_path.glob("*.tlog"))) == 2
    virtually(fly(path, 1.0))
    assert len(read_mcap(path).states.time_s) == 50, "a flight that is over is in nobody's way"


def test_files_that_are_removed_in_flight_are_missed_once(tmp_path: Path) -> None:
    said: list[str] = []

    async def fly_on() -> None:
        async with flight_log(tmp_path / "flights" / "one.mcap", PROVENANCE, said.append) as log:
            shutil.rmtree(tmp_path / "flights")
            for _ in range(100):
                add_state(log)
                await asyncio.sleep(0.02)

    virtually(fly_on())
    assert said == [
        "the recording cannot be written (the file was removed): the flight goes on without, if need be",
        "the end of the recording is lost (the file was removed)",
    ]


def test_the_link_needs_a_file_of_its_own(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"name the recording flight\.mcap"):
        virtually(fly(tmp_path / "flight.tlog"))


def test_a_place_where_nothing_can_be_written_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        virtually(fly(tmp_path / "file" / "flight.mcap"))
