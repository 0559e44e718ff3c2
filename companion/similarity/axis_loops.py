"""What a model's card says of how its vehicle answers: the identified loop of each axis, with intervals."""

from collections.abc import Sequence

import numpy as np

from companion.errors import InputError
from companion.learning.inverse_network import AxisLoop, AxisLoops, Measured
from companion.recording.series import Recording
from companion.similarity.identification import IdentifiedAxis, identify_recording
from companion.similarity.moments import SAMPLE_TIME_S
from companion.similarity.structure import gains_at, structure

_OUTSIDE = 0.025
"""Share of the resampled figures on either side of the interval."""


def axis_loops(recording: Recording) -> AxisLoops | None:
    """North, east and down of the vehicle that flew so; None where the flight gives no model."""
    try:
        model = identify_recording(recording)
    except InputError:
        return None
    north, east, down = map(_loop, model.axes)
    return north, east, down


def _loop(axis: IdentifiedAxis) -> AxisLoop:
    found = structure(axis.model)
    gains = [gains_at(each.system, found.relative_degree) for each in (axis.model, *axis.resamples)]
    position, velocity, acceleration = (
        _measured([each.state[entry] for each in gains]) for entry in range(3)
    )
    return AxisLoop(
        step_s=SAMPLE_TIME_S,
        delay_s=found.delay_s,
        relative_degree=found.relative_degree,
        minimum_phase=found.minimum_phase,
        state_gain=(position, velocity, acceleration),
        input_gain=_measured([each.input for each in gains]),
    )


def _measured(values: Sequence[float]) -> Measured:
    """The first of `values`, and where the rest lie."""
    low, high = np.quantile(values[1:], (_OUTSIDE, 1.0 - _OUTSIDE))
    return float(values[0]), float(low), float(high)
