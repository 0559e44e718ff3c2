from typing import Any

from mavlink_fakes import FakeSimulation, command_long, encode
from pymavlink.dialects.v20 import common as mavlink

from sitl.mavlink.frames import Encoder, decode
from sitl.mavlink.signing import Signing
from sitl.mavlink.vehicle import MavlinkVehicle

KEY, OTHER_KEY = bytes(range(32)), bytes(32)


def peer(key: bytes = KEY, timestamp: int = 10**13) -> mavlink.MAVLink:
    """A ground station that signs."""
    station = mavlink.MAVLink(None, 255, 190)
    station.signing.secret_key = key
    station.signing.sign_outgoing = True
    station.signing.timestamp = timestamp
    return station


def received(frame: bytes) -> Any:
    (message,) = decode(frame)
    return message


def arm() -> Any:
    return command_long(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1.0)


def test_what_the_vehicle_signs_is_believed_by_pymavlink() -> None:
    encoder, station = Encoder(1, 3, Signing(KEY)), peer(timestamp=0)
    frames = [encoder.encode(arm()) for _ in range(3)]
    assert [frame[-13] for frame in frames] == [3, 3, 3]
    assert [station.decode(bytearray(frame)).get_type() for frame in frames] == ["COMMAND_LONG"] * 3


def test_only_what_is_signed_and_newer_than_the_last_is_believed() -> None:
    signing, station = Signing(KEY), peer()
    first, second = (received(arm().pack(station)) for _ in range(2))
    assert [signing.believes(message) for message in (first, second, first, second)] == [
        True,
        True,
        False,
        False,
    ]
    assert not signing.believes(received(encode(arm())))
    assert not signing.believes(received(arm().pack(peer(OTHER_KEY, 2**47))))
    assert signing.believes(received(arm().pack(station)))


def test_the_vehicles_time_is_the_latest_that_it_heard() -> None:
    signing = Signing(KEY)
    assert signing.next_timestamp() == 1
    assert signing.believes(received(arm().pack(peer(timestamp=10**13))))
    assert signing.next_timestamp() == 10**13 + 1
    late = peer(timestamp=10**13 - 6_000_000)
    late.srcSystem = 7
    assert not signing.believes(received(arm().pack(late)))


def test_a_vehicle_with_a_key_obeys_and_tells_only_who_has_it() -> None:
    simulation: Any = FakeSimulation()
    vehicle, firmware = MavlinkVehicle(simulation, signing_key=KEY), simulation.firmware
    vehicle.receive(encode(arm()))
    vehicle.advance(0.1)
    assert not firmware.armed
    vehicle.receive(arm().pack(peer()))
    deliveries = vehicle.advance(0.2)
    assert firmware.armed
    assert all(delivery.data[2] & mavlink.MAVLINK_IFLAG_SIGNED for delivery in deliveries)
