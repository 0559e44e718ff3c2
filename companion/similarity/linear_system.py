"""Discrete linear systems with one input and one output, x(k+1) = A x + B u, y = C x."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from jaxtyping import Complex, Float

from companion.arrays import Array
from companion.errors import InputError


class Gains(NamedTuple):
    """y(k+r) = 𝒜 x(k) + ℬ u(k) (the paper, Eqn. inputOuputLinear).

    Attributes:
        state: 𝒜 = C Aʳ, shape (n,).
        input: ℬ = C Aʳ⁻¹ B.
    """

    state: Float[Array, " n"]
    input: float


@dataclass(frozen=True, eq=False)
class LinearSystem:
    """A system of n states (the paper, Eqn. linearSystem).

    Attributes:
        A: shape (n, n).
        B: shape (n,).
        C: shape (n,).
    """

    A: Float[Array, "n n"]
    B: Float[Array, " n"]
    C: Float[Array, " n"]

    def step(self, state: Float[Array, " n"], reference: float) -> Float[Array, " n"]:
        """The next state."""
        return self.A @ state + self.B * reference

    def respond(self, references: Float[Array, " k"]) -> Float[Array, "k+1 n"]:
        """The states from rest under a series of references, the state of rest first."""
        states = np.zeros((len(references) + 1, len(self.B)))
        for k, reference in enumerate(references):
            states[k + 1] = self.step(states[k], float(reference))
        return states

    @cached_property
    def relative_degree(self) -> int:
        """Steps r until an input shows in the output: the first C Aʳ⁻¹ B that is not zero.

        Raises:
            InputError: the input never reaches the output.
        """
        markov = self._markov_parameters()
        nonzero = np.flatnonzero(np.abs(markov) > 1e-12 * np.max(np.abs(markov)))
        if len(nonzero) == 0:
            raise InputError("the input of this system never reaches its output: change B or C")
        return int(nonzero[0]) + 1

    @property
    def gains(self) -> Gains:
        """𝒜 and ℬ at the relative degree."""
        return Gains(self.state_gain, self.input_gain)

    @property
    def state_gain(self) -> Float[Array, " n"]:
        """𝒜 = C Aʳ of y(k+r) = 𝒜 x(k) + ℬ u(k)."""
        gain: Array = self.C @ np.linalg.matrix_power(self.A, self.relative_degree)
        return gain

    @property
    def input_gain(self) -> float:
        """ℬ = C Aʳ⁻¹ B of y(k+r) = 𝒜 x(k) + ℬ u(k)."""
        return float(self._markov_parameters()[self.relative_degree - 1])

    @property
    def poles(self) -> Complex[np.ndarray, " n"]:
        """Eigenvalues of A; stable when all lie inside the unit circle."""
        return np.linalg.eigvals(self.A).astype(complex)

    @property
    def zeros(self) -> Complex[np.ndarray, " n-r"]:
        """Zeros of the transfer function; minimum phase when all lie inside the unit circle."""
        return np.roots(self.numerator[self.relative_degree :]).astype(complex)

    @property
    def denominator(self) -> Float[Array, " n+1"]:
        """Coefficients of the transfer function's denominator, falling powers of z."""
        return np.asarray(np.poly(self.A), dtype=np.float64)

    @property
    def numerator(self) -> Float[Array, " n+1"]:
        """Coefficients of its numerator, likewise, as many: the first r are zero."""
        impulse_response = np.concatenate([[0.0], self._markov_parameters()])
        coefficients: Array = np.convolve(self.denominator, impulse_response)[: len(self.B) + 1]
        return coefficients

    def _markov_parameters(self) -> Float[Array, " n"]:
        """C B, C A B, …, C Aⁿ⁻¹ B: the response to an impulse."""
        impulse = np.zeros(len(self.B))
        impulse[0] = 1.0
        response: Array = self.respond(impulse)[1:] @ self.C
        return response
