"""Signed links: what is believed, what is not, and that nothing forged does harm."""

import asyncio
import stat
from collections.abc import Callable
from pathlib import Path

import pytest
from fake_vehicle import FakeVehicle, encoder, heartbeat, in_virtual_time
from hypothesis import given
from hypothesis import strategies as st

from companion.errors import InputError, LinkError
from companion.link.connection import connect_over
from companion.link.dialect import Message, mavlink
from companion.link.framing import Frame, FrameSplitter
from companion.link.signing import LARGEST_STREAMS, LAST_TIMESTAMP, TICKS_PER_S, Rejection, Signer, SigningKey
from companion.link.signing_key import read_signing_key
from companion.link.signing_state import lasting_signer, state_file
from companion.link.transport import Receiver, Transport

KEY = SigningKey(bytes(range(32)))
OTHER_KEY = SigningKey(bytes(32))
NOW = 10**13
MINUTE = 60 * TICKS_PER_S

messages = st.sampled_from(
    [heartbeat(), mavlink.MAVLink_local_position_ned_message(1, 1.0, -2.0, -3.5, 0.25, 0.5, 0.0)]
)
timestamps = st.integers(min_value=NOW, max_value=NOW + 1000)
ids = st.integers(min_value=1, max_value=3)


def signer(key: SigningKey = KEY, now: int = NOW) -> Signer:
    return Signer(key, lambda: now)


def signed_by_pymavlink(
    message: Message, timestamp: int, *, system_id: int = 1, link_id: int = 0, key: SigningKey = KEY
) -> bytes:
    peer = encoder(system_id)
    peer.signing.secret_key = key.secret
    peer.signing.sign_outgoing = True
    peer.signing.link_id = link_id
    peer.signing.timestamp = timestamp
    return bytes(message.pack(peer))


def frame(data: bytes) -> Frame:
    (only,) = FrameSplitter().feed(data)
    return only


@given(messages, st.integers(min_value=0, max_value=LAST_TIMESTAMP - 1))
def test_our_signatures_are_those_of_pymavlink(message: Message, now: int) -> None:
    ours = signer(now=now).sign(message.pack(encoder()))
    assert ours == signed_by_pymavlink(message, max(now, 1))
    theirs = encoder()
    theirs.signing.secret_key = KEY.secret
    assert theirs.decode(bytearray(ours)).to_dict() == message.to_dict()


@given(messages, timestamps)
def test_what_pymavlink_signs_is_believed_once(message: Message, timestamp: int) -> None:
    receiver = signer()
    signed = frame(signed_by_pymavlink(message, timestamp))
    assert [receiver.rejection(signed) for _ in range(2)] == [None, Rejection.REPLAYED]
    assert receiver.timestamp == timestamp


@given(messages, timestamps, st.integers(min_value=0), st.integers(min_value=1, max_value=255))
def test_a_frame_with_any_byte_changed_is_not_believed(
    message: Message, timestamp: int, place: int, change: int
) -> None:
    data = bytearray(signed_by_pymavlink(message, timestamp))
    data[place % len(data)] ^= change
    receiver = signer()
    for found in FrameSplitter().feed(bytes(data) + bytes(300)):
        assert receiver.rejection(found) in (Rejection.UNSIGNED, Rejection.WRONGLY_SIGNED)
    assert receiver.streams == {}
    assert receiver.timestamp == 0


@given(messages, st.integers(min_value=1, max_value=255), st.integers(min_value=1, max_value=13))
def test_a_signature_with_any_byte_changed_is_not_believed(message: Message, change: int, place: int) -> None:
    data = bytearray(signed_by_pymavlink(message, NOW))
    data[-place] ^= change
    receiver = signer()
    assert receiver.rejection(frame(bytes(data))) is Rejection.WRONGLY_SIGNED
    assert receiver.streams == {}


@given(st.lists(st.tuples(ids, ids, timestamps), max_size=30))
def test_in_any_order_a_stream_is_believed_only_as_it_rises(sent: list[tuple[int, int, int]]) -> None:
    receiver = signer()
    newest: dict[tuple[int, int, int], int] = {}
    believed = 0
    for system_id, link_id, timestamp in sent:
        data = signed_by_pymavlink(heartbeat(), timestamp, system_id=system_id, link_id=link_id)
        rises = timestamp > newest.get((system_id, 1, link_id), -1)
        assert receiver.rejection(frame(data)) is (None if rises else Rejection.REPLAYED)
        if rises:
            believed += 1
            newest[system_id, 1, link_id] = timestamp
    assert receiver.streams == newest
    assert receiver.timestamp == max(newest.values(), default=0)
    assert receiver.rejected.total() == len(sent) - believed


