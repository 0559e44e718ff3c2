"""The ν-gap between two discrete systems with one input and one output.

G. Vinnicombe, "Frequency domain uncertainty and the graph topology", IEEE Transactions on Automatic Control
38(9), 1993. That it orders sources by how well they transfer is found in M. Sorocky, S. Zhou, A. Schoellig,
"Experience selection using dynamics similarity", ICRA 2020.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.optimize import minimize_scalar

from companion.arrays import Array
from companion.similarity.linear_system import LinearSystem

ON_THE_CIRCLE = 1e-9
ROUNDING = 1e-14
LEAST_DELAY = 0.02
"""Steps; what is less is none."""
FREQUENCIES = 400


class TransferFunction(NamedTuple):
    """P(z) = numerator / denominator, proper: coefficients of falling powers of z."""

    numerator: Float[Array, " m"]
    denominator: Float[Array, " n"]

    @classmethod
    def of(cls, system: LinearSystem, delay: float = 0.0) -> "TransferFunction":
        """From input to output of a system, with that many steps of dead time before it, part ones as well.

        The part of a step is an all-pass of first order (Thiran's fractional delay).
        """
        numerator, denominator = system.numerator, system.denominator
        whole = int(delay)
        part = delay - whole
        if part > LEAST_DELAY:
            a = (1.0 - part) / (1.0 + part)
            numerator = np.convolve(numerator, (a, 1.0))
            denominator = np.convolve(denominator, (1.0, a))
        return cls(numerator, np.concatenate((denominator, np.zeros(whole))))


def nu_gap(first: TransferFunction, second: TransferFunction) -> float:
    """δ_ν: 0 for equal systems, 1 for those that no one controller serves; symmetric.

    The greatest chordal distance |P1 − P2| / √((1 + |P1|²)(1 + |P2|²)) on the unit circle, if 1 + P2* P1 does
    not vanish there and wno(1 + P2* P1) + η(P1) − η̄(P2) = 0, else 1. η counts poles outside the closed unit
    disc, η̄ those on the circle as well; what is a right half-plane there is the outside of the disc here.
    """
    if not _winding_condition_holds(first, second):
        return 1.0

    poles = np.concatenate((np.roots(first.denominator), np.roots(second.denominator)))
    grid = np.concatenate((np.linspace(0.0, np.pi, FREQUENCIES), np.geomspace(1e-4, np.pi, FREQUENCIES)))
    grid = np.unique(np.concatenate((grid, np.abs(np.angle(poles)))))
    distances = _chordal_distance(first, second, grid)
    nearest = int(np.argmax(distances))
    bracket = (float(grid[max(nearest - 1, 0)]), float(grid[min(nearest + 1, len(grid) - 1)]))
    refined = minimize_scalar(
        lambda frequency: -float(_chordal_distance(first, second, np.array([frequency]))[0]),
        bounds=bracket,
        method="bounded",
        options={"xatol": 1e-9},
    )
    return min(max(-float(refined.fun), float(distances[nearest])), 1.0)


def _chordal_distance(
    first: TransferFunction, second: TransferFunction, frequency: Float[Array, " f"]
) -> Float[Array, " f"]:
    """Between the values at each frequency, from numerators and denominators so that poles do no harm."""
    z = np.exp(1j * frequency)
    (n1, d1), (n2, d2) = (
        (np.polyval(each.numerator, z), np.polyval(each.denominator, z)) for each in (first, second)
    )
    distance: Float[Array, " f"] = np.abs(n1 * d2 - n2 * d1) / (
        np.hypot(np.abs(n1), np.abs(d1)) * np.hypot(np.abs(n2), np.abs(d2))
    )
    return distance


def _winding_condition_holds(first: TransferFunction, second: TransferFunction) -> bool:
    """Whether 1 + P2* P1 does not vanish on the circle, and wno(1 + P2* P1) + η(P1) − η̄(P2) = 0.

    With normalised coprime factors G of both, the condition is that G2* G1 does not wind about the origin.
    Its numerator is that of 1 + P2* P1, d1 d2* + n1 n2*; its denominator is a spectral factor of P1, with all
    its roots inside the unit circle, times the mirrored one of P2, with all of them outside. So, counted
    exactly, the numerator must have as many roots inside as P1 has poles, and none on the circle.
    """
    order = len(first.denominator) - 1
    d2, n2 = second.denominator[::-1], _padded(second.numerator, len(second.denominator) - 1)[::-1]
    common = np.convolve(first.denominator, d2) + np.convolve(_padded(first.numerator, order), n2)
    # Rounding leaves coefficients of powers that are not there; their roots would be near infinity.
    common[np.abs(common) < ROUNDING * np.max(np.abs(common))] = 0.0
    sizes = np.abs(np.roots(common))
    on_the_circle = bool(np.any(np.abs(sizes - 1.0) < ON_THE_CIRCLE))
    return not on_the_circle and int(np.count_nonzero(sizes < 1.0)) == order


def _padded(numerator: Float[Array, " m"], order: int) -> Float[Array, " n"]:
    """Coefficients for all powers from `order` down."""
    return np.concatenate((np.zeros(order + 1 - len(numerator)), numerator))
