"""What a radio does to frames: each is late; some never arrive, some come twice, some behind later ones."""

from collections.abc import Iterator, Sequence

import numpy as np

_OVERTAKEN_S = 0.05
"""How much later a frame comes that is overtaken: behind those that were sent right after it."""


class Channel:
    """The way from one end of a link to the other.

    Latency is uniform within `latency_s` ± `jitter_s` (s) and drawn for each frame, so that one frame may
    overtake another. `loss`, `duplicates` and `overtaken` are the probabilities (0 to 1) that a frame is
    lost, comes twice, or comes behind later ones. `rng` is this channel's alone.
    """

    def __init__(
        self,
        latency_s: float,
        jitter_s: float,
        loss: float,
        rng: np.random.Generator,
        *,
        duplicates: float = 0.0,
        overtaken: float = 0.0,
    ) -> None:
        self._latency_s = latency_s
        self._jitter_s = jitter_s
        self._loss = loss
        self._duplicates = duplicates
        self._overtaken = overtaken
        self._uniform = _uniform_numbers(rng)

    def arrivals_s(self, sent_s: float) -> Sequence[float]:
        """When a frame that was sent at `sent_s` (s) arrives: never, once or twice."""
        if self._happens(self._loss):
            return ()
        twice = self._happens(self._duplicates)
        first_s = self._arrival_s(sent_s)
        return [first_s, self._arrival_s(sent_s)] if twice else [first_s]

    def _arrival_s(self, sent_s: float) -> float:
        spread_s = self._jitter_s * (2.0 * next(self._uniform) - 1.0) if self._jitter_s else 0.0
        detour_s = _OVERTAKEN_S if self._happens(self._overtaken) else 0.0
        return sent_s + max(0.0, self._latency_s + spread_s) + detour_s

    def _happens(self, probability: float) -> bool:
        return probability > 0.0 and next(self._uniform) < probability


def _uniform_numbers(rng: np.random.Generator) -> Iterator[float]:
    """Numbers in [0, 1); drawn in blocks, which costs a tenth of drawing one by one."""
    while True:
        yield from rng.random(1024).tolist()
