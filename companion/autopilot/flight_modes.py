"""The modes of a vehicle in flight: whose it is, and waiting for what it was asked to do."""

import asyncio
from collections.abc import Callable, Container

from companion import clock
from companion.errors import FlightError, LinkError, NoReplyError, TakenError
from companion.link.command import command
from companion.link.connection import Connection
from companion.link.dialect import Message, mavlink
from companion.link.telemetry import Telemetry

HOLD_ATTEMPTS = 2
"""A hold that is asked for longer than a vehicle waits for setpoints could undo what its failsafe did, or
its pilot after that."""
MODE_TIMEOUT_S = 3.0
"""A change of mode shows in the next HEARTBEAT, which comes once a second."""
_POLL_S = 0.02


class FlightModes:
    """The modes of one vehicle, by HEARTBEAT.custom_mode, and whether it is ours.

    Args:
        connection: to the vehicle.
        telemetry: of the same vehicle.
        name: the autopilot's own name of a mode.
        following: the mode in which the vehicle follows setpoints.
    """

    def __init__(
        self, connection: Connection, telemetry: Telemetry, name: Callable[[int], str], following: int
    ) -> None:
        self._connection = connection
        self._telemetry = telemetry
        self._name = name
        self._following = following
        self._engaged = False
        self._overruled = False
        self._taken = asyncio.Event()
        self._taken_by = ""
        for report in (mavlink.MAVLink_heartbeat_message, mavlink.MAVLink_current_mode_message):
            connection.subscribe(report, self._watch)

    @property
    def now(self) -> str:
        """The name of the mode that the vehicle is in."""
        return self._name(self._telemetry.status.custom_mode)

    @property
    def engaged(self) -> bool:
        """Whether the vehicle follows our setpoints, in the mode for that because we asked for it."""
        return self._engaged

    @property
    def overruled(self) -> bool:
        """Whether PX4 says that a failsafe has it in another mode than was chosen last."""
        return self._overruled

    @property
    def taken(self) -> bool:
        """Whether the vehicle changed its mode unasked since it was last engaged."""
        return self._taken.is_set()

    def engage(self) -> None:
        """From now on, leaving the mode that follows setpoints is noticed."""
        self._taken.clear()
        self._engaged = True

    def release(self) -> None:
        """We are about to send the vehicle elsewhere."""
        self._engaged = False

    async def until_taken(self) -> str:
        """Wait until the engaged vehicle changes its mode unasked; the name of the mode that it went to."""
        await self._taken.wait()
        return self._taken_by

    async def switch(self, mode: int, *params: float, attempts: int = 4) -> None:
        """Have the vehicle go to `mode`, as parameters 2 and on of MAV_CMD_DO_SET_MODE name it.

        One that is in the mode by then has heard us, even if its answers were lost.

        Args:
            mode: custom_mode of the HEARTBEAT that shows that it did.
            params: of the command.
            attempts: how often to ask, each for half a second.

        Raises:
            RefusedError, NoReplyError, FlightError, LinkError: as `command` and `until`.
        """
        flags = mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
        try:
            await command(self._connection, mavlink.MAV_CMD_DO_SET_MODE, flags, *params, attempts=attempts)
        except NoReplyError:
            if not self._is_in((mode,)):
                raise
        await self.until(lambda: self._is_in((mode,)), MODE_TIMEOUT_S, f"it did not go to {self._name(mode)}")

    async def until(self, condition: Callable[[], bool], timeout_s: float, otherwise: str) -> None:
        """Wait until `condition` holds.

        Raises:
            FlightError: it did not within `timeout_s` (s); `otherwise` says what that means.
            LinkError: the vehicle fell silent meanwhile.
        """
        give_up_s = clock.now() + timeout_s
        while not condition():
            if self._connection.lost:
                raise LinkError("the vehicle fell silent: check the link")
            if clock.now() >= give_up_s:
                raise FlightError(
                    f"the vehicle accepted, but {otherwise} within {timeout_s:g} s; mode {self.now}"
                )
            await asyncio.sleep(_POLL_S)

    def unless_taken(self, modes: tuple[int, ...], condition: Callable[[], bool]) -> Callable[[], bool]:
        """`condition`, but for a TakenError once the vehicle was in the first of `modes` and is in none.

        Heartbeats alone tell, as they have mode and arming of one instant: a vehicle that has landed changes
        its mode when it disarms itself.
        """
        begun = False

        def checked() -> bool:
            nonlocal begun
            if condition():
                return True
            heartbeat = self._connection.heartbeat
            begun = begun or heartbeat.custom_mode == modes[0]
            armed = heartbeat.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED
            if begun and armed and heartbeat.custom_mode not in modes:
                raise TakenError(f"the vehicle went to {self.now} unasked: it was left to whoever did that")
            return False

        return checked

    def _is_in(self, modes: Container[int]) -> bool:
        return self._telemetry.status.custom_mode in modes

    def _watch(self, report: Message) -> None:
        if isinstance(report, mavlink.MAVLink_current_mode_message):
            self._overruled = report.intended_custom_mode not in (0, report.custom_mode)
        if self._engaged and not self._is_in((self._following,)):
            self._engaged = False
            self._taken_by = self.now
            self._taken.set()
