"""A flight as it shows on a terminal: a line for each event, and a bar while the trajectory is tracked."""

from concurrent.futures import ThreadPoolExecutor
from types import TracebackType
from typing import Self

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn

from companion import clock
from companion.cli.lines import show
from companion.link.status_text import StatusText

_WARNING = 4  # MAV_SEVERITY_WARNING: it and all below are worth a colour


class FlightDisplay:
    """Shows one flight; time counts from when it was made.

    Lines are written by a thread of their own: a terminal that hangs, as over a network, holds up no flight,
    and one that is gone ends none.
    """

    def __init__(self, console: Console) -> None:
        self._console = console
        self._began_s = clock.now()
        self._terminal = ThreadPoolExecutor(max_workers=1)
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TaskProgressColumn(),
            console=console,
            transient=True,
            disable=not console.is_terminal,
        )
        self._tracking = self._bar.add_task("tracking", total=1.0, visible=False)

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._terminal.shutdown()
        self._bar.stop()

    def phase(self, text: str) -> None:
        """The flight came to another phase."""
        self._bar.update(self._tracking, visible=False)
        self._line(text)

    def vehicle_said(self, line: StatusText) -> None:
        """The vehicle sent a STATUSTEXT."""
        self._line(f"vehicle: {line.text}", style="yellow" if line.severity <= _WARNING else None)

    def progress(self, share: float, error_m: float) -> None:
        """The vehicle is that far along its trajectory (0 to 1), and that far away from it (m)."""
        self._bar.update(
            self._tracking, completed=share, visible=True, description=f"{error_m:.2f} m from the trajectory"
        )

    def _line(self, text: str, style: str | None = None) -> None:
        time = f"{clock.now() - self._began_s:7.1f} s  "
        self._terminal.submit(show, self._console, time + text, style=style)
