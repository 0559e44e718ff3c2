"""A vehicle's closed loop, from reference to position, identified from a flight by least squares.

Axis by axis: x(k+1) = A x(k) + B u(k − delay) + offset, with x the measured position, velocity and
acceleration. What is known is not estimated: a vehicle displaced together with its reference flies the same,
and its position is the integral of its velocity.

Velocity and acceleration references act on an autopilot's position loop as a displaced position reference
would: u = p_r + T_v v_r + T_a a_r. The weights are found by reduced-rank regression (A. Izenman, Journal of
Multivariate Analysis 5, 1975), which makes one input of the three.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from companion.arrays import Array
from companion.errors import InputError
from companion.recording.series import Recording, ReferenceSeries, StateSeries
from companion.similarity.linear_system import LinearSystem
from companion.similarity.moments import FARTHEST_M, SAMPLE_TIME_S, Moments, moments
from companion.similarity.samples import GRID_S, AxisSeries, axis_series

AXES = ("north", "east", "down")
RESAMPLES = 100
FEWEST_ROWS = 150
"""Three seconds of flight; intervals tell whether that is enough."""
LEAST_MOTION_M = 0.1
"""An axis along which the position varied by less (standard deviation) tells of gusts, not of the vehicle."""
_RIDGE = 1e-9


@dataclass(frozen=True, eq=False)
class AxisModel:
    """The closed loop of one axis.

    Attributes:
        system: from u to the position; its state is position, velocity and acceleration.
        reference_weights: T_v (s) and T_a (s²); 0 where no such reference was sent.
        offset: what is added to the state in each step: wind, and what else does not change.
        delay_s: dead time before u acts (s).
        noise: covariance of what one step adds to velocity and acceleration unforeseen.
    """

    system: LinearSystem
    reference_weights: Float[Array, "2"]
    offset: Float[Array, "3"]
    delay_s: float
    noise: Float[Array, "2 2"]


class AxisEstimate(NamedTuple):
    """What is estimated of one axis from a flight, the real one or one put together from its blocks.

    Attributes:
        model: of the whole flight.
        bands: of the parts flown at each band of speed, None where there was too little.
        drift_m_s: RMS speed at which the position moves beside its velocity (m/s).
    """

    model: AxisModel
    bands: tuple[AxisModel | None, ...]
    drift_m_s: float


@dataclass(frozen=True, eq=False)
class IdentifiedAxis:
    """What a flight tells of one axis.

    Attributes:
        estimate: of the flight as it was.
        resampled: of as many flights drawn from its blocks with replacement (block bootstrap).
        spread: standard deviation of position, velocity and acceleration.
        second_moments: mean of zᵀz, z = (velocity, acceleration, p_r − p, v_r, a_r, 1), for each band.
        shares: of the flight's time, of each band.
    """

    estimate: AxisEstimate
    resampled: tuple[AxisEstimate, ...]
    spread: Float[Array, "3"]
    second_moments: Float[Array, "bands 6 6"]
    shares: Float[Array, " bands"]

    @property
    def model(self) -> AxisModel:
        """Of the flight as it was."""
        return self.estimate.model

    @property
    def moved(self) -> bool:
        """Whether it tells of the vehicle."""
        return bool(self.spread[0] >= LEAST_MOTION_M)

    @property
    def resamples(self) -> tuple[AxisModel, ...]:
        """The models of the resampled flights."""
        return tuple(each.model for each in self.resampled)


@dataclass(frozen=True, eq=False)
class VehicleModel:
    """What a flight tells of a vehicle: north, east and down, and how long it was (s)."""

    axes: tuple[IdentifiedAxis, IdentifiedAxis, IdentifiedAxis]
    seconds: float


def identify_recording(recording: Recording, *, resamples: int = RESAMPLES, seed: int = 0) -> VehicleModel:
    """`identify` what was recorded."""
    return identify(recording.states, recording.references, resamples=resamples, seed=seed)


def identify(
    states: StateSeries, references: ReferenceSeries, *, resamples: int = RESAMPLES, seed: int = 0
) -> VehicleModel:
    """The vehicle that flew so.

    Raises:
        InputError: too little of the flight can be used, no position was sent, or the reference hardly moved
            along any axis.
    """
    if len(states.time_s) < 2 or len(references.time_s) < 2:
        raise InputError("no states or no references in this flight: record both")
    rng = np.random.default_rng(seed)
    series = axis_series(states, references)
    found = [moments(axis) for axis in series]
    fewest, worst = min((each.rows, axis) for each, axis in zip(found, AXES, strict=True))
    if fewest < FEWEST_ROWS:
        raise InputError(
            f"{worst}: {fewest * 2 * GRID_S:.1f} s of flight with states, and references within "
            f"{FARTHEST_M:g} m; at least {FEWEST_ROWS * 2 * GRID_S:.0f} s are needed: "
            "fly longer, nearer to the reference, or mend the gaps in its telemetry"
        )
    if max(_reference_motion(each) for each in series) < LEAST_MOTION_M:
        raise InputError(
            f"the reference moved by less than {LEAST_MOTION_M:g} m (standard deviation) along every axis: "
            "fly farther"
        )
    north, east, down = (
        _identify_axis(each, axis, resamples, rng) for each, axis in zip(found, series, strict=True)
    )
    return VehicleModel((north, east, down), seconds=fewest * 2 * GRID_S)


def _reference_motion(series: AxisSeries) -> float:
    """Standard deviation of the position reference (m)."""
    return float(np.nanstd(series.reference[:, 0]))


def _spread(series: AxisSeries) -> Float[Array, "3"]:
    """Of the state where it was given a reference."""
    asked = np.isfinite(series.reference).all(axis=1)
    spread: Array = np.nanstd(series.state[asked], axis=0)
    return spread


def _identify_axis(
    found: Moments, series: AxisSeries, resamples: int, rng: np.random.Generator
) -> IdentifiedAxis:
    blocks = found.sums.shape[1]
    drawn = rng.multinomial(blocks, np.full(blocks, 1.0 / blocks), size=resamples)
    weights = np.vstack((np.ones(blocks), drawn.astype(np.float64)))
    redrawn = zip(np.tensordot(weights, found.sums, axes=(1, 1)), found.drift_m_s(weights), strict=True)
    estimate, *resampled = (_estimate(sums, found.inputs, float(drift)) for sums, drift in redrawn)
    in_bands = found.sums[round(estimate.model.delay_s / GRID_S)].sum(axis=0)
    one = 2 + found.inputs
    rows = in_bands[:, one, one]
    kept = [*range(2 + found.inputs), one]
    second = np.zeros((len(rows), 6, 6))
    place = [*range(2 + found.inputs), 5]
    second[np.ix_(range(len(rows)), place, place)] = (
        in_bands[np.ix_(range(len(rows)), kept, kept)] / np.maximum(rows, 1.0)[:, None, None]
    )
    return IdentifiedAxis(estimate, tuple(resampled), _spread(series), second, rows / rows.sum())


def _estimate(sums: Float[Array, "delays bands q q"], inputs: int, drift_m_s: float) -> AxisEstimate:
    model = _best(sums.sum(axis=1), inputs)
    one = 2 + inputs
    bands = tuple(
        axis_model(each, inputs, model.delay_s) if each[one, one] >= FEWEST_ROWS else None
        for each in sums[round(model.delay_s / GRID_S)]
    )
    return AxisEstimate(model, bands, drift_m_s)


def _best(by_delay: Float[Array, "delays q q"], inputs: int) -> AxisModel:
    """The model with the dead time that leaves least unexplained: log det of the residuals' covariance."""
    z = 3 + inputs
    regressors = by_delay[:, :z, :z] + _RIDGE * np.eye(z) * by_delay[:, z - 1, z - 1, None, None]
    explained = by_delay[:, z:, :z] @ np.linalg.solve(regressors, by_delay[:, :z, z:])
    least = _RIDGE * np.eye(2) * by_delay[:, z - 1, z - 1, None, None]
    left = np.linalg.slogdet(by_delay[:, z:, z:] - explained + least)[1]
    best = int(np.argmin(left))
    return axis_model(by_delay[best], inputs, best * GRID_S)


