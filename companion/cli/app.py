"""The root of the command: subcommands, exit statuses, and errors in one line."""

import typer

app = typer.Typer(
    name="companion",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def main() -> None:
    """Run the command line."""
    app()
