"""The online model that starts from constant velocity: what else moves the vehicle, learned axis by axis.

Ignorance, here, is to expect p(k) + v(k) τ one lead τ later, and still v(k). What is learned is the mean
velocity beyond that, and by how much the velocity will have changed, as linear functions of what can cause
it, each input in m/s: what it would add to the mean velocity if it acted in full.

| input | why |
|-|-|
| τ/2 · 2 s⁻² · (p_r − p_a) | the position loop pulls; 2 s⁻² is about what PX4 and ArduPilot do by default |
| τ/2 · 2 s⁻¹ · (v_r − v_a) | so does the velocity loop |
| τ/2 · a_r | feed-forward acceleration |
| τ/2 · a | acceleration goes on for a while |
| τ/2 · a_u | so will what corrections have just asked for: setpoints take their time |
| d | an estimator that is being pulled to a measurement moves its position beside its own velocity |

The axes are independent, as the paper assumes of the quadrotor's outer loops: that leaves six weights to
learn for each. With inputs in the output's own unit one prior variance serves all of them, at every lead.
"""

from dataclasses import dataclass
from typing import Annotated, Literal, NamedTuple, TypeAlias

import numpy as np
from jaxtyping import Float
from pydantic import BaseModel, ConfigDict, Field

from companion.arrays import Array, Vec3
from companion.learning.error_prediction import PredictedError, Step
from companion.learning.features import Preview
from companion.learning.gaussian_process import SlidingWindow

POSITION_STIFFNESS = 2.0
"""Acceleration that a position error is taken to call for (1/s²)."""
VELOCITY_STIFFNESS = 2.0
"""The same of a velocity error (1/s)."""
NOISE_REACH = 10.0
"""A fitted σ2² is at most so many times larger or smaller than the given one."""
_NOISE_LEVELS = np.geomspace(1.0 / NOISE_REACH, NOISE_REACH, 13)
_AXES, _INPUTS, _OUTPUTS = 3, 6, 2

Variance: TypeAlias = Annotated[float, Field(ge=1e-9, le=1e9)]
"""In the bounds within which the weights' covariance can be found."""


