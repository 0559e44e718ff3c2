"""What an autopilot offers to a flight, whichever it is.

Taking over is split in two: the flight streams setpoints by `send_setpoint`, and while it does, `engage`
has the vehicle follow them. Nothing here repeats a setpoint: when the flight stops, so does the stream,
and the autopilot's own failsafe acts.
"""

import math
from dataclasses import dataclass
from typing import ClassVar, Protocol

from companion.arrays import Vec3
from companion.autopilot.position_loop import PositionLoop


@dataclass(frozen=True, slots=True)
class MotionLimits:
    """What an autopilot keeps its vehicle to where it follows setpoints; infinite where to nothing.

    Attributes:
        up_m_s, down_m_s: climb and descent (m/s).
        acceleration_m_s2: horizontal (m/s²).
        vertical_acceleration_m_s2: m/s².
    """

    up_m_s: float
    down_m_s: float
    acceleration_m_s2: float = math.inf
    vertical_acceleration_m_s2: float = math.inf


class Autopilot(Protocol):
    """A vehicle that can be flown.

    Every method that asks something of it waits within a limit, and raises RefusedError when it refuses
    (with what it said), NoReplyError when it does not answer, FlightError when it accepts but does not
    follow in time, and TakenError when someone else takes the vehicle meanwhile.
    """

    usual_position_loop: ClassVar[PositionLoop]
    """That of the autopilot's default parameters."""

    @property
    def mode(self) -> str:
        """The flight mode, by the autopilot's own name."""
        ...

    @property
    def engaged(self) -> bool:
        """Whether the vehicle follows our setpoints."""
        ...

    @property
    def taken(self) -> bool:
        """Whether someone else took the vehicle since it followed our setpoints."""
        ...

    async def motion_limits(self) -> MotionLimits:
        """What it keeps the vehicle to."""
        ...

    async def position_loop(self) -> PositionLoop:
        """How strongly it answers to setpoints, as its parameters have it."""
        ...

    async def setpoint_timeout_s(self) -> float:
        """How long it waits for the next setpoint before it stops following them (s)."""
        ...

    async def arm(self) -> None:
        """Arm, unless it is armed."""
        ...

    async def takeoff(self, altitude_m: float) -> None:
        """Climb to `altitude_m` above where it is; returns when it is there."""
        ...

    async def engage(self) -> None:
        """Have the vehicle follow the setpoints, which must be streaming already."""
        ...

    async def hold(self) -> None:
        """Have the vehicle hold where it is, without setpoints."""
        ...

    async def land(self) -> None:
        """Land here; returns when the vehicle is on the ground and disarmed."""
        ...

    async def return_home(self) -> None:
        """Fly back to where it took off and land; returns when the vehicle is on the ground and disarmed."""
        ...

    async def until_taken(self) -> str:
        """Wait until the vehicle, engaged, changes its mode unasked (its pilot, its failsafe).

        Returns:
            The name of the mode that it went to.
        """
        ...

    def send_setpoint(
        self,
        position: Vec3 | None,
        velocity: Vec3 | None = None,
        acceleration: Vec3 | None = None,
        yaw: float | None = None,
    ) -> None:
        """Send one setpoint, now. What is None is left to the autopilot.

        Args:
            position: NED of the vehicle's local origin (m).
            velocity: NED (m/s).
            acceleration: NED (m/s²).
            yaw: rad.
        """
        ...
