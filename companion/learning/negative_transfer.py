"""Negative transfer: whether what was learned does harm, measured while it is flown.

The yardstick is what would have come without it. A reference that differs from another pulls the vehicle by
an acceleration, and how far that moves it, its position loop's stiffness and damping tell (`Displacement`);
they are the autopilot's, not the online model's, for a judge must not be the one who is judged. With the
error e that came, the vehicle moved by φ: e + φ is the error that the plainer reference would have left.

Two are judged. The network's share is the one that would have left the least error, as far as that can be
told from all other reasons for errors (`NetworkJudge`). The online correction, which answers to errors and
so may run away, is either believed or not (`CorrectionJudge`). No share changes faster than from full to none
in `FADE_S`; that of the network, which rests on a memory of seconds (`harm_memory_s`), mostly changes slower.
"""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from companion.arrays import Array, Vec3

FADE_S = 0.5
"""From full share to none, and back."""
_SPREAD = 0.3
"""Standard deviation of a network's best share about the usual one, before anything was flown with it."""
_LEAST_POWER = 1e-8
"""Less (m² s) is no displacement at all, but rounding."""
_USUAL_ERROR_M = 0.002
"""Of other reasons, always reckoned with: one look at a network does not tell everything of it."""
_INDEPENDENT_S = 0.5
"""Errors this far apart have other reasons: gusts, and an estimate that wanders."""
_BELIEVED = 0.5
"""Of a computed displacement: an autopilot's integrator undoes what is held for long."""
_HARM, _HELP = 1.2, 0.8
"""Ratio of mean square errors with and without, above which it is harm, below which help."""
_TOLERATED_M = 0.02
"""RMS errors below this are no harm, whatever their reason."""
_DIVERGING, _CONTRACTING = 2.0, 1.5
"""|1 − α Ĝ|: beyond the first the correction makes of an error a larger one, by its own model; 1 is the
limit, but in flights that go well Ĝ comes out so wrong that 1.5 is seen."""
_LOOP_MEMORY_S = 1.0
_CONTRADICTED_S = 0.4
"""Errors that come opposite to what was predicted for so long show a model that is wrong."""
_FIRST_RETRY_S = 3.0
"""How long a correction that did harm is off at least; each time twice as long."""


class Shares(NamedTuple):
    """How much of what was learned is flown, 0 to 1.

    Attributes:
        network: of the way from the plain reference to the network's.
        correction: of the online correction.
    """

    network: float = 0.0
    correction: float = 1.0


class Displacement:
    """How far a pull has moved a vehicle whose position loop holds it: φ'' = a − c φ' − k φ, by axis.

    Attributes:
        position: φ (m).
    """

    def __init__(self) -> None:
        self.position: Vec3 = np.zeros(3)
        self._velocity: Vec3 = np.zeros(3)

    def pull(self, acceleration: Vec3, stiffness: Vec3, damping: Vec3, duration_s: float) -> Vec3:
        """φ (m) after the pull `acceleration` (m/s²) of this duration, with k (1/s²) and c (1/s).

        Integrated backwards (implicit Euler), which is stable for every k, c and duration.
        """
        gained = self._velocity + duration_s * (acceleration - stiffness * self.position)
        self._velocity = gained / (1.0 + duration_s * damping + duration_s**2 * stiffness)
        self.position = self.position + duration_s * self._velocity
        return self.position


class NetworkJudge:
    """The share of each network that leaves the least error, as far as that shows above other reasons for it.

    The error without any, e + φ, is s ψ and noise, ψ being the displacement that all of a network would
    cause: a regression in one dimension, whose observations count less with age. The variance of its s,
    robust to noise that comes and goes (White, "A heteroskedasticity-consistent covariance matrix
    estimator", Econometrica 48, 1980), is weighed against that of a network's best share about the usual
    one. So what does not reach above the noise changes nothing.

    Attributes:
        shares: now, of each network, 0 to 1.
    """

    def __init__(self, count: int, usual_share: float, memory_s: float) -> None:
        self.shares: Float[Array, " n"] = np.full(count, usual_share)
        self._usual_share = usual_share
        self._memory_s = memory_s
        self._agreement, self._power, self._noise = np.zeros((3, count))

    def judge(self, error: Vec3, moved: Vec3, would_move: Float[Array, "n 3"], duration_s: float) -> None:
        """A step passed.

        Args:
            error: e = y_d − y (m).
            moved: φ, displacement by what is flown of the networks (m).
            would_move: ψ, by all of each alone (m).
            duration_s: of the step.
        """
        if self._memory_s > 0.0:
            kept = math.exp(-duration_s / self._memory_s)
            agreement, power = would_move @ (error + moved), (would_move**2).sum(axis=1)
            self._agreement = kept * self._agreement + duration_s * agreement
            self._power = kept * self._power + duration_s * power
            unexplained = agreement - self._agreement / np.maximum(self._power, _LEAST_POWER) * power
            self._noise = kept * self._noise + duration_s * unexplained**2
        self.shares = faded(self.shares, self._best_shares(), duration_s)

    @property
    def gains(self) -> Float[Array, " n"]:
        """By how much less the mean square error is with each network's share of it than without (m²)."""
        if self._memory_s == 0.0:
            return np.zeros_like(self.shares)
        gains: Float[Array, " n"] = self.shares * (2.0 * self._agreement - self.shares * self._power)
        return gains / self._memory_s

    def _best_shares(self) -> Float[Array, " n"]:
        power = np.maximum(self._power, _LEAST_POWER)
        variance = _INDEPENDENT_S * (self._noise / power + _USUAL_ERROR_M**2) / power
        known = _SPREAD**2 / (_SPREAD**2 + variance) * np.minimum(self._power / _LEAST_POWER, 1.0)
        shares: Float[Array, " n"] = self._usual_share + known * (self._agreement / power - self._usual_share)
        return shares