def axis_model(sums: Float[Array, "q q"], inputs: int, delay_s: float) -> AxisModel:
    """The model of least squares, its references joined to one input, from moments with that dead time."""
    asked = slice(2, 2 + inputs)
    z = 3 + inputs
    own = [0, 1, z - 1]
    count = sums[z - 1, z - 1]
    ridge = _RIDGE * count * np.eye(z)
    coefficients = np.linalg.solve(sums[:z, :z] + ridge, sums[:z, z:]).T
    noise = (sums[z:, z:] - coefficients @ sums[:z, z:]) / count + _RIDGE * np.eye(2)
    of_own = np.linalg.solve(sums[np.ix_(own, own)] + ridge[:3, :3], sums[own, asked])
    partial = sums[asked, asked] - sums[asked, own] @ of_own + ridge[:inputs, :inputs]
    whitening = np.linalg.cholesky(np.linalg.inv(noise)).T
    colour = np.linalg.cholesky(partial)
    left, values, right = np.linalg.svd(whitening @ coefficients[:, asked] @ colour)
    direction = np.linalg.solve(colour.T, right[0])
    gain = values[0] * np.linalg.solve(whitening, left[:, 0]) * direction[0]
    weights = np.zeros(2)
    weights[: inputs - 1] = direction[1:] / direction[0]
    joined = np.outer(gain, direction / direction[0])
    rest = np.linalg.solve(
        sums[np.ix_(own, own)] + ridge[:3, :3], sums[own, z:] - sums[own, asked] @ joined.T
    ).T
    return _with_kinematics(rest, gain, weights, delay_s, noise)


def _with_kinematics(
    rest: Float[Array, "2 3"],
    gain: Float[Array, "2"],
    weights: Float[Array, "2"],
    delay_s: float,
    noise: Float[Array, "2 2"],
) -> AxisModel:
    """The whole state's model, from changes of velocity and acceleration.

    Args:
        rest: per unit of velocity, of acceleration, and constant.
        gain: per metre of u − p.
        weights: T_v and T_a.
        delay_s: dead time.
        noise: of those changes.
    """
    h = SAMPLE_TIME_S
    A, B, offset = np.eye(3), np.zeros(3), np.zeros(3)
    A[1:, 0], A[1:, 1:], B[1:], offset[1:] = -gain, np.eye(2) + rest[:, :2], gain, rest[:, 2]
    if not rest[1].any():
        A[2] = 0.0  # no acceleration is measured, so that there is none to carry on
    # The position is the cubic's integral between velocities and accelerations at both ends.
    A[0] = (1.0, h / 2.0, h**2 / 12.0) + h / 2.0 * A[1] - h**2 / 12.0 * A[2]
    B[0], offset[0] = (h / 2.0 * each[1] - h**2 / 12.0 * each[2] for each in (B, offset))
    return AxisModel(LinearSystem(A, B, np.array([1.0, 0.0, 0.0])), weights, offset, delay_s, noise)