def test_a_forged_frame_of_the_future_shuts_nothing_out() -> None:
    receiver = signer()
    forged = signed_by_pymavlink(heartbeat(), NOW + 10**9, key=OTHER_KEY)
    assert receiver.rejection(frame(forged)) is Rejection.WRONGLY_SIGNED
    assert receiver.rejection(frame(signed_by_pymavlink(heartbeat(), NOW))) is None


def test_a_stream_that_begins_more_than_a_minute_behind_is_stale() -> None:
    receiver = signer()
    stale, late = (signed_by_pymavlink(heartbeat(), NOW - MINUTE - behind) for behind in (1, 0))
    assert receiver.rejection(frame(stale)) is Rejection.STALE
    assert receiver.rejection(frame(late)) is None


def test_what_is_unsigned_is_counted_in_both_versions() -> None:
    receiver = signer()
    for version_1 in (True, False):
        data = heartbeat().pack(encoder(), force_mavlink1=version_1)
        assert receiver.rejection(frame(data)) is Rejection.UNSIGNED
    assert receiver.rejected == {Rejection.UNSIGNED: 2}


def test_signers_without_number_are_not_remembered() -> None:
    receiver = signer()
    for link_id in range(256):
        for system_id in (1, 2):
            receiver.rejection(
                frame(signed_by_pymavlink(heartbeat(), NOW, system_id=system_id, link_id=link_id))
            )
    assert len(receiver.streams) == LARGEST_STREAMS
    assert receiver.rejected == {Rejection.TOO_MANY_STREAMS: 512 - LARGEST_STREAMS}


@given(st.lists(st.integers(min_value=-(10**6), max_value=10**6), max_size=20), timestamps)
def test_our_timestamps_rise_whatever_the_clock_does(clock_errors: list[int], heard: int) -> None:
    now = NOW
    ours = Signer(KEY, lambda: now)
    ours.rejection(frame(signed_by_pymavlink(heartbeat(), heard)))
    sent = [heard]
    for error in clock_errors:
        now = NOW + error
        sent.append(int.from_bytes(ours.sign(heartbeat().pack(encoder()))[-12:-6], "little"))
    assert sent == sorted(set(sent))


@in_virtual_time
async def test_a_connection_believes_and_sends_what_is_signed() -> None:
    vehicle = FakeVehicle(heartbeats=0)
    far_end = signer()
    beat = far_end.sign(heartbeat().pack(encoder(1)))
    forged = signer(OTHER_KEY).sign(heartbeat().pack(encoder(7)))
    for place, data in enumerate((forged, heartbeat().pack(encoder(8)), beat, beat)):
        asyncio.get_running_loop().call_later(0.1 + place, vehicle.deliver, data)
    async with connect_over(vehicle.open, signer=signer()) as connection:
        await asyncio.sleep(2.0)
        assert connection.system_id == 1
        assert connection.vehicle_signs
        assert connection.signer is not None
        assert connection.signer.rejected == {
            Rejection.WRONGLY_SIGNED: 1,
            Rejection.UNSIGNED: 1,
            Rejection.REPLAYED: 1,
        }
    assert vehicle.frames
    assert [far_end.rejection(sent) for sent in vehicle.frames] == [None] * len(vehicle.frames)


@in_virtual_time
async def test_a_vehicle_whose_clock_is_behind_hears_of_our_time_first() -> None:
    """As on UDP, where we send nothing before we know whom to answer."""
    vehicle = FakeVehicle(heartbeats=0)
    far_end = signer(now=0)
    answered: list[Signer] = []

    async def open_deaf(receiver: Receiver) -> Transport:
        transport = await vehicle.open(receiver)
        send = transport.send

        def send_when_answered(data: bytes) -> None:
            if answered:
                far_end.rejection(frame(data))
                send(data)

        transport.send = send_when_answered  # type: ignore[method-assign]
        transport.answer_sender = lambda: answered.append(far_end)  # type: ignore[method-assign]
        return transport

    loop = asyncio.get_running_loop()
    for second in range(5):
        loop.call_later(0.5 + second, lambda: vehicle.deliver(far_end.sign(heartbeat().pack(encoder()))))
    async with connect_over(open_deaf, signer=signer()) as connection:
        assert connection.signer is not None
        assert connection.signer.rejected == {Rejection.STALE: 1}
        assert answered


@in_virtual_time
async def test_a_vehicle_with_another_key_is_told_of() -> None:
    with pytest.raises(LinkError, match=r"not believed \(.* unsigned\).*the same key"):
        async with connect_over(FakeVehicle().open, signer=signer()):
            pytest.fail("nothing is signed")


