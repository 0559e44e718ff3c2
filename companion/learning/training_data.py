"""From a recorded flight to what the inverse network is trained on: {x(k), y(k+r)} → u(k).

The paper's section "Background on Offline Inverse Learning": what was flown one preview later stands for what
is desired, and the reference that led to it is what the network has to answer.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from companion.arrays import Array, Times, Vec3s
from companion.errors import InputError
from companion.learning.features import Preview, inverse_inputs, inverse_outputs, state_vector
from companion.recording.series import Indices, Recording, ReferenceSeries, rows

LONGEST_GAP_S = 0.25
"""A stream that pauses for longer is broken there: nothing is interpolated or learned across the gap."""

FEWEST_PAIRS = 200
"""What a training needs at the very least; the paper used 2,800."""

LONGEST_LAG_S = 2.0

HELD_OUT_SHARE = 0.15
"""Of each flight: its last part."""

COPIES = 4
DISPLACEMENT_M = 0.2
"""Standard deviation on each axis, about that of a tracking error."""
TILT_NOISE_RAD = 0.1
"""Standard deviation; about that of a tilt against the wind, which no acceleration answers to."""


class Samples(NamedTuple):
    """Inputs and outputs of an inverse network, in the order of time within each flight."""

    inputs: Float[Array, "n d"]
    outputs: Float[Array, "n m"]

    def rows(self, chosen: slice) -> "Samples":
        """Some of them."""
        return Samples(self.inputs[chosen], self.outputs[chosen])


def split(flights: Sequence[Samples]) -> tuple[Samples, Samples]:
    """What is trained on, and what is held out: the last part of each flight, in one piece.

    Neighbours in time are nearly copies of each other, and a shuffled split would measure memory.
    """
    kept = [round(len(flight.inputs) * (1.0 - HELD_OUT_SHARE)) for flight in flights]
    return (
        joined([flight.rows(slice(count)) for flight, count in zip(flights, kept, strict=True)]),
        joined([flight.rows(slice(count, None)) for flight, count in zip(flights, kept, strict=True)]),
    )


def joined(flights: Sequence[Samples]) -> Samples:
    """The samples of all flights, one after the other."""
    return Samples(*(np.concatenate(parts) for parts in zip(*flights, strict=True)))


def training_pairs(recording: Recording, preview: Preview, sample_time_s: float) -> Samples:
    """Inputs I1 and outputs O1 at every `sample_time_s` (s) of a flight, in the order of time.

    k is the instant at which a reference was sent; states are interpolated there and one preview later.
    Where most references have an acceleration, it joins the outputs (`features.ACCELERATING_OUTPUTS`). Left
    out is what lacks a part of its reference, and what falls into a gap of states or references.

    Raises:
        InputError: too little of the flight can be used.
    """
    sent, states = _complete(recording.references), recording.states
    continues_s = _end_of_stretch(sent.time_s) - sent.time_s
    chosen = _thinned(sent.time_s, sample_time_s)
    chosen = chosen[continues_s[chosen] >= preview.longest_s]
    time_s = sent.time_s[chosen]
    flown = state_vector(states.position, states.velocity, states.attitude, states.rates)
    x = _interpolated(time_s, states.time_s, flown)
    inputs = inverse_inputs(
        x,
        _ahead(time_s, preview.position_s, states.time_s, states.position),
        _ahead(time_s, preview.velocity_s, states.time_s, states.velocity),
    )
    acceleration = sent.acceleration[chosen] if has_acceleration(recording) else None
    outputs = inverse_outputs(x, sent.position[chosen], sent.velocity[chosen], acceleration)
    usable = np.isfinite(inputs).all(axis=1) & np.isfinite(outputs).all(axis=1)
    if usable.sum() < FEWEST_PAIRS:
        raise InputError(
            f"the recording gives {usable.sum()} training samples, at least {FEWEST_PAIRS} are needed: "
            "fly longer, or mend the gaps in its telemetry"
        )
    return Samples(inputs[usable], outputs[usable])


def has_acceleration(recording: Recording) -> bool:
    """Whether most of the references sent had an acceleration as well."""
    accelerations = _complete(recording.references).acceleration
    return int(np.isfinite(accelerations).all(axis=1).sum()) > len(accelerations) / 2


def without_acceleration(recording: Recording) -> Recording:
    """The recording as if no acceleration had been sent: what the paper's network learns from."""
    sent = recording.references
    return replace(recording, references=replace(sent, acceleration=np.full_like(sent.acceleration, np.nan)))


