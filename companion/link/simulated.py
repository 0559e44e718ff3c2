"""The built-in vehicle behind `sitl://`: its bytes, in this process and in the event loop's time.

In a `VirtualTimeLoop` the whole flight is deterministic, and as fast as the machine allows.
"""

import asyncio
import heapq
from itertools import count
from typing import TYPE_CHECKING

from companion.errors import InputError, LinkError
from companion.link.address import Simulated
from companion.link.transport import Receiver

if TYPE_CHECKING:
    from sitl.mavlink import MavlinkVehicle

_TICK_S = 0.01
_ROUNDING_S = 1e-9


def open_simulated(address: Simulated, receiver: Receiver) -> "SimulatedTransport":
    """A vehicle on the ground whose time 0 is now.

    Raises:
        InputError: the vehicle, the conditions or a fault are not there, or wrong.
        LinkError: what the simulator needs is not installed.
    """
    try:
        from sitl.errors import SitlError
        from sitl.faults.reading import parse_faults
        from sitl.mavlink import open_vehicle
    except ModuleNotFoundError as error:
        raise LinkError(
            f"the built-in vehicle needs {error.name}: install it with `pip install 'impromptu[sim]'`"
        ) from error
    try:
        vehicle = open_vehicle(
            address.vehicle,
            address.conditions,
            seed=address.seed,
            record_truth=address.record_truth,
            faults=parse_faults(address.faults),
        )
    except SitlError as error:
        raise InputError(str(error)) from error
    return SimulatedTransport(vehicle, receiver)


class SimulatedTransport:
    """A simulated vehicle as a `Transport`; made by `open_simulated`.

    Attributes:
        vehicle: the vehicle itself, for experiments that look behind the link.
        epoch_s: companion clock at the vehicle's time 0 (s).
    """

    def __init__(self, vehicle: "MavlinkVehicle", receiver: Receiver) -> None:
        self.dropped = 0
        self.vehicle = vehicle
        self._receiver = receiver
        self._loop = asyncio.get_running_loop()
        self.epoch_s = self._loop.time()
        self._ticks = 0
        self._order = count()
        self._on_the_way: list[tuple[float, int, bytes]] = []
        self._timer = self._loop.call_at(self.epoch_s, self._on_time)

    def send(self, data: bytes) -> None:
        """Send one frame; the vehicle's own link makes it late."""
        self.vehicle.receive(data)

    def answer_sender(self) -> None:
        """Nothing to do: there is one peer."""

    async def aclose(self) -> None:
        """Let the vehicle's time stand still."""
        self._timer.cancel()

    def _on_time(self) -> None:
        """Move the vehicle up to now, hand on what has arrived, and come back at whatever is next."""
        now_s = self._loop.time() - self.epoch_s + _ROUNDING_S
        try:
            if now_s >= self._ticks * _TICK_S:
                self._advance(now_s)
            while self._on_the_way and self._on_the_way[0][0] <= now_s:
                self._receiver.bytes_received(heapq.heappop(self._on_the_way)[2])
        except Exception as error:
            self._receiver.transport_lost(error)
            return
        next_s = self._ticks * _TICK_S
        if self._on_the_way:
            next_s = min(next_s, self._on_the_way[0][0])
        self._timer = self._loop.call_at(self.epoch_s + next_s, self._on_time)

    def _advance(self, now_s: float) -> None:
        for delivery in self.vehicle.advance(now_s):
            heapq.heappush(self._on_the_way, (delivery.time_s, next(self._order), delivery.data))
        self._ticks = int(now_s / _TICK_S) + 1
