"""What the learned models are shown: the state as they know it, and the desired motion one preview ahead."""

from typing import Protocol

import numpy as np
from jaxtyping import Float

from companion.arrays import Array, Vec3
from companion.learning.features import Preview, state_vector
from companion.state import VehicleState
from companion.trajectory.trajectory import Sample


class DesiredMotion(Protocol):
    """What is to be flown, known ahead: a `Trajectory`, or anything that can be asked the same."""

    def at(self, time_s: float) -> Sample:
        """The sample at `time_s` of its own clock (s)."""
        ...


def state_of(state: VehicleState) -> Float[Array, "12"]:
    """x(k) of the paper (`features.state_vector`)."""
    return state_vector(state.position, state.velocity, state.attitude, state.rates)


def desired_ahead(trajectory: DesiredMotion, time_s: float, preview: Preview) -> tuple[Vec3, Vec3]:
    """Desired position (m) and velocity (m/s), each axis its own lead after `time_s` of the trajectory."""
    samples = {
        lead_s: trajectory.at(time_s + lead_s) for lead_s in {*preview.position_s, *preview.velocity_s}
    }
    position = np.array([samples[lead_s].position[axis] for axis, lead_s in enumerate(preview.position_s)])
    velocity = np.array([samples[lead_s].velocity[axis] for axis, lead_s in enumerate(preview.velocity_s)])
    return position, velocity
