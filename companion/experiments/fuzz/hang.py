"""A bound on how long a reader may take, which ends it where it does not end by itself."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


class HangError(BaseException):
    """It took too long; no `except Exception` on the way takes this for an error of its own."""


@contextmanager
def ended_after(seconds: float) -> Iterator[None]:
    """Raise `HangError` where the block runs for longer (s); in the main thread of a process only."""

    def end(number: int, frame: FrameType | None) -> None:
        raise HangError(f"still running after {seconds:g} s")

    former = signal.signal(signal.SIGALRM, end)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, former)