class CorrectionJudge:
    """Whether the online correction is believed: fully, until it does harm, and again once it would help.

    Harm is an error larger than the autopilot alone would have left, or one that comes opposite to what was
    predicted: that is seen at once, when a model goes wrong on which much depends.

    Attributes:
        share: now, 0 to 1.
        believed: where the share goes.
    """

    def __init__(self, memory_s: float) -> None:
        self.share = 1.0
        self.believed = True
        self._memory_s = memory_s
        self._came = self._otherwise = self._contradiction = 0.0
        self._loop_gain = 1.0
        self._since_s = 0.0
        self._retry_s = _FIRST_RETRY_S

    def judge(
        self,
        error: Vec3,
        predicted: Vec3,
        moved: Vec3,
        would_move: Vec3,
        loop_gain: float,
        duration_s: float,
    ) -> None:
        """A step passed.

        Args:
            error: e = y_d − y (m).
            predicted: the error that had been predicted for now (m).
            moved: displacement by the correction as it was flown, held by the autopilot alone (m).
            would_move: by all of it, held by correction and autopilot (m).
            loop_gain: largest |1 − α Ĝ| of the axes, α as it would be in full.
            duration_s: of the step.
        """
        if self._memory_s > 0.0:
            otherwise = error + _BELIEVED * moved if self.believed else error - _BELIEVED * would_move
            contradiction = -float((error + 0.5 * predicted) @ predicted)
            recent, latest = (min(duration_s / span_s, 1.0) for span_s in (self._memory_s, _CONTRADICTED_S))
            self._came += recent * (float(error @ error) - self._came)
            self._otherwise += recent * (float(otherwise @ otherwise) - self._otherwise)
            self._contradiction += latest * (contradiction - self._contradiction)
            self._loop_gain += min(duration_s / _LOOP_MEMORY_S, 1.0) * (loop_gain - self._loop_gain)
            self._since_s += duration_s
            self._decide()
        most = duration_s / FADE_S
        self.share = min(self.share + most, 1.0) if self.believed else max(self.share - most, 0.0)

    def _decide(self) -> None:
        does_harm = self._came > _HARM * self._otherwise + _TOLERATED_M**2
        is_wrong = self._contradiction > _TOLERATED_M**2 or self._loop_gain > _DIVERGING
        if self.believed and (does_harm or is_wrong):
            self._turn(believed=False)
        would_help = self._otherwise < _HELP * self._came and self._contradiction <= 0.0
        may_return = self._since_s > self._retry_s and self._loop_gain < _CONTRACTING
        if not self.believed and would_help and may_return:
            self._retry_s *= 2.0
            self._turn(believed=True)

    def _turn(self, *, believed: bool) -> None:
        """What was compared before compared something else."""
        self.believed = believed
        self._since_s = self._came = self._otherwise = self._contradiction = 0.0


def faded(share: Float[Array, "*n"], target: Float[Array, "*n"], duration_s: float) -> Float[Array, "*n"]:
    """Shares on their way to targets (both held within 0 and 1) after `duration_s`, within `FADE_S` there."""
    most = duration_s / FADE_S
    on_its_way: Float[Array, "*n"] = np.minimum(np.maximum(target, share - most), share + most)
    return np.minimum(np.maximum(on_its_way, 0.0), 1.0)


def bounded(pull: Vec3, stiffness: Vec3, farthest_m: float) -> float:
    """The part (0 to 1) of a pull (m/s²) that, held, moves the vehicle by at most `farthest_m`.

    However wrong a network is, the vehicle is not farther off than that until it is found out.
    """
    held_m = math.hypot(*(pull / stiffness))
    if not math.isfinite(held_m):
        return 0.0
    return 1.0 if held_m <= farthest_m else farthest_m / held_m


def loop_gain(alpha: Vec3, error_gradient: Float[Array, "3 3"]) -> Vec3:
    """|1 − α Ĝ| of each axis, Ĝ = −∂e_p/∂u1: what a step of the correction leaves of an error (Insight 1).

    1, which is nothing done, where the model knows no gradient (NaN).
    """
    gain: Vec3 = np.abs(1.0 + alpha * error_gradient.diagonal())
    return np.where(np.isfinite(gain), gain, 1.0)
