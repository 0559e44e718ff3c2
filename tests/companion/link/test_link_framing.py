import itertools
import struct

import pytest
from fake_vehicle import encoder
from fastcrc.crc16 import mcrf4xx
from hypothesis import given
from hypothesis import strategies as st

from companion.link.dialect import Message, mavlink
from companion.link.framing import Frame, FrameSplitter, decode

LONGEST_FRAME = 280

MESSAGES: list[Message] = [
    mavlink.MAVLink_heartbeat_message(2, 12, 81, 6 << 16, 4, 3),
    mavlink.MAVLink_local_position_ned_message(1000, 1.0, -2.0, -3.5, 0.25, 0.5, 0.0),
    mavlink.MAVLink_statustext_message(4, b"Arming denied", 7, 0),
    mavlink.MAVLink_param_value_message(b"MPC_Z_VEL_MAX_UP", 3.0, 9, 2, 1),
    mavlink.MAVLink_odometry_message(1, 1, 8, 1, 2, 3, [1, 0, 0, 0], 1, 2, 3, 4, 5, 6, [0.5] * 21, [1] * 21),
    mavlink.MAVLink_command_ack_message(400, 0, 0, 0, 1, 191),
]

messages = st.sampled_from(MESSAGES)
versions = st.booleans()
noise = st.binary(max_size=20) | st.sampled_from(
    [b"\xfd\xff", b"\xfe\xff", b"\xfd", b"\xfe\x09", b"\xfd\x10\x00"]
)


def packed(message: Message, *, version_1: bool = False, sequence: int = 0) -> bytes:
    peer = encoder(3, 1)
    peer.seq = sequence
    fits_version_1 = message.get_msgId() < 256
    return bytes(message.pack(peer, force_mavlink1=version_1 and fits_version_1))


def in_chunks(data: bytes, cuts: list[int]) -> list[bytes]:
    places = [0, *sorted(cut % (len(data) + 1) for cut in cuts), len(data)]
    return [data[start:end] for start, end in itertools.pairwise(places)]


def read(chunks: list[bytes]) -> list[Frame]:
    splitter = FrameSplitter()
    return [frame for chunk in chunks for frame in splitter.feed(chunk)]


@given(
    st.lists(st.tuples(noise, messages, versions), max_size=8),
    st.lists(st.integers(min_value=0, max_value=2000), max_size=12),
)
def test_every_frame_is_found_whatever_lies_between_and_however_the_stream_is_cut(
    parts: list[tuple[bytes, Message, bool]], cuts: list[int]
) -> None:
    stream = b"".join(
        stray + packed(message, version_1=version_1, sequence=place)
        for place, (stray, message, version_1) in enumerate(parts)
    )
    silence = bytes(LONGEST_FRAME)  # whatever looks like a long frame at the end turns out to be none
    frames = read(in_chunks(stream + silence, cuts))
    assert [(frame.message_id, frame.sequence) for frame in frames] == [
        (message.get_msgId(), place) for place, (_, message, _) in enumerate(parts)
    ]


@given(st.lists(st.binary(max_size=400), max_size=8))
def test_garbage_yields_nothing_and_never_piles_up(chunks: list[bytes]) -> None:
    splitter = FrameSplitter()
    frames = [frame for chunk in chunks for frame in splitter.feed(chunk)]
    passed_over = splitter.counts.stray_bytes + sum(LONGEST_FRAME for _ in frames)
    assert sum(map(len, chunks)) - passed_over <= LONGEST_FRAME


@pytest.mark.parametrize("stray", [b"\xfd\xff", b"\xfe\xff", b"\xfd\xfd\xfd", b"\xfe" * 9])
def test_frames_behind_stray_bytes_are_read_at_once(stray: bytes) -> None:
    good = [packed(MESSAGES[1], sequence=place) for place in range(5)]
    assert len(read([stray + b"".join(good)])) == 5


@pytest.mark.parametrize("message", MESSAGES, ids=lambda message: message.msgname)
def test_a_message_comes_out_as_it_went_in(message: Message) -> None:
    (frame,) = read([packed(message, sequence=9)])
    received = decode(frame)
    assert received.to_dict() == message.to_dict()
    assert (received.get_srcSystem(), received.get_srcComponent(), received.get_seq()) == (3, 1, 9)


def test_pymavlink_reads_the_same_fields() -> None:
    data = packed(MESSAGES[1])
    theirs = encoder().decode(bytearray(data))
    (frame,) = read([data])
    assert decode(frame).to_dict() == theirs.to_dict()


def test_a_wrong_checksum_is_counted_and_passed_over() -> None:
    spoilt = bytearray(packed(MESSAGES[0]))
    spoilt[-1] ^= 1
    splitter = FrameSplitter()
    frames = splitter.feed(bytes(spoilt) + packed(MESSAGES[1]))
    assert [frame.message_id for frame in frames] == [MESSAGES[1].get_msgId()]
    assert splitter.counts.bad_checksums == 1
    assert splitter.counts.stray_bytes == len(spoilt)


def test_messages_of_other_dialects_are_counted_and_passed_over() -> None:
    unknown = bytes([0xFD, 4, 0, 0, 0, 1, 1]) + (54321).to_bytes(3, "little") + bytes(6)
    splitter = FrameSplitter()
    assert len(splitter.feed(unknown + packed(MESSAGES[0]))) == 1
    assert splitter.counts.unknown_messages == 1


def test_a_signed_frame_is_read_with_its_signature() -> None:
    peer = encoder(3, 1)
    peer.signing.secret_key = bytes(32)
    peer.signing.sign_outgoing = True
    signed = bytes(MESSAGES[0].pack(peer))
    assert len(read([signed + packed(MESSAGES[1])])) == 2


def local_position(payload: bytes, *, incompatible_flags: int = 0) -> bytes:
    kind = mavlink.MAVLink_local_position_ned_message
    checked = bytes([len(payload), incompatible_flags, 0, 0, 3, 1, 32, 0, 0]) + payload
    return b"\xfd" + checked + struct.pack("<H", mcrf4xx(checked + bytes([kind.crc_extra])))


def test_a_longer_payload_of_a_newer_dialect_is_read() -> None:
    (frame,) = read([local_position(bytes(28) + b"more")])
    assert decode(frame).get_type() == "LOCAL_POSITION_NED"


def test_a_frame_with_flags_that_nobody_knows_is_passed_over() -> None:
    assert read([local_position(bytes(28), incompatible_flags=2)]) == []
