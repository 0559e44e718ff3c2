"""Hostile streams on a link: to the companion at one end of it, and to the simulated vehicle at the other.

Meanwhile the companion asks for all that it ever asks for, so that hostile answers find someone who waits.
"""

import asyncio
from collections.abc import Awaitable, Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise

import numpy as np
from pymavlink.dialects.v20 import common as vehicle_dialect

from companion import clock
from companion.autopilot import Autopilot, detect
from companion.errors import ImpromptuError
from companion.experiments.fuzz.hang import HangError, ended_after
from companion.experiments.fuzz.row import FuzzRow, described, some
from companion.experiments.fuzz.streams import Stream, message_id, random_stream, reading
from companion.experiments.memory import resident_bytes
from companion.flight.takeoff import take_off
from companion.link import connect, start_telemetry
from companion.link.address import Simulated
from companion.link.command import request_message
from companion.link.connection import Connection
from companion.link.dialect import Message, mavlink
from companion.link.framing import FrameSplitter
from companion.link.parameter_encoding import usual_encoding
from companion.link.parameter_list import list_parameters
from companion.link.simulated import SimulatedTransport
from companion.link.telemetry import Telemetry
from companion.mission.transfer import download_plan
from sitl.errors import SitlError
from sitl.mavlink import frames as vehicle_frames

PIECES = 64
"""Of one stream, the input whose time is bounded."""
LONGEST_S = 5.0
"""No stream may take more of the processor (s)."""

VEHICLES = ("bebop2", "arducopter_sitl")
_STREAM_EVERY_S = 0.02
_MOST_CUTS = 8
_ALTITUDE_M = 3.0
_SPOKEN = (
    *("heartbeat", "attitude", "local_position_ned", "timesync", "ping", "statustext", "sys_status"),
    *(
        "extended_sys_state",
        "gps_raw_int",
        "global_position_int",
        "home_position",
        "gps_global_origin",
        "estimator_status",
    ),
    *("ekf_status_report", "battery_status", "current_mode", "command_long", "command_int", "command_ack"),
    *(
        "param_value",
        "param_set",
        "param_request_read",
        "param_request_list",
        "mission_count",
        "mission_item",
    ),
    *("mission_item_int", "mission_request", "mission_request_int", "mission_request_list", "mission_ack"),
    *(
        "mission_set_current",
        "mission_clear_all",
        "mission_current",
        "manual_control",
        "rc_channels_override",
    ),
    *("set_position_target_local_ned", "set_position_target_global_int", "set_attitude_target", "set_mode"),
    *("set_gps_global_origin", "autopilot_version", "setup_signing"),
)
"""What either of the two makes something of."""
_KINDS: Sequence[type[Message]] = tuple(getattr(mavlink, f"MAVLink_{name}_message") for name in _SPOKEN)


@dataclass(eq=False)
class _Tally:
    """What was sent so far, and what came of it."""

    inputs: int = 0
    valid: int = 0
    swallowed: int = 0
    lost: int = 0
    faults: list[str] = field(default_factory=list)
    slowest_s: float = 0.0

    def count(self, stream: Stream, frames: Sequence[bytes]) -> None:
        """What one of the readers found in a stream."""
        found = reading(stream, frames)
        self.valid += len(stream.valid)
        self.swallowed += found.swallowed
        self.lost += found.lost


def fuzz_link(seed: int, inputs: int) -> FuzzRow:
    """Send so many pieces, in virtual time; the same seed, the same bytes."""
    rng = np.random.default_rng(seed)
    tally = _Tally()
    begun_s = clock.stopwatch_s()
    half_bytes = 0
    for until in (inputs // 2, inputs):
        half_bytes = resident_bytes()
        while tally.inputs < until:
            try:
                clock.run(_attack(tally, until, seed, rng), virtual=True)
            except (ImpromptuError, SitlError):
                pass  # the connection was talked to death, as its user is told: the next one
            except (Exception, HangError) as error:
                tally.faults.append(described(error))
    return FuzzRow(
        reader="link",
        inputs=tally.inputs,
        valid=tally.valid,
        swallowed=tally.swallowed,
        lost=tally.lost,
        faults=some(tally.faults),
        slowest_s=tally.slowest_s,
        grown_bytes=resident_bytes() - half_bytes,
        wall_s=clock.stopwatch_s() - begun_s,
    )


async def _attack(tally: _Tally, until: int, seed: int, rng: np.random.Generator) -> None:
    """One connection after its vehicle was found, until so many pieces are sent or it ends."""
    address = Simulated(VEHICLES[seed % len(VEHICLES)], seed=seed)
    async with connect(address) as connection:
        telemetry = await start_telemetry(connection)
        autopilot = await detect(connection, telemetry)
        transport = connection.transport
        assert isinstance(transport, SimulatedTransport)
        for request in _requests(connection, telemetry, autopilot):
            connection.spawn(_again_and_again(request))
        splitter = FrameSplitter()
        while tally.inputs < until:
            stream = random_stream(PIECES, _KINDS, rng)
            tally.inputs += PIECES
            begun_s = clock.processor_s()
            with ended_after(LONGEST_S):
                frames = []
                for piece in _in_pieces(stream.data, rng):
                    frames += [frame.data for frame in splitter.feed(piece)]
                    connection.bytes_received(piece)
                transport.vehicle.receive(stream.data)
                await asyncio.sleep(_STREAM_EVERY_S)
            tally.slowest_s = max(tally.slowest_s, clock.processor_s() - begun_s)
            tally.count(stream, frames)
            tally.count(*_vehicle_reads(stream))


def _in_pieces(data: bytes, rng: np.random.Generator) -> Iterator[bytes]:
    places = np.sort(rng.integers(0, len(data), _MOST_CUTS)).tolist()
    for start, end in pairwise([0, *places, len(data)]):
        yield data[start:end]


def _vehicle_reads(stream: Stream) -> tuple[Stream, list[bytes]]:
    """What the vehicle's dialect has of the stream, and the frames that it finds."""
    known = [(start, data) for start, data in stream.valid if message_id(data) in vehicle_dialect.mavlink_map]
    return Stream(stream.data, known), [
        bytes(found.get_msgbuf()) for found in vehicle_frames.decode(stream.data)
    ]


def _requests(
    connection: Connection, telemetry: Telemetry, autopilot: Autopilot
) -> Sequence[Callable[[], Awaitable[object]]]:
    """What is asked of a vehicle, one way or another; some of it makes it fly."""
    return (
        partial(take_off, autopilot, telemetry, _ALTITUDE_M, lambda text: None),
        autopilot.engage,
        partial(list_parameters, connection, usual_encoding(connection.heartbeat.autopilot)),
        partial(download_plan, connection),
        partial(request_message, connection, mavlink.MAVLink_autopilot_version_message),
    )


async def _again_and_again(request: Callable[[], Awaitable[object]]) -> None:
    while True:
        with suppress(ImpromptuError):
            await request()
        await asyncio.sleep(_STREAM_EVERY_S)
