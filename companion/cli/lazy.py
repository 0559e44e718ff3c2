"""Commands imported only when they are run: help stays fast, and no command needs the extras of another."""

from collections.abc import Iterator, Sequence
from importlib import import_module
from typing import Any

import typer
from typer.core import TyperCommand, TyperGroup


class ManyValuesCommand(TyperCommand):
    """Takes `--speed 0.6 1.2` as `--speed 0.6 --speed 1.2`, unless the second could be an argument."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the words of the command line."""
        if all(param.param_type_name == "option" for param in self.params):
            repeatable = {
                name for param in self.params if getattr(param, "multiple", False) for name in param.opts
            }
            args = list(_each_named(args, repeatable))
        return super().parse_args(ctx, args)


def _each_named(words: Sequence[str], repeatable: set[str]) -> Iterator[str]:
    """The words, with the option's name before each of its values."""
    option, values = "", 0
    for word in words:
        if word.startswith("--"):
            option, values = word, 0
        else:
            values += 1
            if values > 1 and option in repeatable:
                yield option
        yield word


class LazyCommand(TyperCommand):
    """Stands in the list of commands for the function `name` of `module`, a Typer command."""

    def __init__(self, name: str, module: str, summary: str) -> None:
        super().__init__(name, help=summary)
        self.function_name = name
        self.module = module

    def make_context(self, *args: Any, **kwargs: Any) -> Any:
        """Import the function, and let its own command read the arguments."""
        loaded = typer.Typer(add_completion=False, rich_markup_mode="markdown")
        loaded.command(self.function_name, cls=ManyValuesCommand)(
            getattr(import_module(self.module), self.function_name)
        )
        return typer.main.get_command(loaded).make_context(*args, **kwargs)


def lazy_group(package: str, summaries: dict[str, str]) -> type[TyperGroup]:
    """A group of the functions in modules `package` + name, each with its one line of help."""

    class LazyGroup(TyperGroup):
        def __init__(self, *args: Any, **kwargs: Any) -> None:
            super().__init__(*args, **kwargs)
            for name, summary in summaries.items():
                self.add_command(LazyCommand(name, package + name, summary))

    return LazyGroup
