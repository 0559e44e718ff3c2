"""Others on the link: what they ask of us, and ground stations that reach the vehicle through us."""

import asyncio
import socket
from collections.abc import Iterator
from contextlib import closing
from typing import Any

import pytest
from fake_vehicle import FakeVehicle, encoder, heartbeat, in_virtual_time
from hypothesis import given
from hypothesis import strategies as st

from companion.errors import InputError
from companion.link.connecting import connect
from companion.link.connection import connect_over
from companion.link.courtesy import QUESTIONS, answers
from companion.link.dialect import Message, mavlink
from companion.link.forward import forwarding
from companion.link.framing import FrameSplitter, decode
from companion.link.memory import MemoryTransport
from companion.link.signing import Signer, SigningKey
from companion.link.transport import Receiver

HOST = "127.0.0.1"
OURS = (1, 191)
GROUND = (255, 190)
REQUEST_MESSAGE, VERSION = mavlink.MAV_CMD_REQUEST_MESSAGE, mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION
ARM = mavlink.MAV_CMD_COMPONENT_ARM_DISARM


def command(target: tuple[int, int], number: int, param1: float = 0.0) -> Message:
    return mavlink.MAVLink_command_long_message(*target, number, 0, param1, 0, 0, 0, 0, 0, 0)


def asked(question: Message, sender: tuple[int, int] = GROUND) -> list[Any]:
    header = question.get_header()
    header.srcSystem, header.srcComponent = sender
    return list(answers(question, OURS))


def test_a_ground_station_learns_our_version() -> None:
    acknowledged, version = asked(command(OURS, REQUEST_MESSAGE, VERSION))
    assert acknowledged.to_dict() | {"target_system": 255, "target_component": 190} == acknowledged.to_dict()
    assert acknowledged.result == mavlink.MAV_RESULT_ACCEPTED
    assert version.get_msgId() == VERSION


@pytest.mark.parametrize(
    ("question", "answer"),
    [
        (command(OURS, ARM, 1.0), mavlink.MAVLINK_MSG_ID_COMMAND_ACK),
        (command(OURS, REQUEST_MESSAGE, 30), mavlink.MAVLINK_MSG_ID_COMMAND_ACK),
        (mavlink.MAVLink_param_request_list_message(*OURS), mavlink.MAVLINK_MSG_ID_PARAM_ERROR),
        (mavlink.MAVLink_param_request_read_message(*OURS, b"A", -1), mavlink.MAVLINK_MSG_ID_PARAM_ERROR),
        (mavlink.MAVLink_param_set_message(*OURS, b"A", 1.0, 9), mavlink.MAVLINK_MSG_ID_PARAM_ERROR),
        (mavlink.MAVLink_mission_request_list_message(*OURS), mavlink.MAVLINK_MSG_ID_MISSION_ACK),
    ],
    ids=lambda value: getattr(value, "msgname", ""),
)
def test_what_we_do_not_have_is_refused_at_once_and_only_when_we_are_meant(
    question: Any, answer: int
) -> None:
    assert question.get_msgId() in QUESTIONS
    (refusal,) = asked(question)
    assert refusal.get_msgId() == answer
    assert (refusal.target_system, refusal.target_component) == GROUND
    assert getattr(refusal, "result", None) != mavlink.MAV_RESULT_ACCEPTED
    for target in ((1, 1), (0, 0), (1, 0), (2, 191)):
        question.target_system, question.target_component = target
        assert asked(question) == []


def test_the_vehicles_answer_to_a_download_of_ours_is_no_question() -> None:
    assert mavlink.MAVLINK_MSG_ID_MISSION_COUNT not in QUESTIONS


def test_a_ping_to_everyone_is_answered_to_its_sender_and_an_answer_is_not() -> None:
    (answer,) = asked(mavlink.MAVLink_ping_message(5, 6, 0, 0), (1, 1))
    assert (answer.time_usec, answer.seq, answer.target_system, answer.target_component) == (5, 6, 1, 1)
    assert asked(mavlink.MAVLink_ping_message(5, 6, *OURS)) == []


@given(st.sampled_from(sorted(QUESTIONS)), st.binary(min_size=60, max_size=60))
def test_no_question_makes_us_fail(message_id: int, payload: bytes) -> None:
    kind = mavlink.mavlink_map[message_id]
    size = kind.unpacker.size
    draft = mavlink.MAVLink_ping_message(0, 0, 0, 0)
    frame = FrameSplitter().feed(draft.pack(encoder(*GROUND)))[0]
    question = decode(frame._replace(message_id=message_id, payload=payload[:size]))
    for answer in answers(question, OURS):
        assert answer.pack(encoder())


@in_virtual_time
async def test_the_vehicle_passes_questions_on_and_gets_the_answers() -> None:
    vehicle = FakeVehicle()
    async with connect_over(vehicle.open) as connection:
        vehicle.say(command(connection.ids, REQUEST_MESSAGE, VERSION), system_id=255, component_id=190)
        vehicle.say(mavlink.MAVLink_ping_message(1, 2, 0, 0))
        await asyncio.sleep(0.1)
        assert len(vehicle.heard_of(mavlink.MAVLink_autopilot_version_message)) == 1
        assert len(vehicle.heard_of(mavlink.MAVLink_ping_message)) == 1


