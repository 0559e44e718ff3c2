"""Which faults are there at a time, and since when."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from sitl.faults.kinds import Fault, Phase
from sitl.firmware.interface import Autopilot, Landed, Mode


@dataclass(frozen=True, slots=True)
class Active:
    """A fault that is there.

    Attributes:
        fault: which.
        since_s: when it began (s since boot).
    """

    fault: Fault
    since_s: float


@dataclass(frozen=True, slots=True)
class Change:
    """What began and what ended since the last look."""

    begun: tuple[Active, ...] = ()
    ended: tuple[Active, ...] = ()


class Schedule:
    """Faults that wait for their time, and those that are there.

    Attributes:
        active: those that are there, in the order in which they began.
    """

    def __init__(self, faults: Iterable[Fault] = ()) -> None:
        self.active: tuple[Active, ...] = ()
        self._waiting = tuple(faults)
        self._phases = {Phase.BOOT: 0.0}
        self._ended: tuple[Active, ...] = ()
        self._injected: tuple[Fault, ...] = ()

    @property
    def is_idle(self) -> bool:
        """Whether nothing is there, nor ever will be."""
        return not (self.active or self._waiting or self._injected or self._ended)

    def inject(self, fault: Fault) -> None:
        """Let a fault begin at the next look, whatever it says of its beginning."""
        self._injected += (fault,)

    def clear(self, concerns: Callable[[Fault], bool]) -> None:
        """End the faults that `concerns` picks."""
        self._ended += tuple(each for each in self.active if concerns(each.fault))
        self._injected = tuple(fault for fault in self._injected if not concerns(fault))
        self.active = tuple(each for each in self.active if not concerns(each.fault))

    def update(self, time_s: float, autopilot: Autopilot) -> Change:
        """Look at the time (s since boot) and at what the vehicle does."""
        for phase in _phases_of(autopilot):
            self._phases.setdefault(phase, time_s)
        due = tuple(fault for fault in self._waiting if self._begins_s(fault) <= time_s)
        begun = tuple(Active(fault, time_s) for fault in (*due, *self._injected))
        over = tuple(each for each in self.active if _is_over(each, time_s))
        change = Change(begun, self._ended + over)
        self._waiting = tuple(fault for fault in self._waiting if fault not in due)
        self.active = (*(each for each in self.active if each not in over), *begun)
        self._injected = self._ended = ()
        return change

    def _begins_s(self, fault: Fault) -> float:
        return self._phases.get(fault.after, float("inf")) + fault.at_s


def _is_over(active: Active, time_s: float) -> bool:
    lasts_s = active.fault.lasts_s
    return lasts_s is not None and time_s >= active.since_s + lasts_s


def _phases_of(autopilot: Autopilot) -> Iterable[Phase]:
    landed = autopilot.landed
    if landed is Landed.ON_GROUND:
        return
    yield Phase.TAKEOFF
    if landed is Landed.LANDING or autopilot.mode in (Mode.LAND, Mode.RTL):
        yield Phase.LANDING
    elif landed is Landed.IN_AIR and autopilot.mode is Mode.OFFBOARD:
        yield Phase.SETPOINTS
