"""A part of a recording, as a recording."""

from dataclasses import replace

import numpy as np

from companion.arrays import Times
from companion.recording.segments import Window
from companion.recording.series import Indices, Recording, rows


def cut(recording: Recording, start_s: float, end_s: float) -> Recording:
    """What happened from `start_s` to `end_s`, both counted in (s, the recording's clock, which stays).

    Segments and the hover window are kept where they lie within as a whole.
    """

    def within(time_s: Times) -> Indices:
        return np.flatnonzero((time_s >= start_s) & (time_s <= end_s))

    def whole(window: Window) -> bool:
        return start_s <= window.start_s and window.end_s <= end_s

    states, references, tracking = recording.states, recording.references, recording.tracking
    return replace(
        recording,
        states=rows(states, within(states.time_s)),
        references=rows(references, within(references.time_s)),
        tracking=None if tracking is None else rows(tracking, within(tracking.time_s)),
        events=tuple(event for event in recording.events if start_s <= event[0] <= end_s),
        segments=tuple(segment for segment in recording.segments if whole(segment.window)),
        hover=recording.hover if recording.hover is not None and whole(recording.hover) else None,
    )
