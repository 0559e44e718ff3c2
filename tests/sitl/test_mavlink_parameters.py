import struct
from typing import Any

import pytest
from mavlink_fakes import ARDUCOPTER, answers, fake_vehicle, parse
from pymavlink.dialects.v20 import common as mavlink

from sitl.firmware.ardupilot_parameters import ArduPilotParameters
from sitl.firmware.px4_parameters import Px4Parameters
from sitl.mavlink import MavlinkVehicle
from sitl.mavlink.px4_parameters import parameter_hash

REAL32, INT32 = mavlink.MAV_PARAM_TYPE_REAL32, mavlink.MAV_PARAM_TYPE_INT32


def read(name: str = "", index: int = -1) -> Any:
    return mavlink.MAVLink_param_request_read_message(1, 1, name.encode(), index)


def write(name: str, value: float, kind: int = REAL32) -> Any:
    return mavlink.MAVLink_param_set_message(1, 1, name.encode(), value, kind)


def copied(value: int) -> float:
    """An integer as PX4 puts it into the float field."""
    (as_float,) = struct.unpack("<f", struct.pack("<i", value))
    return float(as_float)


def listed(vehicle: MavlinkVehicle) -> list[Any]:
    values = answers(vehicle, mavlink.MAVLink_param_request_list_message(1, 1))
    return values + parse(vehicle.advance(vehicle.simulation.time_s + 2.0))


def crc32_of_px4(data: bytes) -> int:
    crc = 0
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0xEDB88320 if crc & 1 else 0)
    return crc


def test_px4_lists_hash_and_parameters_in_its_encoding() -> None:
    vehicle, _ = fake_vehicle()
    first, *values = listed(vehicle)
    assert (first.param_id, first.param_index) == ("_HASH_CHECK", 65535)
    assert [value.param_index for value in values] == list(range(first.param_count))
    by_name = {value.param_id: value for value in values}
    assert by_name["MPC_XY_P"].param_value == pytest.approx(0.95)
    autostart = by_name["SYS_AUTOSTART"]
    assert autostart.param_type == INT32
    assert struct.unpack("<i", struct.pack("<f", autostart.param_value)) == (4001,)


@pytest.mark.parametrize("vehicle_file", [None, ARDUCOPTER])
def test_a_list_does_not_flood(vehicle_file: Any) -> None:
    vehicle, _ = fake_vehicle(vehicle=vehicle_file) if vehicle_file else fake_vehicle()
    assert 0 < len(answers(vehicle, mavlink.MAVLink_param_request_list_message(1, 1))) <= 6


def test_the_hash_is_px4s_and_knows_every_change() -> None:
    parameters = Px4Parameters()
    data = b"".join(
        name.encode() + struct.pack("<i" if isinstance(value, int) else "<f", value)
        for name, value in sorted(parameters.model_dump().items())
    )
    assert parameter_hash(parameters) == crc32_of_px4(data)
    assert parameter_hash(parameters.changed("MPC_XY_P", 1.0)) != parameter_hash(parameters)


def test_the_hash_is_asked_for_by_its_name_and_set_to_end_a_list() -> None:
    vehicle, firmware = fake_vehicle()
    (value,) = answers(vehicle, read("_HASH_CHECK"))
    as_written = struct.unpack("<I", struct.pack("<f", value.param_value))
    assert as_written == (parameter_hash(firmware.parameters),)
    answers(vehicle, mavlink.MAVLink_param_request_list_message(1, 1))
    assert answers(vehicle, write("_HASH_CHECK", 0.0)) == []


def test_px4_reads_by_name_or_index() -> None:
    vehicle, _ = fake_vehicle()
    (by_name,) = answers(vehicle, read("COM_OF_LOSS_T"))
    (by_index,) = answers(vehicle, read(index=by_name.param_index))
    assert by_name.param_id == by_index.param_id == "COM_OF_LOSS_T"
    assert by_name.param_value == by_index.param_value == 1.0
    assert answers(vehicle, read("NO_SUCH"), read(index=9999)) == []


def test_what_px4_is_told_to_set_acts_on_the_firmware() -> None:
    vehicle, firmware = fake_vehicle()
    real, whole = answers(vehicle, write("COM_OF_LOSS_T", 2.5), write("COM_OBL_RC_ACT", copied(4), INT32))
    assert (real.param_value, whole.param_value) == (2.5, copied(4))
    assert firmware.parameters == Px4Parameters(COM_OF_LOSS_T=2.5, COM_OBL_RC_ACT=4)


def test_px4_tells_the_old_value_when_it_refuses_one() -> None:
    vehicle, firmware = fake_vehicle()
    *text, value = answers(vehicle, write("MPC_XY_P", 99.0))
    assert "MPC_XY_P" in text[0].text
    assert value.param_value == pytest.approx(0.95)
    assert firmware.parameters == Px4Parameters()


def test_px4_does_not_take_another_type() -> None:
    vehicle, firmware = fake_vehicle()
    assert answers(vehicle, write("COM_OBL_RC_ACT", 4.0, REAL32), write("MPC_XY_P", 1.0, INT32)) == []
    assert firmware.parameters == Px4Parameters()


def test_ardupilot_converts_numbers_whatever_the_type() -> None:
    vehicle, firmware = fake_vehicle(vehicle=ARDUCOPTER)
    real, whole = answers(vehicle, write("WPNAV_SPEED", 500.0, INT32), write("RTL_ALT", 1999.995, REAL32))
    assert (real.param_value, real.param_type) == (500.0, REAL32)
    assert (whole.param_value, whole.param_type) == (2000.0, INT32)
    assert firmware.parameters == ArduPilotParameters(WPNAV_SPEED=500.0, RTL_ALT=2000)


def test_ardupilot_names_widths_and_gives_an_index_only_when_asked_by_index() -> None:
    vehicle, _ = fake_vehicle(vehicle=ARDUCOPTER)
    (by_name,) = answers(vehicle, read("DISARM_DELAY"))
    assert (by_name.param_type, by_name.param_index) == (mavlink.MAV_PARAM_TYPE_INT8, 65535)
    values = listed(vehicle)
    assert [value.param_index for value in values] == list(range(len(values)))
    assert {value.param_count for value in values} == {len(values)}


def test_parameters_for_others_are_left_alone() -> None:
    vehicle, firmware = fake_vehicle()
    other = mavlink.MAVLink_param_set_message(2, 1, b"MPC_XY_P", 1.0, REAL32)
    assert answers(vehicle, other, mavlink.MAVLink_param_request_list_message(2, 1)) == []
    assert firmware.parameters == Px4Parameters()
