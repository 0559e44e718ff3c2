"""Remark 2 of the paper: y_t(k+r) = θ1(x) y_s(k+r) + θ2(x), over the envelope that the target flew.

The envelope is divided by speed along the axis, and each band has a model of its own. Positions are counted
from where the vehicle is.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from companion.arrays import Array
from companion.similarity.identification import AxisEstimate, AxisModel, IdentifiedAxis
from companion.similarity.structure import gains_at

_ASKED = 2
"""Where p_r − p stands in z."""


@dataclass(frozen=True)
class BandMeasure:
    """θ1 and θ2 of one band.

    Attributes:
        theta_1: ℬ_t/ℬ_s, 1 where both answer alike.
        theta_2_m: RMS over the target's flight in that band (m), 0 where both answer alike.
        share: of the target's flight spent there.
    """

    theta_1: float
    theta_2_m: float
    share: float


Envelope = tuple[BandMeasure | None, ...]
"""A measure for each band of speed, slowest first; None where one of the flights had too little."""


def envelope(source: AxisEstimate, target: AxisEstimate, flown: IdentifiedAxis, degree: int) -> Envelope:
    """Remark 2's measure in each band that both flew, over what the target flew there."""
    return tuple(
        None
        if ours is None or theirs is None
        else _measure(lead_gains(ours, degree), lead_gains(theirs, degree), second, float(share))
        for ours, theirs, second, share in zip(
            source.bands, target.bands, flown.second_moments, flown.shares, strict=True
        )
    )


def inverse_error_share(
    source: AxisModel, target: AxisModel, degree: int, moments: Float[Array, "6 6"]
) -> float:
    """RMS error that the source's inverse leaves on the target, over the target's RMS distance to p_r.

    Asked for what the target did, y_d = y_t(k+r), the source's inverse gives a u1 under which the target is
    off by θ1 (y_t − y_s): the error e_p* that is left to the online module, over the states that were flown.
    0 is a perfect transfer.
    """
    ours, theirs = lead_gains(source, degree), lead_gains(target, degree)
    theta_1 = theirs[_ASKED] / ours[_ASKED]
    return float(abs(theta_1) * _rms(theirs - ours, moments) / np.sqrt(moments[_ASKED, _ASKED]))


def lead_gains(model: AxisModel, degree: int) -> Float[Array, "6"]:
    """y(k+r) − p(k) per velocity, acceleration, p_r − p, v_r, a_r and 1, references held until then."""
    gains = gains_at(model.system, degree)
    powers = [model.system.C @ np.linalg.matrix_power(model.system.A, i) for i in range(degree)]
    constant = sum(float(power @ model.offset) for power in powers)
    return np.array(
        (*gains.state[1:], gains.input, *(gains.input * model.reference_weights), constant), dtype=np.float64
    )


def _measure(
    ours: Float[Array, "6"], theirs: Float[Array, "6"], moments: Float[Array, "6 6"], share: float
) -> BandMeasure:
    theta_1 = float(theirs[_ASKED] / ours[_ASKED])
    return BandMeasure(theta_1, _rms(theirs - theta_1 * ours, moments), share)


def _rms(weights: Float[Array, "6"], moments: Float[Array, "6 6"]) -> float:
    return float(np.sqrt(max(float(weights @ moments @ weights), 0.0)))
