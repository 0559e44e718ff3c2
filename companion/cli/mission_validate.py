"""`companion mission validate`: what would keep a plan from being flown."""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from companion.autopilot import detect
from companion.cli import options
from companion.cli.endpoint import Endpoint, with_vehicle
from companion.cli.lines import show
from companion.cli.mission import counts, summary
from companion.cli.result_file import write_result
from companion.errors import InputError
from companion.flight.guard import GuardLimits
from companion.link import Connection, start_telemetry
from companion.link.command import request_message
from companion.link.dialect import mavlink
from companion.mission.checks import Findings, check_places, check_plan
from companion.mission.files import read_plan
from companion.mission.items import Plan
from companion.mission.site import planned_site, vehicle_site
from companion.mission.transfer import download_fence

_CAPABILITIES = {
    "missions": mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_INT,
    "fences": mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_FENCE,
    "rally points": mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_RALLY,
}


def validate(
    file: Annotated[Path, typer.Argument(dir_okay=False, help="Plan: .plan or QGC WPL 110.")],
    connect: options.ConnectUnlessDry = None,
    max_distance: Annotated[
        float | None, typer.Option(min=1.0, help="Refuse places farther than this from takeoff (m).")
    ] = None,
    system_id: options.SystemId = None,
    signing_key: options.SigningKeyFile = None,
    json: options.Json = None,
) -> None:
    """Say what would keep a plan from being flown; with --connect, by that vehicle, from where it is.

    Without a vehicle places are looked at from the plan's own home. Exit status 2 where there is a fault.

    Example: companion mission validate survey.plan --max-distance 300
    """
    plan = read_plan(file)
    if json is not None:
        options.writable(json)
    limit_m = GuardLimits().max_distance_m if max_distance is None else max_distance
    findings = [check_plan(plan)]
    if connect is not None:
        endpoint = Endpoint(connect, system_id, options.signing_key(signing_key))
        findings += with_vehicle(endpoint, lambda connection: _by_vehicle(connection, plan, limit_m))
    elif plan.home is not None:
        findings.append(check_places(plan, planned_site(plan), plan.fence, "plan", limit_m))
    faults = [fault for each in findings for fault in each.faults]
    remarks = [remark for each in findings for remark in each.remarks]
    show(Console(), summary(plan), *remarks, *faults)
    if json is not None:
        result = {"file": str(file), **counts(plan), "faults": faults, "remarks": remarks}
        write_result(result, json)
    if faults:
        raise InputError(f"{file}: {len(faults)} faults; the first: {faults[0]}")


async def _by_vehicle(connection: Connection, plan: Plan, limit_m: float) -> list[Findings]:
    """What one vehicle has against the plan."""
    telemetry = await start_telemetry(connection)
    await detect(connection, telemetry)
    told = await request_message(connection, mavlink.MAVLink_autopilot_version_message)
    site = await vehicle_site(connection, telemetry)
    fence = await download_fence(connection)
    return [
        Findings(tuple(_lacking(told.capabilities, plan))),
        check_places(plan, site, plan.fence, "plan", limit_m),
        check_places(plan, site, fence, "vehicle", limit_m),
    ]


def _lacking(capabilities: int, plan: Plan) -> Iterator[str]:
    """What the plan has that the vehicle takes none of."""
    wanted = {"missions": bool(plan.mission), "fences": bool(plan.fence), "rally points": bool(plan.rally)}
    for what, capability in _CAPABILITIES.items():
        if wanted[what] and not capabilities & capability:
            yield f"the vehicle takes no {what}"
