"""A flight on a terminal: whatever becomes of the terminal, the flight goes on."""

import io
import threading

from rich.console import Console

from companion import clock
from companion.cli.display import FlightDisplay


class Hanging(io.StringIO):
    """A terminal that takes nothing until it is let go, or five seconds are over."""

    def __init__(self) -> None:
        super().__init__()
        self.let_go = threading.Event()

    def write(self, text: str, /) -> int:
        self.let_go.wait(5.0)
        return super().write(text)


class Gone(io.StringIO):
    """A terminal that was closed."""

    def write(self, text: str, /) -> int:
        raise BrokenPipeError


def show_three(terminal: Hanging | Gone) -> str:
    """What the terminal has had when the flight has said all."""

    async def fly() -> str:
        with FlightDisplay(Console(file=terminal)) as display:
            for phase in ("arming", "climbing", "holding"):
                display.phase(phase)
            had = terminal.getvalue()
            if isinstance(terminal, Hanging):
                terminal.let_go.set()
        return had

    return clock.run(fly(), virtual=True)


def test_a_terminal_that_hangs_holds_up_no_flight() -> None:
    terminal = Hanging()
    assert show_three(terminal) == ""
    lines = terminal.getvalue().split("\n")
    assert [line.split("  ")[-1] for line in lines] == ["arming", "climbing", "holding", ""]


def test_a_terminal_that_is_gone_ends_no_flight() -> None:
    assert show_three(Gone()) == ""
