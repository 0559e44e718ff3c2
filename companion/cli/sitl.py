"""`companion sitl`: simulated vehicles for MAVLink clients."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer
from rich.console import Console

from companion import clock
from companion.cli import options
from companion.errors import InputError, LinkError
from sitl.faults.kinds import KINDS
from sitl.faults.reading import describe_kinds, load_faults, parse_faults

if TYPE_CHECKING:
    from sitl.server import Served

_APART_M = 3.0
_MOST_SYSTEMS = 255


def sitl(
    vehicle: Annotated[str, typer.Option(help="Name in config/vehicles, or a YAML file.")] = "bebop2",
    conditions: Annotated[str, typer.Option(help="Name in config/conditions, or a YAML file.")] = "ideal",
    autopilot: Annotated[
        Literal["px4", "ardupilot"] | None, typer.Option(help="Default: what the vehicle's file says.")
    ] = None,
    instances: Annotated[int, typer.Option(min=1, max=_MOST_SYSTEMS, help="How many vehicles.")] = 1,
    speed: Annotated[float, typer.Option(min=0.1, max=100.0, help="Simulated seconds a second.")] = 1.0,
    seed: Annotated[int, typer.Option(min=0, help="Of everything random.")] = 0,
    boot_time: Annotated[float, typer.Option(min=0.0, help="Seconds without a position after a boot.")] = 0.0,
    system_id: Annotated[
        int, typer.Option(min=1, max=_MOST_SYSTEMS, help="MAVLink id of the first; moves the ports.")
    ] = 1,
    signing_key: options.SigningKeyFile = None,
    host: Annotated[str, typer.Option(help="Machine of the companion and the ground station.")] = "127.0.0.1",
    fault: Annotated[
        list[str] | None,
        typer.Option(
            metavar="KIND:KEY=VALUE,...",
            show_default=False,
            help="What goes wrong, as often as you like: motor_weak:motor=2,effectiveness=0.6,at_s=12. "
            f"Kinds, whose keys --fault-kinds shows: {', '.join(KINDS)}.",
        ),
    ] = None,
    faults: Annotated[
        Path | None, typer.Option(exists=True, dir_okay=False, help="YAML file with a list of faults.")
    ] = None,
    fault_kinds: Annotated[
        bool,
        typer.Option(
            "--fault-kinds", is_eager=True, help="List the kinds of fault with their keys, and end."
        ),
    ] = False,
) -> None:
    """Serve simulated quadrotors over MAVLink, as the simulators of PX4 and ArduPilot do.

    With PX4 on board, a companion finds the first on UDP port 14540, the next on 14541, and a ground station
    all of them on 14550; with ArduPilot, the first on UDP 14550 and TCP 5760, the next 10 ports further.
    Ctrl-C ends it.

    Faults befall every vehicle. Each may wait for a phase (after=boot, takeoff, setpoints or landing), begins
    at_s seconds later, and ends when it has lasted lasts_s seconds.

    Example: companion sitl --vehicle bebop2 --autopilot ardupilot --conditions realistic --instances 2

    Example: companion sitl --fault gps_lost:after=takeoff,at_s=20 --fault gust:north_m_s=8,at_s=30,lasts_s=3
    """
    # imported here: the base install has no numba, and --help must not wait for it
    try:
        from sitl.endpoints import ENDPOINTS
        from sitl.errors import ConfigError, ServeError
        from sitl.mavlink import open_vehicle
        from sitl.plant import TICK_S
        from sitl.server import Served, serve
        from sitl.vehicle import load_vehicle
    except ModuleNotFoundError as error:
        raise InputError(
            f"the simulator needs {error.name}: install it with `pip install 'impromptu[sim]'`"
        ) from error

    if fault_kinds:
        typer.echo(describe_kinds())
        return
    last = system_id + instances - 1
    if last > _MOST_SYSTEMS:
        raise InputError(f"{instances} vehicles from --system-id {system_id} on end beyond {_MOST_SYSTEMS}")
    try:
        befalls = (*parse_faults(fault or ()), *(load_faults(faults) if faults else ()))
        flies = autopilot or load_vehicle(vehicle).firmware
        with Console(stderr=True).status("preparing the simulator; the first time takes half a minute"):
            open_vehicle(vehicle, conditions, autopilot=flies).advance(TICK_S)  # compiles what is not yet
    except ConfigError as error:
        raise InputError(str(error)) from error
    key = options.signing_key(signing_key)
    fleet = []
    for number in range(instances):
        endpoints = ENDPOINTS[flies](system_id + number, host)
        flying = open_vehicle(
            vehicle,
            conditions,
            seed=seed + number,
            system_id=system_id + number,
            links=[endpoint.link for endpoint in endpoints],
            autopilot=flies,
            start=(0.0, number * _APART_M),
            boot_time_s=boot_time,
            signing_key=None if key is None else key.secret,
            faults=befalls,
        )
        fleet.append(Served(flying, endpoints))
        typer.echo(_introduced(fleet[-1]))
    try:
        clock.run(serve(fleet, speed=speed, say=typer.echo))
    except ServeError as error:
        raise LinkError(str(error)) from error
    except KeyboardInterrupt:  # the way to end it
        typer.echo("ended")


def _introduced(served: "Served") -> str:
    simulation = served.vehicle.simulation
    places = ", ".join(map(str, served.endpoints))
    return (
        f"{simulation.vehicle.name}, {simulation.conditions.name} conditions, "
        f"system {served.vehicle.system_id}: {places}"
    )