class Ground:
    """A ground station at the far end of an in-memory link."""

    def __init__(self) -> None:
        self.heard = b""

    async def open(self, receiver: Receiver) -> MemoryTransport:
        self.transport = MemoryTransport(receiver, self._hear)
        return self.transport

    def _hear(self, data: bytes) -> None:
        self.heard += data

    def kinds(self) -> list[str]:
        return [decode(frame).msgname for frame in FrameSplitter().feed(self.heard)]


@in_virtual_time
async def test_frames_pass_both_ways_as_they_are() -> None:
    vehicle, ground = FakeVehicle(heartbeats=1), Ground()
    key = SigningKey(bytes(32))
    stranger = Signer(SigningKey(b"another key".ljust(32)), lambda: 7)
    from_vehicle = stranger.sign(mavlink.MAVLink_ahrs2_message(1, 2, 3, 4, 5, 6).pack(encoder(1, 1)))
    to_vehicle = stranger.sign(command((1, 1), ARM, 1.0).pack(encoder(*GROUND)))
    beat = Signer(key, lambda: 5).sign(heartbeat().pack(encoder()))
    asyncio.get_running_loop().call_later(0.05, vehicle.deliver, beat)
    async with (
        connect_over(vehicle.open, signer=Signer(key, lambda: 5)) as connection,
        forwarding(connection, ground.open),
    ):
        vehicle.deliver(b"noise" + from_vehicle)
        ground.transport.deliver(to_vehicle[:9])
        ground.transport.deliver(to_vehicle[9:])
        await asyncio.sleep(0.3)
        assert from_vehicle in ground.heard
        assert b"noise" not in ground.heard
        assert to_vehicle in [frame.data for frame in vehicle.frames]
        await asyncio.sleep(2.0)
        assert ground.kinds().count("HEARTBEAT") >= 2  # ours too: a ground station may know that we are here
        before = len(ground.heard)
    vehicle.deliver(from_vehicle)
    await asyncio.sleep(0.1)
    assert len(ground.heard) == before


@in_virtual_time
async def test_who_is_behind_us_is_never_taken_for_the_vehicle() -> None:
    vehicle, ground = FakeVehicle(heartbeats=1), Ground()
    async with connect_over(vehicle.open) as connection, forwarding(connection, ground.open):
        landed: list[int] = []
        connection.subscribe(
            mavlink.MAVLink_extended_sys_state_message, lambda message: landed.append(message.landed_state)
        )
        ground.transport.deliver(mavlink.MAVLink_extended_sys_state_message(0, 1).pack(encoder(1, 1)))
        ground.transport.deliver(heartbeat().pack(encoder(1, 1)))
        ground.transport.deliver(command(connection.ids, ARM, 1.0).pack(encoder(*GROUND)))
        await asyncio.sleep(5.0)
        assert landed == []
        assert connection.lost
        assert "COMMAND_ACK" in ground.kinds()


@in_virtual_time
async def test_a_signing_key_on_its_way_goes_no_farther() -> None:
    vehicle, ground = FakeVehicle(), Ground()
    setup = mavlink.MAVLink_setup_signing_message(1, 1, [7] * 32, 0)
    async with connect_over(vehicle.open) as connection, forwarding(connection, ground.open):
        vehicle.say(setup)
        ground.transport.deliver(setup.pack(encoder(*GROUND)))
        await asyncio.sleep(0.5)
        assert "SETUP_SIGNING" not in ground.kinds()
        assert vehicle.heard_of(mavlink.MAVLink_setup_signing_message) == []


@pytest.mark.parametrize(
    ("address", "forward"),
    [("sitl://bebop2", "udpout://127.0.0.1:14550"), ("udpin://127.0.0.1:1", "sitl://bebop2")],
)
async def test_the_built_in_vehicle_is_shared_in_another_way(address: str, forward: str) -> None:
    with pytest.raises(InputError, match="built-in vehicle"):
        async with connect(address, forward=[forward]):
            pytest.fail("it cannot be shared")


@pytest.fixture
def sockets() -> Iterator[tuple[socket.socket, socket.socket]]:
    with (
        closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as vehicle,
        closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as ground,
    ):
        for end in (vehicle, ground):
            end.bind((HOST, 0))
            end.setblocking(False)
        yield vehicle, ground


@pytest.mark.realtime
async def test_a_ground_station_shares_an_udp_link(sockets: tuple[socket.socket, socket.socket]) -> None:
    vehicle, ground = sockets
    loop = asyncio.get_running_loop()
    ports = [end.getsockname()[1] for end in sockets]
    beat = heartbeat().pack(encoder())
    order = command((1, 1), ARM, 1.0).pack(encoder(*GROUND))
    our_end = loop.create_future()

    async def speak() -> None:
        _, companion = await loop.sock_recvfrom(vehicle, 2048)
        our_end.set_result(companion)
        while True:
            vehicle.sendto(beat, companion)
            await asyncio.sleep(0.02)

    async def sender_of(expected: bytes, end: socket.socket) -> Any:
        data, sender = await loop.sock_recvfrom(end, 2048)
        while data != expected:
            data, sender = await loop.sock_recvfrom(end, 2048)
        return sender

    speaking = asyncio.create_task(speak())
    async with (
        asyncio.timeout(20.0),
        connect(f"udpout://{HOST}:{ports[0]}", forward=[f"udpout://{HOST}:{ports[1]}"]),
    ):
        ground.sendto(order, await sender_of(beat, ground))
        assert await sender_of(order, vehicle) == await our_end
    speaking.cancel()
