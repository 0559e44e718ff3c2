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
    """Serve a simulated quadrotor over MAVLink, as the simulators of PX4 and ArduPilot do.

    With PX4 on board, a companion finds it on UDP port 14540 and a ground station on 14550; with ArduPilot,
    both on 14550. Ctrl-C ends it.

    Example: companion sitl --vehicle bebop2 --conditions realistic --speed 5
    """
    # imported here: the base install has no numba, and --help must not wait for it
    try:
        from sitl.errors import ConfigError, ServeError
        from sitl.mavlink import open_vehicle
        from sitl.plant import TICK_S
        from sitl.server import ENDPOINTS, serve
        from sitl.vehicle import load_vehicle
    except ModuleNotFoundError as error:
        raise InputError(
            f"the simulator needs {error.name}: install it with `pip install 'impromptu[sim]'`"
        ) from error

    try:
        endpoints = ENDPOINTS[load_vehicle(vehicle).firmware](system_id, host)
        with Console(stderr=True).status("preparing the simulator; the first time takes half a minute"):
            open_vehicle(vehicle, conditions).advance(TICK_S)  # compiles what is not yet
    except ConfigError as error:
        raise InputError(str(error)) from error
    links = [endpoint.link for endpoint in endpoints]
    flying = open_vehicle(vehicle, conditions, seed=seed, system_id=system_id, links=links)
    name, air = flying.simulation.vehicle.name, flying.simulation.conditions.name
    places = ", ".join(f"{each.link.name} at udpin://0.0.0.0:{each.peer[1]}" for each in endpoints)
    typer.echo(f"{name}, {air} conditions, system {system_id}: {places}")
    try:
        clock.run(serve(flying, endpoints, speed=speed, say=typer.echo))
    except ServeError as error:
        raise LinkError(str(error)) from error
    except KeyboardInterrupt:  # the way to end it
        typer.echo("ended")
