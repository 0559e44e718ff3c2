"""A fixed slice of `companion bench fuzz`, and what it is made of."""

from collections.abc import Sequence

import numpy as np
import pytest

from companion.experiments.fuzz.files import READERS, fuzz_files
from companion.experiments.fuzz.hang import HangError, ended_after
from companion.experiments.fuzz.link import fuzz_link
from companion.experiments.fuzz.row import FuzzRow
from companion.experiments.fuzz.samples import samples
from companion.experiments.fuzz.streams import Reading, Stream, frame, random_stream, reading
from companion.experiments.fuzz.table import complaints, summaries
from companion.link.dialect import mavlink
from companion.link.framing import FrameSplitter

SAMPLES = samples()
HEARTBEAT = frame(0, bytes(9), (1, 1), 0)


@pytest.mark.parametrize("seed", [0, 1])
def test_a_link_withstands_hostile_frames(seed: int) -> None:
    row = fuzz_link(seed, 4000)
    assert (row.lost, row.faults) == (0, ())
    assert row.valid > 4000
    assert row.swallowed < 0.001 * row.valid


@pytest.mark.parametrize("name", READERS)
def test_a_reader_withstands_mutated_files(name: str) -> None:
    row = fuzz_files(name, SAMPLES[name], 0, 60)
    assert row.faults == ()
    assert name in {"tlog", "ulog"} or row.refused > 0


@pytest.mark.parametrize("name", READERS)
def test_files_are_right_before_they_are_mutated(name: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    for content in SAMPLES[name]:
        path = tmp_path_factory.mktemp("right") / f"flight{READERS[name].suffix}"
        path.touch(0o600)
        path.write_bytes(content)
        assert READERS[name].read(path) is not None


def test_the_same_seed_gives_the_same_bytes() -> None:
    kinds = [mavlink.MAVLink_heartbeat_message]
    first, second = (random_stream(50, kinds, np.random.default_rng(3)) for _ in range(2))
    assert first == second


def frames_in(data: bytes) -> list[bytes]:
    return [found.data for found in FrameSplitter().feed(data)]


def read(*parts: tuple[bytes, bool]) -> Reading:
    """The reading of a stream of parts that are valid frames or not."""
    data, valid = b"", []
    for part, is_valid in parts:
        valid += [(len(data), part)] if is_valid else []
        data += part
    return reading(Stream(data, valid), frames_in(data))


def test_frames_behind_noise_are_read() -> None:
    assert read((b"\xfd\xff", False), (HEARTBEAT, True), (b"\xfe", False), (HEARTBEAT, True)) == Reading(
        2, 0, 0
    )


def test_a_frame_in_a_valid_longer_one_is_swallowed() -> None:
    around = frame(mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED, bytes(5) + HEARTBEAT, (1, 1), 0)
    cut = around.index(HEARTBEAT)
    parts = (around[:cut], False), (HEARTBEAT, True), (around[cut + len(HEARTBEAT) :], False)
    assert read(*parts) == Reading(0, 1, 0)


def test_a_frame_that_nobody_reads_is_lost() -> None:
    assert reading(Stream(HEARTBEAT, [(0, HEARTBEAT)]), []) == Reading(0, 0, 1)


def compute_for_ever() -> None:
    while True:
        pass


def test_a_block_that_does_not_end_is_ended() -> None:
    with pytest.raises(HangError), ended_after(0.01):
        compute_for_ever()


def rows(**what: object) -> Sequence[FuzzRow]:
    return [FuzzRow.model_validate({"reader": "link", "inputs": 10, **what})]


def test_what_is_lost_raised_or_kept_is_complained_of() -> None:
    assert not list(complaints(summaries(rows())))
    for what in ({"lost": 2}, {"faults": ("KeyError at a.py:1: 3",)}, {"grown_bytes": 10**8}):
        (told,) = summaries(rows(**what))
        assert told.fails
        assert len(list(complaints([told]))) == 1
