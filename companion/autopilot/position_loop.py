"""How strongly an autopilot answers to setpoints: the gains of its position loop over its velocity loop."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from companion.arrays import Vec3
from companion.errors import NoReplyError
from companion.link.connection import Connection
from companion.link.parameter import read_parameter


class PositionLoop(NamedTuple):
    """What an error makes an autopilot do, by axis: north, east, down.

    Attributes:
        stiffness_1_s2: acceleration for a position error (1/s²).
        damping_1_s: acceleration for a velocity error (1/s).
    """

    stiffness_1_s2: Vec3
    damping_1_s: Vec3


def loop_of(gains: Sequence[float]) -> PositionLoop:
    """Of position and vertical position gain, velocity and vertical velocity gain (1/s)."""
    position, position_z, velocity, velocity_z = gains
    damping = np.array([velocity, velocity, velocity_z])
    return PositionLoop(damping * np.array([position, position, position_z]), damping)


async def read_position_loop(connection: Connection, namings: Sequence[Sequence[str]]) -> PositionLoop:
    """By the first names that the vehicle answers for.

    Args:
        connection: to the vehicle.
        namings: names of the four gains, in the order of `loop_of`, of one version or another.

    Raises:
        NoReplyError: it answers for none, or with gains that make no loop.
    """
    for names in namings:
        try:
            gains = [float(await read_parameter(connection, name)) for name in names]
        except NoReplyError:
            continue
        if all(0.0 < gain < np.inf for gain in gains):
            return loop_of(gains)
    raise NoReplyError(f"the vehicle tells no gains of its position loop ({', '.join(namings[0])})")
