"""How long a vehicle that changed in flight takes until it tracks as before."""

import numpy as np

from companion.experiments.flights import Flight

_WORSE = 2.0
"""Times its RMS before, under which an error counts as back."""
_STAYS_S = 1.0
"""So long it must stay there, or to the end of the flight."""


def recovery_s(flight: Flight, event_s: float) -> float | None:
    """Time (s) from an event until the error is back under twice its RMS before, and stays there for 1 s.

    0 where it never left; None where it never came back, or nothing was flown before the event.
    """
    error = np.linalg.norm(flight.flown - flight.desired, axis=1)
    before = error[flight.time_s < event_s]
    if not before.size:
        return None
    bound = _WORSE * np.sqrt(np.mean(before**2))
    above = flight.time_s[(flight.time_s >= event_s) & (error > bound)]
    left = np.concatenate(([event_s], above))
    stays = np.diff(left, append=np.inf) > _STAYS_S
    back_s = float(left[np.argmax(stays)])
    return None if back_s >= flight.time_s[-1] else back_s - event_s
