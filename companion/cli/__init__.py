"""The command `companion`: one module a subcommand."""

from companion.cli.app import main

__all__ = ["main"]
