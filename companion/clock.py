"""The one clock: all code asks the running event loop for the time and waits through it.

In real time that loop is asyncio's own. In virtual time it is `VirtualTimeLoop`, which never waits: when
nothing is ready to run, its clock jumps to the next timer. The same program then runs as fast as the
machine allows, and the same way each time.
"""

import asyncio
import selectors
import time
from collections.abc import Callable, Coroutine
from concurrent.futures import Executor
from typing import Any, TypeVar, TypeVarTuple

T = TypeVar("T")
R = TypeVar("R")
Ts = TypeVarTuple("Ts")

_VIRTUAL_EPOCH_S = 1_767_225_600.0
"""2026-01-01, which is the simulated vehicles' date, too."""


def now() -> float:
    """The time of the running loop in seconds (monotonic; its zero has no meaning)."""
    return asyncio.get_running_loop().time()


def unix_time_s() -> float:
    """The wall's time (s since 1970), as wrong as this machine has it: for what must outlive the program."""
    return time.time()


def stopwatch_s() -> float:
    """The wall's time (s) at the finest resolution there is; only differences mean something."""
    return time.perf_counter()


def processor_s() -> float:
    """Time (s) that the processor has spent on this thread; only differences mean something."""
    return time.thread_time()


def utc_stamp() -> str:
    """The wall's date and time, for the name of a file: `20260501T123456Z`."""
    return time.strftime("%Y%m%dT%H%M%SZ", time.gmtime())


def epoch_s() -> float:
    """The date (s since 1970) at the zero of the running loop's clock; the same for every virtual time."""
    loop = asyncio.get_running_loop()
    return _VIRTUAL_EPOCH_S if isinstance(loop, VirtualTimeLoop) else time.time() - loop.time()


async def sleep_until(time_s: float) -> None:
    """Wait until the running loop's clock reads `time_s` (s); at least one turn of the loop."""
    await asyncio.sleep(max(0.0, time_s - now()))


class VirtualTimeLoop(asyncio.SelectorEventLoop):
    """An event loop whose clock stands still while code runs and jumps over every wait."""

    def __init__(self) -> None:
        self._virtual_time_s = 0.0
        self._selector_of_jumps = _JumpingSelector(self)
        super().__init__(self._selector_of_jumps)

    def time(self) -> float:
        """The virtual time in seconds since the loop was made."""
        return self._virtual_time_s

    def run_in_executor(
        self, executor: Executor | None, func: Callable[[*Ts], R], *args: *Ts
    ) -> "asyncio.Future[R]":
        """Run `func` at once: while another thread did it, the clock would jump on."""
        future: asyncio.Future[R] = self.create_future()
        try:
            future.set_result(func(*args))
        except Exception as error:
            future.set_exception(error)
        return future

    def jump(self, seconds: float) -> None:
        """Move the clock on by `seconds` (s, not negative)."""
        self._virtual_time_s += seconds


class _JumpingSelector(selectors.DefaultSelector):
    """Where the loop would sleep in `select`, its clock jumps instead."""

    def __init__(self, loop: VirtualTimeLoop) -> None:
        super().__init__()
        self._loop = loop

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
        if timeout is None:  # no timer at all: only another thread or a socket can wake this loop
            return super().select(None)
        ready = super().select(0.0)
        if not ready and timeout > 0.0:
            self._loop.jump(timeout)
        return ready


def run(main: Coroutine[Any, Any, T], *, virtual: bool = False) -> T:
    """Run `main` to its end in a new event loop, in real time or in virtual time; cancels what is left."""
    with asyncio.Runner(loop_factory=VirtualTimeLoop if virtual else None) as runner:
        return runner.run(main)
