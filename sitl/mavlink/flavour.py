"""What differs on the wire between the autopilots that the vehicle may be."""

from collections.abc import Callable, Container, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

from sitl.firmware.interface import Autopilot, Mode, Result
from sitl.mavlink.links import Link

if TYPE_CHECKING:
    from sitl.mavlink.commands import Command
    from sitl.mavlink.frames import Message
    from sitl.mavlink.mission_upload import MissionWire
    from sitl.mavlink.parameters import ParameterWire
    from sitl.mavlink.session import Session
    from sitl.mavlink.telemetry import Report

Execute: TypeAlias = "Callable[[Session, Command], int]"
"""Does what a command asks for; returns a MAV_RESULT."""
Handle: TypeAlias = "Callable[[Session, Any], None]"
"""Does what a message asks for."""


@dataclass(frozen=True, eq=False)
class Flavour:
    """How one autopilot speaks MAVLink.

    Attributes:
        autopilot: MAV_AUTOPILOT.
        version: AUTOPILOT_VERSION.flight_sw_version of the release that it behaves as.
        capabilities: MAV_PROTOCOL_CAPABILITY flags.
        links: those of its own simulator.
        mode_names: the autopilot's own names of flight modes, where they differ.
        custom_modes: HEARTBEAT.custom_mode of each flight mode.
        modes: the flight modes that a peer may ask for, by custom_mode.
        base_mode: HEARTBEAT.base_mode of a flight mode, armed or not.
        system_status: MAV_STATE of the vehicle.
        results: MAV_RESULT of each answer of the firmware.
        system_id_parameter: which parameter has the vehicle's MAVLink id, from the next boot on.
        earth_radius_m: by which its places on the map are local.
        parameters: how it puts parameters into messages.
        missions: how it conducts plan transfers.
        reached_repeats: how often it tells again which item was reached.
        tells_current_at_once: whether MISSION_CURRENT does not wait for its turn when another item is.
        writers: what writes each message that can be streamed or asked for, by message id.
        commands: what each MAV_CMD does.
        commands_to_all: the MAV_CMDs that are taken when they are sent to every system.
        handlers: what is done with messages that not every autopilot takes alike, by message id.
    """

    autopilot: int
    version: int
    capabilities: int
    links: tuple[Link, ...]
    mode_names: Mapping[Mode, str]
    custom_modes: Mapping[Mode, int]
    modes: Mapping[int, Mode]
    base_mode: Callable[[Mode, bool], int]
    system_status: Callable[[Autopilot], int]
    results: Mapping[Result, int]
    system_id_parameter: str
    earth_radius_m: float
    parameters: "ParameterWire"
    missions: "MissionWire"
    reached_repeats: int
    tells_current_at_once: bool
    writers: Mapping[int, "Callable[[Report], Message]"]
    commands: Mapping[int, Execute]
    commands_to_all: Container[int]
    handlers: Mapping[int, Handle]
