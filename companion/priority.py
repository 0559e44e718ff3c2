"""Computing time when it is due, on a machine that has other work too."""

import gc
import os
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from enum import StrEnum

_LEAST_REALTIME = 1
_NICENESS = -10


class Priority(StrEnum):
    """What the operating system grants."""

    REALTIME = "real-time"
    """Ahead of every program that has not the same (SCHED_RR); the kernel keeps a twentieth for those."""
    HIGH = "high"
    """A larger share than others have (niceness -10)."""
    NORMAL = "normal"
    """The same as others: more takes root, CAP_SYS_NICE, or an `rtprio` in limits.conf."""


@contextmanager
def prioritised() -> Iterator[Priority]:
    """Run the block with as much priority as this user may have, and without looking for older garbage.

    The priority is that of this thread, and of the threads that the block starts.
    """
    with ExitStack() as afterwards:
        gc.freeze()
        afterwards.callback(gc.unfreeze)
        yield _take(afterwards)


def _take(afterwards: ExitStack) -> Priority:
    if hasattr(os, "sched_setscheduler"):  # Linux
        policy, parameters = os.sched_getscheduler(0), os.sched_getparam(0)
        with suppress(PermissionError):
            os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(_LEAST_REALTIME))
            afterwards.callback(os.sched_setscheduler, 0, policy, parameters)
            return Priority.REALTIME
    niceness = os.getpriority(os.PRIO_PROCESS, 0)
    with suppress(PermissionError):
        os.setpriority(os.PRIO_PROCESS, 0, min(niceness, _NICENESS))
        afterwards.callback(os.setpriority, os.PRIO_PROCESS, 0, niceness)
        return Priority.HIGH
    return Priority.NORMAL
