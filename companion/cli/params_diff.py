"""`companion params diff`: where two sets of parameters differ."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from companion.cli import options
from companion.cli.endpoint import Endpoint
from companion.cli.lines import show
from companion.cli.params import read_file, read_vehicle
from companion.cli.result_file import write_result
from companion.link.parameter_changes import Difference, differences
from companion.link.parameter_encoding import Number
from companion.link.parameter_file import written

_NAMES_SHOWN = 20


def diff(
    a: Annotated[str, typer.Argument(metavar="A", help="Parameter file, or connection string of a vehicle.")],
    b: Annotated[str, typer.Argument(metavar="B", help="What to compare it with: likewise.")],
    system_id: options.SystemId = None,
    signing_key: options.SigningKeyFile = None,
    json: options.Json = None,
) -> None:
    """Show the parameters in which two files, two vehicles, or a file and a vehicle differ.

    Values that are the same to a float32 are the same.

    Example: companion params diff mine.params udpin://0.0.0.0:14540
    """
    if json is not None:
        options.writable(json)
    console = Console()
    key = options.signing_key(signing_key)
    before, after = (_values(Endpoint(each, system_id, key), console) for each in (a, b))
    found = differences(before, after)
    show(console, f"A: {a}", f"B: {b}")
    both = [each for each in found if each.before is not None and each.after is not None]
    if both:
        console.print(_table(both))
    show(console, *_lines(found, len(both)))
    if json is not None:
        write_result([asdict(each) for each in found], json)


def _values(endpoint: Endpoint, console: Console) -> Mapping[str, Number]:
    if "://" in endpoint.url:
        found = read_vehicle(endpoint, console)
        return {name: each.value for name, each in found.parameters.items()}
    return {each.name: each.value for each in read_file(Path(endpoint.url), console)}


def _table(differing: Sequence[Difference]) -> Table:
    table = Table("parameter", box=SIMPLE_HEAD)
    table.add_column("A", justify="right")
    table.add_column("B", justify="right")
    for each in differing:
        assert each.before is not None
        assert each.after is not None
        table.add_row(each.name, written(each.before), written(each.after))
    return table


def _lines(found: Sequence[Difference], differing: int) -> Iterator[str]:
    for side, names in (
        ("A", [each.name for each in found if each.after is None]),
        ("B", [each.name for each in found if each.before is None]),
    ):
        if names:
            more = f" and {len(names) - _NAMES_SHOWN} more" if len(names) > _NAMES_SHOWN else ""
            yield f"only in {side}, {len(names)}: {', '.join(names[:_NAMES_SHOWN])}{more}"
    yield f"{differing} parameters differ" if found else "no differences"
