"""A bound on how long a reader may compute, which ends it where it does not end by itself."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


class HangError(BaseException):
    """It computed for too long; no `except Exception` on the way takes this for an error of its own."""


@contextmanager
def ended_after(seconds: float) -> Iterator[None]:
    """Raise `HangError` where the block takes more of the processor (s); in the main thread only."""

    def end(number: int, frame: FrameType | None) -> None:
        raise HangError(f"still computing after {seconds:g} s")

    former = signal.signal(signal.SIGPROF, end)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, former)