class LinearKernel(BaseModel):
    """k(ξ, ξ') = σ1² ξᵀξ', with noise of variance σ2² on each observation.

    Attributes:
        prior_variance: σ1², of each weight; of none when inputs and outputs have one unit.
        noise_variance: σ2² (m/s)². Outcomes of neighbouring steps overlap, so that they say less than
            independent ones would: σ2² is to be so many times larger.
        noise: σ2² as given, or the likeliest within `NOISE_REACH` of that (`likeliest_kernel`).
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    prior_variance: Variance
    noise_variance: Variance
    noise: Literal["given", "fitted"] = "given"


class Weights(NamedTuple):
    """What the process knows: weights of the inputs, and their covariance, for each axis.

    Attributes:
        mean: (3, inputs, outputs).
        covariance: (3, inputs, inputs), the same for each output.
    """

    mean: Float[Array, "3 d m"]
    covariance: Float[Array, "3 d d"]


def fit_weights(
    inputs: Float[Array, "n 3 d"], outputs: Float[Array, "n 3 m"], kernel: LinearKernel
) -> Weights:
    """Condition the process on observations, none included (Rasmussen and Williams, equation 2.8)."""
    ridge = kernel.noise_variance / kernel.prior_variance * np.eye(inputs.shape[2])
    information = _sums_of_products(inputs, inputs) + ridge
    inverse = np.asarray(np.linalg.inv(information), dtype=np.float64)
    return Weights(inverse @ _sums_of_products(inputs, outputs), kernel.noise_variance * inverse)


def log_likelihoods(
    inputs: Float[Array, "n 3 d"],
    outputs: Float[Array, "n 3 m"],
    prior_variance: float,
    noise_variances: Float[Array, " k"],
) -> Float[Array, " k"]:
    """Log p(outputs | inputs) of each σ2², summed over axes and outputs, but for a constant.

    Rasmussen and Williams, equation 5.8; with the eigenvalues λ of the inputs' products the determinant of
    σ1² ΞΞᵀ + σ2² I and its inverse are sums over the few inputs, not over the observations.
    """
    eigenvalues, directions = np.linalg.eigh(_sums_of_products(inputs, inputs))
    along = directions.swapaxes(1, 2) @ _sums_of_products(inputs, outputs)
    explained = noise_variances[:, None, None] + prior_variance * np.maximum(eigenvalues, 0.0)
    fitted = prior_variance * np.sum(along**2 / explained[..., None], axis=(1, 2, 3))
    misfit = (np.sum(outputs**2) - fitted) / noise_variances
    (n, axes, d), m = inputs.shape, outputs.shape[2]
    spread = axes * (n - d) * np.log(noise_variances) + np.sum(np.log(explained), axis=(1, 2))
    likelihoods: Float[Array, " k"] = -0.5 * (misfit + m * spread)
    return likelihoods


def likeliest_kernel(
    inputs: Float[Array, "n 3 d"], outputs: Float[Array, "n 3 m"], kernel: LinearKernel
) -> LinearKernel:
    """The kernel with the σ2² of the highest marginal likelihood within `NOISE_REACH` of its own.

    One decomposition serves all levels that are tried: always the same work, and no start to depend on.
    """
    levels = kernel.noise_variance * _NOISE_LEVELS
    best = np.argmax(log_likelihoods(inputs, outputs, kernel.prior_variance, levels))
    return kernel.model_copy(update={"noise_variance": float(levels[best])})


def _sums_of_products(one: Float[Array, "n 3 d"], other: Float[Array, "n 3 m"]) -> Float[Array, "3 d m"]:
    """Over the observations, for each axis.

    Those between different axes come along and are dropped: one product of matrices takes half the time of
    three whose rows are not side by side in memory.
    """
    (_, axes, d), m = one.shape, other.shape[2]
    products = one.reshape(-1, axes * d).T @ other.reshape(-1, axes * m)
    each = np.arange(axes)
    return products.reshape(axes, d, axes, m)[each, :, each]


@dataclass(frozen=True, slots=True, eq=False)
class _Leads:
    """τ of each axis (s)."""

    position: Vec3
    velocity: Vec3


class MotionModel:
    """Learns from steps whose outcome was flown, predicts that of the present one (`OnlineModel`)."""

    def __init__(self, kernel: LinearKernel, window: int, preview: Preview) -> None:
        self._kernel = kernel
        self._leads = _Leads(np.array(preview.position_s), np.array(preview.velocity_s))
        half_lead_s = 0.5 * self._leads.position[:, None]
        stiffness = np.array((POSITION_STIFFNESS, VELOCITY_STIFFNESS, 1.0, 1.0, 1.0))
        self._scale = np.hstack((half_lead_s * stiffness, np.ones((_AXES, 1))))
        self._window = SlidingWindow(window, inputs=_AXES * _INPUTS, outputs=_AXES * _OUTPUTS)
        self._weights: Weights | None = None

    def __len__(self) -> int:
        """How many observations it rests on."""
        return len(self._window)

    def learn(self, step: Step, flown_position: Vec3, flown_velocity: Vec3) -> bool:
        """Take in where `step` (with the reference as sent) led to; False if that is not finite."""
        self._weights = None
        position, velocity = step.state[:3], step.state[3:6]
        gained = (flown_position - position) / self._leads.position - velocity
        outputs = np.stack((gained, flown_velocity - velocity), axis=1)
        return self._window.append(self._inputs(step).ravel(), outputs.ravel())

    def predict(self, step: Step) -> PredictedError:
        """The error that `step` leads to; NaN, never an exception, if the step is not finite."""
        if self._weights is None:
            self._weights = self._fit()
        inputs, lead_s = self._inputs(step), self._leads.position
        gained, velocity_gained = (inputs[:, None] @ self._weights.mean)[:, 0].T
        position = step.state[:3] + lead_s * (step.state[3:6] + gained)
        velocity = step.state[3:6] + velocity_gained
        variance = np.einsum("ad,ade,ae->a", inputs, self._weights.covariance, inputs)
        full_pull = 0.5 * lead_s**2 * POSITION_STIFFNESS
        return PredictedError(
            error=step.desired_position - position,
            velocity_error=step.desired_velocity - velocity,
            position=position,
            velocity=velocity,
            variance=float((lead_s**2 * variance).max()),
            gradient=-np.diag(full_pull * self._weights.mean[:, 0, 0]),
            gradient_variance=full_pull**2 * self._weights.covariance[:, 0, 0],
        )

    def _fit(self) -> Weights:
        inputs = self._window.inputs.reshape(-1, _AXES, _INPUTS)
        outputs = self._window.outputs.reshape(-1, _AXES, _OUTPUTS)
        fitted = self._kernel.noise == "fitted" and len(inputs) > 0
        return fit_weights(
            inputs, outputs, likeliest_kernel(inputs, outputs, self._kernel) if fitted else self._kernel
        )

    def _inputs(self, step: Step) -> Float[Array, "3 6"]:
        position, velocity = step.state[:3], step.state[3:6]
        causes = np.empty((_AXES, _INPUTS))
        causes[:, 0] = step.reference_position - position
        causes[:, 1] = step.reference_velocity - velocity
        causes[:, 2] = step.reference_acceleration
        causes[:, 3] = step.acceleration
        causes[:, 4] = step.underway
        causes[:, 5] = step.drift
        return self._scale * causes
