import math
import struct

import pytest
from fake_vehicle import FakeVehicle, in_virtual_time
from hypothesis import given, settings
from hypothesis import strategies as st
from parameter_vehicle import ROUGH, ParameterVehicle, Trouble, many

from companion import clock
from companion.errors import NoReplyError
from companion.link.connection import connect_over
from companion.link.dialect import mavlink
from companion.link.parameter import read_parameters, same_value, set_parameters
from companion.link.parameter_encoding import (
    Encoding,
    Number,
    Parameter,
    ParameterType,
    decode_value,
    encode_value,
    parameter_encoding,
)
from companion.link.parameter_exchange import Exchange
from companion.link.parameter_list import list_parameters

INT32, REAL32 = ParameterType.INT32, ParameterType.REAL32
BOTH = pytest.mark.parametrize("encoding", [Encoding.BYTEWISE, Encoding.CAST])


def listed(vehicle: ParameterVehicle) -> dict[str, tuple[Number, ParameterType]]:
    async def scenario() -> dict[str, tuple[Number, ParameterType]]:
        async with connect_over(vehicle.open) as connection:
            found = await list_parameters(connection, vehicle.encoding)
        return {name: (each.value, each.type) for name, each in found.items()}

    return clock.run(scenario(), virtual=True)


@BOTH
def test_all_parameters_come_with_their_types_and_in_order(encoding: Encoding) -> None:
    vehicle = ParameterVehicle(many(900), encoding)
    found = listed(vehicle)
    assert list(found.items()) == list(vehicle.values.items())
    assert "_HASH_CHECK" not in found


@BOTH
@pytest.mark.parametrize("seed", range(3))
def test_all_parameters_come_over_a_rough_link(encoding: Encoding, seed: int) -> None:
    trouble = Trouble(ROUGH.lost, ROUGH.duplicated, ROUGH.reordered, ROUGH.jitter_s, seed)
    vehicle = ParameterVehicle(many(1300), encoding, trouble)
    assert listed(vehicle) == vehicle.values
    assert len(vehicle.requests) < 250  # gaps are filled, the list is not asked for again


@given(
    count=st.integers(1, 60),
    trouble=st.builds(
        Trouble,
        lost=st.floats(0.0, 0.4),
        duplicated=st.floats(0.0, 0.5),
        reordered=st.floats(0.0, 0.5),
        jitter_s=st.floats(0.0, 0.3),
        seed=st.integers(0, 10_000),
    ),
)
@settings(max_examples=25)
def test_what_is_listed_is_what_there_is_or_an_error(count: int, trouble: Trouble) -> None:
    vehicle = ParameterVehicle(many(count), Encoding.CAST, trouble)
    try:
        found = listed(vehicle)
    except NoReplyError:
        assert trouble.lost > 0.2
    else:
        assert found == vehicle.values


def test_a_count_that_changes_meanwhile_moves_every_index() -> None:
    vehicle = ParameterVehicle(many(50), Encoding.CAST)
    vehicle.newcomer = (20, "NEW_ENABLE")
    assert listed(vehicle) == vehicle.values
    assert "NEW_ENABLE" in vehicle.values


@in_virtual_time
async def test_a_vehicle_without_parameters_is_told() -> None:
    async with connect_over(FakeVehicle().open) as connection:
        with pytest.raises(NoReplyError, match="no parameters"):
            await list_parameters(connection, Encoding.BYTEWISE)


@BOTH
def test_settings_are_verified_over_a_rough_link(encoding: Encoding) -> None:
    @in_virtual_time
    async def scenario() -> None:
        vehicle = ParameterVehicle(many(200), encoding, ROUGH)
        wanted = [Parameter(name, value + 1, kind) for name, (value, kind) in vehicle.values.items()]
        done: list[int] = []
        async with connect_over(vehicle.open) as connection:
            assert await set_parameters(connection, wanted, encoding, progress=done.append) == {}
        for each in wanted:
            assert same_value(vehicle.values[each.name][0], each.value)
        assert done[-1] == 200

    scenario()


