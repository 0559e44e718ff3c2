"""The online model of Remark 1: what tracking error will the reference u1 lead to, one preview from now?

Its forms differ in two things only: what the process sees, and the point from which it counts the position
and velocity y(k+r) that it learns to predict. The error is what remains to y_d(k+r).

| form | inputs ξ | counts from | |
|-|-|-|-|
| `error` | x(k), u(k), y_d(k+r) | y_d(k+r) | Remark 1: learns y − y_d, the error with its sign turned |
| `position` | I2 | the origin | the paper's flights: learns p_a(k+r), then subtracts it |
| `displacement` | I2 relative to p_a(k) | x(k) | learns the change during the preview |

With a zero prior mean `position` pulls an ignorant prediction to the map's origin, however far away that is;
`displacement` pulls it to where the vehicle is, and what it learns in one place holds in any other.
A fourth, `motion`, pulls it to constant velocity and learns with a linear kernel: `motion_model`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
from jaxtyping import Float

from companion.arrays import Array, Vec3
from companion.learning.features import ERROR_INPUTS, error_inputs
from companion.learning.gaussian_process import (
    Kernel,
    Posterior,
    SlidingWindow,
    fit,
    gradient_variance,
    predict,
)


class Step(NamedTuple):
    """One control step k, as the online model sees it; NED, SI.

    Attributes:
        state: x(k), `features.state_vector`.
        reference_position: p_r(k): u1(k) to predict its error, u(k) as sent to learn from it (m).
        reference_velocity: v_r(k) (m/s).
        desired_position: p_d(k+r) (m).
        desired_velocity: v_d(k+r−1) (m/s).
        reference_acceleration: a_r(k), zero where none is sent (m/s²).
        acceleration: of the vehicle, the mean of the last moments; zero where that is not known (m/s²).
        drift: how fast its position then moved beside its own velocity; zero where not known (m/s).
        underway: acceleration that the newest corrections asked for, which has not shown yet (m/s²).
    """

    state: Float[Array, "12"]
    reference_position: Vec3
    reference_velocity: Vec3
    desired_position: Vec3
    desired_velocity: Vec3
    reference_acceleration: Vec3
    acceleration: Vec3
    drift: Vec3
    underway: Vec3


def _paper_inputs(step: Step) -> Float[Array, "24"]:
    return error_inputs(
        *(step.state, step.reference_position, step.reference_velocity),
        *(step.desired_position, step.desired_velocity),
    )


FormName: TypeAlias = Literal["error", "position", "displacement"]


class Form(NamedTuple):
    """One form of the online model: what the process sees of a step, and where it counts positions from.

    `reference` is where the reference position stands among the inputs.
    """

    inputs: Callable[[Step], Float[Array, " d"]]
    origin: Callable[[Step], Float[Array, "6"]]
    reference: slice
    size: int


def _desired(step: Step) -> Float[Array, "6"]:
    return np.concatenate((step.desired_position, step.desired_velocity))


def _relative_inputs(step: Step) -> Float[Array, "21"]:
    here = step.state[:3]
    return np.concatenate(
        (
            *(step.state[3:], step.reference_position - here, step.reference_velocity),
            *(step.desired_position - here, step.desired_velocity),
        )
    )


FORMS: Mapping[FormName, Form] = MappingProxyType(
    {
        "error": Form(
            inputs=_paper_inputs,
            origin=_desired,
            reference=slice(12, 15),
            size=len(ERROR_INPUTS),
        ),
        "position": Form(
            inputs=_paper_inputs,
            origin=lambda step: np.zeros(6),
            reference=slice(12, 15),
            size=len(ERROR_INPUTS),
        ),
        "displacement": Form(
            inputs=_relative_inputs,
            origin=lambda step: step.state[:6],
            reference=slice(9, 12),
            size=21,
        ),
    }
)


@dataclass(frozen=True, eq=False)
class PredictedError:
    """What the online model expects of one step.

    Attributes:
        error: e_p(k+r) = y_d(k+r) − ŷ(k+r), of the position (m).
        velocity_error: the same of the velocity (m/s).
        position: ŷ(k+r) (m).
        velocity: its velocity (m/s).
        variance: of each of them in its own unit squared, where they share one (`ErrorModel`); else the
            largest of the position's axes (m², `MotionModel`).
        gradient: ∂F/∂u1 = ∂e_p/∂u1, row: error, column: reference position.
        gradient_variance: of its diagonal.
    """

    error: Vec3
    velocity_error: Vec3
    position: Vec3
    velocity: Vec3
    variance: float
    gradient: Float[Array, "3 3"]
    gradient_variance: Vec3


class ErrorModel:
    """The online model: learns from steps whose outcome was flown, predicts that of the present one."""

    def __init__(self, form: FormName, kernel: Kernel, window: int) -> None:
        self._form = FORMS[form]
        self._kernel = kernel
        self._window = SlidingWindow(window, inputs=self._form.size, outputs=6)
        self._posterior: Posterior | None = None

    def __len__(self) -> int:
        """How many observations it rests on."""
        return len(self._window)

    def learn(self, step: Step, flown_position: Vec3, flown_velocity: Vec3) -> bool:
        """Take in where `step` (with the reference as sent) led to; False if that is not finite."""
        self._posterior = None
        flown = np.concatenate((flown_position, flown_velocity))
        return self._window.append(self._form.inputs(step), flown - self._form.origin(step))

    def predict(self, step: Step) -> PredictedError:
        """The error that `step` leads to; NaN, never an exception, if the step is not finite."""
        if self._posterior is None:
            self._posterior = fit(self._window.inputs, self._window.outputs, self._kernel)
        inputs = self._form.inputs(step)
        prediction = predict(self._posterior, inputs)
        flown = self._form.origin(step) + prediction.mean
        position, velocity = flown[:3], flown[3:]
        return PredictedError(
            error=step.desired_position - position,
            velocity_error=step.desired_velocity - velocity,
            position=position,
            velocity=velocity,
            variance=prediction.variance,
            gradient=-prediction.gradient[:3, self._form.reference],
            gradient_variance=gradient_variance(self._posterior, inputs, self._form.reference),
        )
