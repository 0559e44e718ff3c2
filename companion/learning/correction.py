"""From the predicted error to the correction of the reference: u2(k) = α e_p(k+r) (Eqn. adaptationForm)."""

import math
from typing import Annotated, Literal, Self, TypeAlias

import numpy as np
from jaxtyping import Float
from pydantic import BaseModel, ConfigDict, Field, model_validator

from companion.arrays import Array, Vec3
from companion.learning.cautious_correction import cautious_gain

GainValue: TypeAlias = Annotated[float, Field(ge=0.0, le=100.0, allow_inf_nan=False)]


class ConstantGain(BaseModel):
    """The same α at every step, one for each axis (north, east, down): what the paper flew."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    kind: Literal["constant"] = "constant"
    alpha: tuple[GainValue, GainValue, GainValue]


class EstimatedGain(BaseModel):
    """α̂* = −(∂F/∂u1)⁻¹ from the online model at every step (Insight 1, Remark 1), as far as it knows.

    Attributes:
        least: where the gradient is unknown or of the wrong sign.
        most: however small the gradient.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    kind: Literal["estimated"] = "estimated"
    least: GainValue = 0.5
    most: GainValue = 4.0

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.least > self.most:
            raise ValueError(f"least ({self.least:g}) is above most ({self.most:g})")
        return self


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
    stiffness_1_s2: Annotated[float, Field(gt=0.0, le=1000.0, allow_inf_nan=False)]
    most: GainValue = 20.0


Gain: TypeAlias = Annotated[ConstantGain | EstimatedGain | StiffnessGain, Field(discriminator="kind")]


def adaptation_gain(
    gain: Gain, error_gradient: Float[Array, "3 3"], gradient_variance: Vec3, stiffness_1_s2: Vec3
) -> Vec3:
    """α of each axis.

    Args:
        gain: how it is found.
        error_gradient: ∂F/∂u1, if it is to be estimated.
        gradient_variance: of its diagonal.
        stiffness_1_s2: of the vehicle's own position loop (1/s²).
    """
    match gain:
        case ConstantGain(alpha=alpha):
            return np.array(alpha)
        case EstimatedGain(least=least, most=most):
            return estimated_gain(np.diag(error_gradient), gradient_variance, least, most)
        case StiffnessGain(stiffness_1_s2=wanted, most=most):
            return np.minimum(wanted / stiffness_1_s2, most)


_LARGEST_GRADIENT = 1e6
"""Beyond this a gradient, or its deviation, says nothing."""
_LEAST_VARIANCE = 1e-12
"""Of a gradient: no more than keeps 0/0 away."""


def estimated_gain(error_gradient: Vec3, variance: Vec3, least: float, most: float) -> Vec3:
    """α̂* = −(∂F/∂u1)⁻¹ of each axis, limited by its uncertainty: between `least` and `most` whatever comes.

    With G = −∂F/∂u1, the inverse 1/G is replaced by the α that leaves the least expected square of the
    error (`cautious_gain`). Towards a gradient that the model cannot tell from 0 it falls instead of growing
    without limit, and a gradient of the wrong sign, or none (NaN), gives `least`.
    """
    known = (np.abs(error_gradient) < _LARGEST_GRADIENT) & (variance < _LARGEST_GRADIENT**2)
    slope = np.where(known, -error_gradient, 0.0)
    spread = np.maximum(np.where(known, variance, 0.0), _LEAST_VARIANCE)
    return np.clip(cautious_gain(slope, spread), least, most)


def certain_share(error: Vec3, variance: float, caution: float) -> float:
    """How much of a predicted error is no mere uncertainty of the model: e² / (e² + caution · variance).

    Args:
        error: e_p (m).
        variance: of each of its axes (m²).
        caution: how much the variance counts; 0: not, and the share is 1.
    """
    if caution == 0.0:
        return 1.0
    square = _finite_square(error)
    return square / (square + caution * variance) if square > 0.0 else 0.0


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
        weighed = self._expected + self._caution * self._innovation
        return self._expected / weighed if weighed > 0.0 else 0.0

    def expect(self, error: Float[Array, " n"]) -> None:
        """An error was predicted (m or m/s)."""
        self._expected += (_finite_square(error) - self._expected) / self._memory

    def compare(self, innovation: Float[Array, " n"]) -> None:
        """What was predicted came, but for the innovation y − ŷ (m or m/s)."""
        self._innovation += (_finite_square(innovation) - self._innovation) / self._memory


def _finite_square(vector: Float[Array, " n"]) -> float:
    square = float(vector @ vector)
    return square if math.isfinite(square) else 0.0