@in_virtual_time
async def test_what_a_vehicle_does_not_take_is_told_with_its_reason() -> None:
    vehicle = ParameterVehicle(many(5), Encoding.CAST)
    vehicle.read_only.add("INT_1")
    change = [Parameter("INT_1", 5, INT32), Parameter("INT_3", 6, INT32), Parameter("NONE", 1, INT32)]
    async with connect_over(vehicle.open) as connection:
        left = await set_parameters(connection, change, Encoding.CAST)
        assert left == {"INT_1": "it keeps -299", "NONE": "it does not answer"}
        vehicle.says_errors = True
        left = await set_parameters(connection, change, Encoding.CAST)
        assert left == {"INT_1": "it says READ_ONLY", "NONE": "it says DOES_NOT_EXIST"}
    assert vehicle.values["INT_3"] == (6, INT32)


@in_virtual_time
async def test_parameters_that_are_not_there_are_left_out() -> None:
    vehicle = ParameterVehicle(many(5), Encoding.BYTEWISE)
    async with connect_over(vehicle.open) as connection:
        found = await read_parameters(connection, ["SIXTEEN_LETTERS_", "NONE"], Encoding.BYTEWISE)
    assert found == {"SIXTEEN_LETTERS_": Parameter("SIXTEEN_LETTERS_", -7, INT32)}


@BOTH
@pytest.mark.parametrize("tells", [True, False])
def test_the_encoding_is_what_the_vehicle_says_or_what_its_autopilot_uses(
    encoding: Encoding, tells: bool
) -> None:
    @in_virtual_time
    async def scenario() -> None:
        vehicle = ParameterVehicle({}, encoding)
        vehicle.tells_capabilities = tells
        async with connect_over(vehicle.open) as connection:
            assert await parameter_encoding(connection) is encoding

    scenario()


INTEGERS = st.sampled_from([kind for kind in ParameterType if kind.is_integer])


@given(kind=INTEGERS, data=st.data())
def test_an_integer_comes_back_from_its_bytes(kind: ParameterType, data: st.DataObject) -> None:
    value = data.draw(st.integers(-(2**31), 2**32 - 1).filter(kind.holds))
    as_float = struct.unpack("<f", struct.pack("<i" if value < 0 else "<I", value))[0]
    if not math.isnan(as_float):  # the bits of a signalling NaN do not survive being a Python float
        assert decode_value(encode_value(value, kind, Encoding.BYTEWISE), kind, Encoding.BYTEWISE) == value


@given(st.integers(-(2**24), 2**24))
def test_a_cast_integer_comes_back_where_a_float_holds_it(value: int) -> None:
    (field,) = struct.unpack("<f", struct.pack("<f", encode_value(value, INT32, Encoding.CAST)))
    assert decode_value(field, INT32, Encoding.CAST) == value


def test_an_integer_type_holds_only_whole_numbers_in_its_range() -> None:
    assert ParameterType.INT8.holds(-128)
    assert not ParameterType.INT8.holds(128)
    assert not ParameterType.UINT8.holds(-1)
    assert not INT32.holds(0.5)
    assert REAL32.holds(0.5)


@pytest.mark.parametrize(
    ("one", "other", "same"),
    [
        (0.3, 0.30000001192, True),
        (0.3, 0.3001, False),
        (16777217, 16777216, False),
        (math.nan, math.nan, True),
        (math.nan, 0.0, False),
        (1, 1.0, True),
        (0.0, -0.0, True),
        (1e300, 1e300, True),
    ],
)
def test_values_are_compared_as_a_vehicle_keeps_them(one: Number, other: Number, same: bool) -> None:
    assert same_value(one, other) is same


@in_virtual_time
async def test_requests_under_way_are_bounded() -> None:
    asked: list[int] = []
    exchange = Exchange(range(100), asked.append, attempts=2)
    await exchange.run()
    assert exchange.unanswered == set(range(100))
    assert len(asked) == 200
    assert asked[:8] == list(range(8))
    assert asked[8] == 0  # the first window is asked for again before anything new


def test_messages_for_one_parameter_do_not_answer_for_another() -> None:
    @in_virtual_time
    async def scenario() -> None:
        vehicle = FakeVehicle()
        vehicle.script[mavlink.MAVLink_param_request_read_message] = lambda message: [
            mavlink.MAVLink_param_value_message(b"OTHER", 9.0, 9, 2, 0)
        ]
        async with connect_over(vehicle.open) as connection:
            assert await read_parameters(connection, ["MINE"], Encoding.CAST) == {}

    scenario()
