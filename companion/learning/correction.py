"""From the predicted error to the correction of the reference: u2(k) = α e_p(k+r) (Eqn. adaptationForm)."""

import math
from typing import Annotated, Literal, TypeAlias

import numpy as np
from jaxtyping import Float
from pydantic import BaseModel, ConfigDict, Field, PositiveFloat

from companion.arrays import Array, Vec3

GainValue: TypeAlias = Annotated[float, Field(ge=0.0, le=100.0, allow_inf_nan=False)]


class ConstantGain(BaseModel):
    """The same α at every step, one for each axis (north, east, down): what the paper flew."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    kind: Literal["constant"] = "constant"
    alpha: tuple[GainValue, GainValue, GainValue]


class EstimatedGain(BaseModel):
    """α̂* = −(∂F/∂u1)⁻¹ from the online model at every step (Insight 1, Remark 1), kept within bounds."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    kind: Literal["estimated"] = "estimated"
    least: GainValue = 0.5
    most: PositiveFloat = 4.0


class StiffnessGain(BaseModel):
    """α with which u2 pulls alike on every vehicle: what is wanted over what its own position loop does.

    The autopilot turns u2 into an acceleration by its own stiffness, which differs between vehicles by a
    factor of four; a gain that serves one makes another swing.

    Attributes:
        stiffness_1_s2: acceleration that a predicted position error is to call for (1/s²).
        most: whatever the autopilot's stiffness.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    kind: Literal["stiffness"] = "stiffness"
    stiffness_1_s2: PositiveFloat
    most: PositiveFloat = 20.0


Gain: TypeAlias = Annotated[ConstantGain | EstimatedGain | StiffnessGain, Field(discriminator="kind")]


def adaptation_gain(gain: Gain, error_gradient: Float[Array, "3 3"], stiffness_1_s2: Vec3) -> Vec3:
    """α of each axis.

    Args:
        gain: how it is found.
        error_gradient: ∂F/∂u1, if it is to be estimated.
        stiffness_1_s2: of the vehicle's own position loop (1/s²).
    """
    match gain:
        case ConstantGain(alpha=alpha):
            return np.array(alpha)
        case EstimatedGain(least=least, most=most):
            return estimated_gain(np.diag(error_gradient), least, most)
        case StiffnessGain(stiffness_1_s2=wanted, most=most):
            return np.minimum(wanted / stiffness_1_s2, most)


def estimated_gain(error_gradient: Vec3, least: float, most: float) -> Vec3:
    """α̂* = −(∂F/∂u1)⁻¹ of each axis, regularised: between `least` and `most` whatever the gradient.

    With G = −∂F/∂u1, the inverse 1/G is replaced by G / (G² + λ²). λ = 1 / (2 `most`) puts its peak at
    `most`; towards a smaller gradient, of which the model knows nothing, it falls to 0 instead of growing
    without limit, and a gradient of the wrong sign, or none (NaN), gives `least`.
    """
    slope = np.where(np.abs(error_gradient) < 1e6, -error_gradient, 0.0)
    regularisation = 1.0 / (2.0 * most)
    inverse: Vec3 = slope / (slope**2 + regularisation**2)
    return np.maximum(inverse, least)


def velocity_correction(u2: Vec3, previous_u2: Vec3, sample_time_s: float) -> Vec3:
    """Correction of the velocity reference (m/s): first-order finite difference of u2.

    As in the paper's section "Online Learning for Bebop".
    """
    return (u2 - previous_u2) / sample_time_s


FIRST_INNOVATION = 1e-3
"""Assumed on each axis before there is any (m or m/s)."""


class Confidence:
    """How much of the predicted errors is real: their mean square against that of the innovations.

    share = E[e_p²] / (E[e_p²] + caution · E[(y − ŷ)²]), running means over about `memory` steps of the sums
    over the axes. Where what the model expects comes true but for a small part, the share is nearly 1;
    where sensor noise or gusts make up what it expects, the correction shrinks instead of amplifying them.
    """

    def __init__(self, caution: float, memory: int) -> None:
        self._caution = caution
        self._memory = memory
        self._expected = 0.0
        self._innovation = 3.0 * FIRST_INNOVATION**2

    @property
    def share(self) -> float:
        """From 0 (nothing known yet) to 1; always 1 without caution."""
        if self._caution == 0.0:
            return 1.0
        return self._expected / (self._expected + self._caution * self._innovation)

    def expect(self, error: Float[Array, " n"]) -> None:
        """An error was predicted (m or m/s)."""
        self._expected += (_finite_square(error) - self._expected) / self._memory

    def compare(self, innovation: Float[Array, " n"]) -> None:
        """What was predicted came, but for the innovation y − ŷ (m or m/s)."""
        self._innovation += (_finite_square(innovation) - self._innovation) / self._memory


def _finite_square(vector: Float[Array, " n"]) -> float:
    square = float(vector @ vector)
    return square if math.isfinite(square) else 0.0
