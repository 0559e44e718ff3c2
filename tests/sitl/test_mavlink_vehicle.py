import math
import struct
from collections import Counter
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mavlink_fakes import (
    PEER_COMPONENT,
    PEER_SYSTEM,
    answers,
    command_long,
    encode,
    fake_vehicle,
    parse,
)
from pymavlink.dialects.v20 import common as mavlink

from sitl.conditions import LinkConditions
from sitl.firmware.interface import Severity, StatusText
from sitl.mavlink import GROUND_STATION, OFFBOARD, MavlinkVehicle

REALISTIC = LinkConditions(
    telemetry_latency_s=0.02, telemetry_jitter_s=0.01, telemetry_loss_fraction=0.01, setpoint_latency_s=0.02
)
POSITION_ONLY = 0b1101_1111_1000


def setpoint(x: float, system: int = 1, component: int = 1) -> Any:
    values = [x, 0.0, -2.0, *[0.0] * 8]
    return mavlink.MAVLink_set_position_target_local_ned_message(
        0, system, component, mavlink.MAV_FRAME_LOCAL_NED, POSITION_ONLY, *values
    )


def test_an_ideal_link_delivers_every_stream_at_its_rate_and_at_once() -> None:
    vehicle, _ = fake_vehicle()
    deliveries = vehicle.advance(10.0)
    counts = Counter(int.from_bytes(delivery.data[7:10], "little") for delivery in deliveries)
    assert all(abs(counts[message_id] - 10.0 * rate) <= 1 for message_id, rate in OFFBOARD.rates_hz.items())
    assert counts[mavlink.MAVLINK_MSG_ID_ATTITUDE] == 1000
    assert vehicle.simulation.time_s == 10.0
    first = parse(deliveries)[0]
    assert (first.get_srcSystem(), first.get_srcComponent()) == (1, 1)


def test_time_advances_in_whole_ticks() -> None:
    vehicle, _ = fake_vehicle()
    assert vehicle.advance(0.009) == []
    assert vehicle.advance(0.019)
    assert vehicle.simulation.time_s == 0.01


def test_message_times_are_the_simulations() -> None:
    vehicle, _ = fake_vehicle()
    times = [m.time_boot_ms for m in parse(vehicle.advance(0.5)) if m.get_type() == "ATTITUDE"]
    assert times == list(range(10, 501, 10))


def test_frames_are_late_and_sorted_by_arrival_under_latency() -> None:
    vehicle, _ = fake_vehicle(REALISTIC)
    late = []
    for tick in range(1, 501):
        deliveries = vehicle.advance(tick / 100)
        assert deliveries == sorted(deliveries, key=lambda delivery: delivery.time_s)
        late += [delivery.time_s - tick / 100 for delivery in deliveries]
    assert 0.01 <= min(late) < 0.011
    assert 0.029 < max(late) <= 0.03


def test_one_frame_in_a_hundred_is_lost() -> None:
    lossy, _ = fake_vehicle(REALISTIC)
    whole, _ = fake_vehicle()
    assert len(lossy.advance(60.0)) / len(whole.advance(60.0)) == pytest.approx(0.99, abs=0.002)


def test_the_seed_fixes_every_byte_and_every_arrival() -> None:
    def flight(seed: int) -> list[tuple[float, bytes]]:
        vehicle, _ = fake_vehicle(REALISTIC, seed=seed)
        vehicle.receive(encode(command_long(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1.0)))
        return [(delivery.time_s, delivery.data) for delivery in vehicle.advance(5.0)]

    assert flight(3) == flight(3)
    assert flight(3) != flight(4)


def test_setpoints_reach_the_firmware_after_their_latency() -> None:
    vehicle, firmware = fake_vehicle(REALISTIC)
    vehicle.advance(1.0)
    vehicle.receive(encode(setpoint(7.0)))
    vehicle.advance(1.02)
    assert firmware.setpoints == []
    vehicle.advance(1.03)
    np.testing.assert_array_equal(firmware.setpoints[0].position, [7.0, 0.0, -2.0])


def test_setpoints_for_others_are_left_alone() -> None:
    vehicle, firmware = fake_vehicle()
    for target in ((2, 1), (1, 191)):
        vehicle.receive(encode(setpoint(1.0, *target)))
    for target in ((0, 0), (1, 0)):
        vehicle.receive(encode(setpoint(2.0, *target)))
    vehicle.advance(0.01)
    assert [s.position[0] for s in firmware.setpoints] == [2.0, 2.0]


def test_a_refused_setpoint_is_answered_with_the_reason() -> None:
    vehicle, firmware = fake_vehicle()
    masked = setpoint(1.0)
    masked.type_mask = 0b1_1111_1111
    (text,) = answers(vehicle, masked)
    assert text.text == "SET_POSITION_TARGET_LOCAL_NED invalid"
    assert firmware.setpoints == []