def displaced(samples: Samples, rng: np.random.Generator) -> Samples:
    """The samples, each `COPIES` times in a row, with the vehicle beside its path, and its tilt uncertain.

    In training, what is desired is what was flown, so that no sample shows the vehicle beside its path: a
    network would have no answer to a position error, and could not tell it from speed. Here desired and
    reference position stay while the vehicle is moved: the source's own position loop acts, as it would.
    Noise on the tilt keeps the network from repeating what the vehicle is about to do anyway.
    """
    inputs, outputs = (np.repeat(part, COPIES, axis=0) for part in samples)
    beside = rng.normal(scale=DISPLACEMENT_M, size=(len(inputs), 3))
    inputs[:, 0:3] -= beside
    outputs[:, 0:3] -= beside
    inputs[:, 6:8] += rng.normal(scale=TILT_NOISE_RAD, size=(len(inputs), 2))
    return Samples(inputs, outputs)


def constant_lag(recording: Recording) -> float:
    """The constant time (s) by which the flown position lags behind its reference: least squares, to 10 ms.

    To send the desired position that much early is what can be done without a model. With an acceleration in
    the reference a vehicle lags less, and it is not that time.
    """
    sent, states = _complete(recording.references), recording.states
    lags = np.arange(0.0, LONGEST_LAG_S, 0.01)
    misfits = np.full(len(lags), np.inf)
    for index, lag in enumerate(lags):
        misfit = _ahead(sent.time_s, (lag, lag, lag), states.time_s, states.position) - sent.position
        known = np.isfinite(misfit).all(axis=1)
        if known.sum() >= FEWEST_PAIRS:
            misfits[index] = np.mean(misfit[known] ** 2)
    return float(lags[np.argmin(misfits)])


def plain_lag(recordings: Sequence[Recording]) -> float | None:
    """`constant_lag` of the first flight without acceleration; None where every one was sent it."""
    plain = (recording for recording in recordings if not has_acceleration(recording))
    return next(map(constant_lag, plain), None)


def _complete(references: ReferenceSeries) -> ReferenceSeries:
    """Those references that had both a position and a velocity."""
    complete = np.isfinite(references.position).all(axis=1) & np.isfinite(references.velocity).all(axis=1)
    return rows(references, np.flatnonzero(complete))


def _end_of_stretch(time_s: Times) -> Times:
    """For each instant, the last one that follows it without a gap."""
    stretch = np.concatenate(([0], np.cumsum(np.diff(time_s) > LONGEST_GAP_S))) if len(time_s) else time_s
    last = np.searchsorted(stretch, stretch, side="right") - 1
    return time_s[last]


def _thinned(time_s: Times, sample_time_s: float) -> Int[Indices, " k"]:
    """Indices of instants that are `sample_time_s` apart, or farther where there are none."""
    number = np.round((time_s - time_s[:1]) / sample_time_s)
    return np.unique(number, return_index=True)[1]


def _ahead(time_s: Times, lead_s: tuple[float, float, float], known_s: Times, values: Vec3s) -> Vec3s:
    """Each axis of `values` its own lead later than `time_s`."""
    return np.column_stack(
        [_interpolated(time_s + lead, known_s, values[:, [axis]]) for axis, lead in enumerate(lead_s)]
    )


def _interpolated(time_s: Times, known_s: Times, values: Float[Array, "m d"]) -> Float[Array, "n d"]:
    """Linear between the known instants; NaN outside of them and within their gaps."""
    if len(known_s) < 2:
        return np.full((len(time_s), values.shape[1]), np.nan)
    after = np.clip(np.searchsorted(known_s, time_s), 1, len(known_s) - 1)
    between = known_s[after] - known_s[after - 1]
    elapsed = time_s - known_s[after - 1]
    share = np.divide(elapsed, between, out=np.zeros_like(between), where=between > 0.0)
    interpolated = values[after - 1] + share[:, None] * (values[after] - values[after - 1])
    interpolated[(elapsed < 0.0) | (elapsed > between) | (between > LONGEST_GAP_S)] = np.nan
    return interpolated
