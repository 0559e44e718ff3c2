"""What the learned models are shown: the vehicle's state or the trajectory's own, and the motion ahead."""

from functools import lru_cache
from typing import Protocol

import numpy as np
from jaxtyping import Float

from companion.arrays import Array, Vec3
from companion.learning.features import Preview, state_vector, tilt
from companion.state import VehicleState
from companion.trajectory.trajectory import Sample

_GRAVITY = np.array((0.0, 0.0, 9.80665))
_TILT_STEP_S = 0.02
"""Between the instants whose tilts make a rate: short beside the time that a multirotor takes to tilt."""


class DesiredMotion(Protocol):
    """What is to be flown, known ahead: a `Trajectory`, or anything that can be asked the same."""

    def at(self, time_s: float) -> Sample:
        """The sample at `time_s` of its own clock (s)."""
        ...

    def __hash__(self) -> int:
        """What was asked of it may be remembered."""
        ...


def state_of(state: VehicleState) -> Float[Array, "12"]:
    """x(k) of the paper (`features.state_vector`)."""
    return state_vector(state.position, state.velocity, state.attitude, state.rates)


@lru_cache(maxsize=4)  # what is asked twice at a step, by a network and by the online model
def flat_state(trajectory: DesiredMotion, time_s: float) -> Float[Array, "12"]:
    """x(k), read-only, of a multirotor that is exactly on the trajectory, without drag and wind, at yaw zero.

    Position and velocity are the trajectory's; thrust along g − a gives the tilt (differential flatness:
    Mellinger and Kumar, "Minimum snap trajectory generation and control for quadrotors", ICRA 2011, section
    III), and the tilt's change the rates, exactly when level.
    """
    desired = trajectory.at(time_s)
    before, after = (trajectory.at(time_s + side * 0.5 * _TILT_STEP_S) for side in (-1.0, 1.0))
    accelerations = np.array((before.acceleration, desired.acceleration, after.acceleration))
    tilt_before, tilt_now, tilt_after = tilt(_GRAVITY - accelerations)
    x = np.zeros(12)
    x[0:3], x[3:6] = desired.position, desired.velocity
    x[6:8] = tilt_now
    x[9:11] = (tilt_after - tilt_before) / _TILT_STEP_S
    x.flags.writeable = False
    return x


def desired_ahead(trajectory: DesiredMotion, time_s: float, preview: Preview) -> tuple[Vec3, Vec3]:
    """Desired position (m) and velocity (m/s), each axis its own lead after `time_s` of the trajectory."""
    samples = {
        lead_s: trajectory.at(time_s + lead_s) for lead_s in {*preview.position_s, *preview.velocity_s}
    }
    position = np.array([samples[lead_s].position[axis] for axis, lead_s in enumerate(preview.position_s)])
    velocity = np.array([samples[lead_s].velocity[axis] for axis, lead_s in enumerate(preview.velocity_s)])
    return position, velocity
