"""Commands imported only when they are run: help stays fast, and no command needs the extras of another."""

from importlib import import_module
from typing import Any

import typer
from typer.core import TyperCommand, TyperGroup


class LazyCommand(TyperCommand):
    """Stands in the list of commands for the function `name` of `module`, a Typer command."""

    def __init__(self, name: str, module: str, summary: str) -> None:
        super().__init__(name, help=summary)
        self.function_name = name
        self.module = module

    def make_context(self, *args: Any, **kwargs: Any) -> Any:
        """Import the function, and let its own command read the arguments."""
        loaded = typer.Typer(add_completion=False, rich_markup_mode="markdown")
        loaded.command(self.function_name)(getattr(import_module(self.module), self.function_name))
        return typer.main.get_command(loaded).make_context(*args, **kwargs)


def lazy_group(package: str, summaries: dict[str, str]) -> type[TyperGroup]:
    """A group of the functions in modules `package` + name, each with its one line of help."""

    class LazyGroup(TyperGroup):
        def __init__(self, *args: Any, **kwargs: Any) -> None:
            super().__init__(*args, **kwargs)
            for name, summary in summaries.items():
                self.add_command(LazyCommand(name, package + name, summary))

    return LazyGroup
