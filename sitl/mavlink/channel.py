"""What a radio does to frames: each is late by a random latency, and some never arrive."""

from collections.abc import Iterator

import numpy as np


class Channel:
    """The way of telemetry from the vehicle to its peer.

    Latency is uniform within `latency_s` ± `jitter_s` (s) and drawn for each frame, so that one frame may
    overtake another; `loss` is the probability (0 to 1) that a frame is lost. `rng` is this channel's alone.
    """

    def __init__(self, latency_s: float, jitter_s: float, loss: float, rng: np.random.Generator) -> None:
        self._latency_s = latency_s
        self._jitter_s = jitter_s
        self._loss = loss
        self._uniform = _uniform_numbers(rng)

    def arrival_s(self, sent_s: float) -> float | None:
        """When a frame that was sent at `sent_s` (s) arrives; None when it is lost."""
        if self._loss and next(self._uniform) < self._loss:
            return None
        spread_s = self._jitter_s * (2.0 * next(self._uniform) - 1.0) if self._jitter_s else 0.0
        return sent_s + max(0.0, self._latency_s + spread_s)


def _uniform_numbers(rng: np.random.Generator) -> Iterator[float]:
    """Numbers in [0, 1); drawn in blocks, which costs a tenth of drawing one by one."""
    while True:
        yield from rng.random(1024).tolist()
