"""Parts of a recording that have a name: what was flown there, and where the vehicle truly hovered."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Window:
    """From one instant to another, both counted in (s, the recording's clock)."""

    start_s: float
    end_s: float


@dataclass(frozen=True)
class Segment:
    """One manoeuvre of a recording.

    Attributes:
        id: its name, unique in the recording.
        window: when it was flown.
        setpoints: what was sent, in words ("position+velocity").
        rms_m: RMS distance of setpoint and position at setpoint times, as whoever recorded it found it (m).
    """

    id: str
    window: Window
    setpoints: str = ""
    rms_m: float | None = None
