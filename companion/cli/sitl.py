"""`companion sitl`: a simulated vehicle for MAVLink clients."""

from typing import Annotated

import typer
from rich.console import Console

from companion import clock
from companion.errors import InputError, LinkError


def sitl(
    vehicle: Annotated[str, typer.Option(help="Name in config/vehicles, or a YAML file.")] = "bebop2",
    conditions: Annotated[str, typer.Option(help="Name in config/conditions, or a YAML file.")] = "ideal",
    speed: Annotated[float, typer.Option(min=0.1, max=100.0, help="Simulated seconds a second.")] = 1.0,
    seed: Annotated[int, typer.Option(min=0, help="Of everything random.")] = 0,
    system_id: Annotated[int, typer.Option(min=1, max=255, help="MAVLink id; moves the ports.")] = 1,
    host: Annotated[str, typer.Option(help="Machine of the companion and the ground station.")] = "127.0.0.1",
) -> None:
    """Serve a simulated quadrotor over MAVLink, as PX4's own simulator does.

    A companion finds it on UDP port 14540, a ground station on 14550. Ctrl-C ends it.

    Example: companion sitl --vehicle bebop2 --conditions realistic --speed 5
    """
    # imported here: the base install has no numba, and --help must not wait for it
    try:
        from sitl.errors import ConfigError, ServeError
        from sitl.mavlink import open_vehicle
        from sitl.plant import TICK_S
        from sitl.server import px4_endpoints, serve
    except ModuleNotFoundError as error:
        raise InputError(
            f"the simulator needs {error.name}: install it with `pip install 'impromptu[sim]'`"
        ) from error

    offboard, ground_station = px4_endpoints(system_id, host)
    try:
        with Console(stderr=True).status("preparing the simulator; the first time takes half a minute"):
            open_vehicle(vehicle, conditions).advance(TICK_S)  # compiles what is not yet
    except ConfigError as error:
        raise InputError(str(error)) from error
    flying = open_vehicle(
        vehicle, conditions, seed=seed, system_id=system_id, links=(offboard.link, ground_station.link)
    )
    name, air = flying.simulation.vehicle.name, flying.simulation.conditions.name
    typer.echo(
        f"{name}, {air} conditions, system {system_id}: companion at udpin://0.0.0.0:{offboard.peer[1]}, "
        f"ground station at UDP {ground_station.peer[1]}"
    )
    try:
        clock.run(serve(flying, (offboard, ground_station), speed=speed, say=typer.echo))
    except ServeError as error:
        raise LinkError(str(error)) from error
    except KeyboardInterrupt:  # the way to end it
        typer.echo("ended")