@in_virtual_time
async def test_without_a_key_signed_frames_count_like_any() -> None:
    vehicle = FakeVehicle(heartbeats=0)
    data = signed_by_pymavlink(heartbeat(), 5)
    asyncio.get_running_loop().call_later(0.1, vehicle.deliver, data)
    async with connect_over(vehicle.open) as connection:
        assert connection.vehicle_signs


@pytest.fixture(autouse=True)
def own_state(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))


def wall(monkeypatch: pytest.MonkeyPatch, unix_time_s: float) -> None:
    monkeypatch.setattr("companion.clock.unix_time_s", lambda: unix_time_s)


def last_sent(ours: Signer) -> int:
    return int.from_bytes(ours.sign(heartbeat().pack(encoder()))[-12:-6], "little")


@pytest.mark.parametrize("later_s", [-1e9, -100.0, 0.0, 100.0])
async def test_timestamps_rise_from_one_start_to_the_next(
    monkeypatch: pytest.MonkeyPatch, later_s: float
) -> None:
    wall(monkeypatch, 1.8e9)
    heard = frame(signed_by_pymavlink(heartbeat(), 2 * 10**14))
    async with lasting_signer(KEY) as ours:
        first = last_sent(ours)
        assert abs(first - (1_800_000_000 - 1_420_070_400) * TICKS_PER_S) < MINUTE
        ours.rejection(heard)
        second = last_sent(ours)
    wall(monkeypatch, 1.8e9 + later_s)
    async with lasting_signer(KEY) as ours:
        assert ours.rejection(heard) is Rejection.REPLAYED
        assert first < second < last_sent(ours)
    assert stat.S_ISREG(state_file(KEY).stat().st_mode)
    assert KEY.secret.hex() not in str(state_file(KEY)) + state_file(KEY).read_text()


async def test_who_dies_without_a_word_begins_behind_all_that_was_sent(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    wall(monkeypatch, 1.8e9)
    async with lasting_signer(KEY) as ours:
        sent = [last_sent(ours) for _ in range(100)]
        kept = state_file(KEY).read_bytes()
    state_file(KEY).write_bytes(kept)  # as it was while the program ran
    wall(monkeypatch, 0.0)
    async with lasting_signer(KEY) as ours:
        assert last_sent(ours) > sent[-1]


@pytest.mark.parametrize("content", ["", "{", '{"timestamp": -1}', '{"timestamp": 1, "more": 2}'])
async def test_a_broken_state_file_is_told(content: str) -> None:
    state_file(KEY).parent.mkdir(parents=True)
    state_file(KEY).write_text(content)
    with pytest.raises(InputError, match="remove it"):
        async with lasting_signer(KEY):
            pytest.fail("the file is broken")


async def test_timestamps_that_cannot_be_kept_are_told(tmp_path: Path) -> None:
    (tmp_path / "state").write_text("in the way")
    with pytest.raises(InputError, match="timestamps"):
        async with lasting_signer(KEY):
            pytest.fail("there is no folder for it")


@pytest.fixture
def key_file(tmp_path: Path) -> Callable[[bytes], Path]:
    def write(content: bytes) -> Path:
        path = tmp_path / "key"
        path.write_bytes(content)
        path.chmod(0o600)
        return path

    return write


@pytest.mark.parametrize(
    ("content", "secret"),
    [
        (b"00" * 31 + b"fF\n", bytes(31) + b"\xff"),
        (b"AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA=", bytes(32)),
        (b"abc\r\n", bytes.fromhex("ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad")),
    ],
)
def test_a_key_is_read_in_each_form(key_file: Callable[[bytes], Path], content: bytes, secret: bytes) -> None:
    key = read_signing_key(key_file(content))
    assert key.secret == secret
    assert secret.hex() not in repr(key)


@pytest.mark.parametrize("content", [b"", b"\n", b"one\ntwo\n", b"\xff\xfe\x00", b"x" * 5000])
def test_what_is_no_key_is_told(key_file: Callable[[bytes], Path], content: bytes) -> None:
    with pytest.raises(InputError, match=r"openssl rand -hex 32"):
        read_signing_key(key_file(content))


@pytest.mark.parametrize("mode", [0o640, 0o604, 0o620, 0o666])
def test_a_key_that_others_may_read_is_refused(key_file: Callable[[bytes], Path], mode: int) -> None:
    path = key_file(b"00" * 32)
    path.chmod(mode)
    with pytest.raises(InputError, match="chmod 600"):
        read_signing_key(path)


def test_a_key_file_that_is_not_there_is_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        read_signing_key(tmp_path / "none")
