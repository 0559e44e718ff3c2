"""The errors that Impromptu raises on purpose; each message says what was wrong and what to do.

ImpromptuError
├── InputError           a file, an argument or a connection string is wrong        (exit status 2)
└── FlightError          the flight or the job failed                               (exit status 1)
    ├── LinkError        nothing there, port taken, link lost
    │   └── NoReplyError    the vehicle did not answer a request in time
    ├── GapError         setpoints stopped for longer than the vehicle waits for them
    ├── RefusedError     the vehicle refused: its own STATUSTEXT is in the message
    ├── TakenError       the vehicle left our control unasked
    └── TrackingError    the flight was ended by a guard; the vehicle was left in a hold
"""


class ImpromptuError(Exception):
    """The root: every error that this program raises on purpose."""

    exit_status = 1


class InputError(ImpromptuError):
    """A file, an argument or a connection string is wrong: names it, and says what was expected."""

    exit_status = 2


class FlightError(ImpromptuError):
    """The flight or the job failed."""


class LinkError(FlightError):
    """Nothing there, port taken, or link lost."""


class NoReplyError(LinkError):
    """The vehicle did not answer a request in time."""


class GapError(FlightError):
    """Setpoints stopped for longer than the vehicle waits for them: it was left to its own failsafe."""


class RefusedError(FlightError):
    """The vehicle refused a request; the message carries the reason that it gave."""


class TrackingError(FlightError):
    """A guard ended the flight; the vehicle was left in a hold."""


class TakenError(FlightError):
    """The vehicle left our control unasked (its pilot, its failsafe), and was left to whoever has it."""
