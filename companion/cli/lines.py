"""Lines of text on a terminal."""

from rich.console import Console


def show(console: Console, *lines: str, style: str | None = None) -> None:
    """Print lines as they are: brackets are no markup, and none is broken."""
    for line in lines:
        console.print(line, style=style, markup=False, highlight=False, soft_wrap=True)
