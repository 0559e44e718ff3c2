"""The built-in vehicle in virtual time, behind a link on which a test may change, drop and add frames."""

import asyncio
from collections.abc import AsyncIterator, Callable, Coroutine
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np

from companion import clock
from companion.arrays import Vec3
from companion.autopilot import Autopilot, detect
from companion.errors import FlightError
from companion.flight.approach import rest_to_rest
from companion.flight.flight import FlightOutcome, FlightPlan, fly
from companion.flight.recorder import FlightRecorder
from companion.link import Connection, Telemetry, start_telemetry
from companion.link.address import Simulated
from companion.link.connection import connect_over
from companion.link.dialect import Message, mavlink
from companion.link.framing import FrameSplitter, decode
from companion.link.simulated import open_simulated
from companion.link.transport import Receiver
from companion.recording import Provenance
from companion.trajectory import Trajectory

T = TypeVar("T")

PROVENANCE = Provenance(vehicle="bebop2")
POSCTL = (3, 0)


def straight(start: Vec3 | None = None, end: Vec3 | None = None) -> Trajectory:
    """About four seconds along a line, 2 m above takeoff."""
    return rest_to_rest(
        np.array([0.0, 0.0, -2.0]) if start is None else start,
        np.array([2.0, 0.0, -2.5]) if end is None else end,
        "straight",
    )


class TamperedLink:
    """A `Transport` to the built-in vehicle, which it also keeps in `vehicle`.

    Attributes:
        incoming: what becomes of each message from the vehicle; None loses it.
        outgoing: whether each message to the vehicle arrives.
        sent: what the companion sent, with the time.
    """

    def __init__(self, conditions: str = "ideal", vehicle: str = "bebop2") -> None:
        self.dropped = 0
        self.incoming: Callable[[Any], Message | None] = lambda message: message
        self.outgoing: Callable[[Any], bool] = lambda message: True
        self.sent: list[tuple[float, Any]] = []
        self._address = Simulated(vehicle, conditions, seed=1)
        self._encoder = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
        self._pilot = mavlink.MAVLink(None, srcSystem=255, srcComponent=190)

    async def open(self, receiver: Receiver) -> "TamperedLink":
        self._receiver = receiver
        self._transport = open_simulated(self._address, self)
        self.simulated = self._transport.vehicle
        self.firmware = self.simulated.simulation.firmware
        self.estimator: Any = self.simulated.simulation._estimator
        return self

    def send(self, data: bytes) -> None:
        for message in _messages(data):
            self.sent.append((clock.now(), message))
            if self.outgoing(message):
                self._transport.send(data)

    def answer_sender(self) -> None: ...

    async def aclose(self) -> None:
        await self._transport.aclose()

    def bytes_received(self, data: bytes) -> None:
        for message in _messages(data):
            kept = self.incoming(message)
            if kept is not None:
                self.say(kept)

    def transport_lost(self, error: Exception) -> None:
        self._receiver.transport_lost(error)

    def say(self, message: Message) -> None:
        """Have the companion receive a message from the vehicle."""
        self._receiver.bytes_received(message.pack(self._encoder))

    def pilot_switches_to(self, mode: tuple[int, int]) -> None:
        """Have a ground station on the same vehicle change its mode: parameters 2 and 3 of DO_SET_MODE."""
        command = mavlink.MAVLink_command_long_message(
            1, 1, mavlink.MAV_CMD_DO_SET_MODE, 0, 1.0, mode[0], mode[1], 0.0, 0.0, 0.0, 0.0
        )
        self._transport.send(command.pack(self._pilot))

    def commanded(self, command_id: int) -> list[float]:
        """When the companion sent that command."""
        return [
            time_s
            for time_s, message in self.sent
            if isinstance(message, mavlink.MAVLink_command_long_message) and message.command == command_id
        ]

    def setpoint_times(self) -> list[float]:
        kind = mavlink.MAVLink_set_position_target_local_ned_message
        return [time_s for time_s, message in self.sent if isinstance(message, kind)]

    @property
    def mode(self) -> str:
        """The vehicle's mode, asked behind the link."""
        return self.firmware.mode.name


@dataclass
class Pilot:
    """A connected vehicle, and what flights on it say and keep."""

    connection: Connection
    autopilot: Autopilot
    telemetry: Telemetry
    recorder: FlightRecorder = field(default_factory=FlightRecorder)
    announced: list[str] = field(default_factory=list)
    on_announce: Callable[[str], None] = lambda text: None

    async def fly(self, plan: FlightPlan) -> FlightOutcome:
        return await fly(
            plan,
            self.autopilot,
            self.telemetry,
            provenance=PROVENANCE,
            recorder=self.recorder,
            announce=self._announce,
        )

    def _announce(self, text: str) -> None:
        self.announced.append(text)
        self.on_announce(text)


@asynccontextmanager
async def connected(link: TamperedLink) -> AsyncIterator[Pilot]:
    async with connect_over(link.open) as connection:
        telemetry = await start_telemetry(connection)
        yield Pilot(connection, await detect(connection, telemetry), telemetry)


def virtually(scenario: Coroutine[Any, Any, T]) -> T:
    return clock.run(scenario, virtual=True)


Trouble = Callable[[TamperedLink, Pilot], None]


def fly_with(
    link: TamperedLink,
    trouble: Trouble,
    *,
    phase: str = "tracking",
    after_s: float = 1.0,
    plan: FlightPlan | None = None,
) -> tuple[Pilot, FlightOutcome | None, BaseException | None]:
    """Fly, with `trouble` striking `after_s` into a phase; what came of it."""

    async def scenario() -> tuple[Pilot, FlightOutcome | None, BaseException | None]:
        async with connected(link) as pilot:

            def at(text: str) -> None:
                if text.startswith(phase):
                    asyncio.get_running_loop().call_later(after_s, trouble, link, pilot)

            pilot.on_announce = at
            try:
                return pilot, await pilot.fly(plan or FlightPlan(straight())), None
            except FlightError as error:
                await asyncio.sleep(3.0)  # whether anything goes on after the flight
                return pilot, None, error

    return virtually(scenario())


def without(*kinds: type[Message]) -> Callable[[Any], Message | None]:
    return lambda message: None if isinstance(message, kinds) else message


def _messages(data: bytes) -> list[Message]:
    return [decode(frame) for frame in FrameSplitter().feed(data)]
