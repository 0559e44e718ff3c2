"""`companion doctor`: what would stop a flight of this vehicle, and what to set."""

from collections.abc import AsyncIterator, Mapping, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import asdict
from functools import partial
from typing import Annotated, Any

import typer
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table
from rich.text import Text

from companion import __version__, clock
from companion.cli import options
from companion.cli.display import FlightDisplay
from companion.cli.result_file import write_result
from companion.doctor import Finding, Observation, Severity, Traffic, examine, judge
from companion.doctor.silence import likely_causes
from companion.errors import LinkError
from companion.link import Connection, parse_address
from companion.link.address import Address, Simulated
from companion.link.connection import connect_over
from companion.link.opening import open_transport
from companion.link.signing import SigningKey
from companion.link.signing_state import lasting_signer

_STYLES = {Severity.FINE: "green", Severity.WARNS: "yellow", Severity.STOPS: "bold red"}
_NOT_READY = 1
_WIDTH_OF_FILES = 100
_CONNECT_S = 3.0


def doctor(
    connect: options.Connect,
    system_id: options.SystemId = None,
    seconds: Annotated[float, typer.Option(min=1.0, max=3600.0, help="How long to measure (s).")] = 10.0,
    patience: Annotated[
        float, typer.Option(min=0.0, max=3600.0, help="How long to wait for it to be ready (s).")
    ] = 60.0,
    signing_key: options.SigningKeyFile = None,
    json: options.Json = None,
) -> None:
    """Look at a vehicle and the link to it, and say what would stop a flight and what to set.

    Nothing is changed: it does not arm, change modes or set parameters. Exit status 1 when something stops
    a flight.

    Example: companion doctor --connect udpin://0.0.0.0:14540
    """
    address = parse_address(connect)
    key = options.signing_key(signing_key)
    if json is not None:
        options.writable(json)
    console = Console()
    if not console.is_terminal:
        console.width = max(console.width, _WIDTH_OF_FILES)
    look = _look(address, system_id, key, seconds, patience, console)
    seen = clock.run(look, virtual=isinstance(address, Simulated))
    findings = judge(seen)
    console.print(_table(findings))
    stopping = [finding for finding in findings if finding.severity is Severity.STOPS]
    warning = sum(finding.severity is Severity.WARNS for finding in findings)
    console.print(_verdict(len(stopping), warning), highlight=False)
    if json is not None:
        write_result(_result(seen, findings), json)
    if stopping:
        raise typer.Exit(_NOT_READY)


async def _look(
    address: Address,
    system_id: int | None,
    key: SigningKey | None,
    seconds: float,
    patience_s: float,
    console: Console,
) -> Observation:
    with FlightDisplay(console) as display:
        timeout_s = max(patience_s, _CONNECT_S)
        display.phase(f"listening for a vehicle, {timeout_s:g} s at most")
        traffic = Traffic()
        async with _connected(address, system_id, key, traffic, timeout_s) as connection:
            connection.status_texts.subscribe(display.vehicle_said)
            return await examine(
                connection,
                traffic,
                seconds=seconds,
                patience_s=patience_s,
                chosen=system_id is not None,
                announce=display.phase,
            )


@asynccontextmanager
async def _connected(
    address: Address, system_id: int | None, key: SigningKey | None, traffic: Traffic, timeout_s: float
) -> AsyncIterator[Connection]:
    """As `connect`, with `traffic` watching the bytes; where no vehicle is heard it tells likely causes."""
    async with AsyncExitStack() as stack:
        signer = await stack.enter_async_context(lasting_signer(key)) if key else None
        opener = traffic.watching(partial(open_transport, address))
        connecting = connect_over(opener, system_id=system_id, signer=signer, timeout_s=timeout_s)
        try:
            connection = await stack.enter_async_context(connecting)
        except LinkError as error:
            if not traffic.opened:
                raise
            causes = likely_causes(address, traffic.peers, traffic.counts, system_id)
            raise LinkError("; ".join([str(error), *causes])) from error
        yield connection


def _table(findings: Sequence[Finding]) -> Table:
    """The gravest last, where the verdict follows."""
    table = Table("", "what", "seen, and what to do", box=SIMPLE_HEAD)
    for finding in sorted(findings, key=lambda each: list(_STYLES).index(each.severity)):
        told = Text(finding.seen)
        if finding.advice:
            told.append(f"\nto do: {finding.advice}", style="bold")
        table.add_row(Text(finding.severity, style=_STYLES[finding.severity]), finding.topic, told)
    return table


def _verdict(stopping: int, warning: int) -> str:
    warnings = f"; {warning} to know of" if warning else ""
    if stopping:
        return f"[bold red]not ready: {stopping} of these stop a flight[/]{warnings}"
    return f"[green]ready: nothing stops a flight[/]{warnings}"


def _result(seen: Observation, findings: Sequence[Finding]) -> Mapping[str, Any]:
    """Everything, for programs."""
    observed = asdict(seen) | {
        "losses": {
            f"{system}.{component}": asdict(loss) | {"share": loss.share}
            for (system, component), loss in seen.losses.items()
        }
    }
    return {
        "ready": not any(finding.severity is Severity.STOPS for finding in findings),
        "findings": [asdict(finding) for finding in findings],
        "observed": observed,
        "software": __version__,
    }
