"""Whether tracking errors come out as the online model expected them to."""

import math
from collections import deque

import numpy as np

from companion.arrays import Vec3


class Expectation:
    """Compares errors with what was expected of them.

    Attributes:
        missed_m: distance between the newest error and what was expected of it (m); infinite where that was
            no number, NaN where nothing was expected.
    """

    def __init__(self) -> None:
        self.missed_m = math.nan
        self._expected: deque[tuple[float, Vec3]] = deque()

    def expect(self, time_s: float, error: Vec3) -> None:
        """This error (m) is expected at `time_s` (s); times rise."""
        self._expected.append((time_s, error))

    def compare(self, time_s: float, error: Vec3) -> None:
        """This is the error (m) at `time_s` (s)."""
        expected = None
        while self._expected and self._expected[0][0] <= time_s:
            _, expected = self._expected.popleft()
        if expected is not None:
            missed_m = float(np.linalg.norm(error - expected))
            self.missed_m = missed_m if math.isfinite(missed_m) else math.inf

    def forget(self) -> None:
        """What was expected no longer counts: another trajectory is followed, or the estimate jumped."""
        self._expected.clear()
        self.missed_m = math.nan
