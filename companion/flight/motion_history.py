"""Where the vehicle was and how fast, at instants between those of its states."""

from bisect import bisect_left
from typing import TypeAlias

import numpy as np
from jaxtyping import Float

from companion.arrays import Array, Vec3
from companion.flight.drift import LONGEST_GAP_S
from companion.state import VehicleState

Leads: TypeAlias = tuple[float, float, float]
"""One for each axis (s)."""

RECENT_S = 0.1
"""Over so long acceleration and drift are averaged: the estimator's steps are shorter."""
_UNKNOWN = np.full(6, np.nan)


class MotionHistory:
    """Where the vehicle was and how fast, at any instant of the last `span_s` seconds."""

    def __init__(self, span_s: float) -> None:
        self._span_s = span_s
        self._times: list[float] = []
        self._motions: list[Float[Array, "6"]] = []

    def append(self, state: VehicleState) -> None:
        """Take in the newest state; times rise."""
        self._times.append(state.time_s)
        self._motions.append(np.concatenate((state.position, state.velocity)))
        if self._times[0] < state.time_s - 2.0 * self._span_s:  # rarely, so that it costs little
            kept = bisect_left(self._times, state.time_s - self._span_s)
            del self._times[:kept], self._motions[:kept]

    def position(self, time_s: float, leads_s: Leads) -> Vec3:
        """Each axis of the position (m) its own lead after `time_s`; NaN where no states are near enough."""
        at = {lead_s: self._at(time_s + lead_s) for lead_s in set(leads_s)}
        return np.array([at[lead_s][axis] for axis, lead_s in enumerate(leads_s)])

    def velocity(self, time_s: float, leads_s: Leads) -> Vec3:
        """The same of the velocity (m/s)."""
        at = {lead_s: self._at(time_s + lead_s) for lead_s in set(leads_s)}
        return np.array([at[lead_s][3 + axis] for axis, lead_s in enumerate(leads_s)])

    def recent(self, state: VehicleState) -> tuple[Vec3, Vec3]:
        """Mean acceleration (m/s²) and drift (m/s) over the last `RECENT_S` before `state`, or zeros.

        Drift is how fast the position moved beside its own velocity.
        """
        past = self._at(state.time_s - RECENT_S)
        if np.isnan(past).any():
            return np.zeros(3), np.zeros(3)
        moved = (state.position - past[:3]) / RECENT_S
        return (state.velocity - past[3:]) / RECENT_S, moved - 0.5 * (state.velocity + past[3:])

    def _at(self, time_s: float) -> Float[Array, "6"]:
        """Linear between two states."""
        after = bisect_left(self._times, time_s)
        if after == len(self._times) or (after == 0 and self._times[0] > time_s):
            return _UNKNOWN
        if self._times[after] == time_s:
            return self._motions[after]
        gap_s = self._times[after] - self._times[after - 1]
        if gap_s > LONGEST_GAP_S:
            return _UNKNOWN
        share = (time_s - self._times[after - 1]) / gap_s
        return (1.0 - share) * self._motions[after - 1] + share * self._motions[after]