def test_status_texts_go_to_every_link_and_to_who_watches() -> None:
    vehicle, firmware = fake_vehicle(links=(OFFBOARD, GROUND_STATION))
    firmware.texts = [StatusText(Severity.WARNING, "Arming denied: no position")]
    deliveries = vehicle.advance(0.01)
    links = [d.link for d in deliveries if parse([d])[0].get_type() == "STATUSTEXT"]
    assert links == [OFFBOARD, GROUND_STATION]
    assert [text.text for text in vehicle.status_texts] == ["Arming denied: no position"]


@pytest.mark.parametrize("length", [1, 49, 50, 51, 99, 100, 101, 250])
def test_a_text_of_any_length_can_be_put_together_again(length: int) -> None:
    vehicle, firmware = fake_vehicle()
    text = "".join(chr(ord("a") + i % 26) for i in range(length))
    firmware.texts = [StatusText(Severity.INFO, text)]
    chunks = answers(vehicle)
    assert [chunk.chunk_seq for chunk in chunks] == list(range(len(chunks)))
    assert len({chunk.id for chunk in chunks}) == 1
    assert "".join(chunk.text for chunk in chunks) == text
    if length > 50:
        assert chunks[0].id != 0
        assert len(chunks[-1].text) < 50


def test_answers_go_to_the_link_that_asked() -> None:
    vehicle, _ = fake_vehicle(links=(OFFBOARD, GROUND_STATION))
    vehicle.receive(encode(command_long(mavlink.MAV_CMD_NAV_LAND)), GROUND_STATION)
    links = [d.link for d in vehicle.advance(0.01) if parse([d])[0].get_type() == "COMMAND_ACK"]
    assert links == [GROUND_STATION]


def test_timesync_requests_are_answered_with_the_time_since_boot() -> None:
    vehicle, _ = fake_vehicle()
    vehicle.advance(2.5)
    (answer,) = answers(vehicle, mavlink.MAVLink_timesync_message(tc1=0, ts1=987654321))
    assert (answer.tc1, answer.ts1) == (2_500_000_000, 987654321)
    assert answers(vehicle, mavlink.MAVLink_timesync_message(tc1=5, ts1=7)) == []


def test_pings_to_everyone_are_answered_to_their_sender() -> None:
    vehicle, _ = fake_vehicle()
    (answer,) = answers(vehicle, mavlink.MAVLink_ping_message(123, 7, 0, 0))
    assert (answer.time_usec, answer.seq) == (123, 7)
    assert (answer.target_system, answer.target_component) == (PEER_SYSTEM, PEER_COMPONENT)
    assert answers(vehicle, mavlink.MAVLink_ping_message(123, 7, 1, 1)) == []


def still_answers(vehicle: MavlinkVehicle) -> bool:
    told = answers(vehicle, mavlink.MAVLink_ping_message(123, 7, 0, 0))
    return any(message.get_type() == "PING" and message.seq == 7 for message in told)


@settings(max_examples=200, deadline=None)
@given(st.sampled_from(sorted(mavlink.mavlink_map)), st.binary(max_size=255), st.integers(0, 255))
def test_no_message_with_any_payload_harms(message_id: int, payload: bytes, sequence: int) -> None:
    """Every message of the dialect, filled at random and with a right checksum."""
    vehicle, _ = fake_vehicle()
    header = struct.pack(
        "<BBBBBBBHB", 253, len(payload), 0, 0, sequence, 9, 9, message_id & 0xFFFF, message_id >> 16
    )
    crc = mavlink.x25crc(header[1:] + payload + bytes([mavlink.mavlink_map[message_id].crc_extra])).crc
    vehicle.receive(header + payload + struct.pack("<H", crc))
    vehicle.advance(0.02)
    assert still_answers(vehicle)


@given(st.integers(0, 65535), st.lists(st.floats(width=32), min_size=7, max_size=7))
def test_no_command_with_any_parameters_harms(command: int, params: list[float]) -> None:
    vehicle, _ = fake_vehicle()
    vehicle.receive(encode(command_long(command, *params)))
    vehicle.advance(0.02)
    assert still_answers(vehicle)


@pytest.mark.parametrize("command", [400, 22, 21, 20, 176, 192, 511, 510, 512, 519, 520, 410, 420])
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 3.4e38, -1.0])
def test_known_commands_bear_any_number(command: int, value: float) -> None:
    vehicle, _ = fake_vehicle()
    vehicle.receive(encode(command_long(command, *[value] * 7)))
    assert any(m.get_type() == "COMMAND_ACK" for m in parse(vehicle.advance(0.02)))
