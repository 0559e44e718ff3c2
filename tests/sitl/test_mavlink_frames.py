import pytest
from hypothesis import given
from hypothesis import strategies as st
from mavlink_fakes import encode
from pymavlink.dialects.v20 import common as mavlink

from sitl.mavlink.frames import Encoder, decode, whole_frames

HEARTBEAT = mavlink.MAVLink_heartbeat_message(18, 8, 0, 0, 4, 3)
PING = mavlink.MAVLink_ping_message(12345, 7, 0, 0)


def names(datagram: bytes) -> list[str]:
    return [message.get_type() for message in decode(datagram)]


def test_pymavlink_reads_what_the_encoder_writes() -> None:
    encoder = Encoder(system_id=3)
    frames = [encoder.encode(HEARTBEAT) for _ in range(300)]
    parser = mavlink.MAVLink(None)
    messages = [message for frame in frames for message in parser.parse_buffer(frame) or []]
    assert {(m.get_srcSystem(), m.get_srcComponent(), m.get_type()) for m in messages} == {
        (3, 1, "HEARTBEAT")
    }
    assert [m.get_seq() for m in messages] == [i % 256 for i in range(300)]


def test_both_protocol_versions_are_read_in_one_datagram() -> None:
    version_1 = bytes(PING.pack(mavlink.MAVLink(None, 9, 9), force_mavlink1=True))
    assert names(version_1 + encode(HEARTBEAT)) == ["PING", "HEARTBEAT"]


def test_a_signed_frame_is_read() -> None:
    signer = mavlink.MAVLink(None, 9, 9)
    signer.signing.secret_key = b"k" * 32
    signer.signing.sign_outgoing = True
    assert names(bytes(HEARTBEAT.pack(signer)) + encode(PING)) == ["HEARTBEAT", "PING"]


@pytest.mark.parametrize("stray", [b"\xfd\xff", b"\xfe", b"\xfd\x00\x02", b"GET / HTTP/1.1\r\n\r\n"])
def test_stray_bytes_do_not_hide_the_frame_behind_them(stray: bytes) -> None:
    assert names(stray + encode(HEARTBEAT) + stray + encode(PING)) == ["HEARTBEAT", "PING"]


def test_a_broken_checksum_costs_that_frame_only() -> None:
    broken = bytearray(encode(HEARTBEAT))
    broken[-1] ^= 0xFF
    assert names(bytes(broken) + encode(PING)) == ["PING"]


def test_a_frame_that_is_cut_off_is_nothing() -> None:
    assert all(names(encode(PING)[:length]) == [] for length in range(len(encode(PING))))


@given(st.integers(0, 255), st.binary(max_size=300))
def test_no_bytes_raise_or_hide_the_frame_behind_them(length: int, datagram: bytes) -> None:
    for stray in (datagram, b"\xfd" + datagram, bytes([0xFD, length, 0]) + datagram):
        assert names(stray + encode(PING)) == [*names(stray), "PING"]


@given(st.integers(0, 60))
def test_of_a_stream_only_whole_frames_are_taken(cut: int) -> None:
    encoder = Encoder(1)
    frames = [encoder.encode(mavlink.MAVLink_heartbeat_message(2, 12, 0, 0, 0, 3)) for _ in range(3)]
    ends = [sum(map(len, frames[:count])) for count in range(4)]
    stream = b"".join(frames)[:cut]
    assert whole_frames(stream) == max(end for end in ends if end <= len(stream))
