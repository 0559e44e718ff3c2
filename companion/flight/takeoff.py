"""From wherever the vehicle is found into the air: wait until it knows its position, arm, climb."""

import asyncio
from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from companion import clock
from companion.arrays import Vec3
from companion.autopilot import Autopilot
from companion.errors import FlightError, RefusedError
from companion.link.status import Landed
from companion.link.telemetry import Telemetry

Announce: TypeAlias = Callable[[str], None]

_READY_WITHIN_S = 60.0
"""How long a vehicle that was just switched on may take until it can be armed."""
_ASK_AGAIN_S = 1.0
_TELLS_WITHIN_S = 3.0
_POLL_S = 0.05


async def is_flying(telemetry: Telemetry, note: Announce) -> bool:
    """Whether the vehicle is off the ground; waits until it knows its position.

    Raises:
        LinkError: it knows none in time.
        FlightError: it does not tell whether it flies.
    """
    if telemetry.state is None:
        note("waiting until the vehicle knows its position")
    await telemetry.next_state(_READY_WITHIN_S)
    if not await _told(lambda: telemetry.status.landed is not Landed.UNDEFINED):
        raise FlightError("the vehicle does not tell whether it flies: have it send EXTENDED_SYS_STATE")
    return telemetry.status.landed is not Landed.ON_GROUND


async def home_of(telemetry: Telemetry, note: Announce) -> Vec3:
    """Where a vehicle in the air took off (NED, m)."""
    if not await _told(lambda: telemetry.status.home is not None):
        note("the vehicle tells no home position: the origin of its own map stands in")
    return np.zeros(3) if telemetry.status.home is None else telemetry.status.home


async def take_off(autopilot: Autopilot, telemetry: Telemetry, altitude_m: float, note: Announce) -> Vec3:
    """Arm and climb to `altitude_m` above where the vehicle is; where it took off (NED, m).

    Asks again while the vehicle is still getting ready, and tells why it is not. One that disarmed itself
    meanwhile, as PX4 does after COM_DISARM_PRFLT, is armed again.

    Raises:
        RefusedError: the vehicle still refuses after a minute.
    """
    give_up_s = clock.now() + _READY_WITHIN_S
    said: set[str] = set()

    def once(text: str) -> None:
        if text not in said:
            said.add(text)
            note(text)

    while True:
        try:
            once("arming")
            await autopilot.arm()
            start = await telemetry.next_state()
            once(f"taking off to {altitude_m:g} m")
            await autopilot.takeoff(altitude_m)
        except RefusedError as refusal:
            if clock.now() >= give_up_s:
                raise
            once(f"not ready, trying for up to {_READY_WITHIN_S:g} s: {refusal}")
        else:
            return start.position
        await asyncio.sleep(_ASK_AGAIN_S)


async def _told(condition: Callable[[], bool]) -> bool:
    """Wait a little for what the vehicle tells now and then; whether it did."""
    give_up_s = clock.now() + _TELLS_WITHIN_S
    while clock.now() < give_up_s:
        if condition():
            return True
        await asyncio.sleep(_POLL_S)
    return condition()
