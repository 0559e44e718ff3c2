"""Relative degree, dead time and zeros of an identified closed loop: what assumption (A2) asks about.

A vehicle sampled faster than it answers has, strictly, a relative degree of 1 and an inverse that no one can
use: its first response is next to nothing, and sampling puts zeros on the negative real axis, outside of the
unit circle (Åström, Hagander and Sternby, "Zeros of sampled systems", Automatica 20, 1984). The relative
degree that an inverse works with is the step at which a reference shows; further ahead yet where what shows
earlier would leave such a zero of sampling. Any other zero outside is the vehicle's own: its inverse is
refused.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float

from companion.arrays import Array
from companion.recording.series import ReferenceSeries, StateSeries
from companion.similarity.identification import AxisModel, identify
from companion.similarity.linear_system import Gains, LinearSystem
from companion.similarity.moments import SAMPLE_TIME_S

SHOWS = 0.1
"""Share of the greatest response from which on a reference shows."""
_ROUNDING = 1e-6


@dataclass(frozen=True, eq=False)
class Structure:
    """How an axis answers.

    Attributes:
        relative_degree: steps r until a reference shows, beyond the dead time.
        delay_s: dead time (s).
        zeros: of the model from that step on.
    """

    relative_degree: int
    delay_s: float
    zeros: Complex[np.ndarray, " z"]

    @property
    def lead_s(self) -> float:
        """How far ahead of now a reference acts (s): the preview that an inverse wants."""
        return self.delay_s + self.relative_degree * SAMPLE_TIME_S

    @property
    def minimum_phase(self) -> bool:
        """Whether all zeros lie inside the unit circle, so that the inverse is stable."""
        return bool(np.all(np.abs(self.zeros) < 1.0))


def relative_degree_and_delay(
    states: StateSeries, references: ReferenceSeries
) -> tuple[Structure, Structure, Structure]:
    """North, east and down of the vehicle that flew so, from least squares on the flight.

    Raises:
        InputError: too little of the flight can be used.
    """
    north, east, down = (structure(axis.model) for axis in identify(states, references, resamples=0).axes)
    return north, east, down


def structure(model: AxisModel) -> Structure:
    """Of an identified axis."""
    numerator = model.system.numerator
    response = np.abs(impulse_response(model.system, len(numerator) - 1))
    peak = np.max(np.abs(impulse_response(model.system, 30)))
    shows = np.flatnonzero(response >= SHOWS * peak)
    degree = int(shows[0]) + 1 if len(shows) else len(response)
    zeros = np.roots(numerator[degree:]).astype(complex)
    while np.any((zeros.real < -1.0 + _ROUNDING) & (np.abs(zeros.imag) < _ROUNDING)):
        degree += 1
        zeros = np.roots(numerator[degree:]).astype(complex)
    return Structure(degree, model.delay_s, zeros)


def impulse_response(system: LinearSystem, steps: int) -> Float[Array, " k"]:
    """C B, C A B, … C Aᵏ⁻¹ B."""
    impulse = np.zeros(steps)
    impulse[0] = 1.0
    response: Array = system.respond(impulse)[1:] @ system.C
    return response


def gains_at(system: LinearSystem, degree: int) -> Gains:
    """𝒜 and ℬ of y(k+r) = 𝒜 x(k) + ℬ u(k) at that r, with u held until then.

    At the system's own relative degree these are C Aʳ and C Aʳ⁻¹ B. Where r is greater, what would show
    earlier is counted in.
    """
    state: Array = system.C @ np.linalg.matrix_power(system.A, degree)
    return Gains(state, float(impulse_response(system, degree).sum()))
