"""What the inverse network and the online model see of a flight: the vectors I1, O1 and I2 of the paper.

Every function works on the last axis, so that one sample in flight and a whole data set in training
share one definition. The paper's section "Experiment Setup" defines the vectors; where it prints
z_d(k+3) − z_d(k) in I1, z_a(k) is meant. (O2, the predicted errors, is made in `error_prediction`.)

Vectors are NED; attitude and rates enter as they would read if the nose pointed north (`state_vector`), so
that what is learned at one heading holds at any other.
"""

from typing import Annotated, TypeAlias

import numpy as np
from jaxtyping import Float
from pydantic import BaseModel, ConfigDict, Field

from companion.arrays import Array

Lead: TypeAlias = Annotated[float, Field(ge=0.0, le=10.0, allow_inf_nan=False)]


class Preview(BaseModel):
    """How far ahead of now the desired trajectory is read: r·Δt of north, east and down (s)."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    position_s: tuple[Lead, Lead, Lead]
    velocity_s: tuple[Lead, Lead, Lead]

    @classmethod
    def of_steps(cls, relative_degree: tuple[int, int, int], sample_time_s: float) -> "Preview":
        """The paper's choice: r steps for the position and r − 1 for the velocity (of each axis)."""
        north, east, down = (degree * sample_time_s for degree in relative_degree)
        return cls(
            position_s=(north, east, down),
            velocity_s=(north - sample_time_s, east - sample_time_s, down - sample_time_s),
        )

    @classmethod
    def of_time(cls, lead_s: float) -> "Preview":
        """The same lead (s) for every axis, position and velocity alike."""
        return cls(position_s=(lead_s,) * 3, velocity_s=(lead_s,) * 3)

    @property
    def longest_s(self) -> float:
        """The time after which all that a sample leads to has been flown (s)."""
        return max(*self.position_s, *self.velocity_s)


def _along_axes(*vectors: str) -> tuple[str, ...]:
    return tuple(f"{vector}.{axis}" for vector in vectors for axis in ("north", "east", "down"))


ATTITUDE: tuple[str, ...] = ("roll", "pitch", "yaw", "rate.p", "rate.q", "rate.r")
"""θ_a and ω_a: names of the last six entries of the state."""

STATE: tuple[str, ...] = (*_along_axes("position", "velocity"), *ATTITUDE)
"""x(k): names of the entries of `state_vector`."""

INVERSE_INPUTS: tuple[str, ...] = (*_along_axes("position_ahead", "velocity_ahead"), *ATTITUDE)
"""I1: names of the inverse network's inputs."""

INVERSE_OUTPUTS: tuple[str, ...] = _along_axes("reference_position_offset", "reference_velocity_offset")
"""O1: names of the inverse network's outputs."""

ACCELERATING_OUTPUTS: tuple[str, ...] = (*INVERSE_OUTPUTS, *_along_axes("reference_acceleration"))
"""O1 and the reference acceleration, of a network that learned from a flight with one: names likewise."""

ERROR_INPUTS: tuple[str, ...] = (
    *STATE,
    *_along_axes("reference_position", "reference_velocity", "desired_position", "desired_velocity"),
)
"""I2: names of the online model's inputs."""


def state_vector(
    position: Float[Array, "*n 3"],
    velocity: Float[Array, "*n 3"],
    attitude: Float[Array, "*n 3"],
    rates: Float[Array, "*n 3"],
) -> Float[Array, "*n 12"]:
    """x(k): position (m), velocity (m/s), attitude (rad) and rates (rad/s), whatever way the nose points.

    `attitude` is roll, pitch, yaw (rad, z-y'-x'' from NED), `rates` are body rates p, q, r (rad/s). Both are
    turned about the vertical to a yaw of zero: the tilt of the thrust axis is kept exactly, the rates are
    exact when level. The yaw itself is left at zero: the reference does not depend on it, and it jumps at ±π.
    """
    roll, pitch, yaw = attitude[..., 0], attitude[..., 1], attitude[..., 2]
    p, q, r = rates[..., 0], rates[..., 1], rates[..., 2]
    cos, sin = np.cos(yaw), np.sin(yaw)
    # Third column of R = Rz(yaw) Ry(pitch) Rx(roll): the body's down axis in NED.
    forward, right, down = np.cos(roll) * np.sin(pitch), -np.sin(roll), np.cos(roll) * np.cos(pitch)
    body_down = np.stack((cos * forward - sin * right, sin * forward + cos * right, down), axis=-1)
    x = np.zeros((*attitude.shape[:-1], 12))
    x[..., 0:3] = position
    x[..., 3:6] = velocity
    x[..., 6:8] = tilt(body_down)
    x[..., 9] = cos * p - sin * q
    x[..., 10] = sin * p + cos * q
    x[..., 11] = r
    return x


def tilt(body_down: Float[Array, "*n 3"]) -> Float[Array, "*n 2"]:
    """Roll and pitch (rad) at yaw zero of a body whose down axis is `body_down` (NED, of any length)."""
    north, east, down = body_down[..., 0], body_down[..., 1], body_down[..., 2]
    return np.stack((-np.arctan2(east, np.hypot(north, down)), np.arctan2(north, down)), axis=-1)


def inverse_inputs(
    state: Float[Array, "*n 12"],
    desired_position: Float[Array, "*n 3"],
    desired_velocity: Float[Array, "*n 3"],
) -> Float[Array, "*n 12"]:
    """I1: p_d(k+r) − p_a(k), v_d(k+r−1) − v_a(k), attitude and rates.

    `desired_position` and `desired_velocity` are those of one preview later; in training, what came of it.
    """
    return np.concatenate(
        (desired_position - state[..., 0:3], desired_velocity - state[..., 3:6], state[..., 6:12]), axis=-1
    )


def inverse_outputs(
    state: Float[Array, "*n 12"],
    reference_position: Float[Array, "*n 3"],
    reference_velocity: Float[Array, "*n 3"],
    reference_acceleration: Float[Array, "*n 3"] | None = None,
) -> Float[Array, "*n m"]:
    """O1: p_r(k) − p_a(k) and v_r(k) − v_a(k), from the reference that acts from k on, and a_r(k) if any."""
    offsets = (reference_position - state[..., 0:3], reference_velocity - state[..., 3:6])
    acceleration = () if reference_acceleration is None else (reference_acceleration,)
    return np.concatenate((*offsets, *acceleration), axis=-1)


def reference(
    state: Float[Array, "*n 12"], outputs: Float[Array, "*n m"]
) -> tuple[Float[Array, "*n 3"], Float[Array, "*n 3"], Float[Array, "*n 3"] | None]:
    """Reference position (m), velocity (m/s) and acceleration (m/s²) that outputs stand for at that state.

    The acceleration is None where the outputs are O1 alone.
    """
    acceleration = outputs[..., 6:9] if outputs.shape[-1] == len(ACCELERATING_OUTPUTS) else None
    return state[..., 0:3] + outputs[..., 0:3], state[..., 3:6] + outputs[..., 3:6], acceleration


def error_inputs(
    state: Float[Array, "*n 12"],
    reference_position: Float[Array, "*n 3"],
    reference_velocity: Float[Array, "*n 3"],
    desired_position: Float[Array, "*n 3"],
    desired_velocity: Float[Array, "*n 3"],
) -> Float[Array, "*n 24"]:
    """I2: x(k), p_r(k), v_r(k), p_d(k+r) and v_d(k+r−1)."""
    return np.concatenate(
        (state, reference_position, reference_velocity, desired_position, desired_velocity), axis=-1
    )
